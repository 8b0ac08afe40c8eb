//! The drive so far: what was seen from its blocks, and the estimate of poses, wheels and landmarks together.

use nalgebra::{Matrix3, SMatrix, Vector5};

use super::associate::associate;
use super::graph::{Graph, Match, STATES};
use crate::landmarks::{Landmark, LandmarkMap, Noise, Shape, Sighting, learn};
use crate::odometry::Odometry;
use crate::parameters::Parameters;
use crate::pose::Pose;

/// What poses by the wheels alone are off by against each other in the first seconds, in metres.
const FIRST_SIGMA_M: f64 = 0.015;
/// The same of refined poses: the least for which landmarks explain enough peaks a block counts.
const REFINED_SIGMAS_M: [f64; 3] = [0.002, 0.005, 0.015];
const ENOUGH_EXPLAINED: f64 = 1.5;
/// Gates on the range before landmarks are learnt anew, and after, in metres.
const COARSE_GATES_M: [f64; 4] = [0.08, 0.08, 0.05, 0.03];
const FINE_GATES_M: [f64; 3] = [0.04, 0.03, 0.025];
/// Part of a gate that is the range's standard deviation while poses are coarse.
const GATE_PART: f64 = 0.1;
/// Range residual in metres up to which a peak speaks for an estimate, and by how many nats.
const TIGHT_M: f64 = 0.005;
const MATCH_NATS: f64 = 2.0;
/// What the wheels lack, over the usual, beyond which others are tried beside an estimate unless it has so many peaks a
/// block, and beyond which it is dropped.
const DOUBTFUL_STRAIN: f64 = 0.6;
const MANY_MATCHED: f64 = 4.0;
const MOST_STRAIN: f64 = 1.5;
/// Peaks a block that the first estimate needs, and seconds after which it is taken without them.
const CHECKED_MATCHED: f64 = 2.0;
const FIRST_AT_MOST_S: f64 = 20.0;
/// Gauss-Newton steps for each gate.
const STEPS: usize = 2;

/// The start and the blocks of a drive.
pub(super) struct Joint {
    pub(super) graph: Graph,
    /// Mean odometry during each block.
    pub(super) during: Vec<Odometry>,
    /// What each block saw; none while the robot stood.
    pub(super) seen: Vec<Option<Sighting>>,
    /// The landmarks of the last estimate that was taken.
    pub(super) landmarks: Vec<Landmark>,
    /// The graph of that estimate.
    good: Option<Graph>,
    noise: Noise,
}

/// The newest block's numbers, of which the wheels' errors are what they lack there in all.
pub(super) struct Newest {
    pub(super) state: Vector5<f64>,
    /// None where the estimate was dropped.
    pub(super) covariance: Option<SMatrix<f64, STATES, STATES>>,
}

/// One estimate of the drive so far.
struct Attempt {
    graph: Graph,
    landmarks: Vec<Landmark>,
    covariance: SMatrix<f64, STATES, STATES>,
    /// Logarithm of its likelihood, but for a constant.
    score: f64,
    /// Peaks a block that speak for it.
    matched: f64,
}

impl Attempt {
    /// Whether it asks much of the wheels, and not because many echoes say so.
    fn is_doubtful(&self) -> bool {
        let strain = self.graph.strain();
        strain > MOST_STRAIN || (strain > DOUBTFUL_STRAIN && self.matched < MANY_MATCHED)
    }

    /// Whether there are echoes that check it: of two landmarks, what is none fits as well.
    fn is_checked(&self) -> bool {
        self.landmarks.len() > 2 && self.matched >= CHECKED_MATCHED
    }
}

impl Joint {
    /// A drive that has only a start.
    pub(super) fn new(start: Pose, noise: Noise) -> Self {
        Self {
            graph: Graph::new(start),
            during: vec![Odometry::default()],
            seen: vec![None],
            landmarks: Vec::new(),
            good: None,
            noise,
        }
    }

    /// Number of blocks.
    pub(super) fn blocks(&self) -> usize {
        self.graph.nodes.len() - 1
    }

