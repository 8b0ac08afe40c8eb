//! A free-field drive in pieces of time, each in a small domain around where the drive is then.
//!
//! Without walls nothing comes back: what the microphone hears now left the loudspeaker a moment ago, and cells far from both
//! cannot matter. Each piece starts from silence some time before it is listened to. The source rises from zero in a smooth
//! ramp, and the rest of the warm-up lets die away what the ramp itself sent out.
//!
//! A piece's window is a whole number of cells away from the domain's origin, so that source and receiver keep their places within
//! a cell to the last bit.

use super::Domain;
use super::domain::Extent;
use crate::field::FieldSetup;
use crate::grid::Grid;
use crate::walls::WallCells;

/// Time over which a piece's source rises, seconds.
const RAMP_S: f64 = 0.010;

/// Time between a piece's first step and the first that is listened to, seconds.
const WARM_UP_S: f64 = 0.020;

/// Time by which pieces are measured out, seconds; instants within it at which the drive's place is looked up.
const TICK_S: f64 = 0.005;
const INSTANTS: u64 = 5;

/// A step costs as much as this many cells, however small the domain: forcing, and the start of each row.
const STEP_COST_CELLS: u64 = 2000;

/// Cells of a piece, counted from the domain's first; a window may reach beyond the domain, where there is nothing but air.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Window {
    pub(super) first: [i64; 2],
    pub(super) nx: usize,
    pub(super) ny: usize,
}

/// A stretch of a drive that is simulated by itself, in steps from the drive's beginning.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Piece {
    pub(super) window: Window,
    /// First step that is simulated; the field before it is silent.
    pub(super) start: u64,
    /// First step that is listened to.
    pub(super) from: u64,
    /// End of the steps.
    pub(super) to: u64,
    /// Steps that all pieces before this one take, warm-ups included.
    pub(super) before: u64,
    /// Steps over which the source rises; none at the drive's own beginning.
    pub(super) ramp: u64,
}

impl Piece {
    /// Steps that the piece takes, its warm-up included.
    pub(super) fn steps(&self) -> u64 {
        self.to - self.start
    }

    fn cells(&self) -> u64 {
        (self.window.nx * self.window.ny) as u64
    }
}

/// The pieces of a run, one after the other.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Plan {
    pub(super) pieces: Vec<Piece>,
}

impl Plan {
    /// `steps` steps in the whole domain.
    pub(super) fn whole(domain: &Domain, steps: u64) -> Self {
        let window = Window {
            first: [0; 2],
            nx: domain.grid.nx,
            ny: domain.grid.ny,
        };
        Self {
            pieces: vec![Piece {
                window,
                start: 0,
                from: 0,
                to: steps,
                before: 0,
                ramp: 0,
            }],
        }
    }

    /// The plan of least work for `steps` steps of a free-field drive through `points` (metres, in the domain) at a time in seconds:
    /// the whole domain, or pieces of equal length. Depends on nothing else, so that all runs of a drive give the same bytes.
    pub(super) fn cheapest(
        domain: &Domain,
        steps: u64,
        points: &dyn Fn(f64) -> [[f64; 2]; 2],
    ) -> Self {
        let whole = Self::whole(domain, steps);
        let ticks = Ticks::new(domain, steps, points);
        // Each length is half as long again as the one before.
        let lengths = std::iter::successors(Some(ticks.of_seconds(WARM_UP_S)), |length| {
            Some(length + length.div_ceil(2))
        });
        lengths
            .take_while(|&length| length < ticks.extents.len())
            .map(|length| ticks.plan(domain, length))
            .fold(whole, |best, plan| match plan.cost() < best.cost() {
                true => plan,
                false => best,
            })
    }

    /// Steps of all pieces, their warm-ups included.
    pub(super) fn steps(&self) -> u64 {
        self.pieces.iter().map(Piece::steps).sum()
    }

    /// All that determines the pieces.
    pub(super) fn numbers(&self) -> impl Iterator<Item = u64> {
        self.pieces.iter().flat_map(|piece| {
            let Window { first, nx, ny } = piece.window;
            let [x, y] = first.map(i64::cast_unsigned);
            [
                x,
                y,
                nx as u64,
                ny as u64,
                piece.start,
                piece.from,
                piece.to,
                piece.ramp,
            ]
        })
    }

    /// Index of the piece of step `step`, counted with all warm-ups; of the last piece beyond the end.
    pub(super) fn index_at(&self, step: u64) -> usize {
        self.pieces.partition_point(|piece| piece.before <= step) - 1
    }

