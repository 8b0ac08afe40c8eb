//! A picture of the pressure field at one time, with walls and robot.

use std::path::{Path, PathBuf};

use anyhow::Result;
use fdtd::scene::Scene;
use fdtd::walls::rasterize;

use super::drawing::png::write_png;
use crate::data::field_frame::FieldFrame;
use crate::metrics::quantile;

/// Draws a frame of the drive `path` into `folder`; the file name holds the time in microseconds. Red is pressure
/// above, blue below the mean; the scale is the frame's own. A drive in free field has a domain of its own, without
/// walls.
///
/// # Errors
/// When the scene has no such path or the picture cannot be written.
pub fn draw(scene: &Scene, path: &str, frame: &FieldFrame, folder: &Path) -> Result<PathBuf> {
    let FieldFrame {
        t_s,
        nx,
        ny,
        ref pressures,
        ..
    } = *frame;
    let magnitudes: Vec<f64> = pressures
        .iter()
        .step_by(17)
        .map(|value| f64::from(value.abs()))
        .collect();
    let full = quantile(&magnitudes, 0.995).max(f64::MIN_POSITIVE);
    let whole = [nx, ny] == [scene.grid.nx, scene.grid.ny];
    let solid = rasterize(&scene.grid, if whole { &scene.walls } else { &[] });
    let [x, y] = scene.path(path)?.point_at(t_s, [0.0, 0.0]);
    let from_origin = [x - frame.origin_m[0], y - frame.origin_m[1]];
    let robot = scene.grid.to_cells(from_origin);
    let mut pixels = Vec::with_capacity(3 * nx * ny);
    for iy in (0..ny).rev() {
        for ix in 0..nx {
            let index = iy * nx + ix;
            let distance = (ix as f64 - robot[0]).hypot(iy as f64 - robot[1]);
            pixels.extend(if whole && solid.cells.get(index) == Some(&true) {
                [0, 0, 0]
            } else if distance < 5.0 {
                [0, 158, 115]
            } else {
                shade(f64::from(pressures[index]) / full)
            });
        }
    }
    let picture = folder.join(format!("pressure_{:09.0}us.png", t_s * 1e6));
    write_png(&picture, nx as u32, ny as u32, &pixels)?;
    Ok(picture)
}

/// Blue below zero, white at zero, red above.
fn shade(value: f64) -> [u8; 3] {
    let strength = value.abs().min(1.0).sqrt();
    let end = if value > 0.0 {
        [178.0, 34.0, 24.0]
    } else {
        [20.0, 80.0, 160.0]
    };
    end.map(|channel| (255.0 + strength * (channel - 255.0)).round() as u8)
}

#[cfg(test)]
mod tests {
    use super::shade;

    #[test]
    fn silence_is_white_and_signs_differ() {
        assert_eq!(shade(0.0), [255, 255, 255]);
        assert_ne!(shade(0.5), shade(-0.5));
        assert_eq!(shade(7.0), shade(1.0));
    }
}
