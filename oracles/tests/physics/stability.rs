//! No mode of the discrete operator grows, and silence stays silent; see the laws for layout, formula and tolerance.
//!
//! Whether the measurement sees a growing mode: the same with the constant mode's stiffness made negative by forty
//! quanta, more than the layer's restoring force.

use crate::rig::assert_within;
use fdtd::scheme::{RESTORING_QUANTUM, Scheme};
use oracles::laws::stability::{Room, growth, setup};
use oracles::laws::{Depth, silence, stability};

#[test]
fn no_mode_grows_at_any_courant_number() {
    assert_within(
        "no growing mode",
        &stability::measure(Depth::Quick).expect("no scene is read"),
    );
}

#[test]
fn silence_stays_silent_in_any_air() {
    assert_within(
        "silence",
        &silence::measure(Depth::Quick).expect("no scene is read"),
    );
}

#[test]
fn a_value_outside_the_spectrum_is_looked_for_again() {
    // The small space of the first look has a value of 1 + 3.5e-5 here; the field itself decays.
    let courant = 0.489_775_303_535_17;
    let growth = growth(
        setup(Scheme::Slf, courant, 8, Room::Open, 114),
        courant,
        114,
    );
    assert!(growth < 0.0, "{growth}");
}

#[test]
fn a_mode_that_grows_is_seen() {
    for (turn, scheme) in Scheme::ALL.into_iter().enumerate() {
        let courant = 342.0 / 600.0;
        let mut setup = setup(scheme, courant, 8, Room::Open, turn);
        setup.weights.centre += 40.0 * RESTORING_QUANTUM;
        let growth = growth(setup, courant, turn);
        assert!(growth > 1e-4, "{scheme}: {growth}");
    }
}
