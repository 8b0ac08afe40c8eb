//! Bearing index: the pixels around the robot that are seen in each direction, eqs. (6) and (16).
//!
//! Pixels sorted by angle form a circle. Under a heading, each direction is one arc of it to the left and one to the
//! right, with borders at equal steps. Borders are computed in integer fractions of a turn, where a whole turn is an
//! overflow; only a pixel within rounding of a border is decided in double precision.

use std::f64::consts::PI;
use std::ops::Range;

use crate::pose::wrap_angle;

/// Equal sectors of the turn in the lookup table; a power of two.
const SECTORS: usize = 4096;
/// Entries compared together in a search.
const AT_ONCE: usize = 8;
/// Pixels nearer to a border than this, in 2^-32 of a turn, may be on either side of it: more than all rounding
/// errors.
const AMBIGUITY: u32 = 4;

/// Angles of pixels in cyclic order, with a table for searches.
#[derive(Debug, Clone)]
pub(crate) struct BearingIndex {
    /// World angles in [-pi, pi), sorted.
    angles_rad: Vec<f64>,
    /// The angle at which the order starts; no pixel is near it.
    seam_rad: f64,
    /// Angles from the seam in 2^-32 of a turn, minus 2^31 so that they compare as signed numbers; followed by
    /// [`AT_ONCE`] times the largest number.
    codes: Vec<i32>,
    /// For each of the [`SECTORS`] from the seam on, the first pixel in it or after it.
    sectors: Vec<u32>,
}

/// Maps an angle in (-pi, pi] to [-pi, pi).
pub(crate) fn from_minus_pi(angle_rad: f64) -> f64 {
    if angle_rad == PI { -PI } else { angle_rad }
}

/// An angle in 2^-64 of a turn, modulo one turn.
fn parts_of_turn(angle_rad: f64) -> u64 {
    let turns = angle_rad / (2.0 * PI);
    // A whole turn, if rounding leads there, saturates to the largest number.
    ((turns - turns.floor()) * 2.0_f64.powi(64)) as u64
}

/// The upper half of a number of 2^-64 of a turn, in the form of [`BearingIndex::codes`].
fn code(parts: u64) -> i32 {
    ((parts >> 32) as u32 ^ 1 << 31) as i32
}

impl BearingIndex {
    /// An index of sorted angles in [-pi, pi), see [`from_minus_pi`].
    pub(crate) fn new(angles_rad: Vec<f64>) -> Self {
        // Half way between the last angle and pi.
        let last_rad = angles_rad.last().copied().unwrap_or(0.0);
        let seam_rad = 0.5 * (last_rad + PI);
        let parts: Vec<u64> = angles_rad
            .iter()
            .map(|angle| parts_of_turn(angle - seam_rad))
            .collect();
        let sectors = (0..SECTORS as u64).map(|sector| {
            let start = sector * (u64::MAX / SECTORS as u64 + 1);
            parts.partition_point(|&parts| parts < start) as u32
        });
        Self {
            sectors: sectors.collect(),
            codes: parts
                .iter()
                .map(|&parts| code(parts))
                .chain([i32::MAX; AT_ONCE])
                .collect(),
            seam_rad,
            angles_rad,
        }
    }

    /// Number of pixels.
    pub(crate) fn len(&self) -> usize {
        self.angles_rad.len()
    }

    /// Writes, for each border under a heading, the first pixel behind it. `directions` is the index of the direction
    /// astern, at least 1; there are twice as many borders: arc n is centred n steps to the left of the heading, and
    /// border n follows it.
    pub(crate) fn borders(&self, directions: usize, heading_rad: f64, borders: &mut [u32]) {
        let heading_rad = wrap_angle(heading_rad);
        let step = u64::MAX / (2 * directions) as u64;
        let ahead = parts_of_turn(heading_rad - self.seam_rad);
        for (arc, rank) in borders.iter_mut().enumerate() {
            // The step's rounding adds up to less than 2^-50 of a turn.
            let border = ahead.wrapping_add(step / 2 + arc as u64 * step);
            let found = self.rank_of(border);
            *rank = if self.is_ambiguous(found, border) {
                self.resolved(found, border, arc, directions, heading_rad)
            } else {
                found
            } as u32;
        }
    }

