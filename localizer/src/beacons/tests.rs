//! Against exact geometry (tolerance 1 um to 1 mm where circles nearly touch), a grid search and refused geometry.

use proptest::prelude::*;

use super::receivers::{cross, minus};
use super::*;
use crate::error::Error;

const SQUARE: [[f64; 2]; 4] = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]];

fn ranges(receivers: &[[f64; 2]], point: [f64; 2]) -> Vec<f64> {
    receivers
        .iter()
        .map(|receiver| (point[0] - receiver[0]).hypot(point[1] - receiver[1]))
        .collect()
}

fn apart(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

#[test]
fn all_methods_find_the_nine_points_of_the_table() {
    let beacons = Beacons::new(&SQUARE).unwrap();
    for point in [1.0, 2.0, 3.0]
        .map(|y| [1.0, 2.0, 3.0].map(|x| [x, y]))
        .concat()
    {
        let ranges = ranges(&SQUARE, point);
        for a in 0..4 {
            for b in (0..4).filter(|b| *b != a) {
                let found = beacons.dual_circle(&ranges, [a, b]).unwrap();
                assert!(apart(found, point) < 1e-5, "{a} {b} {found:?} {point:?}");
            }
        }
        assert!(apart(beacons.triangulate(&ranges).unwrap(), point) < 1e-9);
        let fix = beacons.least_squares(&ranges, 0.01).unwrap();
        assert!(apart(fix.position_m, point) < 1e-7 && fix.residual_m < 1e-6);
    }
    // At the centre J^T J is twice the identity.
    let fix = beacons
        .least_squares(&ranges(&SQUARE, [2.0, 2.0]), 0.01)
        .unwrap();
    assert!((fix.covariance_m2[0][0] - 0.5e-4).abs() < 1e-9);
    assert!(fix.covariance_m2[0][1].abs() < 1e-9);
}

#[test]
fn least_squares_are_no_worse_than_a_grid_search() {
    let beacons = Beacons::new(&SQUARE).unwrap();
    let mut noisy = ranges(&SQUARE, [1.3, 2.9]);
    for (range, error) in noisy.iter_mut().zip([0.03, -0.05, 0.02, 0.04]) {
        *range += error;
    }
    let found = beacons.least_squares(&noisy, 0.01).unwrap().position_m;
    let grid = (0..801).flat_map(|i| (0..801).map(move |j| [i, j].map(|k| 0.005 * f64::from(k))));
    let oracle = beacons.best(&noisy, grid).unwrap();
    assert!(beacons.misfit(&noisy, found) <= beacons.misfit(&noisy, oracle));
    assert!(apart(found, oracle) < 0.005, "{found:?} {oracle:?}");
}

#[test]
fn degenerate_geometry_and_bad_numbers_are_refused() {
    let degenerate = |error: Error| matches!(error, Error::Degenerate { .. });
    let line = [[0.0, 0.0], [1.0, 1.0], [3.0, 3.0]];
    assert!(degenerate(Beacons::new(&line).unwrap_err()));
    assert!(degenerate(Beacons::new(&SQUARE[..2]).unwrap_err()));
    let twice = [[0.0, 0.0], [0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
    assert!(degenerate(Beacons::new(&twice).unwrap_err()));
    let invalid = |error: Error| matches!(error, Error::Invalid { .. });
    assert!(invalid(Beacons::new(&[[f64::NAN, 0.0]; 3]).unwrap_err()));
    let beacons = Beacons::new(&SQUARE).unwrap();
    let short = [0.5; 4];
    assert!(degenerate(beacons.dual_circle(&short, [0, 1]).unwrap_err()));
    assert!(degenerate(beacons.triangulate(&short).unwrap_err()));
    assert!(degenerate(beacons.least_squares(&short, 0.01).unwrap_err()));
    let inside = intersections([0.0, 0.0], 5.0, [1.0, 0.0], 1.0);
    assert!(degenerate(inside.unwrap_err()));
    assert!(degenerate(
        intersections([1.0; 2], 1.0, [1.0; 2], 1.0).unwrap_err()
    ));
    assert!(invalid(
        beacons
            .triangulate(&[1.0, f64::INFINITY, 1.0, 1.0])
            .unwrap_err()
    ));
    assert!(invalid(
        beacons.least_squares(&[2.8; 4], f64::NAN).unwrap_err()
    ));
    assert!(invalid(beacons.dual_circle(&[2.8; 4], [0, 4]).unwrap_err()));
    assert!(invalid(beacons.triangulate(&[2.8; 3]).unwrap_err()));
}

proptest! {
    #[test]
    fn random_geometry_is_recovered(
        corners in prop::array::uniform3(prop::array::uniform2(-5.0..5.0_f64)),
        point in prop::array::uniform2(-5.0..5.0_f64),
    ) {
        let [a, b, c] = corners;
        // Three receivers well apart and well off each other's lines, as seen from each other and from the point.
        prop_assume!(cross(minus(b, a), minus(c, a)).abs() > 4.0);
        prop_assume!(cross(minus(a, point), minus(b, point)).abs() > 1.0);
        prop_assume!(cross(minus(b, point), minus(c, point)).abs() > 1.0);
        let beacons = Beacons::new(&corners).unwrap();
        let ranges = ranges(&corners, point);
        prop_assert!(apart(beacons.dual_circle(&ranges, [0, 1]).unwrap(), point) < 1e-6);
        prop_assert!(apart(beacons.triangulate(&ranges).unwrap(), point) < 1e-6);
        prop_assert!(apart(beacons.least_squares(&ranges, 0.01).unwrap().position_m, point) < 1e-6);
    }
}
