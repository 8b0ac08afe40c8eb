//! One landmark fitted to the peaks near it: robust least squares on the ranges.

use super::landmark::Shape;
use super::sighting::Sighting;

/// Gates on the range, one for each round of refinement, in metres.
pub(super) const GATES_M: [f64; 6] = [0.08, 0.04, 0.025, 0.02, 0.02, 0.02];
/// Residual of the range at which a peak has half its weight, in metres.
const ROBUST_M: f64 = 0.004;
/// Standard deviations of the cosine up to which a peak may belong to a landmark.
pub(super) const COSINE_GATE: f64 = 3.0;
/// Residual of the range in metres within which most peaks of a landmark lie, and that part of them. Peaks that
/// happen to lie near a line are spread over the whole gate.
const TIGHT_M: f64 = 0.008;
const LEAST_TIGHT: f64 = 0.75;
/// Largest standard deviation of a landmark's position (metres) and normal (radians).
const MOST_SIGMA: f64 = 0.03;
/// Standard deviation of poses in metres up to which they are known as well as ranges.
const KNOWN_M: f64 = 0.002;
/// Largest correlation of the residuals of neighbouring blocks that is believed.
const MOST_ALIKE: f64 = 0.95;
/// Blocks over which residuals are alike, so that they count once.
pub(super) const ALIKE_BLOCKS: f64 = 4.0;

/// A landmark with the peaks that belong to it, one a block at most.
pub(super) struct Fit {
    pub(super) shape: Shape,
    /// For each sighting the number of the peak.
    pub(super) peaks: Vec<Option<usize>>,
    pub(super) blocks: usize,
    pub(super) rms_m: f64,
    /// Part of the peaks whose residual is at most [`TIGHT_M`].
    tight: f64,
    pub(super) covariance: [[f64; 2]; 2],
}

impl Fit {
    /// Whether its peaks crowd around it and tell where it is.
    pub(super) fn is_good(&self) -> bool {
        self.tight >= LEAST_TIGHT && (0..2).all(|k| self.covariance[k][k].sqrt() <= MOST_SIGMA)
    }
}

/// Robust least squares on the ranges of the free peaks near a landmark, with narrower gates from round to round.
pub(super) fn fit(
    mut shape: Shape,
    seen: &[Sighting],
    free: &[Vec<bool>],
    gates_m: &[f64],
    pose_sigma_m: f64,
) -> Option<Fit> {
    let mut peaks = vec![None; seen.len()];
    let mut last = ([[0.0; 2]; 2], 0.0, 0.0, 0);
    for &gate_m in gates_m {
        let gate_m = gate_m + 2.0 * pose_sigma_m;
        let (mut information, mut pull) = ([[0.0; 2]; 2], [0.0; 2]);
        let (mut squares, mut weights, mut tight) = (0.0, 0.0, 0);
        for ((sighting, free), chosen) in seen.iter().zip(free).zip(&mut peaks) {
            let echo = shape.echo(&sighting.pose, &sighting.motion);
            let near = |number: &usize| {
                let peak = &sighting.peaks[*number];
                free[*number]
                    && (peak.range_m - echo.range_m).abs() < gate_m
                    && (peak.cosine - echo.cosine).abs() < COSINE_GATE * sighting.cosine_sigma
            };
            let off = |number: usize| (sighting.peaks[number].range_m - echo.range_m).abs();
            *chosen = (0..sighting.peaks.len())
                .filter(near)
                .min_by(|&a, &b| off(a).total_cmp(&off(b)));
            let Some(number) = *chosen else {
                continue;
            };
            let residual_m = sighting.peaks[number].range_m - echo.range_m;
            let weight = 1.0 / (1.0 + (residual_m / (ROBUST_M + pose_sigma_m)).powi(2));
            let [a, b] = echo.range_by_shape;
            pull[0] += weight * a * residual_m;
            pull[1] += weight * b * residual_m;
            information[0][0] += weight * a * a;
            information[0][1] += weight * a * b;
            information[1][0] += weight * a * b;
            information[1][1] += weight * b * b;
            squares += weight * residual_m * residual_m;
            weights += weight;
            tight += usize::from(residual_m.abs() <= TIGHT_M + 1.5 * pose_sigma_m);
        }
        let inverse = invert(information)?;
        let change = [0, 1].map(|row| inverse[row][0] * pull[0] + inverse[row][1] * pull[1]);
        if !change
            .iter()
            .all(|number| number.is_finite() && number.abs() < 1.0)
        {
            return None;
        }
        shape = shape.moved(change);
        last = (inverse, squares, weights, tight);
    }
    let (inverse, squares, weights, tight) = last;
    let variance = (squares / weights).max(1e-8);
    // Where poses are off, residuals last for that reason.
    let variance = if pose_sigma_m <= KNOWN_M {
        variance * lasting(&shape, seen, &peaks)
    } else {
        variance
    };
    let scale = variance * ALIKE_BLOCKS;
    Some(Fit {
        shape,
        blocks: peaks.iter().flatten().count(),
        tight: tight as f64 / peaks.iter().flatten().count().max(1) as f64,
        peaks,
        rms_m: variance.sqrt(),
        covariance: inverse.map(|row| row.map(|number| number * scale)),
    })
}

/// Blocks in a row that count as one, because their residuals are alike: by the correlation of neighbours, as of a
/// first-order process. What is no landmark but happens to lie near one has residuals that last.
fn lasting(shape: &Shape, seen: &[Sighting], peaks: &[Option<usize>]) -> f64 {
    let residual = |index: usize| {
        let sighting = &seen[index];
        let echo = shape.echo(&sighting.pose, &sighting.motion);
        peaks[index].map(|number| sighting.peaks[number].range_m - echo.range_m)
    };
    let (mut squares, mut products) = (0.0, 0.0);
    for index in 1..seen.len() {
        if let (Some(before), Some(here)) = (residual(index - 1), residual(index)) {
            squares += 0.5 * (before * before + here * here);
            products += before * here;
        }
    }
    let alike = (products / squares.max(1e-12)).clamp(0.0, MOST_ALIKE);
    (1.0 + alike) / (1.0 - alike)
}

pub(super) fn invert([[a, b], [c, d]]: [[f64; 2]; 2]) -> Option<[[f64; 2]; 2]> {
    let determinant = a * d - b * c;
    (determinant > 1e-9 * a * d).then(|| {
        [
            [d / determinant, -b / determinant],
            [-c / determinant, a / determinant],
        ]
    })
}