    /// Cells of the largest window.
    pub(super) fn largest(&self) -> Window {
        let windows = self.pieces.iter().map(|piece| piece.window);
        windows
            .max_by_key(|window| window.nx * window.ny)
            .expect("a plan has a piece")
    }

    /// What the field of a piece needs.
    ///
    /// # Panics
    /// As [`FieldSetup::new`].
    pub(super) fn setup(&self, domain: &Domain, piece: usize) -> FieldSetup {
        let Window { nx, ny, .. } = self.pieces[piece].window;
        let open;
        let walls = if self.pieces.len() == 1 {
            &domain.walls
        } else {
            open = WallCells::open(nx, ny);
            &open
        };
        let grid = Grid {
            nx,
            ny,
            ..domain.grid
        };
        FieldSetup::new(
            &grid,
            &domain.medium,
            domain.scheme,
            domain.layer_cells,
            walls,
        )
    }

    /// Work, in cells times steps.
    fn cost(&self) -> u64 {
        let costs = self.pieces.iter();
        costs
            .map(|piece| piece.steps() * (piece.cells() + STEP_COST_CELLS))
            .sum()
    }
}

/// Where the drive is, tick by tick.
struct Ticks {
    steps: u64,
    steps_per_tick: u64,
    dt_s: f64,
    extents: Vec<Extent>,
}

impl Ticks {
    fn new(domain: &Domain, steps: u64, points: &dyn Fn(f64) -> [[f64; 2]; 2]) -> Self {
        let dt_s = domain.grid.dt_s;
        let steps_per_tick = ((TICK_S / dt_s).round() as u64).max(1);
        let extent = |tick: u64| {
            let mut extent = Extent::default();
            for instant in 0..=INSTANTS {
                let step = (tick as f64 + instant as f64 / INSTANTS as f64) * steps_per_tick as f64;
                extent.add(&domain.grid, points(step * dt_s));
            }
            extent
        };
        Self {
            steps,
            steps_per_tick,
            dt_s,
            extents: (0..steps.div_ceil(steps_per_tick)).map(extent).collect(),
        }
    }

    fn of_seconds(&self, time_s: f64) -> usize {
        (time_s / (self.steps_per_tick as f64 * self.dt_s)).ceil() as usize
    }

    /// Pieces of `length` ticks.
    fn plan(&self, domain: &Domain, length: usize) -> Plan {
        let warm_up = self.of_seconds(WARM_UP_S);
        let count = self.extents.len().div_ceil(length);
        let mut pieces = Vec::with_capacity(count);
        let mut before = 0;
        for index in 0..count {
            let from = index * length;
            let to = (from + length).min(self.extents.len());
            let start = from.saturating_sub(warm_up);
            let mut extent = Extent::default();
            for tick in &self.extents[start..to] {
                extent.join(tick);
            }
            let piece = Piece {
                window: Window::around(&extent, domain),
                start: start as u64 * self.steps_per_tick,
                from: from as u64 * self.steps_per_tick,
                to: (to as u64 * self.steps_per_tick).min(self.steps),
                before,
                ramp: if start > 0 {
                    (RAMP_S / self.dt_s).round() as u64
                } else {
                    0
                },
            };
            before += piece.steps();
            pieces.push(piece);
        }
        Plan { pieces }
    }
}

impl Window {
    /// The window around a drive's extent, with its clearance and layer.
    fn around(extent: &Extent, domain: &Domain) -> Self {
        let margin = domain.margin_cells() as i64;
        let first = extent.low.map(|x| x.floor() as i64 - margin);
        let end = extent.high.map(|x| x.ceil() as i64 + margin);
        Self {
            first,
            // Whole vectors make full use of the engine.
            nx: ((end[0] - first[0]) as usize).next_multiple_of(8),
            ny: (end[1] - first[1]) as usize,
        }
    }

    /// The window's values among zeros in a frame of `nx` by `ny`, both `[iy, ix]`; what reaches beyond the frame is left out.
    pub(super) fn place(&self, values: &[f32], nx: usize, ny: usize) -> Vec<f32> {
        let mut frame = vec![0.0; nx * ny];
        for (row, from) in values.chunks_exact(self.nx).enumerate() {
            let iy = self.first[1] + row as i64;
            if !(0..ny as i64).contains(&iy) {
                continue;
            }
            let to = &mut frame[iy as usize * nx..][..nx];
            for (column, value) in from.iter().enumerate() {
                let ix = self.first[0] + column as i64;
                if let Some(cell) = usize::try_from(ix).ok().and_then(|ix| to.get_mut(ix)) {
                    *cell = *value;
                }
            }
        }
        frame
    }
}
