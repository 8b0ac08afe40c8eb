//! Roofline of the field engines: arithmetic over intensity, with the machine's measured roofs.

use std::path::Path;

use anyhow::Result;
use plotters::style::RGBColor;
use serde::Deserialize;

use super::drawing::axes::Axes;
use super::drawing::axis::Axis;
use super::drawing::canvas::{self, Canvas, LABEL};
use super::drawing::colour;
use super::drawing::legend::{Entry, legend};
use super::drawing::stroke::{Marker, Stroke};
use crate::data::json;
use crate::data::peaks::Peaks;

/// The fields of a row of `bench.json` that the figure uses.
#[derive(Debug, Clone, Deserialize)]
struct Row {
    engine: String,
    scheme: String,
    nx: usize,
    ny: usize,
    threads: usize,
    gcells_per_s: f64,
    flops_per_cell: f64,
    bytes_per_cell: f64,
}

/// The fields of `bench.json` that the figure uses.
#[derive(Debug, Clone, Deserialize)]
struct Data {
    rows: Vec<Row>,
    peaks: Vec<Peaks>,
}

impl Row {
    /// Flops per byte of memory traffic without blocking in time.
    fn intensity(&self) -> f64 {
        self.flops_per_cell / self.bytes_per_cell
    }

    /// Arithmetic in 10^9 flops per second.
    fn gflops(&self) -> f64 {
        self.flops_per_cell * self.gcells_per_s
    }

    /// Cells of the grid.
    fn cells(&self) -> usize {
        self.nx * self.ny
    }

    /// Marker, and place beside the scheme's line so that equal speeds do not hide each other (factor of intensity).
    fn style(&self) -> (Marker, f64) {
        match (self.engine.as_str(), self.threads) {
            ("reference", _) => (Marker::Triangle, 1.0),
            (_, 1) => (Marker::Disc, 0.955),
            _ => (Marker::Square, 1.045),
        }
    }
}

/// The distinct grids, smallest first, each with its colour: dark for small ones.
fn grids(rows: &[Row]) -> Vec<((usize, usize), RGBColor)> {
    let mut grids: Vec<(usize, usize)> = rows.iter().map(|row| (row.nx, row.ny)).collect();
    grids.sort_by_key(|&(nx, ny)| (nx * ny, nx));
    grids.dedup();
    let last = grids.len().saturating_sub(1).max(1) as f64;
    grids
        .into_iter()
        .enumerate()
        .map(|(place, grid)| (grid, colour::ramp(0.05 + 0.8 * place as f64 / last)))
        .collect()
}

/// The title of the figure.
fn title(data: &Data) -> String {
    let single = || {
        data.rows
            .iter()
            .filter(|row| row.engine == "fast" && row.threads == 1)
    };
    let cells = single().map(Row::cells).max();
    let largest = single()
        .filter(|row| Some(row.cells()) == cells)
        .max_by(|a, b| a.gcells_per_s.total_cmp(&b.gcells_per_s));
    let roof = data.peaks.iter().find(|peak| peak.threads == 1);
    if let (Some(row), Some(roof)) = (largest, roof) {
        let above = row.gcells_per_s * row.bytes_per_cell / roof.memory_gbps;
        if above > 1.0 {
            return format!(
                "Blocking in time: {} on {} \u{d7} {} cells runs at {above:.1} times the memory\u{2019}s roof",
                row.scheme, row.nx, row.ny
            );
        }
    }
    "Speed of the field engines beside the machine\u{2019}s roofs".to_string()
}

/// Draws the roofs of one number of threads: bandwidths up to the peak, and the peak.
fn roofs(axes: &Axes<'_>, peak: &Peaks, stroke: Stroke) -> Result<()> {
    let top = peak.fma_gflops.log10();
    for bandwidth in [peak.memory_gbps, peak.l1_load_gbps] {
        let ridge = top - bandwidth.log10();
        axes.curve(
            &[(axes.x.low, axes.x.low + bandwidth.log10()), (ridge, top)],
            stroke,
        )?;
    }
    let first = top - peak.l1_load_gbps.log10();
    axes.curve(&[(first.max(axes.x.low), top), (axes.x.high, top)], stroke)
}

