//! Walls whose impedance is made of branches of resistance, inertance and compliance: reflection over frequency and
//! angle ([`oracles::laws::branches`] says layout, formula and tolerance), and passivity.
//!
//! Layout, passivity: the box and the walls of `impedance_wall`, of one to four branches whose resistances, inertances
//! and compliances are from 1e-6 to 1e6 times those with the air's impedance at 10 kHz, or none.
//! Formula: the energy of the field, of the air before the surfaces and of the branches never grows.
//! Bias: the sum of squares is not the energy, which goes back and forth between the field and masses and springs in
//! the walls. Slow ones return their energy after the field has decayed.
//! Tolerance: the largest sum of squares in 330 steps after 3000 is at most 1.5 times that during the burst; between
//! any walls, where few modes beat, three times after 6000 steps. With an active wall it overflows.
//!
//! A branch with nothing but a resistance is the same wall as one of that impedance, number by number.

use crate::rig::{Conditions, Rig, Setting, crossed_room, largest_sum};
use fdtd::field::{Field, FieldSetup};
use fdtd::scheme::Scheme;
use fdtd::walls::{Branch, Impedance, WallModel};
use oracles::laws::branches::{CASES, PLACES, largest, setting, tolerance, walls};
use oracles::laws::impedance::is_held;
use oracles::laws::room::slanted_room;
use proptest::prelude::*;
use std::f64::consts::TAU;

#[test]
fn the_reflection_factor_is_that_of_the_branches() {
    // All frequencies, places and angles are left to `echolot validate`.
    let [whole, part] = PLACES;
    let held = |scheme| {
        CASES
            .into_iter()
            .filter(move |(hz, _)| is_held(scheme, *hz))
    };
    let every_other = held(Scheme::O13).skip(1).step_by(2);
    let all = every_other.map(|case| (Scheme::O13, case, part));
    let others = [Scheme::Slf, Scheme::D25];
    let highest = others.map(|scheme| held(scheme).next_back().map(|case| (scheme, case, whole)));
    for (scheme, (frequency_hz, [normal, .., grazing]), place) in
        all.chain(highest.into_iter().flatten())
    {
        let setting = setting(scheme, frequency_hz, place);
        let errors = largest(&setting, scheme, frequency_hz, &[normal, grazing], place);
        println!(
            "branches, {scheme}, {} kHz, {place} of a cell, {setting}: {errors:.4?}",
            frequency_hz / 1e3
        );
        for (wall, ((name, _), error)) in walls().into_iter().zip(errors).enumerate() {
            assert!(
                error < tolerance(wall, frequency_hz),
                "{scheme}, {name}, {frequency_hz}, {place}, {setting}: {error}"
            );
        }
    }
}

#[test]
fn nothing_but_resistance_is_the_real_impedance() {
    let setup = |impedance: Impedance| {
        let (scheme, model) = (Scheme::O13, WallModel::CutCells);
        let setting = Setting::before_surfaces(scheme, "branches", "resistance");
        let rig = slanted_room(&setting, scheme, 120, model, Some(impedance));
        let medium = &rig.conditions().medium;
        FieldSetup::new(&rig.grid(), medium, rig.scheme, 0, &rig.walls).surfaces
    };
    let real = setup(Impedance::Real(321.0));
    let alone = vec![Branch::resistance(321.0)];
    assert!(real == setup(Impedance::Branches(alone)));
    // In parallel they are one; 428 and 1284 are 321.
    let two = [428.0, 1284.0].map(Branch::resistance).to_vec();
    assert_eq!(
        real.memory_count(),
        setup(Impedance::Branches(two)).memory_count()
    );
}

/// A branch of numbers over those that have the air's impedance at 10 kHz on the papers' grid, as powers of ten; none
/// is 0.
fn branch(conditions: &Conditions, powers: [Option<f64>; 3]) -> Branch {
    let omega = TAU * conditions.hz(10e3);
    let [resistance, inertance, stiffness] =
        powers.map(|power| power.map_or(0.0, |power| 440.0 * 10_f64.powf(power)));
    Branch {
        resistance_pasm: resistance,
        inertance_kgpm2: inertance / omega,
        stiffness_papm: stiffness * omega,
    }
}

/// Largest sums of squares of the pressure: during a burst, and, by place and steps on the papers' grid, in 330 steps
/// that follow so many steps of silence.
fn sums(rig: &Rig, place_m: [f64; 2], steps: [usize; 2]) -> [f64; 2] {
    let conditions = rig.conditions();
    let place_m = conditions.point(place_m);
    let [loud, silent] = steps.map(|steps| conditions.steps(steps));
    let burst = conditions.burst(8e3, 4000.0);
    let mut field = rig.field();
    let sounding = rig.sounding(place_m, &|t_s| burst.value(t_s), loud);
    let during = largest_sum(&mut field, &sounding);
    field.advance(&rig.silence(silent), &mut Vec::new());
    [during, largest_sum(&mut field, &rig.silence(330))]
}

#[test]
fn no_reactance_makes_energy() {
    let walls = [
        vec![[None, None, Some(-6.0)]],
        vec![[None, None, Some(6.0)]],
        vec![[None, Some(-6.0), Some(-6.0)]],
        vec![[None, Some(0.0), Some(0.0)], [None, None, Some(0.5)]],
        vec![[Some(-6.0), Some(6.0), None], [None, Some(-3.0), Some(3.0)]],
        vec![[Some(-1.0), Some(0.3), Some(-0.3)], [Some(0.0), None, None]],
        // Slow: it returns the burst's energy after the field has decayed.
        vec![[Some(0.0), None, None], [None, Some(4.7), Some(-0.7)]],
    ];
    for scheme in Scheme::ALL {
        for model in WallModel::ALL {
            for powers in &walls {
                let case = format!("{scheme}, {model}, {powers:?}");
                let setting = Setting::before_surfaces(scheme, "passivity of branches", &case);
                let branch = |&powers: &_| branch(&setting.conditions, powers);
                let impedance = Impedance::Branches(powers.iter().map(branch).collect());
                let rig = slanted_room(&setting, scheme, 120, model, Some(impedance));
                let sums = sums(&rig, [0.3, 0.32], [400, 3000]);
                println!("passivity, {case}, {setting}: {sums:?}");
                assert!(sums[1] <= 1.5 * sums[0], "{case}, {setting}: {sums:?}");
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 32, failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn no_branches_make_energy_between_any_walls(
        scheme in prop::sample::select(&Scheme::ALL[..]),
        model in prop::sample::select(&WallModel::ALL[..]),
        lines in prop::collection::vec(prop::array::uniform4(0.03..0.25_f64), 1..5),
        powers in prop::collection::vec(
            prop::array::uniform3(prop::option::weighted(0.8, -6.0..6.0_f64)),
            1..5,
        ),
        number in 0..1000_u32,
    ) {
        let setting = Setting::before_surfaces(scheme, "any branches", &number.to_string());
        let branches: Vec<Branch> = powers
            .iter()
            .filter(|powers| powers.iter().any(Option::is_some))
            .map(|&powers| branch(&setting.conditions, powers))
            .collect();
        prop_assume!(!branches.is_empty());
        let rig = crossed_room(
            &setting,
            scheme,
            model,
            &lines,
            Some(&Impedance::Branches(branches)),
        );
        let sums = sums(&rig, [0.14, 0.14], [200, 6000]);
        prop_assert!(sums[1] <= 3.0 * sums[0], "{scheme}, {model}, {setting}: {sums:?}");
    }
}
