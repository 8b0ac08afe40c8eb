//! Votes of peaks for the walls and points that they may come from.

use std::f64::consts::TAU;

use super::landmark::Shape;
use super::sighting::Sighting;

/// Directions of normals that are told apart.
const NORMALS: usize = 360;
/// Width of a bin of a wall's distance in metres.
const DISTANCE_M: f64 = 0.02;
/// Width of a cell of a point's place in metres.
const CELL_M: f64 = 0.03;
/// Standard deviations of the cosine beyond which a peak does not vote.
const COSINE_REACH: f64 = 2.5;
/// Largest side of the grid of points in cells: 30 m.
const MOST_CELLS: f64 = 1000.0;

/// Counts over all walls (normal, distance) and all points of a grid.
pub(super) struct Votes {
    middle_m: [f64; 2],
    /// Distances from `middle_m`, `[normal][bin]`, of walls.
    walls: Vec<f32>,
    bins: usize,
    least_distance_m: f64,
    points: Vec<f32>,
    columns: usize,
    corner_m: [f64; 2],
    cosines: Vec<[f64; 2]>,
}

impl Votes {
    /// The votes of all peaks.
    pub(super) fn new(seen: &[Sighting]) -> Self {
        let count = seen.len().max(1) as f64;
        let mean = |of: fn(&Sighting) -> f64| seen.iter().map(of).sum::<f64>() / count;
        let middle_m = [
            mean(|sighting| sighting.pose.x_m),
            mean(|sighting| sighting.pose.y_m),
        ];
        let mut spread_m: f64 = 0.0;
        let mut farthest_m: f64 = 0.0;
        for sighting in seen {
            let [dx, dy] = [
                sighting.pose.x_m - middle_m[0],
                sighting.pose.y_m - middle_m[1],
            ];
            spread_m = spread_m.max(dx.hypot(dy));
            for peak in &sighting.peaks {
                farthest_m = farthest_m.max(peak.range_m);
            }
        }
        let reach_m = (spread_m + farthest_m + 0.1).min(0.5 * MOST_CELLS * CELL_M);
        let bins = (2.0 * reach_m / DISTANCE_M) as usize + 2;
        let columns = (2.0 * reach_m / CELL_M) as usize + 2;
        let mut votes = Self {
            middle_m,
            walls: vec![0.0; NORMALS * bins],
            bins,
            least_distance_m: -reach_m,
            points: vec![0.0; columns * columns],
            columns,
            corner_m: [middle_m[0] - reach_m, middle_m[1] - reach_m],
            cosines: (0..NORMALS)
                .map(|k| {
                    let (sine, cosine) = (TAU * k as f64 / NORMALS as f64).sin_cos();
                    [cosine, sine]
                })
                .collect(),
        };
        for (index, sighting) in seen.iter().enumerate() {
            for number in 0..sighting.peaks.len() {
                votes.vote(seen, index, number, 1.0);
            }
        }
        votes
    }

    /// Takes the votes of one peak back.
    pub(super) fn remove(&mut self, seen: &[Sighting], index: usize, number: usize) {
        self.vote(seen, index, number, -1.0);
    }

