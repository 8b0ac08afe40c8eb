//! The simulated part of the domain: all that walls and drive take, or, for a free-field drive, segments of time, each
//! in a small window around the pair.
//!
//! Without walls there are no echoes: sound at the microphone left the loudspeaker a moment ago, and cells far from
//! both cannot matter. Each segment starts from silence some time before its first sample. In this warm-up the source
//! rises from zero in a smooth ramp, and the sound of the ramp itself passes the microphone and goes into the layer;
//! then the segment before it fades out and it fades in, for the two differ by rounding errors of a few hertz, which
//! would leave a step.
//!
//! A segment's window is a whole number of cells away from the domain's origin, so that source and receiver keep their
//! places within a cell to the last bit. All times are multiples of the time that sound takes across a window, so that
//! they suit any grid.

use super::domain::{Domain, Extent};
use crate::field::FieldSetup;
use crate::grid::Grid;
use crate::walls::WallCells;

/// A row costs as much as this many further cells: the layers at its ends, and its start (fast engine, 13-point
/// stencil).
const ROW_COST_CELLS: u64 = 300;

/// Cells of a segment, counted from the domain's first; a window may reach beyond the domain, where there is nothing
/// but air.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Window {
    pub(super) first: [i64; 2],
    pub(super) nx: usize,
    pub(super) ny: usize,
}

/// A stretch of a drive that is simulated by itself, in steps from the drive's beginning.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Segment {
    pub(super) window: Window,
    /// First step that is simulated; the field before it is silent.
    pub(super) start: u64,
    /// First step of the signal.
    pub(super) from: u64,
    /// End of the steps.
    pub(super) to: u64,
    /// Steps that all segments before this one take, warm-ups included.
    pub(super) before: u64,
    /// Steps over which the source rises; none at the drive's own beginning.
    pub(super) ramp: u64,
    /// Last steps of the warm-up, over which the signal goes over from the segment before.
    pub(super) fade: u64,
}

impl Segment {
    /// Steps that the segment takes, its warm-up included.
    pub(super) fn steps(&self) -> u64 {
        self.to - self.start
    }

    /// Work of the segment, in cells times steps.
    fn cost(&self) -> u64 {
        self.steps() * self.window.ny as u64 * (self.window.nx as u64 + ROW_COST_CELLS)
    }
}

/// The segments of a run, one after the other.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct SegmentPlan {
    pub(super) segments: Vec<Segment>,
}

impl SegmentPlan {
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
            segments: vec![Segment {
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

    /// Steps of all segments, their warm-ups included.
    pub(super) fn steps(&self) -> u64 {
        self.segments.iter().map(Segment::steps).sum()
    }

    /// All that determines the segments.
    pub(super) fn numbers(&self) -> impl Iterator<Item = u64> {
        self.segments.iter().flat_map(|segment| {
            let Window { first, nx, ny } = segment.window;
            let [x, y] = first.map(i64::cast_unsigned);
            [
                x,
                y,
                nx as u64,
                ny as u64,
                segment.start,
                segment.from,
                segment.to,
                segment.ramp,
                segment.fade,
            ]
        })
    }

    /// Index of the segment of step `step`, counted with all warm-ups; of the last segment beyond the end.
    pub(super) fn index_at(&self, step: u64) -> usize {
        self.segments
            .partition_point(|segment| segment.before <= step)
            - 1
    }

    /// Cells of the largest window.
    pub(super) fn largest(&self) -> Window {
        let windows = self.segments.iter().map(|segment| segment.window);
        windows
            .max_by_key(|window| window.nx * window.ny)
            .expect("a plan has a segment")
    }

    /// Setup of the field of a segment.
    ///
    /// # Panics
    /// As [`FieldSetup::new`].
    pub(super) fn setup(&self, domain: &Domain, segment: usize) -> FieldSetup {
        let window = self.segments[segment].window;
        let Window { nx, ny, .. } = window;
        let part;
        let walls = if window == Window::whole(domain) {
            &domain.walls
        } else if self.segments.len() == 1 {
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
        self.segments.iter().map(Segment::cost).sum()
    }

    /// The drive's signal from the samples of all segments one after the other: entry `n` of either after `n` steps,
    /// the first silent.
    pub(super) fn join(&self, received: &[f32]) -> Vec<f32> {
        let mut joined = received[..1].to_vec();
        for segment in &self.segments {
            let end = received
                .len()
                .min((1 + segment.before + segment.steps()) as usize);
            let first = 1 + segment.before as usize;
            let own = first + (segment.from - segment.start) as usize;
            if end > own - segment.fade as usize {
                let fading = &received[own - segment.fade as usize..end.min(own)];
                let at = joined.len() - segment.fade as usize;
                for (k, (before, now)) in joined[at..].iter_mut().zip(fading).enumerate() {
                    let share = (k as f32 + 0.5) / segment.fade as f32;
                    *before += share * (now - *before);
                }
            }
            joined.extend_from_slice(&received[own.min(end)..end]);
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

    /// The part of the domain around a drive and the walls that sound from its start (source and receiver, metres) can
    /// reach, with clearance and layer; never more than the domain.
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

    /// The window's values among zeros in a frame of `nx` by `ny`, both `[iy, ix]`; what reaches beyond the frame is
    /// left out.
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