    /// Seconds of the drive.
    fn seconds(&self) -> f64 {
        self.graph.wheels.iter().map(|(_, seconds)| seconds).sum()
    }

    /// Number of blocks that an estimate that was taken has.
    pub(super) fn good_blocks(&self) -> usize {
        self.good.as_ref().map_or(0, |graph| graph.nodes.len() - 1)
    }

    /// Estimates the drive so far and its landmarks together: from the present poses and, where these ask too much of
    /// the wheels, from the last good ones carried on by the wheels. The most likely estimate is taken; when none is
    /// likely, the drive goes on by the wheels.
    pub(super) fn refine(&mut self) -> Newest {
        let followed = self.graph.clone();
        let mut best = self.attempt(self.landmarks.clone());
        let first = self.good.is_none() && self.seconds() < FIRST_AT_MOST_S;
        if first {
            best = best.filter(Attempt::is_checked);
        }
        if best.as_ref().is_none_or(Attempt::is_doubtful) {
            let mut carried = self.good.clone().unwrap_or_else(|| followed.start());
            carried.carry_on(&followed);
            for landmarks in [self.landmarks.clone(), Vec::new()] {
                self.graph = carried.clone();
                if let Some(other) = self.attempt(landmarks)
                    && (!first || other.is_checked())
                    && best.as_ref().is_none_or(|best| other.score > best.score)
                {
                    best = Some(other);
                }
            }
            let usable = |best: &Attempt| {
                best.graph.strain() <= MOST_STRAIN && !(first && best.is_doubtful())
            };
            best = best.filter(usable);
            if best.is_none() {
                self.graph = carried;
                self.place();
            }
        }
        let covariance = best.map(|best| {
            self.graph = best.graph;
            self.landmarks = best.landmarks;
            self.place();
            self.good = Some(self.graph.clone());
            best.covariance
        });
        let last = self.blocks();
        let [x, y, heading, ..] = self.graph.nodes[last];
        let [turn_rate, speed] = self.graph.wheel_errors(last);
        Newest {
            state: Vector5::new(x, y, heading, turn_rate, speed),
            covariance,
        }
    }

    /// Estimates the drive from the graph's present poses with some landmarks, or, where none are given, with those
    /// that are there at these poses.
    fn attempt(&mut self, mut landmarks: Vec<Landmark>) -> Option<Attempt> {
        self.place();
        if landmarks.is_empty() {
            landmarks = learn::landmarks(&self.moving(), FIRST_SIGMA_M);
        }
        self.solve(&mut landmarks, &COARSE_GATES_M)?;
        self.graph.learn_passing();
        let mut landmarks = self.learn_anew();
        let covariance = self.solve(&mut landmarks, &FINE_GATES_M)?;
        let shapes: Vec<Shape> = landmarks.iter().map(|landmark| landmark.shape).collect();
        let mut matches: Vec<Match> = Vec::new();
        associate(&shapes, &self.seen, TIGHT_M, &mut matches);
        Some(Attempt {
            matched: matches.len() as f64 / self.seen.iter().flatten().count().max(1) as f64,
            score: MATCH_NATS * matches.len() as f64 - self.graph.wheel_cost(),
            graph: self.graph.clone(),
            landmarks,
            covariance,
        })
    }

    /// Landmarks at the present poses.
    fn learn_anew(&self) -> Vec<Landmark> {
        let seen = self.moving();
        let mut landmarks = Vec::new();
        for sigma_m in REFINED_SIGMAS_M {
            landmarks = learn::landmarks(&seen, sigma_m);
            let explained: usize = landmarks.iter().map(|landmark| landmark.blocks).sum();
            if explained as f64 >= ENOUGH_EXPLAINED * seen.len() as f64 {
                break;
            }
        }
        landmarks
    }

    /// Sightings of the blocks in which the robot moved.
    fn moving(&self) -> Vec<Sighting> {
        self.seen.iter().flatten().cloned().collect()
    }

