//! What of the domain is simulated: all that walls and drive take, or, of a free-field drive, pieces of time, each in a small domain around where
//! the drive is then.
//!
//! Without walls nothing comes back: what the microphone hears now left the loudspeaker a moment ago, and cells far from both
//! cannot matter. Each piece starts from silence some time before it is listened to. In this warm-up the source rises from zero
//! in a smooth ramp, and what the ramp itself sent out passes the microphone and goes into the layer; then the piece before it
//! fades out and it fades in, for the two differ by rounding errors of a few hertz, in which a step would be heard.
//!
//! A piece's window is a whole number of cells away from the domain's origin, so that source and receiver keep their places within
//! a cell to the last bit. All times are multiples of the time that sound takes across a window, so that they suit any grid.

use super::Domain;
use super::domain::Extent;
use super::ticks::Ticks;
use crate::field::FieldSetup;
use crate::grid::Grid;
use crate::walls::WallCells;

/// A row costs as much as this many further cells: the layers at its ends, and its start (fast engine, 13-point stencil).
const ROW_COST_CELLS: u64 = 300;

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
    /// Last steps of the warm-up, over which the signal goes over from the piece before.
    pub(super) fade: u64,
}

impl Piece {
    /// Steps that the piece takes, its warm-up included.
    pub(super) fn steps(&self) -> u64 {
        self.to - self.start
    }

    /// Work of the piece, in cells times steps.
    fn cost(&self) -> u64 {
        self.steps() * self.window.ny as u64 * (self.window.nx as u64 + ROW_COST_CELLS)
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
        Self::in_window(Window::whole(domain), steps)
    }

    /// `steps` steps in what walls and drive take of the domain, with room for the layer.
    pub(super) fn cropped(
        domain: &Domain,
        steps: u64,
        duration_s: f64,
        points: &dyn Fn(f64) -> [[f64; 2]; 2],
    ) -> Self {
        let drive = Extent::of_drive(&domain.grid, duration_s, points);
        Self::in_window(Window::within(domain, &drive, points(0.0)), steps)
    }

