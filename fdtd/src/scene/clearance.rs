//! Whether the loudspeaker and the microphone keep clear of walls and of the absorbing layer on every drive.

use super::model::Scene;
use crate::error::Error;
use crate::motion::DrivePath;
use crate::walls::{Wall, WallCells, cell_centre_m};

/// Fastest drive as a part of the speed of sound.
const MAX_MACH: f64 = 0.5;

/// Follows both transducers along every path in steps of at most half a cell.
pub(super) fn check(scene: &Scene, origin: &str) -> Result<(), Error> {
    if scene.paths.is_empty() {
        return Ok(());
    }
    let cells = scene.wall_model.cells(&scene.grid, &scene.walls);
    let transducers = [
        ("loudspeaker", scene.robot.loudspeaker_offset_m),
        ("microphone", scene.robot.microphone_offset_m),
    ];
    for (name, path) in &scene.paths {
        let field = format!("paths.{name}");
        let farthest_m = transducers
            .iter()
            .map(|(_, [x, y])| x.hypot(*y))
            .fold(0.0, f64::max);
        let speed_mps = path.max_speed_mps(farthest_m);
        let fastest_mps = MAX_MACH * scene.medium.c_mps;
        if speed_mps > fastest_mps {
            let problem = format!("the robot moves at up to {speed_mps:.3} m/s");
            let remedy = format!("keep its speed (with turns) below {fastest_mps} m/s");
            return Err(Error::invalid(origin, field, problem, remedy));
        }
        for (transducer, offset_m) in transducers {
            follow(scene, &cells, path, offset_m).map_err(|(t_s, problem, remedy)| {
                let place = path
                    .point_at(t_s, offset_m)
                    .map(|coordinate_m| (coordinate_m * 1e4).round() / 1e4);
                let problem = format!("at {t_s:.3} s the {transducer} at {place:?} m {problem}");
                Error::invalid(origin, &field, problem, remedy)
            })?;
        }
    }
    Ok(())
}

/// The first time at which a transducer is too near something, the obstacle, and the remedy.
fn follow(
    scene: &Scene,
    cells: &WallCells,
    path: &DrivePath,
    offset_m: [f64; 2],
) -> Result<(), (f64, String, String)> {
    let grid = &scene.grid;
    let reach = scene.reach_cells();
    let step_s = 0.5 * grid.dx_m / path.max_speed_mps(offset_m[0].hypot(offset_m[1])).max(1e-9);
    let steps = (path.duration_s() / step_s).ceil().max(1.0) as u64;
    let layer = scene.layer_cells as f64;
    let ends = [grid.nx, grid.ny].map(|cells| cells as f64 - layer);
    let mut last_corner = None;
    for step in 0..=steps {
        let t_s = path.duration_s() * step as f64 / steps as f64;
        let corner = grid.to_cells(path.point_at(t_s, offset_m)).map(f64::floor);
        // Which cells the kernel and the scheme read depends on this cell only.
        if last_corner.replace(corner) == Some(corner) {
            continue;
        }
        let first = corner.map(|cell| cell - (reach as f64 - 1.0));
        let end = corner.map(|cell| cell + reach as f64 + 1.0);
        // Written so that NaN counts as outside.
        if !(0..2).all(|axis| first[axis] >= layer && end[axis] <= ends[axis]) {
            let problem = "is outside the domain, in the absorbing layer or within reach of it";
            let margin_m = (layer + reach as f64) * grid.dx_m;
            return Err((
                t_s,
                problem.into(),
                format!("keep it {margin_m:.4} m from the domain's edge"),
            ));
        }
        if let Some((ix, iy)) = first_touched(
            cells,
            first.map(|cell| cell as usize),
            end.map(|cell| cell as usize),
        ) {
            let centre_m = cell_centre_m(grid, ix, iy);
            // The wall that takes a part of a cell need not reach to its middle.
            let wall = [0.0, 2.0].iter().find_map(|cells| {
                scene.walls.iter().position(|wall| {
                    let thicker = Wall {
                        thickness_m: wall.thickness_m + cells * grid.dx_m,
                        ..wall.clone()
                    };
                    thicker.contains(centre_m)
                })
            });
            let problem = format!(
                "is in walls[{}] or within {reach} cells of it, the reach of {} and {}",
                wall.unwrap_or_default(),
                scene.spread.name(),
                scene.scheme
            );
            // Cells are looked at in a square: its diagonal is the distance that suffices everywhere.
            let margin_m = 1.5 * reach as f64 * grid.dx_m;
            return Err((t_s, problem, format!("keep it {margin_m:.4} m from walls")));
        }
    }
    Ok(())
}

/// The first cell of which a wall takes something with `x0 <= ix < x1` and `y0 <= iy < y1`, row by row.
fn first_touched(
    cells: &WallCells,
    [x0, y0]: [usize; 2],
    [x1, y1]: [usize; 2],
) -> Option<(usize, usize)> {
    let row = |iy| (x0..x1).map(move |ix| (ix, iy));
    (y0..y1)
        .flat_map(row)
        .find(|&(ix, iy)| cells.is_touched(ix, iy))
}
