//! The offset between the clock of a trajectory and the sound's, by the ranges of the echoes.
//!
//! A wall that is followed from block to block has the range `D - n . p(t)`. With the right offset one `D` and one `n`
//! fit all ranges of the wall along the trajectory `p`; with a wrong one the ranges after a turn or a change of speed
//! do not lie on those before. The fit is linear, and needs neither a map nor a bearing.

use super::log_clock::Offset;
use crate::landmarks::peaks::Peak;
use crate::pose::Pose;
use crate::trajectory::Trajectory;

/// Range at which a residual counts as foreign, in metres.
const SCALE_M: f64 = 0.006;

/// What is known of a path along which ranges are fitted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PathKind {
    /// True poses: a wall seen twice is one wall.
    Truth,
    /// A path by wheels, which drifts: walls are followed for some seconds only.
    Wheels,
}

impl PathKind {
    /// Points of the longest track.
    fn most_points(self) -> usize {
        match self {
            Self::Truth => 70,
            Self::Wheels => 40,
        }
    }
}

/// Points of the shortest track.
const LEAST_POINTS: usize = 12;

/// A range differs from what its Doppler effect foresees by at most this, in metres.
const RANGE_GATE_M: f64 = 0.012;

/// Range rates of one wall differ from block to block by at most this, in m/s.
const RATE_GATE_MPS: f64 = 0.12;

/// Offsets that are tried first, in seconds.
const COARSE_S: f64 = 0.04;

/// Offsets at most.
const MOST_OFFSETS: usize = 20_000;

/// Largest standard deviation of an offset that is believed, in seconds.
const LARGEST_SIGMA_S: f64 = 0.05;

/// Distance in time of another minimum.
const APART_S: f64 = 0.4;

/// Excess of the cost, in its unit of a squared standard deviation, of any other minimum.
const LEAST_EXCESS: f64 = 40.0;

/// A wall or corner followed over some blocks: `[time, range]`.
type Track = Vec<[f64; 2]>;

/// Follows peaks from block to block; blocks in their order.
#[derive(Debug)]
pub struct Tracks {
    /// Seconds a metre.
    slowness: f64,
    kind: PathKind,
    done: Vec<Track>,
    open: Vec<(Track, f64)>,
}

impl Tracks {
    /// No tracks yet, in air with this speed of sound, for paths of a kind.
    pub fn new(speed_of_sound_mps: f64, kind: PathKind) -> Self {
        Self {
            kind,
            slowness: 1.0 / speed_of_sound_mps,
            done: Vec::new(),
            open: Vec::new(),
        }
    }

    /// Takes the peaks of a block at `t_s`, measured with the speed `v_mps`.
    pub fn push(&mut self, t_s: f64, v_mps: f64, peaks: &[Peak]) {
        let mut taken = vec![false; peaks.len()];
        let mut still = Vec::with_capacity(peaks.len());
        for (mut track, rate) in std::mem::take(&mut self.open) {
            let [last_s, range_m] = track[track.len() - 1];
            // A peak may be missed once.
            let foreseen = range_m - rate * (t_s - last_s);
            let next = peaks
                .iter()
                .enumerate()
                .filter(|&(k, peak)| {
                    !taken[k]
                        && (peak.range_m - foreseen).abs() < RANGE_GATE_M
                        && (peak.cosine * v_mps - rate).abs() < RATE_GATE_MPS
                })
                .min_by(|a, b| {
                    let far = |peak: &Peak| (peak.range_m - foreseen).abs();
                    far(a.1).total_cmp(&far(b.1))
                });
            match next {
                Some((k, peak)) if track.len() < self.kind.most_points() => {
                    taken[k] = true;
                    let seen = (range_m - peak.range_m) / (t_s - last_s);
                    track.push([t_s, peak.range_m]);
                    still.push((track, 0.5 * (seen + rate)));
                }
                None if t_s - last_s < 0.25 => still.push((track, rate)),
                _ if track.len() >= LEAST_POINTS => self.done.push(track),
                _ => {}
            }
        }
        let fresh = peaks.iter().zip(&taken).filter(|(_, taken)| !**taken);
        still.extend(fresh.map(|(peak, _)| (vec![[t_s, peak.range_m]], peak.cosine * v_mps)));
        self.open = still;
    }