/// Draws the figure from `bench.json`.
///
/// # Errors
/// When the data file is missing or damaged, or the picture cannot be written.
pub(crate) fn draw(data: &Path, picture: &Path) -> Result<()> {
    let data: Data = json::read(data)?;
    let grids = grids(&data.rows);
    let speeds = data.rows.iter().map(Row::gflops);
    let lowest = speeds.fold(f64::INFINITY, f64::min).clamp(1e-3, 1e3);
    let highest = data
        .peaks
        .iter()
        .map(|peak| peak.fma_gflops)
        .chain(data.rows.iter().map(Row::gflops))
        .fold(1.0, f64::max);
    canvas::draw(picture, 1800, 1240, |sheet| {
        sheet.title(&title(&data))?;
        let axes = Axes::new(
            sheet,
            [170.0, 300.0, 1750.0, 1120.0],
            Axis::logarithmic(
                0.2,
                5.0,
                "flops per byte from and to memory without blocking in time [flop/byte]",
            ),
            Axis::logarithmic(0.6 * lowest, 1.6 * highest, "arithmetic [Gflop/s]"),
        );
        axes.grid()?;
        let strokes = [
            Stroke::solid(colour::BLACK, 4.0),
            Stroke::solid(colour::BLACK, 4.0).dashed(&[18.0, 11.0]),
        ];
        for (peak, stroke) in data.peaks.iter().zip(strokes) {
            roofs(&axes, peak, stroke)?;
        }
        schemes(&axes, sheet, &data.rows)?;
        for row in &data.rows {
            let (marker, beside) = row.style();
            let shade = grids
                .iter()
                .find(|(grid, _)| *grid == (row.nx, row.ny))
                .map_or(colour::GREY, |(_, shade)| *shade);
            let at = ((row.intensity() * beside).log10(), row.gflops().log10());
            axes.markers(&[at], marker, 25.0, shade)?;
        }
        axes.finish("")?;
        let mut entries: Vec<Entry> = data
            .peaks
            .iter()
            .zip(strokes)
            .map(|(peak, stroke)| {
                let text = format!(
                    "roofs, {} {}: memory {:.0} GB/s, first-level cache {:.0} GB/s, peak {:.0} Gflop/s",
                    peak.threads,
                    if peak.threads == 1 { "thread" } else { "threads" },
                    peak.memory_gbps,
                    peak.l1_load_gbps,
                    peak.fma_gflops
                );
                Entry::line(stroke, &text)
            })
            .collect();
        let marked = |marker, shade, text: String| Entry {
            stroke: None,
            marker: Some((marker, shade)),
            text,
        };
        for (marker, name) in [
            (Marker::Triangle, "plain sweep"),
            (Marker::Disc, "fast, 1 thread"),
            (Marker::Square, "fast, more threads"),
        ] {
            entries.push(marked(marker, colour::GREY, name.to_string()));
        }
        let mut top = 85.0;
        let (lines, rest) = entries.split_at(data.peaks.len().min(strokes.len()));
        for part in [lines, rest] {
            top += legend(sheet, [170.0, top], 1580.0, part)?;
        }
        let shades: Vec<Entry> = grids
            .iter()
            .map(|&((nx, ny), shade)| {
                let name = if nx == ny {
                    format!("{nx}\u{b2}")
                } else {
                    format!("{nx} \u{d7} {ny}")
                };
                marked(Marker::Disc, shade, name)
            })
            .collect();
        legend(sheet, [170.0, top], 1580.0, &shades)?;
        Ok(())
    })
}

/// Draws a line at every scheme's intensity and its name at the foot of it; schemes of equal intensity share one.
fn schemes(axes: &Axes<'_>, sheet: &Canvas, rows: &[Row]) -> Result<()> {
    let mut places: Vec<(f64, Vec<&str>)> = Vec::new();
    for row in rows {
        let x = row.intensity().log10();
        match places.iter_mut().find(|place| place.0 == x) {
            Some((_, names)) if names.contains(&row.scheme.as_str()) => {}
            Some((_, names)) => names.push(&row.scheme),
            None => places.push((x, vec![&row.scheme])),
        }
    }
    for (x, names) in places {
        axes.curve(
            &[(x, axes.y.low), (x, axes.y.high)],
            Stroke::solid(colour::GREY, 2.0).faint(0.6),
        )?;
        let foot = axes.pixel(x, axes.y.low);
        sheet.text(
            &names.join(", "),
            [foot[0] + 12.0, foot[1] - 24.0],
            (1, 0),
            LABEL,
            false,
            false,
        )?;
    }
    Ok(())
}