    /// Gives all sightings the graph's poses.
    fn place(&mut self) {
        for (node, seen) in self.seen.iter_mut().enumerate() {
            if let Some(sighting) = seen {
                self.graph.place(node, sighting, self.during[node]);
            }
        }
    }

    /// Estimates with ever narrower gates; the covariance of the newest block's numbers. None without landmarks, or
    /// where the equations have no solution.
    fn solve(
        &mut self,
        landmarks: &mut [Landmark],
        gates_m: &[f64],
    ) -> Option<SMatrix<f64, STATES, STATES>> {
        if landmarks.is_empty() {
            return None;
        }
        let mut shapes: Vec<Shape> = landmarks.iter().map(|landmark| landmark.shape).collect();
        let mut matches: Vec<Match> = Vec::new();
        let mut factor = None;
        for &gate_m in gates_m {
            associate(&shapes, &self.seen, gate_m, &mut matches);
            let sigmas = self.range_sigmas_m(landmarks, gate_m);
            let (seen, alike) = (&self.seen, self.noise.alike_blocks);
            factor = self
                .graph
                .solve(&mut shapes, seen, &matches, &sigmas, alike, STEPS);
            factor.as_ref()?;
            self.place();
        }
        let factor = factor?;
        let size = self.graph.size(shapes.len());
        for (number, (landmark, shape)) in landmarks.iter_mut().zip(shapes).enumerate() {
            landmark.shape = shape;
            landmark.covariance = self.graph.landmark_covariance(&factor, number, size);
        }
        Some(self.graph.covariance(&factor, self.blocks(), size))
    }

    /// Standard deviations of the ranges of landmarks; while gates are wide, that of poses counts too.
    fn range_sigmas_m(&self, landmarks: &[Landmark], gate_m: f64) -> Vec<f64> {
        landmarks
            .iter()
            .map(|landmark| {
                let own = landmark.range_sigma_m.hypot(self.noise.range_m);
                own.max(GATE_PART * gate_m)
            })
            .collect()
    }

    /// Covariances of the poses of some blocks beside the landmarks that were taken.
    pub(super) fn covariances(&self, blocks: &[usize]) -> Option<Vec<Matrix3<f64>>> {
        let mut shapes: Vec<Shape> = self.landmarks.iter().map(|known| known.shape).collect();
        let gate_m = FINE_GATES_M[FINE_GATES_M.len() - 1];
        let mut matches: Vec<Match> = Vec::new();
        associate(&shapes, &self.seen, gate_m, &mut matches);
        let sigmas = self.range_sigmas_m(&self.landmarks, gate_m);
        let (mut graph, alike) = (self.graph.clone(), self.noise.alike_blocks);
        let factor = graph.solve(&mut shapes, &self.seen, &matches, &sigmas, alike, 1)?;
        let size = graph.size(shapes.len());
        let of_pose = |&block: &usize| {
            let all = graph.covariance(&factor, block, size);
            all.fixed_view::<3, 3>(0, 0).into_owned()
        };
        Some(blocks.iter().map(of_pose).collect())
    }

    /// The landmarks as a map; none before the first estimate.
    pub(super) fn map(&self, parameters: &Parameters) -> Option<LandmarkMap> {
        if self.landmarks.is_empty() {
            return None;
        }
        let moving = || self.seen.iter().flatten();
        let axis = |of: fn(&Pose) -> f64| {
            let values = moving().map(|sighting| of(&sighting.pose));
            [
                values.clone().fold(f64::INFINITY, f64::min),
                values.fold(f64::NEG_INFINITY, f64::max),
            ]
        };
        let all: usize = moving().map(|sighting| sighting.peaks.len()).sum();
        let explained: usize = self.landmarks.iter().map(|landmark| landmark.blocks).sum();
        Some(LandmarkMap {
            parameters: parameters.clone(),
            landmarks: self.landmarks.clone(),
            area_m: [axis(|pose| pose.x_m), axis(|pose| pose.y_m)],
            explained: explained as f64 / all.max(1) as f64,
        })
    }
}
