//! The fast engine against the reference engine: the same bytes for any size, thread count and instruction set.

use fdtd::field::fast::{InstructionSet, Machine};
use fdtd::field::{FastField, Field, FieldSetup, Injection, ReferenceField, StepForcing};
use fdtd::grid::Grid;
use fdtd::scheme::Scheme;
use fdtd::spread::Spread;
use fdtd::walls::{Branch, Impedance, SolidMask, Wall, WallModel};
use oracles::laws::conditions::{CONDITIONS, Conditions};
use proptest::prelude::*;

/// Scattered solid rectangles, anywhere.
fn mask(grid: &Grid, rectangles: &[[usize; 4]]) -> SolidMask {
    let mut cells = vec![false; grid.cells()];
    for &[x, y, w, h] in rectangles {
        for iy in y..(y + h).min(grid.ny) {
            for ix in x..(x + w).min(grid.nx) {
                cells[iy * grid.nx + ix] = true;
            }
        }
    }
    SolidMask {
        nx: grid.nx,
        ny: grid.ny,
        cells,
    }
}

/// Walls across the grid, anywhere.
fn slanted(conditions: &Conditions, lines: &[[f64; 4]]) -> Vec<Wall> {
    let wall = |&[x0, y0, x1, y1]: &[f64; 4]| Wall {
        points_m: [[x0, y0], [x1, y1], [y1, x0]]
            .map(|point| conditions.point(point))
            .to_vec(),
        thickness_m: conditions.m(0.012),
        impedance: match x0 {
            0.0..0.3 => Some(Impedance::Real(2000.0 * y0 + 1.0)),
            0.3..0.6 => Some(Impedance::Branches(branches(y0, y1))),
            _ => None,
        },
    };
    lines.iter().map(wall).collect()
}

/// One to four branches, some without inertance or compliance.
fn branches(one: f64, other: f64) -> Vec<Branch> {
    let branch = |k: usize| Branch {
        resistance_pasm: 500.0 * one,
        inertance_kgpm2: f64::from(u8::from(!k.is_multiple_of(3))) * 0.02 * other,
        stiffness_papm: f64::from(u8::from(k.is_multiple_of(2))) * 1e7 * one,
    };
    (0..=(4.0 * other) as usize).map(branch).collect()
}

/// A source and a receiver that cross the grid, with a waveform that fills the band.
fn forcing(grid: &Grid, spread: Spread, steps: usize) -> Vec<StepForcing> {
    let (w, h) = (grid.nx as f64 - 15.0, grid.ny as f64 - 15.0);
    (0..steps)
        .map(|n| {
            let u = n as f64 / steps as f64;
            let source = spread.stencil([7.0 + w * u, 7.0 + h * (1.0 - u)]);
            let wave = (n as f32 * 0.5).sin() + (n as f32 * 1.3).cos();
            StepForcing {
                flush: n % 5 < 2,
                injections: [
                    Injection {
                        stencil: source,
                        amplitude: wave,
                    },
                    Injection {
                        stencil: spread.stencil([7.0 + w * u, 7.5 + h * (1.0 - u)]),
                        amplitude: -0.7 * wave,
                    },
                ],
                receiver: spread.stencil([7.0 + w * (1.0 - u), 7.3 + h * u * u]),
            }
        })
        .collect()
}

fn compare(setup: &FieldSetup, forcing: &[StepForcing], threads: usize, machine: Machine) {
    let mut plain = ReferenceField::new(setup.clone());
    let mut fast = FastField::on(machine, setup.clone(), threads);
    let (mut expected, mut got) = (Vec::new(), Vec::new());
    plain.advance(forcing, &mut expected);
    // Uneven parts: blocks of all lengths occur, odd ones swap the buffers.
    let (head, tail) = forcing.split_at(forcing.len() / 3);
    fast.advance(head, &mut got);
    let mut resumed = FastField::on(machine, setup.clone(), 1);
    resumed.set_state(&fast.state());
    fast.advance(tail, &mut got);
    assert_eq!(bits(&expected), bits(&got), "received signal");
    assert_eq!(plain.state(), fast.state(), "state");
    let mut again = Vec::new();
    resumed.advance(tail, &mut again);
    assert_eq!(
        bits(&expected[head.len()..]),
        bits(&again),
        "signal after a resume"
    );
    assert!(expected.iter().any(|p| p.abs() > 1e-6));
}

fn bits(signal: &[f32]) -> Vec<u32> {
    signal.iter().map(|p| p.to_bits()).collect()
}

const INSTRUCTIONS: [InstructionSet; 4] = [
    InstructionSet::Portable,
    InstructionSet::Avx2,
    InstructionSet::Avx512,
    InstructionSet::Avx512,
];

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn fast_engine_gives_the_reference_bytes(
        nx in 50usize..190,
        ny in 50usize..190,
        layer in prop_oneof![Just(0usize), Just(7), Just(20)],
        threads in 1usize..5,
        scheme in prop::sample::select(&Scheme::ALL[..]),
        spread in prop::sample::select(&Spread::ALL[..]),
        steps in 20usize..70,
        instructions in prop::sample::select(&INSTRUCTIONS[..]),
        first_level_bytes in prop_oneof![Just(0usize), 2000usize..20_000],
        rectangles in prop::collection::vec(prop::array::uniform4(0usize..180), 0..4),
        lines in prop::collection::vec(prop::array::uniform4(0.0..0.9_f64), 0..3),
        model in prop::sample::select(&WallModel::ALL[..]),
        conditions in prop::sample::select(&CONDITIONS[..]),
    ) {
        let Conditions { medium, dx_m, dt_s } = conditions;
        let grid = Grid { nx, ny, dx_m, dt_s };
        let rectangles: Vec<_> = rectangles.iter().map(|&[x, y, w, h]| [x, y, 2 + w / 8, 2 + h / 3]).collect();
        let walls = if lines.is_empty() {
            mask(&grid, &rectangles).into()
        } else {
            model.cells(&grid, &slanted(&conditions, &lines))
        };
        let setup = FieldSetup::new(&grid, &medium, scheme, layer, &walls);
        let machine = Machine { instructions, first_level_bytes };
        compare(&setup, &forcing(&grid, spread, steps), threads, machine);
    }
}
