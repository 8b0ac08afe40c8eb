//! Which peak comes from which landmark, at poses that are nearly known.

use super::graph::Match;
use crate::landmarks::Shape;
use crate::landmarks::Sighting;

/// Standard deviations of the cosine up to which a peak may belong to a landmark.
const COSINE_GATE: f64 = 3.0;

/// Gives every peak to the landmark that it fits best within a gate on the range, and every landmark at most one peak
/// of a block, the nearest.
pub(super) fn associate(
    shapes: &[Shape],
    seen: &[Option<Sighting>],
    gate_m: f64,
    matches: &mut Vec<Match>,
) {
    matches.clear();
    let mut best: Vec<Option<(f64, usize)>> = vec![None; shapes.len()];
    let mut echoes = Vec::with_capacity(shapes.len());
    for (node, sighting) in seen.iter().enumerate() {
        let Some(sighting) = sighting else {
            continue;
        };
        echoes.clear();
        echoes.extend(
            shapes
                .iter()
                .map(|shape| shape.echo(&sighting.pose, &sighting.motion)),
        );
        best.fill(None);
        for (number, peak) in sighting.peaks.iter().enumerate() {
            let distance = |landmark: usize| {
                let echo = &echoes[landmark];
                let dr = (peak.range_m - echo.range_m) / gate_m;
                let dc = (peak.cosine - echo.cosine) / (COSINE_GATE * sighting.cosine_sigma);
                (echo.range_m > 0.0 && dr.abs() < 1.0 && dc.abs() < 1.0)
                    .then_some(dr * dr + dc * dc)
            };
            let nearest = (0..shapes.len())
                .filter_map(|landmark| Some((distance(landmark)?, landmark)))
                .min_by(|a, b| a.0.total_cmp(&b.0));
            if let Some((distance, landmark)) = nearest
                && best[landmark].is_none_or(|(least, _)| distance < least)
            {
                best[landmark] = Some((distance, number));
            }
        }
        matches.extend(best.iter().enumerate().filter_map(|(landmark, best)| {
            best.map(|(_, peak)| Match {
                node,
                peak,
                landmark,
            })
        }));
    }
}
