//! A rigid cylinder and a round room: [`oracles::laws::round`] says layout, formula, bias and tolerance.

use fdtd::walls::WallModel;
use oracles::laws::round::{DETUNING, MODES, ROUND, SCHEMES, detuned, largest, setting};

#[test]
fn a_cylinder_echoes_and_shades_as_its_series_says() {
    for scheme in SCHEMES {
        for (round_deg, allowed) in ROUND {
            let setting = setting(scheme, &format!("{round_deg} degrees"));
            let error = largest(&setting, scheme, WallModel::CutCells, round_deg);
            let error = error.expect("a finite field");
            println!(
                "cylinder, {scheme}, {round_deg} degrees round, {setting}: level in dB, delay in s {error:?}"
            );
            for (error, allowed) in error.into_iter().zip(allowed) {
                assert!(
                    error.abs() < allowed,
                    "{scheme}, {round_deg} degrees round, {setting}: {error}"
                );
            }
        }
    }
}

#[test]
fn standing_waves_of_a_round_room_have_their_frequencies() {
    for scheme in SCHEMES {
        for mode in MODES {
            let setting = setting(scheme, &format!("mode {} {}", mode.0, mode.1));
            let error = detuned(&setting, scheme, WallModel::CutCells, mode);
            println!("round room, {scheme}, mode {mode:?}, {setting}: {error:+.1e}");
            assert!(
                error.abs() < DETUNING,
                "{scheme}, {mode:?}, {setting}: {error}"
            );
        }
    }
    // Sensitivity of the test: stairs have larger errors.
    let stairs = MODES.map(|mode| {
        let setting = setting(SCHEMES[1], &format!("mode {} {}", mode.0, mode.1));
        detuned(&setting, SCHEMES[1], WallModel::Staircase, mode).abs()
    });
    assert!(
        stairs.into_iter().fold(0.0, f64::max) > 3.0 * DETUNING,
        "{stairs:?}"
    );
}