    /// The tracks that are long enough. The range that is heard at `t` is the one that the robot had on the sound's
    /// way, at `t - range / c`.
    fn all(&self) -> Vec<Track> {
        let open = self.open.iter().map(|(track, _)| track);
        let long = self
            .done
            .iter()
            .chain(open)
            .filter(|track| track.len() >= LEAST_POINTS);
        let had = |&[t_s, range_m]: &[f64; 2]| [t_s - range_m * self.slowness, range_m];
        long.map(|track| track.iter().map(had).collect()).collect()
    }

    /// What the trajectory's clock shows at time 0 of the sound, among `from_s` to `to_s`. `sensor_m` is the place on
    /// the robot from which ranges count. None when the tracks do not tell.
    pub fn match_path(
        &self,
        path: &Trajectory,
        sensor_m: [f64; 2],
        range_s: [f64; 2],
    ) -> Option<Offset> {
        let coarse_s = self.search(path, sensor_m, range_s)?;
        let at = |t_s: f64| path.pose_at(t_s).unwrap_or_default().carried(sensor_m);
        let mut groups = self.all();
        if self.kind == PathKind::Truth {
            groups = merge(&groups, &|t_s| at(t_s + coarse_s));
        }
        settled(coarse_s, &|offset_s| {
            self.cost(&groups, &|t_s| at(t_s + offset_s))
        })
    }

    /// The sum of the walls' costs along a path.
    fn cost(&self, groups: &[Track], at: &dyn Fn(f64) -> Pose) -> f64 {
        groups.iter().map(|track| fit(track, at).cost).sum()
    }

    /// The best of all offsets of a range, if no other is as good.
    fn search(
        &self,
        trajectory: &Trajectory,
        sensor_m: [f64; 2],
        [from_s, to_s]: [f64; 2],
    ) -> Option<f64> {
        let groups: Vec<Track> = self.all();
        let offsets = ((to_s - from_s) / COARSE_S).ceil();
        if groups.is_empty() || !(0.0..=MOST_OFFSETS as f64).contains(&offsets) {
            return None;
        }
        let at = |t_s: f64| {
            trajectory
                .pose_at(t_s)
                .unwrap_or_default()
                .carried(sensor_m)
        };
        // Multiples of a step, so that another range gives the same minimum.
        let first = (from_s / COARSE_S).ceil();
        let costs: Vec<(f64, f64)> = (0..=offsets as usize)
            .map(|k| (first + k as f64) * COARSE_S)
            .filter(|offset_s| *offset_s <= to_s)
            .map(|offset_s| (offset_s, self.cost(&groups, &|t_s| at(t_s + offset_s))))
            .collect();
        let best = *costs.iter().min_by(|a, b| a.1.total_cmp(&b.1))?;
        let others = costs
            .iter()
            .filter(|(offset_s, _)| (offset_s - best.0).abs() > APART_S)
            .fold(f64::INFINITY, |least, (_, cost)| least.min(*cost));
        (others - best.1 >= LEAST_EXCESS).then_some(best.0)
    }
}

/// The minimum near an offset with its deviation, if that is small.
fn settled(coarse_s: f64, cost: &dyn Fn(f64) -> f64) -> Option<Offset> {
    let offset_s = minimum(coarse_s, COARSE_S, 1e-4, cost);
    let step_s = 0.01;
    let [before, here, after] = [-step_s, 0.0, step_s].map(|by| cost(offset_s + by));
    let bend = (before - 2.0 * here + after) / (step_s * step_s);
    // Neighbouring ranges share their errors: a few of them count as one.
    let sigma_s = 2.0 * (2.0 / bend.max(1e-9)).sqrt();
    (sigma_s < LARGEST_SIGMA_S).then_some(Offset { offset_s, sigma_s })
}