    fn in_window(window: Window, steps: u64) -> Self {
        Self {
            pieces: vec![Piece {
                window,
                start: 0,
                from: 0,
                to: steps,
                before: 0,
                ramp: 0,
                fade: 0,
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
        let lengths = ticks.lengths();
        lengths
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
                piece.fade,
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
        let window = self.pieces[piece].window;
        let Window { nx, ny, .. } = window;
        let part;
        let walls = if window == Window::whole(domain) {
            &domain.walls
        } else if self.pieces.len() == 1 {
            part = domain
                .walls
                .window(window.first.map(|cells| cells as usize), [nx, ny]);
            &part
        } else {
            part = WallCells::open(nx, ny);
            &part
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

    /// Work of the run, in cells times steps; rows count more than their cells.
    pub(super) fn cost(&self) -> u64 {
        self.pieces.iter().map(Piece::cost).sum()
    }

    /// The drive's signal from what was heard so far in all pieces one after the other: entry `n` of either after `n` steps, the first silent.
    pub(super) fn join(&self, heard: &[f32]) -> Vec<f32> {
        let mut joined = heard[..1].to_vec();
        for piece in &self.pieces {
            let end = heard.len().min((1 + piece.before + piece.steps()) as usize);
            let first = 1 + piece.before as usize;
            let own = first + (piece.from - piece.start) as usize;
            if end > own - piece.fade as usize {
                let fading = &heard[own - piece.fade as usize..end.min(own)];
                let at = joined.len() - piece.fade as usize;
                for (k, (before, now)) in joined[at..].iter_mut().zip(fading).enumerate() {
                    let share = (k as f32 + 0.5) / piece.fade as f32;
                    *before += share * (now - *before);
                }
            }
            joined.extend_from_slice(&heard[own.min(end)..end]);
        }
        joined
    }
}

impl Window {
    /// All of the domain.
    pub(super) fn whole(domain: &Domain) -> Self {
        Self {
            first: [0; 2],
            nx: domain.grid.nx,
            ny: domain.grid.ny,
        }
    }

    /// What a drive and the walls that sound from its start (source and receiver, metres) can meet take of the domain, with clearance and layer; never
    /// more than the domain.
    fn within(domain: &Domain, drive: &Extent, start: [[f64; 2]; 2]) -> Self {
        let whole = Self::whole(domain);
        let mut first = drive
            .low
            .map(|x| x.floor() as i64 - domain.margin_cells() as i64);
        let mut end = drive
            .high
            .map(|x| x.ceil() as i64 + domain.margin_cells() as i64);
        let start = start.map(|point| domain.grid.to_cells(point).map(|x| x.floor() as usize));
        if let Some([low, high]) = domain.walls.extent_met(&start) {
            for axis in 0..2 {
                let margin = domain.wall_margin_cells() as i64;
                first[axis] = first[axis].min(low[axis] as i64 - margin);
                end[axis] = end[axis].max(high[axis] as i64 + 1 + margin);
            }
        }
        let first = first.map(|cell| cell.max(0));
        let [nx, ny] = [(0, whole.nx), (1, whole.ny)]
            .map(|(axis, cells)| (end[axis].min(cells as i64) - first[axis]) as usize);
        // Whole vectors make full use of the engine.
        let nx = nx.next_multiple_of(8).min(whole.nx - first[0] as usize);
        Self { first, nx, ny }
    }

    /// The window around a drive's extent, with its clearance and layer.
    pub(super) fn around(extent: &Extent, domain: &Domain) -> Self {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::Medium;
    use crate::scheme::Scheme;
    use crate::spread::Spread;

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
    fn plan(v_mps: f64) -> Plan {
        Plan::cheapest(&domain(), 120_000, &|t_s| {
            [[0.4 + v_mps * t_s, 0.7], [0.5 + v_mps * t_s, 0.7]]
        })
    }

    #[test]
    fn pieces_follow_each_other_around_the_drive() {
        let plan = plan(1.0);
        assert!(plan.pieces.len() > 4, "{}", plan.pieces.len());
        let (mut to, mut before) = (0, 0);
        for piece in &plan.pieces {
            assert_eq!((piece.from, piece.before), (to, before));
            assert!(piece.start + piece.ramp + piece.fade <= piece.from);
            (to, before) = (piece.to, before + piece.steps());
            for (step, x_m) in [(piece.start, 0.4), (piece.to, 0.5)] {
                let x = domain().grid.to_cells([x_m + step as f64 / 120e3, 0.7])[0];
                let beside = x - piece.window.first[0] as f64;
                let margin = domain().margin_cells() as f64;
                assert!(beside >= margin && beside + margin < piece.window.nx as f64 + 1.0);
            }
        }
        assert_eq!((to, before), (120_000, plan.steps()));
    }

    #[test]
    fn a_robot_at_rest_is_one_piece() {
        let mut domain = domain();
        let points = [[0.9, 0.7], [1.0, 0.7]];
        let origin_m = domain.crop(1.0, &|_| points);
        let points = points.map(|[x, y]| [x - origin_m[0], y - origin_m[1]]);
        let plan = Plan::cheapest(&domain, 120_000, &|_| points);
        assert_eq!(plan, Plan::whole(&domain, 120_000));
    }

    #[test]
    fn signals_are_joined_where_they_are_known() {
        let plan = plan(1.0);
        let ones = vec![1.0; plan.steps() as usize + 1];
        assert_eq!(plan.join(&ones), vec![1.0; 120_001]);
        let second = plan.pieces[1];
        for (heard, expected) in [
            (0, 0),
            (second.before, second.from),
            (second.before + 1, second.from),
            (second.before + second.from - second.start, second.from),
            (
                second.before + second.from - second.start + 7,
                second.from + 7,
            ),
        ] {
            let joined = plan.join(&ones[..=heard as usize]);
            assert_eq!(joined.len() as u64, expected + 1);
        }
    }
}
