//! Domain: a source that is switched on in silence. Ahead of the wave front the field falls off faster than any exponential
//! (after n steps only the tails of n stencils reach there), therefore through all numbers down to zero: a band of subnormal
//! numbers, which some processors handle slowly, runs ahead of the front. Behind it no number is that small again while the
//! source sounds. Expected: a few per cent of the cells on the way; none after the front has crossed the domain and its layers
//! several times. Hence subnormal numbers can cost something only during the first some thousand of the millions of steps of
//! a drive.

use fdtd::field::{FastField, Field, FieldSetup, Injection, StepForcing};
use fdtd::grid::{Grid, Medium};
use fdtd::scheme::Scheme;
use fdtd::spread::Spread;
use fdtd::walls::SolidMask;

const SIDE: usize = 240;

/// A domain with layers and a wall that leaves a way around it.
fn field(scheme: Scheme) -> FastField {
    let grid = Grid {
        nx: SIDE,
        ny: SIDE,
        dx_m: 0.005,
        dt_s: 1.0 / 120_000.0,
    };
    let medium = Medium {
        c_mps: 340.0,
        rho_kgpm3: 1.293,
    };
    let mut cells = vec![false; SIDE * SIDE];
    for k in 0..SIDE / 2 {
        for thickness in 0..4 {
            cells[(SIDE / 3 + k / 4 + thickness) * SIDE + SIDE / 4 + k] = true;
        }
    }
    let mask = SolidMask {
        nx: SIDE,
        ny: SIDE,
        cells,
    };
    FastField::new(FieldSetup::new(&grid, &medium, scheme, 20, &mask.into()), 1)
}

/// Steps `from..to` of a tone of 1 kHz.
fn tone(from: usize, to: usize) -> Vec<StepForcing> {
    let stencil = Spread::Kaiser8.stencil([0.5 * SIDE as f64 + 0.3, 0.6 * SIDE as f64]);
    (from..to)
        .map(|n| {
            let injection = Injection {
                stencil,
                amplitude: (std::f32::consts::TAU * 1e3 * n as f32 / 120_000.0).sin(),
            };
            StepForcing {
                injections: [injection; 2],
                receiver: stencil,
            }
        })
        .collect()
}

/// Share of subnormal numbers among pressure and the layers' memory.
fn share(field: &FastField) -> f64 {
    let state = field.state();
    let all = [&state.pressure, &state.layer_x, &state.layer_y];
    let count = |test: fn(&f32) -> bool| {
        all.iter()
            .flat_map(|part| part.iter())
            .filter(|p| test(p))
            .count()
    };
    count(|p| p.is_subnormal()) as f64 / count(|_| true) as f64
}

#[test]
fn subnormal_numbers_run_ahead_of_the_front_and_are_gone_behind_it() {
    for scheme in Scheme::ALL {
        let mut field = field(scheme);
        let mut received = Vec::new();
        field.advance(&tone(0, 100), &mut received);
        let ahead = share(&field);
        field.advance(&tone(100, 2400), &mut received);
        let behind = share(&field);
        println!(
            "{scheme}: {:.3} % ahead, {:.5} % behind",
            100.0 * ahead,
            100.0 * behind
        );
        assert!(ahead > 0.0 && ahead < 0.1, "{scheme}: {ahead}");
        assert!(behind < 1e-4, "{scheme}: {behind}");
    }
}
