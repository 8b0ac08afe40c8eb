//! Where a drive is, tick by tick, and the pieces that are made of ticks.

use super::Domain;
use super::domain::Extent;
use super::pieces::{Piece, Plan, Window};

/// Time between a piece's first step and the first that is its own, in crossings of a window: about 10 ms on the papers' grid. Measured
/// there, a quarter of it gives the same signal within the layers' error.
const WARM_UP_CROSSINGS: f64 = 8.0;

/// Parts of the warm-up in which the source rises, and in which the piece fades in.
const RAMP_PART: f64 = 0.5;
const FADE_PART: f64 = 0.25;

/// Time by which pieces are measured out, in crossings of a window without drive; places that are looked up in it.
const TICK_CROSSINGS: f64 = 4.0;
const INSTANTS: u64 = 5;

/// Where the drive is, tick by tick.
pub(super) struct Ticks {
    steps: u64,
    steps_per_tick: u64,
    /// Steps of a piece's warm-up.
    warm_up: u64,
    extents: Vec<Extent>,
}

impl Ticks {
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

    /// Lengths of pieces to choose from, in ticks: longer than the warm-up, each half as long again as the one before.
    pub(super) fn lengths(&self) -> impl Iterator<Item = usize> {
        let first = 1 + (self.warm_up / self.steps_per_tick) as usize;
        std::iter::successors(Some(first), |length| Some(length + length.div_ceil(2)))
            .take_while(|&length| length < self.extents.len())
    }

    /// Pieces of `length` ticks.
    pub(super) fn plan(&self, domain: &Domain, length: usize) -> Plan {
        let count = self.extents.len().div_ceil(length);
        let mut pieces = Vec::with_capacity(count);
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
            // The drive's own beginning is what it is.
            let part = |part: f64| match index {
                0 => 0,
                _ => (part * self.warm_up as f64) as u64,
            };
            let piece = Piece {
                window: Window::around(&extent, domain),
                start,
                from,
                to,
                before,
                ramp: part(RAMP_PART),
                fade: part(FADE_PART),
            };
            before += piece.steps();
            pieces.push(piece);
        }
        Plan { pieces }
    }
}
