//! Domain: a source that is switched on in silence. Ahead of the wave front the field falls off faster than any
//! exponential (after n steps only the tails of n stencils reach there), therefore through all numbers down to zero:
//! without flushing steps a band of subnormal numbers, which some processors handle slowly, runs ahead of the front and
//! through the layers. Behind it no number is that small again while the source sounds.
//! Expected: a few per mille to per cent of the cells on the way without flushing steps; with them less than a
//! hundredth of that at any time. Without them too none are left once the front has crossed the domain and its layers
//! several times, which is why long drives can do without. The signal differs by rounding: the numbers set to zero are
//! far below the last digit of the signal, but any other digit anywhere in the field makes other roundings later.
//! Tolerance: -110 dB over the first 1200 steps.

use fdtd::field::{FastField, Field, FieldSetup, Injection, StepForcing, flushes_subnormals};
use fdtd::grid::Grid;
use fdtd::scheme::Scheme;
use fdtd::spread::Spread;
use fdtd::walls::SolidMask;
use oracles::laws::conditions::Conditions;
use oracles::laws::setting::Setting;
use std::f64::consts::TAU;

const SIDE: usize = 243;

/// Setting of a scheme's runs.
fn conditions(scheme: Scheme) -> Conditions {
    Setting::drawn("subnormal", scheme.name()).conditions
}

/// A domain with layers and a wall that leaves a way around it.
fn field(scheme: Scheme) -> FastField {
    let Conditions { medium, dx_m, dt_s } = conditions(scheme);
    let grid = Grid {
        nx: SIDE,
        ny: SIDE,
        dx_m,
        dt_s,
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

/// Steps `from..to` of a tone of 1 kHz on the papers' grid, with or without flushing steps.
fn tone(scheme: Scheme, flush: bool, from: usize, to: usize) -> Vec<StepForcing> {
    let stencil = Spread::Kaiser8.stencil([0.5 * SIDE as f64 + 0.3, 0.6 * SIDE as f64]);
    let conditions = conditions(scheme);
    let omega_dt = TAU * conditions.hz(1e3) * conditions.dt_s;
    (from..to)
        .map(|n| {
            let injection = Injection {
                stencil,
                amplitude: (omega_dt * n as f64).sin() as f32,
            };
            StepForcing {
                flush: flush && flushes_subnormals(scheme, n as u64),
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
fn flushing_steps_keep_subnormal_numbers_away_and_change_roundings_only() {
    for scheme in Scheme::ALL {
        let recorded = [false, true].map(|flush| {
            let mut field = field(scheme);
            let mut received = Vec::new();
            // In twos, so that counts are taken just before flushing steps too.
            let most = (0..1200)
                .step_by(2)
                .map(|n| {
                    field.advance(&tone(scheme, flush, n, n + 2), &mut received);
                    share(&field)
                })
                .fold(0.0, f64::max);
            field.advance(&tone(scheme, flush, 1200, 2400), &mut Vec::new());
            let behind = share(&field);
            assert!(behind < 1e-4, "{scheme}: {behind} left behind the front");
            (most, received)
        });
        let [(loud, plain), (flushed, flushed_signal)] = recorded;
        println!("{scheme}: at most {loud:.5} without, {flushed:.1e} with flushing steps");
        assert!(
            loud > 1e-3 && flushed < 1e-2 * loud,
            "{scheme}: {flushed} and {loud}"
        );
        let size = |signal: &[f32]| signal.iter().map(|p| f64::from(p * p)).sum::<f64>();
        let off: Vec<f32> = plain
            .iter()
            .zip(&flushed_signal)
            .map(|(a, b)| a - b)
            .collect();
        let part_db = 10.0 * (size(&off) / size(&plain)).log10();
        println!("{scheme}: signals differ by {part_db:.1} dB");
        assert!(part_db < -110.0, "{scheme}: another signal, {part_db} dB");
    }
}
