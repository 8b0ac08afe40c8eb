//! Walls as cells: thickness, place, tightness; what cut cells keep.

use fdtd::grid::Grid;
use fdtd::scheme::Scheme;
use fdtd::walls::operator::WallOperator;
use fdtd::walls::{SolidMask, Wall, WallCells, cell_at, cell_centre_m, cut, rasterize};

const GRID: Grid = Grid {
    nx: 120,
    ny: 120,
    dx_m: 0.005,
    dt_s: 8e-6,
};

/// Whether a king's walk over open cells leads from `from` to the grid's corner.
fn leaks(mask: &SolidMask, from: (usize, usize)) -> bool {
    let mut seen = mask.cells.clone();
    let mut stack = vec![from];
    while let Some((ix, iy)) = stack.pop() {
        if ix == 0 && iy == 0 {
            return true;
        }
        for y in iy.saturating_sub(1)..(iy + 2).min(mask.ny) {
            for x in ix.saturating_sub(1)..(ix + 2).min(mask.nx) {
                if !std::mem::replace(&mut seen[y * mask.nx + x], true) {
                    stack.push((x, y));
                }
            }
        }
    }
    false
}

#[test]
fn a_wall_on_the_grid_has_the_cells_of_its_size() {
    // From x = 0.1 to 0.3 m at y = 0.2 m, 4 cells thick: 40 x 4 cells whose faces are the wall's.
    let wall = Wall {
        points_m: vec![[0.1, 0.2], [0.3, 0.2]],
        thickness_m: 0.02,
        impedance: None,
    };
    let mask = rasterize(&GRID, &[wall]);
    assert_eq!(mask.solid_cells(), 160);
    assert!(
        mask.iter_solid()
            .all(|(ix, iy)| (20..60).contains(&ix) && (38..42).contains(&iy))
    );
    let column = Wall {
        points_m: vec![[0.2, 0.3], [0.2, 0.1]],
        thickness_m: 0.02,
        impedance: None,
    };
    assert_eq!(rasterize(&GRID, &[column]).solid_cells(), 160);
}

#[test]
fn closed_walls_are_tight_at_any_angle_and_minimal_thickness() {
    for corners in 3..9 {
        for turn in 0..40 {
            let mut points_m: Vec<[f64; 2]> = (0..corners)
                .map(|corner| {
                    let angle = f64::from(turn) * 0.041
                        + std::f64::consts::TAU * f64::from(corner) / f64::from(corners);
                    [
                        0.3 + 0.001 * f64::from(turn) + 0.2 * angle.cos(),
                        0.3 + 0.2 * angle.sin(),
                    ]
                })
                .collect();
            points_m.push(points_m[0]);
            let closed = Wall {
                points_m: points_m.clone(),
                thickness_m: 0.01,
                impedance: None,
            };
            assert!(
                !leaks(&rasterize(&GRID, &[closed]), (60, 60)),
                "{corners} corners, turn {turn}"
            );
            // Without its last segment it leaks.
            points_m.pop();
            let open = Wall {
                points_m,
                thickness_m: 0.01,
                impedance: None,
            };
            assert!(leaks(&rasterize(&GRID, &[open]), (60, 60)));
        }
    }
}

#[test]
fn the_area_of_a_slanted_wall_is_right() {
    for degrees in [3.0_f64, 10.0, 30.0, 41.0] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let wall = Wall {
            points_m: vec![[0.1, 0.1], [0.1 + 0.4 * cos, 0.1 + 0.4 * sin]],
            thickness_m: 0.02,
            impedance: None,
        };
        let area = rasterize(&GRID, &[wall]).solid_cells() as f64 * 2.5e-5;
        assert!((area - 0.008).abs() < 2.5e-4, "{area}");
    }
}

#[test]
fn walls_beyond_the_grid_are_cut_and_cells_found_again() {
    let wall = Wall {
        points_m: vec![[-1.0, 0.2], [9.0, 0.2]],
        thickness_m: 0.02,
        impedance: None,
    };
    assert_eq!(rasterize(&GRID, &[wall]).solid_cells(), 480);
    let far = Wall {
        points_m: vec![[-1e9, -5.0], [1e9, -5.0]],
        thickness_m: 0.02,
        impedance: None,
    };
    assert_eq!(rasterize(&GRID, &[far]).solid_cells(), 0);
    for (ix, iy) in [(0, 0), (119, 3), (57, 119)] {
        assert_eq!(cell_at(&GRID, cell_centre_m(&GRID, ix, iy)), Some((ix, iy)));
    }
    assert_eq!(cell_at(&GRID, [0.6, 0.1]), None);
    assert_eq!(cell_at(&GRID, [f64::NAN, 0.1]), None);
}

#[test]
fn lengths_and_joints() {
    let open = Wall {
        points_m: vec![[0.0, 0.0], [3.0, 0.0], [3.0, 4.0]],
        thickness_m: 0.02,
        impedance: None,
    };
    assert_eq!(open.length_m(), 7.0);
    assert_eq!(open.joints_m().collect::<Vec<_>>(), vec![[3.0, 0.0]]);
    let closed = Wall {
        points_m: vec![[0.0, 0.0], [3.0, 0.0], [3.0, 4.0], [0.0, 0.0]],
        thickness_m: 0.02,
        impedance: None,
    };
    assert_eq!(closed.joints_m().count(), 3);
    assert!(closed.contains([0.0, 0.005]) && !closed.contains([1.0, 1.0]));
}

