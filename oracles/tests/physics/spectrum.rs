//! With any walls, the operator's spectrum stays within the limits of the step.
//!
//! Layout: the closed rooms of the energy test (whole cells, and a turned box in cut cells), 64 x 64 cells, at the
//! largest Courant number of each scheme and at half of it.
//! Formula: `-L v = 2 v - p'` for the step from `p = v`, `p'' = 0`; its largest eigenvalue by power iteration, the
//! smallest by that of its difference to 4.
//! Bias: power iteration approaches from inside.
//! Tolerance: at most [`fdtd::scheme::Polynomial::bound`], at least 0, rounding 1e-5.
//!
//! The same between crossed walls of 20 to 45 degrees, in whose cells the operator is another one (`walls/slant.rs`):
//! at most 4.

use crate::rig::{Conditions, Rig, Setting, crossed_room};
use fdtd::field::{Field, FieldSetup, FieldState, Injection, ReferenceField, StepForcing};
use fdtd::grid::Grid;
use fdtd::scheme::Scheme;
use fdtd::spread::Spread;
use fdtd::walls::WallModel;
use oracles::laws::room::{closed_rig, slanted_rig};

/// Rayleigh quotient after `turns` of power iteration with `-L` (or `4 + L` when `mirrored`), in the inner product of
/// the open areas.
fn extreme(setup: &FieldSetup, areas: &[f64], mirrored: bool, turns: usize) -> f64 {
    let silent = Spread::Bilinear.stencil([30.0, 30.0]);
    let still = Injection {
        stencil: silent,
        amplitude: 0.0,
    };
    let step = [StepForcing {
        flush: false,
        injections: [still; 2],
        receiver: silent,
    }];
    let mut field = ReferenceField::new(setup.clone());
    let blank = field.state();
    let mut v: Vec<f64> = (0..areas.len())
        .map(|cell| {
            if areas[cell] > 0.0 {
                ((cell * 7919) % 1013) as f64 / 1013.0 - 0.5
            } else {
                0.0
            }
        })
        .collect();
    let mut quotient = 0.0;
    for _ in 0..turns {
        let size = v
            .iter()
            .zip(areas)
            .map(|(p, area)| area * p * p)
            .sum::<f64>()
            .sqrt();
        v.iter_mut().for_each(|p| *p /= size);
        field.set_state(&FieldState {
            pressure: v.iter().map(|&p| p as f32).collect(),
            previous: vec![0.0; v.len()],
            ..blank.clone()
        });
        field.advance(&step, &mut Vec::new());
        let next: Vec<f64> = field
            .state()
            .pressure
            .iter()
            .zip(&v)
            .map(|(&after, before)| {
                let minus_l = 2.0 * before - f64::from(after);
                if mirrored {
                    4.0 * before - minus_l
                } else {
                    minus_l
                }
            })
            .collect();
        quotient = next
            .iter()
            .zip(&v)
            .zip(areas)
            .map(|((a, b), area)| area * a * b)
            .sum();
        v = next;
    }
    if mirrored { 4.0 - quotient } else { quotient }
}

/// Smallest and largest eigenvalue with the walls of a rig at a Courant number.
fn extremes(rig: &Rig, courant: f64) -> [f64; 2] {
    let Conditions { medium, dx_m, .. } = *rig.conditions();
    let grid = Grid {
        dt_s: courant * dx_m / medium.c_mps,
        ..rig.grid()
    };
    let setup = FieldSetup::new(&grid, &medium, rig.scheme, 0, &rig.walls);
    let areas = rig.walls.areas();
    [true, false].map(|mirrored| extreme(&setup, &areas, mirrored, 400))
}

#[test]
fn the_spectrum_with_walls_is_within_the_bound() {
    for scheme in Scheme::ALL {
        for part in [0.9999, 0.5] {
            let setting = Setting::drawn("spectrum", &format!("{scheme}, {part}"));
            for rig in [
                closed_rig(&setting, scheme, 64),
                slanted_rig(&setting, scheme, 64),
            ] {
                let courant = part * scheme.max_courant();
                let [smallest, largest] = extremes(&rig, courant);
                let bound = scheme.polynomial(courant).bound().expect("a stable scheme");
                println!(
                    "spectrum, {scheme} at {courant:.4}: {smallest:.2e} to {largest:.4}, bound {bound:.4}"
                );
                assert!(largest < bound + 1e-5, "{scheme}: {largest} over {bound}");
                assert!(smallest > -1e-5, "{scheme}: {smallest}");
            }
        }
    }
}

#[test]
fn slanted_walls_leave_it_within_four() {
    let lines = [
        [0.05, 0.03, 0.12, 0.17],
        [0.1, 0.2, 0.22, 0.06],
        [0.05, 0.25, 0.19, 0.13],
    ];
    for scheme in Scheme::ALL {
        for part in [0.9999, 0.9, 0.5] {
            let courant = part * scheme.max_courant();
            let setting = Setting::drawn("slanted spectrum", &format!("{scheme}, {part}"));
            let rig = crossed_room(&setting, scheme, WallModel::CutCells, &lines, None);
            let [smallest, largest] = extremes(&rig, courant);
            println!("spectrum, slanted, {scheme} at {courant:.4}: {smallest:.2e} to {largest:.4}");
            assert!(largest < 4.0, "{scheme}: {largest}");
            assert!(smallest > -1e-5, "{scheme}: {smallest}");
        }
    }
}
