//! The figures. Each is drawn from the data files of a results folder alone; nothing is computed by the localizer here.

pub mod animation;
pub mod drawing;
pub(crate) mod field;
pub mod inspection;
pub(crate) mod landmarks;
pub mod localization;
pub mod scene;
pub mod snapshot;
pub mod study;

mod angular_resolution;
mod dispersion;
mod dual_circle;
mod error_distribution;
mod estimated_paths;
mod landmark_bound;
mod map_image;
mod means;
mod multipath;
mod noise;
mod periods;
mod reflections;
mod roofline;
mod scene_and_map;
mod scene_echoes;
mod speeds;
mod step_time;
mod window_size;

use std::path::{Path, PathBuf};

use anyhow::Result;

/// A figure: its file name without ending, the data files it needs, and how it is drawn.
struct Figure {
    name: &'static str,
    needs: &'static [&'static str],
    draw: fn(data: &Path, picture: &Path) -> Result<()>,
}

const FIGURES: &[Figure] = &[
    Figure {
        name: "fig_dual_circle",
        needs: &["dual_circle.csv", "dual_circle_published.csv"],
        draw: dual_circle::draw,
    },
    Figure {
        name: "fig_multipath_paths",
        needs: &["multipath.csv", "multipath_drive.csv", "multipath_room.csv"],
        draw: multipath::room::paths,
    },
    Figure {
        name: "fig_multipath_errors",
        needs: &["multipath.csv", "multipath_gates.csv"],
        draw: multipath::room::errors,
    },
    Figure {
        name: "fig_multipath_scene",
        needs: &["layout.json", "drive.csv", "multipath_scene.csv"],
        draw: multipath::scene::draw,
    },
    Figure {
        name: "fig04_scene_and_map",
        needs: &["layout.json", "drive.csv", "map.npy", "map.json"],
        draw: scene_and_map::draw,
    },
    Figure {
        name: "fig05_speeds",
        needs: &["drive.csv"],
        draw: speeds::draw,
    },
    Figure {
        name: "fig06_paths",
        needs: &["layout.json", "drift_paths.csv", "drive.csv"],
        draw: estimated_paths::draw,
    },
    Figure {
        name: "fig06_cdf",
        needs: &["drift_paths.csv"],
        draw: error_distribution::draw,
    },
    Figure {
        name: "fig07_window",
        needs: &["window_size.csv"],
        draw: window_size::draw,
    },
    Figure {
        name: "fig08_reflections",
        needs: &["reflections.npy", "reflections.json", "rays.csv"],
        draw: reflections::draw,
    },
    Figure {
        name: "fig09_snr",
        needs: &["snr.csv"],
        draw: noise::draw,
    },
    Figure {
        name: "fig17_step_time",
        needs: &["step_time.csv"],
        draw: step_time::draw,
    },
    Figure {
        name: "fig_periods",
        needs: &[
            "layout.json",
            "drive.csv",
            "periods.csv",
            "periods_paths.csv",
        ],
        draw: periods::draw,
    },
    Figure {
        name: "fig_angular_resolution",
        needs: &["angular_resolution.csv", "angular_resolution_widths.csv"],
        draw: angular_resolution::draw,
    },
];

/// Figures of the experimental site, from the folder `site` in the results.
const SITE_FIGURES: &[Figure] = &[
    Figure {
        name: "fig11_scene_and_map",
        needs: &["layout.json", "drive.csv", "map.npy", "map.json"],
        draw: scene_and_map::draw,
    },
    Figure {
        name: "fig12_speeds",
        needs: &["drive.csv"],
        draw: speeds::draw,
    },
    Figure {
        name: "fig13_paths",
        needs: &["layout.json", "drift_paths.csv", "drive.csv"],
        draw: estimated_paths::draw,
    },
    Figure {
        name: "fig13_cdf",
        needs: &["drift_paths.csv"],
        draw: error_distribution::draw,
    },
    Figure {
        name: "fig14_window",
        needs: &["window_size.csv"],
        draw: window_size::draw,
    },
    Figure {
        name: "fig15_reflections",
        needs: &["reflections.npy", "reflections.json", "rays.csv"],
        draw: reflections::draw,
    },
    Figure {
        name: "fig16_snr",
        needs: &["snr.csv"],
        draw: noise::draw_site,
    },
];