    /// Calls `visit` with the direction and the pixels of every arc, given the [`Self::borders`]. Each pixel is
    /// visited once.
    pub(crate) fn for_each_arc(&self, borders: &[u32], mut visit: impl FnMut(usize, Range<usize>)) {
        let mut start = borders.last().map_or(0, |&last| last as usize);
        for (arc, &border) in borders.iter().enumerate() {
            let direction = direction_of(arc, borders.len() / 2);
            let end = border as usize;
            self.for_each_part(start, end, |part| visit(direction, part));
            start = end;
        }
    }

    /// Calls `visit` with the directions before and after and the pixels, for all pixels whose direction differs
    /// between two headings' borders. The headings differ by less than half a direction step.
    pub(crate) fn for_each_change(
        &self,
        before: &[u32],
        after: &[u32],
        mut visit: impl FnMut(usize, usize, Range<usize>),
    ) {
        let directions = before.len() / 2;
        for (arc, (&old, &new)) in before.iter().zip(after).enumerate() {
            if old == new {
                continue;
            }
            let next = if arc + 1 == before.len() { 0 } else { arc + 1 };
            let [behind, beyond] = [arc, next].map(|arc| direction_of(arc, directions));
            let (old, new) = (old as usize, new as usize);
            // The shorter way around the circle.
            if (new > old) == (new.abs_diff(old) <= self.len() / 2) {
                self.for_each_part(old, new, |part| visit(beyond, behind, part));
            } else {
                self.for_each_part(new, old, |part| visit(behind, beyond, part));
            }
        }
    }

    /// The one or two ranges of pixels from `start` to `end` around the circle; none if they are equal.
    fn for_each_part(&self, start: usize, end: usize, mut visit: impl FnMut(Range<usize>)) {
        if start < end {
            return visit(start..end);
        }
        if start > end {
            if start < self.len() {
                visit(start..self.len());
            }
            if end > 0 {
                visit(0..end);
            }
        }
    }

    /// Number of pixels from the seam to a border, by the codes alone.
    #[inline(always)]
    fn rank_of(&self, border: u64) -> usize {
        let limit = code(border);
        let mut rank = self.sectors[(border >> (64 - SECTORS.ilog2())) as usize] as usize;
        // A sector holds few pixels: counting several at once avoids unpredictable branches.
        while let Some(next) = self.codes.get(rank..rank + AT_ONCE) {
            let count: i32 = next.iter().map(|&code| i32::from(code < limit)).sum();
            rank += count as usize;
            if count < AT_ONCE as i32 {
                break;
            }
        }
        rank
    }

    /// Whether the pixel at a rank, or the one before it, is within rounding of the border.
    #[inline(always)]
    fn is_ambiguous(&self, rank: usize, border: u64) -> bool {
        let near = |code_there: i32| code_there.abs_diff(code(border)) <= AMBIGUITY;
        near(self.codes[rank]) || near(self.codes[rank.saturating_sub(1)])
    }

    /// Number of pixels before the border behind an arc; those within rounding of it by eqs. (6) and (16) in double
    /// precision.
    #[cold]
    #[inline(never)]
    fn resolved(
        &self,
        mut rank: usize,
        border: u64,
        arc: usize,
        directions: usize,
        heading_rad: f64,
    ) -> usize {
        let ambiguous = |pixel: usize| self.codes[pixel].abs_diff(code(border)) <= AMBIGUITY;
        let is_before = |pixel: usize| {
            let bearing_rad = wrap_angle(self.angles_rad[pixel] - heading_rad).abs();
            let seen = (directions as f64 / PI * bearing_rad).round() as usize;
            if arc < directions {
                seen <= direction_of(arc, directions)
            } else {
                seen >= direction_of(arc, directions)
            }
        };
        while rank > 0 && ambiguous(rank - 1) && !is_before(rank - 1) {
            rank -= 1;
        }
        while rank < self.len() && ambiguous(rank) && is_before(rank) {
            rank += 1;
        }
        rank
    }
}

