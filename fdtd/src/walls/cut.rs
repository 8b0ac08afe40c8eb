//! Conservative cut cells: walls leave parts of cells and faces.
//!
//! A cell keeps its exact open area, so the air between walls is conserved and an echo comes from where the wall is (Tolan and
//! Schneider 2003 for the wave equation; Bilbao 2013 for rooms, as a finite-volume scheme). The masked second difference is `-V^-1 D' a D`,
//! with the open areas `V` and the open parts `a` of the faces.
//!
//! What the step allows. All schemes rely on `-A` and `-B` between 0 and 4 (see [`crate::scheme::Polynomial::largest_eigenvalue`]).
//! That is `sum a (u_i - u_j)^2 <= 4 sum V_i u_i^2` along each row of cells. Every cell shares its `4 V` out between its two faces, in
//! proportion to their open parts; a face that gets `b_i` from one cell and `b_j` from the other keeps the inequality up to a weight
//! of `b_i b_j / (b_i + b_j)`, and is given no more. Full cells give 2 and 2, which is a weight of 1; a cell of
//! area V beside a wall gives its one neighbour `4 V / (1 + 2 V)`: less than 1 below half a cell, the limit of an exact analysis.
//! Taking from the face and not giving to the area keeps the volume, and takes where the flow is small anyway: towards the wall.
//! No cell has to be merged with another, and the time step stays as it is.

use super::clip::{Convex, Cover, open_area};
use super::faces::{Openings, soft_cells};
use super::slant::slants;
use super::{Opening, SolidMask, Wall, WallCells};
use crate::grid::Grid;
use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::TAU;

/// A cell with less air than this is solid: what it held is a shift of the wall by about a micrometre on the papers' grid, and the faces that it
/// closes are less than a forty-fifth of a cell (with a 256th, walls of an impedance along the diagonal were 0.07 off where they dropped such cells).
const LEAST_AREA: f64 = 1.0 / 4096.0;

/// Corners of the polygon that stands for a round joint, of the same area.
const JOINT_CORNERS: usize = 64;

/// What `walls` leave of the cells of a grid. Parts of walls outside the grid are left out.
pub fn cut(grid: &Grid, walls: &[Wall]) -> WallCells {
    let shapes: Vec<(usize, Convex)> = walls
        .iter()
        .enumerate()
        .flat_map(|(index, wall)| shapes(grid, wall).map(move |shape| (index, shape)))
        .collect();
    // The wall that takes a cell or a part of it; the last of several.
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
                // The plain stencil has whole cells beyond the grid, and goes on to them.
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
    let soft = soft_cells(walls, &owners, &solid);
    let open = Openings {
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
                partial.entry(y * grid.nx + x).or_insert_with(|| Opening {
                    area: open.area(x as isize, y as isize),
                    west: open.weight(0, x as isize, y as isize),
                    south: open.weight(1, x as isize, y as isize),
                });
            }
        }
    }
    let loads = open.loads(grid, walls, &soft);
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
