//! Planning of the segments of a free-field drive: the extent of the drive in intervals of time (ticks), and the
//! cheapest segments made of whole ticks.

use super::domain::{Domain, Extent};
use super::segments::{Segment, SegmentPlan, Window};

/// Time between a segment's first step and the first that is its own, in crossings of a window: about 10 ms on the
/// papers' grid (docs/theory/domains.md).
const WARM_UP_CROSSINGS: f64 = 8.0;

/// Parts of the warm-up in which the source rises, and in which the segment fades in.
const RAMP_PART: f64 = 0.5;
const FADE_PART: f64 = 0.25;

/// Time by which segments are measured out, in crossings of a window without drive; places that are looked up in it.
const TICK_CROSSINGS: f64 = 4.0;
const INSTANTS: u64 = 5;

/// The plan of least work for `steps` steps of a free-field drive through `points` (metres, in the domain) at a time in
/// seconds: the whole domain, or segments of equal length. Depends on nothing else, so that all runs of a drive give
/// the same bytes.
pub(super) fn cheapest_plan(
    domain: &Domain,
    steps: u64,
    points: &dyn Fn(f64) -> [[f64; 2]; 2],
) -> SegmentPlan {
    let planner = SegmentPlanner::new(domain, steps, points);
    let lengths = planner.lengths();
    lengths.map(|length| planner.plan(domain, length)).fold(
        SegmentPlan::whole(domain, steps),
        |best, plan| match plan.cost() < best.cost() {
            true => plan,
            false => best,
        },
    )
}

/// The extent of the drive, tick by tick.
pub(super) struct SegmentPlanner {
    steps: u64,
    steps_per_tick: u64,
    /// Steps of a segment's warm-up.
    warm_up: u64,
    extents: Vec<Extent>,
}

impl SegmentPlanner {
    pub(super) fn new(domain: &Domain, steps: u64, points: &dyn Fn(f64) -> [[f64; 2]; 2]) -> Self {
        let courant = domain.grid.courant(&domain.medium);
        let margins = 2.0 * domain.margin_cells() as f64;
        let steps_per_tick = (TICK_CROSSINGS * margins / courant).ceil() as u64;
        let extent = |tick: u64| {
            let mut extent = Extent::default();
            for instant in 0..=INSTANTS {
                let step = (tick as f64 + instant as f64 / INSTANTS as f64) * steps_per_tick as f64;
                extent.add(&domain.grid, points(step * domain.grid.dt_s));
            }
            extent
        };
        let extents: Vec<Extent> = (0..steps.div_ceil(steps_per_tick)).map(extent).collect();
        // Loudspeaker and microphone may be far apart.
        let widest = extents
            .iter()
            .fold(0.0, |widest, extent| extent.width().max(widest));
        Self {
            steps,
            steps_per_tick,
            warm_up: (WARM_UP_CROSSINGS * (margins + widest) / courant).ceil() as u64,
            extents,
        }
    }

    /// Lengths of segments to choose from, in ticks: longer than the warm-up, each half as long again as the one
    /// before.
    pub(super) fn lengths(&self) -> impl Iterator<Item = usize> {
        let first = 1 + (self.warm_up / self.steps_per_tick) as usize;
        std::iter::successors(Some(first), |length| Some(length + length.div_ceil(2)))
            .take_while(|&length| length < self.extents.len())
    }

    /// Segments of `length` ticks.
    pub(super) fn plan(&self, domain: &Domain, length: usize) -> SegmentPlan {
        let count = self.extents.len().div_ceil(length);
        let mut segments = Vec::with_capacity(count);
        let mut before = 0;
        for index in 0..count {
            let [first, end] = [index, index + 1].map(|k| (k * length).min(self.extents.len()));
            let from = first as u64 * self.steps_per_tick;
            let to = (end as u64 * self.steps_per_tick).min(self.steps);
            let start = from.saturating_sub(self.warm_up);
            let mut extent = Extent::default();
            for tick in &self.extents[(start / self.steps_per_tick) as usize..end] {
                extent.join(tick);
            }
            // The drive's own beginning has no warm-up.
            let part = |part: f64| match index {
                0 => 0,
                _ => (part * self.warm_up as f64) as u64,
            };
            let segment = Segment {
                window: Window::around(&extent, domain),
                start,
                from,
                to,
                before,
                ramp: part(RAMP_PART),
                fade: part(FADE_PART),
            };
            before += segment.steps();
            segments.push(segment);
        }
        SegmentPlan { segments }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::Grid;
    use crate::grid::Medium;
    use crate::scheme::Scheme;
    use crate::spread::Spread;
    use crate::walls::WallCells;

    fn domain() -> Domain {
        Domain {
            grid: Grid {
                nx: 400,
                ny: 300,
                dx_m: 0.005,
                dt_s: 1.0 / 120e3,
            },
            medium: Medium {
                c_mps: 340.0,
                rho_kgpm3: 1.293,
            },
            scheme: Scheme::O13,
            spread: Spread::Kaiser12,
            layer_cells: 20,
            walls: WallCells::open(400, 300),
        }
    }

    /// A second of a pair that goes along x.
    fn plan(v_mps: f64) -> SegmentPlan {
        cheapest_plan(&domain(), 120_000, &|t_s| {
            [[0.4 + v_mps * t_s, 0.7], [0.5 + v_mps * t_s, 0.7]]
        })
    }

    #[test]
    fn segments_follow_each_other_around_the_drive() {
        let plan = plan(1.0);
        assert!(plan.segments.len() > 4, "{}", plan.segments.len());
        let (mut to, mut before) = (0, 0);
        for segment in &plan.segments {
            assert_eq!((segment.from, segment.before), (to, before));
            assert!(segment.start + segment.ramp + segment.fade <= segment.from);
            (to, before) = (segment.to, before + segment.steps());
            for (step, x_m) in [(segment.start, 0.4), (segment.to, 0.5)] {
                let x = domain().grid.to_cells([x_m + step as f64 / 120e3, 0.7])[0];
                let beside = x - segment.window.first[0] as f64;
                let margin = domain().margin_cells() as f64;
                assert!(beside >= margin && beside + margin < segment.window.nx as f64 + 1.0);
            }
        }
        assert_eq!((to, before), (120_000, plan.steps()));
    }

    #[test]
    fn a_robot_at_rest_is_one_segment() {
        let mut domain = domain();
        let points = [[0.9, 0.7], [1.0, 0.7]];
        let origin_m = domain.crop(1.0, &|_| points);
        let points = points.map(|[x, y]| [x - origin_m[0], y - origin_m[1]]);
        let plan = cheapest_plan(&domain, 120_000, &|_| points);
        assert_eq!(plan, SegmentPlan::whole(&domain, 120_000));
    }

    #[test]
    fn signals_are_joined_where_they_are_known() {
        let plan = plan(1.0);
        let ones = vec![1.0; plan.steps() as usize + 1];
        assert_eq!(plan.join(&ones), vec![1.0; 120_001]);
        let second = plan.segments[1];
        for (received, expected) in [
            (0, 0),
            (second.before, second.from),
            (second.before + 1, second.from),
            (second.before + second.from - second.start, second.from),
            (
                second.before + second.from - second.start + 7,
                second.from + 7,
            ),
        ] {
            let joined = plan.join(&ones[..=received as usize]);
            assert_eq!(joined.len() as u64, expected + 1);
        }
    }
}