/// The direction of an arc; arcs to the left and to the right share directions.
fn direction_of(arc: usize, directions: usize) -> usize {
    arc.min(2 * directions - arc)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Sorted angles of the pixels of a square around the robot.
    fn square(half: i32) -> Vec<f64> {
        let mut angles: Vec<f64> = (-half..=half)
            .flat_map(|y| (-half..=half).map(move |x| (x, y)))
            .filter(|&pixel| pixel != (0, 0))
            .map(|(x, y)| from_minus_pi(f64::from(y).atan2(f64::from(x))))
            .collect();
        angles.sort_by(f64::total_cmp);
        angles
    }

    /// Each pixel's direction by eqs. (6) and (16).
    fn seen(angles: &[f64], directions: usize, heading_rad: f64) -> Vec<usize> {
        let bearing = |angle: &f64| wrap_angle(angle - wrap_angle(heading_rad)).abs();
        angles
            .iter()
            .map(|angle| (directions as f64 / PI * bearing(angle)).round() as usize)
            .collect()
    }

    fn arcs_agree(half: i32, directions: usize, heading_rad: f64) {
        let angles = square(half);
        let bearings = BearingIndex::new(angles.clone());
        let mut borders = vec![0; 2 * directions];
        bearings.borders(directions, heading_rad, &mut borders);
        let plain = seen(&angles, directions, heading_rad);
        let mut seen_by = vec![usize::MAX; angles.len()];
        bearings.for_each_arc(&borders, |direction, arc| {
            for pixel in arc {
                assert_eq!(seen_by[pixel], usize::MAX);
                seen_by[pixel] = direction;
            }
        });
        assert_eq!(seen_by, plain, "heading {heading_rad}");
    }

    proptest! {
        #[test]
        fn every_pixel_sees_the_direction_of_the_printed_equations(
            half in 1_i32..20,
            directions in 1_usize..60,
            heading in -10.0..10.0,
        ) {
            arcs_agree(half, directions, heading);
        }

        /// Borders on many pixels at once, and on the seam.
        #[test]
        fn so_do_pixels_on_borders(
            half in 1_i32..12,
            directions in 1_usize..60,
            eighths in -16_i32..=16,
            steps in -120_i32..=120,
            nudge in -3_i32..=3,
        ) {
            let step = PI / directions as f64;
            let heading = f64::from(eighths) * PI / 8.0 + (f64::from(steps) + 0.5) * step;
            arcs_agree(half, directions, heading + f64::from(nudge) * 4e-16);
            arcs_agree(half, directions, heading + f64::from(nudge) * 1e-9);
        }

        #[test]
        fn changes_lead_from_one_heading_to_another(
            half in 1_i32..20,
            directions in 1_usize..60,
            heading in -10.0..10.0,
            steps in -0.499..0.499,
        ) {
            let angles = square(half);
            let bearings = BearingIndex::new(angles.clone());
            let turned = heading + steps * PI / directions as f64;
            let borders = [heading, turned].map(|heading| {
                let mut borders = vec![0; 2 * directions];
                bearings.borders(directions, heading, &mut borders);
                borders
            });
            let mut followed = seen(&angles, directions, heading);
            bearings.for_each_change(&borders[0], &borders[1], |before, after, pixels| {
                for pixel in pixels {
                    assert_eq!(followed[pixel], before);
                    followed[pixel] = after;
                }
            });
            prop_assert_eq!(followed, seen(&angles, directions, turned));
        }
    }

    #[test]
    fn no_pixels_have_no_arcs() {
        let nothing = BearingIndex::new(Vec::new());
        let mut borders = [0; 10];
        nothing.borders(5, 1.0, &mut borders);
        nothing.for_each_arc(&borders, |_, _| panic!("an arc of nothing"));
    }
}
