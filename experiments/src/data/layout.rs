//! Walls and size of a scene as figures need them: `layout.json`.

use std::path::Path;

use anyhow::Result;
use fdtd::scene::Scene;
use serde::{Deserialize, Serialize};

use super::{atomic, json};

/// Walls and size of a scene.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Layout {
    /// Name of the scene.
    pub name: String,
    /// Width and height of the domain, metres.
    pub size_m: [f64; 2],
    /// Thickness of the absorbing layer on each side, metres.
    pub layer_m: f64,
    /// Walls.
    pub walls: Vec<LayoutWall>,
}

/// A wall of a [`Layout`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LayoutWall {
    /// Corners of the centre line, metres.
    pub points_m: Vec<[f64; 2]>,
    /// Thickness, metres.
    pub thickness_m: f64,
}

impl Layout {
    /// The layout of a scene.
    pub fn of(scene: &Scene) -> Self {
        Self {
            name: scene.name.clone(),
            size_m: scene.grid.size_m(),
            layer_m: scene.layer_cells as f64 * scene.grid.dx_m,
            walls: scene
                .walls
                .iter()
                .map(|wall| LayoutWall {
                    points_m: wall.points_m.clone(),
                    thickness_m: wall.thickness_m,
                })
                .collect(),
        }
    }

    /// Reads `layout.json` of a data folder.
    ///
    /// # Errors
    /// When the file cannot be read or holds something else.
    pub fn read(data: &Path) -> Result<Self> {
        json::read(&data.join("layout.json"))
    }

    /// Writes it, indented.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<()> {
        let mut text = serde_json::to_string_pretty(self)?;
        text.push('\n');
        atomic::write(path, text.as_bytes())
    }
}
