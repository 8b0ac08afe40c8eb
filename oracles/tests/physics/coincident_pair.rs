//! The direct wave between a loudspeaker and a microphone at the same point must not depend on the place in the cell:
//! the direct wave of a moving pair would flicker as fast as it crosses cells, right in the band of the echoes' Doppler
//! shifts.
//!
//! Layout: free field of 0.5 m x 0.5 m with a layer on all sides; a burst at 10 kHz, 16 places of the resting pair in a
//! cell not far from the middle.
//! Formula: free field is the same everywhere.
//! Bias: a kernel that passes the grid's shortest waves aliases there (a sinc at the full bandwidth: -25 dB).
//! Tolerance: the deviation from the mean over the places, rms, below -50 dB of that mean (kaiser12, every scheme). The
//! others are printed beside it.

use crate::rig::{Rig, Setting, decibels, difference, norm};
use fdtd::scheme::Scheme;
use fdtd::spread::Spread;

#[test]
fn the_direct_wave_does_not_depend_on_the_place_in_the_cell() {
    for scheme in Scheme::ALL {
        for spread in Spread::ALL {
            let setting = Setting::drawn("coincident pair", &format!("{scheme}, {spread}"));
            let conditions = &setting.conditions;
            let burst = conditions.burst(1e4, 1500.0);
            let strength = |t_s: f64| burst.value(t_s);
            let steps = conditions.steps(240);
            let part_m = |part: u32| 0.25 * f64::from(part) * conditions.dx_m;
            let places: Vec<[f64; 2]> = (0..16).map(|k| [k % 4, k / 4].map(part_m)).collect();
            let mut rig = Rig::open(&setting, scheme, 100, 100);
            rig.spread = spread;
            let middle_m = setting.between([[0.2, 0.3], [0.2, 0.3]]);
            let cell = middle_m.map(|x| (x / conditions.dx_m) as usize);
            let recorded: Vec<Vec<f64>> = places
                .iter()
                .map(|place| {
                    let [x, y] = rig.centre_m(cell[0], cell[1]);
                    let point = move |_| [x + place[0], y + place[1]];
                    rig.run(&point, &point, &strength, steps)
                        .expect("a finite field")
                })
                .collect();
            let mean: Vec<f64> = (0..steps)
                .map(|n| recorded.iter().map(|signal| signal[n]).sum::<f64>() / 16.0)
                .collect();
            let deviation = recorded
                .iter()
                .map(|signal| norm(&difference(signal, &mean)).powi(2) / 16.0)
                .sum::<f64>()
                .sqrt();
            let level_db = decibels(deviation / norm(&mean));
            println!("coincident pair, {scheme}, {spread}, {setting}: {level_db:.1} dB");
            if spread == Spread::Kaiser12 {
                assert!(level_db < -50.0, "{scheme}, {setting}: {level_db} dB");
            }
        }
    }
}