/// Names of the data files that the figures are drawn from.
pub(crate) fn data_files() -> impl Iterator<Item = &'static str> {
    let figures = FIGURES.iter().chain(SITE_FIGURES);
    figures.flat_map(|figure| figure.needs.iter().copied())
}

/// Outcome of a figure.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Drawn {
    /// It was drawn into this file.
    Picture(PathBuf),
    /// It was left out because this data file is not there.
    Missing {
        /// Name of the figure.
        figure: String,
        /// The file that is missing.
        file: PathBuf,
    },
}

/// Draws every figure whose data is in `results/data` into `results/figures`, and those of the site when there is one.
///
/// # Errors
/// When a data file is damaged or a picture cannot be written.
pub fn draw_all(results: &Path) -> Result<Vec<Drawn>> {
    let place = |results: &Path, figure: &Figure| {
        results.join("figures").join(format!("{}.png", figure.name))
    };
    draw_into(results, place)
}

/// As [`draw_all`], into another folder and for a page: as SVG, but as PNG where a figure shows an image.
///
/// # Errors
/// As [`draw_all`].
pub(crate) fn draw_for_page(results: &Path, folder: &Path) -> Result<Vec<PathBuf>> {
    let place = |_: &Path, figure: &Figure| {
        let has_image = figure.needs.iter().any(|name| name.ends_with(".npy"));
        let ending = if has_image { "png" } else { "svg" };
        folder.join(format!("{}.{ending}", figure.name))
    };
    let drawn = draw_into(results, place)?.into_iter();
    let pictures = drawn.filter_map(|drawn| match drawn {
        Drawn::Picture(path) => Some(path),
        Drawn::Missing { .. } => None,
    });
    Ok(pictures.collect())
}

/// Draws all figures of a folder of results to where `place` says.
fn draw_into(results: &Path, place: impl Fn(&Path, &Figure) -> PathBuf) -> Result<Vec<Drawn>> {
    let mut drawn = draw_each(FIGURES, results, &place)?;
    let site = results.join("site");
    if site.join("data").is_dir() {
        drawn.extend(draw_each(SITE_FIGURES, &site, &place)?);
    }
    Ok(drawn)
}

/// Draws those of the figures whose data is in `results/data` to where `place` says.
fn draw_each(
    figures: &[Figure],
    results: &Path,
    place: impl Fn(&Path, &Figure) -> PathBuf,
) -> Result<Vec<Drawn>> {
    let data = results.join("data");
    figures
        .iter()
        .map(|figure| {
            let missing = figure
                .needs
                .iter()
                .map(|name| data.join(name))
                .find(|path| !path.exists());
            if let Some(file) = missing {
                let figure = figure.name.to_string();
                return Ok(Drawn::Missing { figure, file });
            }
            let picture = place(results, figure);
            (figure.draw)(&data, &picture)?;
            Ok(Drawn::Picture(picture))
        })
        .collect()
}

/// Draws what a landmark's echo is off by, from the rows of the localizer's example; `None` where there are none.
///
/// # Errors
/// When the rows are damaged or the picture cannot be written.
pub fn draw_bound(results: &Path) -> Result<Option<PathBuf>> {
    let data = results.join("data");
    if !data.join(landmark_bound::DATA).exists() {
        return Ok(None);
    }
    let picture = results.join("figures").join("landmark_bound.png");
    landmark_bound::draw(&data, &picture)?;
    Ok(Some(picture))
}

/// Draws `roofline.png` from the `bench.json` of `folder`; nothing when there is no such file.
///
/// # Errors
/// When the file is damaged or the picture cannot be written.
pub fn draw_bench(folder: &Path) -> Result<Option<PathBuf>> {
    let data = folder.join("bench.json");
    if !data.exists() {
        return Ok(None);
    }
    let picture = folder.join("roofline.png");
    roofline::draw(&data, &picture)?;
    Ok(Some(picture))
}

/// Draws the figures of the validation from `folder/data` into `folder/figures`.
///
/// # Errors
/// When the data is missing or damaged, or a picture cannot be written.
pub fn draw_validation(folder: &Path) -> Result<Vec<PathBuf>> {
    let (data, figures) = (folder.join("data"), folder.join("figures"));
    let pictures = ["fig_dispersion.png", "fig_scene_echoes.png"].map(|name| figures.join(name));
    dispersion::draw(&data, &pictures[0])?;
    scene_echoes::draw(&data, &pictures[1])?;
    Ok(pictures.to_vec())
}