/// Where a function is least within `reach` of `middle`, by golden section.
fn minimum(middle: f64, reach: f64, within: f64, cost: &dyn Fn(f64) -> f64) -> f64 {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    let (mut low, mut high) = (middle - reach, middle + reach);
    let inner = |low: f64, high: f64| [high - GOLDEN * (high - low), low + GOLDEN * (high - low)];
    let [mut a, mut b] = inner(low, high);
    let (mut cost_a, mut cost_b) = (cost(a), cost(b));
    while high - low > within {
        if cost_a < cost_b {
            (high, b, cost_b) = (b, a, cost_a);
            a = inner(low, high)[0];
            cost_a = cost(a);
        } else {
            (low, a, cost_a) = (a, b, cost_b);
            b = inner(low, high)[1];
            cost_b = cost(b);
        }
    }
    0.5 * (low + high)
}

/// A wall through the ranges of a track.
struct Fit {
    /// Normal and distance: range is `distance - normal . place`.
    normal: [f64; 2],
    distance_m: f64,
    cost: f64,
    rms_m: f64,
}

/// Linear least squares, twice: the second time residuals count less the larger they were.
fn fit(track: &Track, at: &dyn Fn(f64) -> Pose) -> Fit {
    let places: Vec<[f64; 2]> = track
        .iter()
        .map(|&[t_s, _]| {
            let pose = at(t_s);
            [pose.x_m, pose.y_m]
        })
        .collect();
    let count = track.len() as f64;
    let mean = |axis: usize| places.iter().map(|place| place[axis]).sum::<f64>() / count;
    let middle = [mean(0), mean(1)];
    let mut weights = vec![1.0; track.len()];
    let mut solution = [0.0; 3];
    for _ in 0..3 {
        // Unknowns: normal x, normal y, range at the middle. A little of the identity keeps straight drives solvable.
        let mut matrix = nalgebra::Matrix3::from_diagonal_element(1e-6 * count);
        let mut right = nalgebra::Vector3::zeros();
        for ((place, &[_, range_m]), weight) in places.iter().zip(track).zip(&weights) {
            let row = nalgebra::Vector3::new(middle[0] - place[0], middle[1] - place[1], 1.0);
            matrix += *weight * row * row.transpose();
            right += *weight * range_m * row;
        }
        let Some(inverse) = matrix.try_inverse() else {
            break;
        };
        let found = inverse * right;
        solution = [found[0], found[1], found[2]];
        for ((place, &[_, range_m]), weight) in places.iter().zip(track).zip(&mut weights) {
            let residual = residual(solution, middle, *place, range_m);
            *weight = 1.0 / (1.0 + (residual / SCALE_M).powi(2));
        }
    }
    let residuals = places
        .iter()
        .zip(track)
        .map(|(place, &[_, range_m])| residual(solution, middle, *place, range_m));
    let squares: f64 = residuals.clone().map(|residual| residual * residual).sum();
    let [x, y, range_m] = solution;
    Fit {
        normal: [x, y],
        distance_m: range_m + x * middle[0] + y * middle[1],
        cost: residuals
            .map(|residual| (residual / SCALE_M).powi(2).ln_1p())
            .sum(),
        rms_m: (squares / count).sqrt(),
    }
}

fn residual([x, y, range]: [f64; 3], middle: [f64; 2], place: [f64; 2], range_m: f64) -> f64 {
    range + x * (middle[0] - place[0]) + y * (middle[1] - place[1]) - range_m
}

/// Joins tracks of one wall: each to the first group that its ranges fit.
fn merge(tracks: &[Track], at: &dyn Fn(f64) -> Pose) -> Vec<Track> {
    let mut sorted: Vec<&Track> = tracks.iter().collect();
    sorted.sort_by_key(|track| std::cmp::Reverse(track.len()));
    let mut groups: Vec<Track> = Vec::new();
    for track in sorted {
        let own = fit(track, at);
        let joined = groups.iter_mut().find_map(|group| {
            let other = fit(group, at);
            let [dx, dy] = [0, 1].map(|axis| own.normal[axis] - other.normal[axis]);
            if dx.hypot(dy) > 0.5 || (own.distance_m - other.distance_m).abs() > 1.5 {
                return None;
            }
            let mut both = group.clone();
            both.extend_from_slice(track);
            (fit(&both, at).rms_m < 0.015).then_some((group, both))
        });
        match joined {
            Some((group, both)) => *group = both,
            None => groups.push(track.clone()),
        }
    }
    groups
}
