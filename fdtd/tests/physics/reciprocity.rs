//! Source and microphone may change places.
//!
//! Layout: 1.2 m x 1.2 m with slanted and bent rigid walls between the two; a broad burst; off the cells' centres.
//! Formula: `p(a -> b) = p(b -> a)`.
//! Bias: none between the walls, the operator is symmetric; the layer is not exactly reciprocal, but its echoes are below -60 dB. Rounding of the
//! fields makes a slow wandering far below the band (some 1e-4 of the signal in these 17 ms), hence single frequencies are compared.
//! Tolerance: 1e-4 of the strongest line at 3 to 13 kHz.

use crate::rig::{Rig, difference, line};
use fdtd::exact::burst::Burst;
use fdtd::scheme::Scheme;
use fdtd::spread::Spread;

#[test]
fn source_and_microphone_change_places() {
    for scheme in Scheme::ALL {
        for spread in Spread::ALL {
            let mut rig = Rig::open(scheme, 240, 240).with_walls(|ix, iy| {
                let slanted =
                    (ix as f64 - 0.3 * iy as f64 - 80.0).abs() < 3.0 && (40..180).contains(&iy);
                let hook = ((190..194).contains(&iy) && (60..200).contains(&ix))
                    || ((150..154).contains(&ix) && (150..194).contains(&iy));
                slanted || hook
            });
            rig.spread = spread;
            let burst = Burst::from_zero(8e3, 2500.0);
            let strength = |t_s: f64| burst.value(t_s);
            let (here, there) = (|_: f64| [0.3512, 0.5033], |_: f64| [0.8777, 0.6841]);
            let forth = rig.run(&here, &there, &strength, 2000);
            let back = rig.run(&there, &here, &strength, 2000);
            let lines =
                |signal: &[f64]| [3e3, 5e3, 7e3, 9e3, 11e3, 13e3].map(|f| line(signal, f).norm());
            let strongest = lines(&forth).into_iter().fold(0.0, f64::max);
            let error = lines(&difference(&forth, &back))
                .into_iter()
                .fold(0.0, f64::max)
                / strongest;
            println!("reciprocity, {scheme}, {spread}: {error:.1e}");
            assert!(
                strongest > 0.0 && error < 1e-4,
                "{scheme}, {spread}: {error}"
            );
        }
    }
}
