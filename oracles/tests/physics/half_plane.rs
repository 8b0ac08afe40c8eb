//! Diffraction at the edge of a rigid half plane in the light, at the shadow's border and in deep shadow:
//! [`oracles::laws::half_plane`] says layout, formula, bias and tolerance.

use crate::rig::assert_within;
use fdtd::scheme::Scheme;
use oracles::laws::Depth;
use oracles::laws::half_plane::{half_plane, measure};
use oracles::laws::setting::Setting;

#[test]
fn sound_bends_round_an_edge_as_sommerfeld_says() {
    assert_within("half plane", &measure(Depth::Full).expect("finite fields"));
}

#[test]
fn what_is_left_is_the_walls_thickness() {
    let setting = Setting::drawn("half plane", "thickness");
    let error = |times| half_plane(&setting, Scheme::M13, 340.0, times).expect("a finite field");
    let [thick, thin] = [1, 2].map(error);
    println!("half plane, 340 degrees, {setting}: {thick:?}, thickness halved {thin:?}");
    assert!(thin.waveform < 0.65 * thick.waveform);
    assert!(thick.naive > 2.5 * thick.waveform);
}