/// Area in square metres that walls take.
fn taken_m2(cells: &WallCells) -> f64 {
    let open: f64 = cells.areas().iter().sum();
    (GRID.cells() as f64 - open) * GRID.dx_m * GRID.dx_m
}

#[test]
fn along_the_axes_on_cell_borders_both_models_are_the_same() {
    let walls = [
        Wall {
            points_m: vec![[0.1, 0.2], [0.3, 0.2]],
            thickness_m: 0.02,
            impedance: None,
        },
        Wall {
            points_m: vec![[0.45, 0.5], [0.45, 0.095]],
            thickness_m: 0.03,
            impedance: None,
        },
        // Across the first.
        Wall {
            points_m: vec![[0.2, 0.1], [0.2, 0.4]],
            thickness_m: 0.02,
            impedance: None,
        },
    ];
    let (cut, stairs) = (cut(&GRID, &walls), rasterize(&GRID, &walls).into());
    assert_eq!(cut, stairs);
    for scheme in Scheme::ALL {
        let weights = scheme.weights(0.5667);
        let polynomial = scheme.polynomial(0.5667);
        let rows = |cells| WallOperator::new(cells, &weights, &polynomial, scheme.radius());
        assert_eq!(rows(&cut), rows(&stairs), "{scheme}");
    }
}

#[test]
fn cut_cells_keep_the_area_of_the_air() {
    for degrees in [3.0_f64, 10.0, 30.0, 41.0, 45.0] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let at = |along: f64| [0.1 + along * cos, 0.1 + along * sin];
        let wall = |from, to, thickness_m| Wall {
            points_m: vec![at(from), at(to)],
            thickness_m,
            impedance: None,
        };
        let whole = [wall(0.0, 0.4, 0.02)];
        // The same place in two walls that overlap, and a thinner one within them.
        let parts = [
            wall(0.0, 0.3, 0.02),
            wall(0.2, 0.4, 0.02),
            wall(0.1, 0.35, 0.012),
        ];
        for walls in [&whole[..], &parts[..]] {
            let taken_m2 = taken_m2(&cut(&GRID, walls));
            // Only cells with less than a 256th of air are closed.
            assert!((taken_m2 - 0.008).abs() < 1e-6, "{degrees}: {taken_m2}");
        }
    }
    let bent = Wall {
        points_m: vec![[0.1, 0.3], [0.3, 0.34], [0.42, 0.2]],
        thickness_m: 0.02,
        impedance: None,
    };
    // Two rectangles and the round joint, less what they share: a kite on the inner side, and half of the disc.
    let turn = (0.12_f64.atan2(0.14) + 0.2_f64.atan2(0.04)) - std::f64::consts::PI;
    let turn = turn.abs();
    let expected_m2 = 0.02 * bent.length_m() + 1e-4 * (0.5 * turn - (0.5 * turn).tan());
    let taken_m2 = taken_m2(&cut(&GRID, &[bent]));
    assert!(
        (taken_m2 - expected_m2).abs() < 2e-6,
        "{taken_m2} {expected_m2}"
    );
}

#[test]
fn faces_of_cut_cells_keep_the_spectrum_and_rows_sum_to_zero() {
    let points_m = vec![
        [0.1, 0.1],
        [0.5, 0.185],
        [0.4, 0.5],
        [0.11, 0.47],
        [0.1, 0.1],
    ];
    let wall = Wall {
        points_m,
        thickness_m: 0.011,
        impedance: None,
    };
    let cells = cut(&GRID, &[wall]);
    for (cell, cut) in cells.partial() {
        assert!((1.0 / 4096.0..=1.0).contains(&cut.area), "{cell}: {cut:?}");
        for face in [cut.west, cut.south] {
            assert!((0.0..=1.0).contains(&face) && face <= 4.0 * cut.area);
        }
    }
    for scheme in Scheme::ALL {
        let weights = scheme.weights(0.5667);
        let polynomial = scheme.polynomial(0.5667);
        let operator = WallOperator::new(&cells, &weights, &polynomial, scheme.radius());
        let solid = |ix: usize, iy: usize| cells.solid().is_solid(ix, iy);
        // The corrections bring back what the plain stencil loses to solid cells.
        let plain = |dx: isize, dy: isize| match (dx.abs().min(dy.abs()), dx.abs().max(dy.abs())) {
            (0, 1) => weights.edge,
            (1, 1) => weights.corner,
            (0, 2) => weights.far,
            (1, 2) => weights.knight,
            (0, 3) => weights.outer,
            _ => 0.0,
        };
        for (iy, row) in operator.corrections.iter().enumerate() {
            for correction in row {
                let mut sum: f64 = correction.entries.iter().map(|e| f64::from(e.2)).sum();
                for dy in -3..=3_isize {
                    for dx in -3..=3_isize {
                        let place = |at: usize, by: isize| (at as isize + by) as usize;
                        if solid(place(correction.ix, dx), place(iy, dy)) {
                            sum -= f64::from(plain(dx, dy));
                        }
                    }
                }
                assert_eq!(sum, 0.0, "{scheme}: cell {} {iy}", correction.ix);
            }
        }
    }
}
