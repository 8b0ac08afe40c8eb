//! A robot drives in front of a right-angled corner: [`fdtd::validation::corner`] says layout, formula, bias and tolerance.

use fdtd::validation::corner::{CASES, corner};

#[test]
fn a_recording_in_a_corner_is_that_of_the_image_sources() {
    for (scheme, [waveform, level_db]) in CASES {
        let error = corner(scheme).expect("a finite field");
        println!("corner, {scheme}: {error:?}");
        assert!(error.waveform < waveform, "{scheme}: {error:?}");
        assert!(error.level_db.abs() < level_db, "{scheme}: {error:?}");
        assert!(error.without_corner > 0.2);
    }
}