    fn vote(&mut self, seen: &[Sighting], index: usize, number: usize, sign: f32) {
        let sighting = &seen[index];
        let (peak, pose) = (&sighting.peaks[number], &sighting.pose);
        let (sine, cosine) = pose.heading_rad.sin_cos();
        let place_m = [pose.x_m - self.middle_m[0], pose.y_m - self.middle_m[1]];
        // A direction votes by how well it agrees with the cosine.
        let weight = |nx: f64, ny: f64| {
            let off = (nx * cosine + ny * sine - peak.cosine) / sighting.cosine_sigma;
            (off.abs() < COSINE_REACH).then(|| (-0.5 * off * off).exp() as f32)
        };
        for (normal, &[nx, ny]) in self.cosines.iter().enumerate() {
            let Some(weight) = weight(nx, ny) else {
                continue;
            };
            let distance_m = peak.range_m + nx * place_m[0] + ny * place_m[1];
            let place = (distance_m - self.least_distance_m) / DISTANCE_M - 0.5;
            let bin = place.floor();
            // Shared between the two nearest bins.
            let share = (place - bin) as f32;
            for (bin, share) in [(bin, 1.0 - share), (bin + 1.0, share)] {
                if bin >= 0.0 && (bin as usize) < self.bins {
                    self.walls[normal * self.bins + bin as usize] += sign * weight * share;
                }
            }
        }
        let steps = (TAU * peak.range_m / (0.7 * CELL_M))
            .ceil()
            .clamp(8.0, 4000.0) as usize;
        let mut last = usize::MAX;
        // Around the circle by the same turn again and again.
        let (turn_sine, turn_cosine) = (TAU / steps as f64).sin_cos();
        let mut next = [1.0, 0.0];
        for _ in 0..steps {
            let [nx, ny] = next;
            next = [
                nx * turn_cosine - ny * turn_sine,
                nx * turn_sine + ny * turn_cosine,
            ];
            let Some(weight) = weight(nx, ny) else {
                continue;
            };
            let at = [pose.x_m + peak.range_m * nx, pose.y_m + peak.range_m * ny];
            let cell = [0, 1].map(|axis| (at[axis] - self.corner_m[axis]) / CELL_M);
            if !cell
                .iter()
                .all(|&cell| cell >= 0.0 && (cell as usize) < self.columns)
            {
                continue;
            }
            let index = cell[1] as usize * self.columns + cell[0] as usize;
            if index != last {
                self.points[index] += sign * weight;
                last = index;
            }
        }
    }

    /// The wall and the point with most votes.
    pub(super) fn best(&self) -> Option<[Shape; 2]> {
        let wall = largest(&self.walls)?;
        let point = largest(&self.points)?;
        Some([self.wall(wall), self.point(point)])
    }

    fn wall(&self, index: usize) -> Shape {
        let (normal, bin) = (index / self.bins, index % self.bins);
        let [nx, ny] = self.cosines[normal];
        let distance_m = self.least_distance_m + (bin as f64 + 0.5) * DISTANCE_M;
        Shape::Wall {
            normal_rad: TAU * normal as f64 / NORMALS as f64,
            distance_m: distance_m + nx * self.middle_m[0] + ny * self.middle_m[1],
        }
    }

    fn point(&self, index: usize) -> Shape {
        let cell = [index % self.columns, index / self.columns];
        Shape::Point {
            place_m: [0, 1].map(|axis| self.corner_m[axis] + (cell[axis] as f64 + 0.5) * CELL_M),
        }
    }

    /// Takes the present best wall and point, and what lies next to them, out of the count.
    pub(super) fn forget_best(&mut self) {
        if let Some(wall) = largest(&self.walls) {
            let (normal, bin) = (wall / self.bins, wall % self.bins);
            for turn in NORMALS - 2..=NORMALS + 2 {
                let row = (normal + turn) % NORMALS * self.bins;
                for bin in bin.saturating_sub(2)..=(bin + 2).min(self.bins - 1) {
                    self.walls[row + bin] = f32::NEG_INFINITY;
                }
            }
        }
        if let Some(point) = largest(&self.points) {
            let (row, column) = (point / self.columns, point % self.columns);
            for row in row.saturating_sub(1)..=(row + 1).min(self.columns - 1) {
                for column in column.saturating_sub(1)..=(column + 1).min(self.columns - 1) {
                    self.points[row * self.columns + column] = f32::NEG_INFINITY;
                }
            }
        }
    }
}

/// Index of the largest number, the first one among equals.
fn largest(counts: &[f32]) -> Option<usize> {
    let mut best: Option<usize> = None;
    for (index, &count) in counts.iter().enumerate() {
        if count > 0.0 && best.is_none_or(|best| count > counts[best]) {
            best = Some(index);
        }
    }
    best
}
