//! A picture of a scene: walls, drive paths and absorbing layer.

use std::path::Path;

use anyhow::Result;
use fdtd::scene::Scene;

use super::drawing::canvas;
use super::drawing::colour;
use super::drawing::layout::{self, path};
use super::drawing::legend::{Entry, legend};
use super::drawing::stroke::Stroke;
use crate::data::layout::Layout;

/// Spacing of the drawn points of a path, seconds.
const STEP_S: f64 = 0.05;

const STROKES: [Stroke; 6] = [
    Stroke::solid(colour::BLUE, 5.0),
    Stroke::solid(colour::GREEN, 3.5).dashed(&[16.0, 8.0]),
    Stroke::solid(colour::VERMILLION, 4.0).dashed(&[6.0, 8.0]),
    Stroke::solid(colour::PURPLE, 4.0).dashed(&[22.0, 9.0, 5.0, 9.0]),
    Stroke::solid(colour::ORANGE, 3.5),
    Stroke::solid(colour::BLACK, 3.5).dashed(&[9.0, 7.0]),
];

/// Draws the scene.
///
/// # Errors
/// When the picture cannot be written.
pub fn draw(scene: &Scene, picture: &Path) -> Result<()> {
    let layout = Layout::of(scene);
    let of_kind = |absorbing: bool| {
        let mut own = layout.clone();
        let walls = scene.walls.iter().zip(&layout.walls);
        own.walls = walls
            .filter(|(wall, _)| wall.impedance.is_some() == absorbing)
            .map(|(_, wall)| wall.clone())
            .collect();
        own
    };
    let [rigid, soft] = [false, true].map(of_kind);
    canvas::draw(picture, 1600, 1100, |sheet| {
        let axes = layout::axes(&layout, sheet, [120.0, 80.0, 1030.0, 990.0]);
        axes.grid()?;
        layout::layer(&layout, &axes)?;
        layout::walls(&rigid, &axes, Stroke::solid(colour::BLACK, 7.0))?;
        layout::walls(&soft, &axes, Stroke::solid(colour::PURPLE, 7.0))?;
        let kinds = [
            (&rigid, colour::BLACK, "rigid wall"),
            (&soft, colour::PURPLE, "absorbing wall"),
        ];
        let mut entries: Vec<Entry> = kinds
            .into_iter()
            .filter(|(layout, ..)| !layout.walls.is_empty())
            .map(|(_, colour, name)| Entry::line(Stroke::solid(colour, 8.0), name))
            .collect();
        entries.push(Entry::line(
            Stroke::solid(colour::SKY, 26.0).faint(0.35),
            "absorbing layer",
        ));
        for (index, (name, drive)) in scene.paths.iter().enumerate() {
            let stroke = STROKES[index % STROKES.len()];
            let steps = (drive.duration_s() / STEP_S).ceil() as usize;
            let points: Vec<(f64, f64)> = (0..=steps)
                .map(|step| drive.point_at(step as f64 * STEP_S, [0.0, 0.0]))
                .map(|[x, y]| (x, y))
                .collect();
            path(&axes, &points, stroke)?;
            entries.push(Entry::line(
                stroke,
                &format!("{name}, {:.0} s", drive.duration_s()),
            ));
        }
        axes.finish(&scene.name)?;
        let mut y = 110.0;
        for entry in entries {
            y += legend(sheet, [1080.0, y], 500.0, &[entry])? + 10.0;
        }
        sheet.text(
            "\u{25cf} start   \u{25a0} end",
            [1080.0, y + 26.0],
            (1, 0),
            28.0,
            false,
            false,
        )
    })
}
