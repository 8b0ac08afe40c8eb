//! The sound field of a scene at one moment after a short burst: wave fronts, echoes, and diffraction at the ends of
//! walls.

use std::path::Path;

use anyhow::Result;
use fdtd::scene::Scene;
use ndarray::ArrayView2;
use plotters::style::RGBColor;

use super::drawing::canvas;
use super::drawing::colour;
use super::drawing::layout;
use super::drawing::legend::{Entry, legend};
use super::drawing::stroke::{Marker, Stroke};
use crate::data::field_frame::FieldFrame;
use crate::data::layout::Layout;
use crate::metrics::quantile;

/// Colours of silence, and of the strongest pressure below and above.
const SHADES: [[f64; 3]; 3] = [
    [250.0, 250.0, 250.0],
    [0.0, 70.0, 140.0],
    [190.0, 70.0, 0.0],
];

/// White at zero, blue below, orange above; weak waves are lifted.
fn shade(value: f64) -> RGBColor {
    let strength = value.abs().min(1.0).powf(0.6);
    let end = if value < 0.0 { SHADES[1] } else { SHADES[2] };
    let channel = |k: usize| (SHADES[0][k] + strength * (end[k] - SHADES[0][k])).round() as u8;
    RGBColor(channel(0), channel(1), channel(2))
}

/// Draws the scene with its field `frame` at `t_s` seconds after a short burst at the start of `path`.
///
/// # Errors
/// When the scene has no such path or the picture cannot be written.
pub(crate) fn draw(
    scene: &Scene,
    path: &str,
    t_s: f64,
    frame: FieldFrame,
    picture: &Path,
) -> Result<()> {
    let FieldFrame {
        nx: columns,
        ny: rows,
        mut pressures,
        ..
    } = frame;
    let robot_m = scene.path(path)?.point_at(0.0, [0.0, 0.0]);
    let layout = Layout::of(scene);
    // The last wave fronts are weaker than the first; all are lifted by the root of their distance.
    let (dx_m, magnitude) = (scene.grid.dx_m, |value: &f32| f64::from(value.abs()));
    for (index, value) in pressures.iter_mut().enumerate() {
        let (x, y) = (
            (index % columns) as f64 + 0.5,
            (index / columns) as f64 + 0.5,
        );
        let away_m = (x * dx_m - robot_m[0]).hypot(y * dx_m - robot_m[1]);
        *value *= away_m.max(0.3).sqrt() as f32;
    }
    let sample: Vec<f64> = pressures.iter().step_by(7).map(magnitude).collect();
    let full = quantile(&sample, 0.985).max(f64::MIN_POSITIVE);
    let scaled: Vec<f32> = pressures
        .iter()
        .map(|p| (f64::from(*p) / full) as f32)
        .collect();
    // One pixel per cell of the papers' grid.
    canvas::draw(picture, 1160, 1250, |sheet| {
        let title = format!("A click among walls, {:.1} ms later", 1e3 * t_s);
        sheet.text(
            &title,
            [0.5 * sheet.width, 24.0],
            (0, 1),
            canvas::TITLE,
            true,
            false,
        )?;
        let axes = layout::axes(&layout, sheet, [120.0, 90.0, 1120.0, 1090.0]);
        let [width_m, height_m] = layout.size_m;
        let image = ArrayView2::from_shape((rows, columns), &scaled)?;
        axes.shaded(image, [[0.0, width_m], [0.0, height_m]], &shade)?;
        layout::walls(&layout, &axes, Stroke::solid(colour::BLACK, 9.0))?;
        axes.markers(
            &[(robot_m[0], robot_m[1])],
            Marker::Disc,
            34.0,
            RGBColor(255, 255, 255),
        )?;
        axes.markers(
            &[(robot_m[0], robot_m[1])],
            Marker::Disc,
            24.0,
            colour::GREEN,
        )?;
        axes.finish("")?;
        let swatch = |value: f64, text: &str| Entry {
            stroke: Some(Stroke::solid(shade(value), 22.0)),
            marker: None,
            text: text.to_string(),
        };
        let entries = [
            Entry::line(Stroke::solid(colour::BLACK, 10.0), "wall"),
            Entry {
                stroke: None,
                marker: Some((Marker::Disc, colour::GREEN)),
                text: "robot".to_string(),
            },
            swatch(0.7, "high pressure"),
            swatch(-0.7, "low pressure"),
        ];
        legend(sheet, [50.0, 1188.0], 1110.0, &entries)?;
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::shade;

    #[test]
    fn silence_is_nearly_white_and_both_signs_get_darker() {
        let luma = |value: f64| {
            let plotters::style::RGBColor(r, g, b) = shade(value);
            u32::from(r) + u32::from(g) + u32::from(b)
        };
        assert!(luma(0.0) == 750 && luma(0.5) < luma(0.1) && luma(-0.5) < luma(-0.1));
        assert_ne!(shade(0.4), shade(-0.4));
    }
}
