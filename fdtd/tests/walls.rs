//! Rasterized walls: thickness, place, tightness.

use fdtd::grid::Grid;
use fdtd::walls::{SolidMask, Wall, cell_at, cell_centre_m, rasterize};

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
    };
    assert_eq!(rasterize(&GRID, &[wall]).solid_cells(), 480);
    let far = Wall {
        points_m: vec![[-1e9, -5.0], [1e9, -5.0]],
        thickness_m: 0.02,
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
    };
    assert_eq!(open.length_m(), 7.0);
    assert_eq!(open.joints_m().collect::<Vec<_>>(), vec![[3.0, 0.0]]);
    let closed = Wall {
        points_m: vec![[0.0, 0.0], [3.0, 0.0], [3.0, 4.0], [0.0, 0.0]],
        thickness_m: 0.02,
    };
    assert_eq!(closed.joints_m().count(), 3);
    assert!(closed.contains([0.0, 0.005]) && !closed.contains([1.0, 1.0]));
}
