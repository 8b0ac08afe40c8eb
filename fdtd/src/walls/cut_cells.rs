//! Conservative cut cells: cells and faces of which walls leave a part.
//!
//! A cell keeps its exact open area, so that the air between walls is conserved and an echo comes from the wall's
//! true place (Tolan and Schneider 2003 for the wave equation; Bilbao 2013 for rooms, as a finite-volume scheme). The
//! masked second difference is `-V^-1 D' a D`, with the open areas `V` and the open parts `a` of the faces.
//!
//! Stability. All schemes need `-A` and `-B` between 0 and 4 (see [`crate::scheme::Polynomial::largest_eigenvalue`]),
//! that is `sum a (u_i - u_j)^2 <= 4 sum V_i u_i^2` along each row of cells. Every cell divides its `4 V` between its
//! two faces in proportion to their open parts; a face that gets `b_i` from one cell and `b_j` from the other
//! satisfies the inequality up to a weight of `b_i b_j / (b_i + b_j)`, which is its limit. Full cells give 2 and 2, a
//! weight of 1; a cell of area V beside a wall gives its one neighbour `4 V / (1 + 2 V)`: less than 1 below half a
//! cell, the limit of an exact analysis. Reducing the face instead of enlarging the area conserves the volume, and
//! reduces the flow towards the wall, which is small. No cells are merged, and the time step stays the same.

use super::clip::{Convex, Cover, open_area};
use super::face_weights::FaceWeights;
use super::load::{impedance_cells, loads};
use super::rasterize::SolidMask;
use super::slant::slants;
use super::wall::Wall;
use super::wall_cells::{CutCell, WallCells};
use crate::grid::Grid;
use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::TAU;

/// A cell of a smaller open area is solid: on the papers' grid the wall is then shifted by about a micrometre, and
/// the faces that it closes are less than a forty-fifth of a cell.
const LEAST_AREA: f64 = 1.0 / 4096.0;

/// Corners of the polygon that stands for a round joint, of the same area.
const JOINT_CORNERS: usize = 64;

/// The cells of a grid, cut by `walls`. Parts of walls outside the grid are left out.
pub fn cut(grid: &Grid, walls: &[Wall]) -> WallCells {
    let shapes: Vec<(usize, Convex)> = walls
        .iter()
        .enumerate()
        .flat_map(|(index, wall)| shapes(grid, wall).map(move |shape| (index, shape)))
        .collect();
    // The wall that takes a cell or a part of it, the last of several.
    let mut owners: BTreeMap<usize, usize> = BTreeMap::new();
    let mut solid = SolidMask::open(grid.nx, grid.ny);
    // Shapes that cover a part of a cell, by the cell's index.
    let mut near: BTreeMap<usize, Vec<&Convex>> = BTreeMap::new();
    for (index, shape) in &shapes {
        let range = |axis: usize, cells: usize| {
            let [low, high] = shape.bounds(axis).map(|x| x.clamp(0.0, cells as f64));
            low.floor() as usize..high.ceil() as usize
        };
        for iy in range(1, grid.ny) {
            for ix in range(0, grid.nx) {
                let cell = iy * grid.nx + ix;
                let cover = shape.covers([ix as f64, iy as f64]);
                if cover != Cover::None {
                    owners.insert(cell, *index);
                }
                match cover {
                    Cover::None => {}
                    Cover::Part => near.entry(cell).or_default().push(shape),
                    Cover::Whole => solid.cells[cell] = true,
                }
            }
        }
    }
    let place = |cell: usize| [(cell % grid.nx) as f64, (cell / grid.nx) as f64];
    let (mut areas, mut slivers) = (BTreeMap::new(), BTreeSet::new());
    for (&cell, shapes) in &near {
        if !solid.cells[cell] {
            let [x, y] = place(cell);
            let mut area = open_area(shapes, [x, y]);
            let inside = (1.0..(grid.nx - 1) as f64).contains(&x)
                && (1.0..(grid.ny - 1) as f64).contains(&y);
            if !inside {
                // The plain stencil continues to cells beyond the grid, which are whole.
                area = area.round();
            }
            if area < LEAST_AREA {
                solid.cells[cell] = true;
                slivers.extend((area > 0.0).then_some(cell));
            } else {
                areas.insert(cell, area);
            }
        }
    }
    let impedance_cells = impedance_cells(walls, &owners, &solid);
    let open = FaceWeights {
        solid: &solid,
        near: &near,
        areas: &areas,
        slivers: &slivers,
    };
    let mut partial = BTreeMap::new();
    for &cell in areas.keys() {
        let (ix, iy) = (cell % grid.nx, cell / grid.nx);
        // The cell itself, and those whose faces at lower x and y are its faces at higher.
        for (x, y) in [(ix, iy), (ix + 1, iy), (ix, iy + 1)] {
            if x < grid.nx && y < grid.ny && !solid.is_solid(x, y) {
                partial.entry(y * grid.nx + x).or_insert_with(|| CutCell {
                    area: open.area(x as isize, y as isize),
                    west: open.weight(0, x as isize, y as isize),
                    south: open.weight(1, x as isize, y as isize),
                });
            }
        }
    }
    let loads = loads(&open, grid, walls, &impedance_cells);
    let slants = slants(&open);
    WallCells::new(solid, partial)
        .with_loads(loads)
        .with_slants(slants)
}

/// The convex parts of a wall, in cells: rectangles and round joints.
fn shapes<'a>(grid: &'a Grid, wall: &'a Wall) -> impl Iterator<Item = Convex> + 'a {
    let cells = move |point_m: [f64; 2]| point_m.map(|x| x / grid.dx_m);
    let rectangles = wall
        .segments_m()
        .map(move |segment| Convex::new(wall.outline_m(segment).map(cells).to_vec()));
    let step = TAU / JOINT_CORNERS as f64;
    let radius_m = 0.5 * wall.thickness_m * (step / step.sin()).sqrt();
    let joints = wall.joints_m().map(move |joint_m| {
        let corner = |k: usize| {
            let (sin, cos) = (step * (k as f64 + 0.5)).sin_cos();
            cells([joint_m[0] + radius_m * cos, joint_m[1] + radius_m * sin])
        };
        Convex::new((0..JOINT_CORNERS).map(corner).collect())
    });
    rectangles.chain(joints)
}
