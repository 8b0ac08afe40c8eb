//! Following the pose among landmarks: a few Gaussian hypotheses, as many as the echoes leave open.

use super::hypothesis::{Hypothesis, Noise, Seen};
use super::map::LandmarkMap;
use super::search::search;
use super::track::{SURE_LOG_ODDS, Track};
use crate::odometry::Odometry;
use crate::pose::Pose;

/// How far an estimate is to be trusted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Status {
    /// Several poses are still possible.
    Converging,
    /// One pose fits, and has for a while.
    Sure,
    /// No pose fits: the estimate is dead reckoning from the last one that did.
    Lost,
}

/// Pose at the start of a drive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Start {
    /// Known, with standard deviations.
    Known {
        /// The pose.
        pose: Pose,
        /// Standard deviation of x and y in metres.
        sigma_m: f64,
        /// Standard deviation of the heading in radians.
        sigma_rad: f64,
    },
    /// Anywhere in the map.
    Unknown,
}

/// Standard deviation of the cosines from which on a block tells directions apart well enough for a search.
const SEARCH_COSINE_SIGMA: f64 = 0.35;
/// Blocks for which a fit must be good to be sure.
const GOOD_BLOCKS: usize = 10;
/// Blocks for which it must be bad for the pose to be sure no longer, and for the robot to be lost.
const DOUBTFUL_BLOCKS: usize = 5;
const BAD_BLOCKS: usize = 15;
/// Blocks in which guesses settle, blocks over which they are compared with the pose that is followed, and blocks after
/// which a search that found no pose begins anew.
const SETTLING_BLOCKS: usize = 12;
const COMPARED_BLOCKS: usize = 20;
const SEARCH_BLOCKS: usize = 30;
/// Blocks after the first search at which its outcome is held against another one.
const CHECK_BLOCKS: [usize; 3] = [25, 50, 75];

/// A filter: the pose that is followed and, while it does not fit, the poses that might be true instead.
pub struct LandmarkFilter {
    noise: Noise,
    main: Track,
    challenger: Option<Track>,
    /// Whether the challenger has settled.
    settled: bool,
    status: Status,
    searching: bool,
    /// Blocks until a pose that a search found is held against another search: symmetric places have copies.
    checks: &'static [usize],
    since_start: usize,
}

impl LandmarkFilter {
    /// A filter at a start.
    pub fn new(start: &Start, noise: Noise) -> Self {
        let (hypotheses, status) = match start {
            Start::Known {
                pose,
                sigma_m,
                sigma_rad,
            } => (
                vec![Hypothesis::new(
                    pose,
                    sigma_m.max(1e-3),
                    sigma_rad.max(1e-3),
                    &noise,
                )],
                Status::Sure,
            ),
            Start::Unknown => (Vec::new(), Status::Converging),
        };
        Self {
            noise,
            searching: hypotheses.is_empty(),
            main: Track::of(hypotheses),
            challenger: None,
            settled: false,
            status,
            checks: match start {
                Start::Known { .. } => &[],
                Start::Unknown => &CHECK_BLOCKS,
            },
            since_start: 0,
        }
    }

    /// The best hypothesis; none before the first block of an unknown start.
    pub fn best(&self) -> Option<&Hypothesis> {
        self.main.hypotheses.first()
    }

    /// All hypotheses that are followed, the best one first.
    pub fn hypotheses(&self) -> &[Hypothesis] {
        &self.main.hypotheses
    }

    /// How far the best hypothesis is to be trusted.
    pub fn status(&self) -> Status {
        self.status
    }

    /// Share of the expected echoes that the best hypothesis found lately.
    pub fn fit(&self) -> f64 {
        self.main.fit()
    }

    /// Moves all hypotheses by the wheels.
    pub fn predict(&mut self, odometry: Odometry, duration_s: f64) {
        self.main.predict(odometry, duration_s, &self.noise);
        if let Some(challenger) = &mut self.challenger {
            challenger.predict(odometry, duration_s, &self.noise);
        }
    }

    /// Takes in the peaks of a block.
    pub fn update(&mut self, seen: &Seen<'_>, map: &LandmarkMap) {
        if self.searching && seen.cosine_sigma < SEARCH_COSINE_SIGMA {
            self.searching = false;
            let found = Track::of(search(seen, map, &self.noise));
            if self.main.hypotheses.is_empty() {
                // The block has been used.
                self.main = found;
                return;
            }
            self.challenger = Some(found);
            self.settled = false;
        } else if let Some(challenger) = &mut self.challenger {
            challenger.update(seen, map, &self.noise);
            if challenger.blocks == SETTLING_BLOCKS && !self.settled {
                // Both are compared from here on.
                challenger.begin();
                self.main.begin();
                self.settled = true;
            }
        }
        self.main.update(seen, map, &self.noise);
        self.judge();
    }

    fn judge(&mut self) {
        if let Some(challenger) = self
            .challenger
            .take_if(|challenger| self.settled && challenger.blocks >= 1)
        {
            let lead = challenger.lately - self.main.lately;
            let lost = self.status == Status::Lost;
            // A pose that is lost may as well be one of several that fit.
            let fits = challenger.blocks >= GOOD_BLOCKS && challenger.fits();
            if lost && fits && lead > SURE_LOG_ODDS {
                self.main = challenger;
                self.status = Status::Converging;
                (self.checks, self.since_start) = (&CHECK_BLOCKS, 0);
            } else if !lost && challenger.blocks >= COMPARED_BLOCKS {
                self.main.join(challenger);
            } else if challenger.blocks < SEARCH_BLOCKS {
                self.challenger = Some(challenger);
            }
        }
        if self.challenger.is_none() {
            self.settled = false;
        }
        if self.main.good >= GOOD_BLOCKS {
            self.status = Status::Sure;
        } else if self.main.bad >= BAD_BLOCKS {
            self.status = Status::Lost;
        } else if self.status == Status::Sure
            && (self.main.bad >= DOUBTFUL_BLOCKS || !self.main.is_single())
        {
            self.status = Status::Converging;
        }
        let lost = self.status == Status::Lost && self.challenger.is_none();
        self.since_start += usize::from(!self.main.hypotheses.is_empty());
        let due = self
            .checks
            .first()
            .is_some_and(|&blocks| self.since_start >= blocks);
        if due {
            self.checks = &self.checks[1..];
        }
        self.searching |= lost || due || self.main.hypotheses.is_empty();
    }
}

#[cfg(test)]
mod tests {
    use super::super::learn;
    use super::super::simulated::{self, Drive};
    use super::*;
    use crate::pose::wrap_angle;

    /// A map learnt from a drive of its own.
    fn map() -> LandmarkMap {
        let drive = Drive::new(77, simulated::shapes());
        let parameters = drive.parameters.clone();
        let seen: Vec<_> = drive.take(390).map(|block| block.sighting).collect();
        LandmarkMap {
            parameters,
            landmarks: learn::landmarks(&seen, 0.0),
            area_m: [[-1.0, 1.0], [-1.0, 1.0]],
            explained: 0.5,
        }
    }

    fn step(filter: &mut LandmarkFilter, block: &simulated::Block, map: &LandmarkMap) {
        filter.predict(block.odometry, map.parameters.period_s());
        filter.update(&block.seen(&map.parameters), map);
    }

    #[test]
    fn errors_are_as_large_as_the_covariance_says_and_the_wheels_errors_are_found() {
        let map = map();
        let (mut nees, mut count, mut found) = (0.0, 0.0, 0.0);
        for seed in 1..=40 {
            let mut drive = Drive::new(seed, simulated::shapes());
            drive.wheel_errors = [0.01, 0.01];
            let start = Start::Known {
                pose: drive.pose(),
                sigma_m: 0.001,
                sigma_rad: 0.002,
            };
            // Peaks are independent here, blocks do not overlap.
            let noise = Noise {
                alike_blocks: 1.0,
                ..Noise::default()
            };
            let mut filter = LandmarkFilter::new(&start, noise);
            for block in drive.by_ref().take(200) {
                step(&mut filter, &block, &map);
                let best = filter.best().expect("a known start");
                let pose = best.pose();
                let off = nalgebra::Vector3::new(
                    pose.x_m - block.truth.x_m,
                    pose.y_m - block.truth.y_m,
                    wrap_angle(pose.heading_rad - block.truth.heading_rad),
                );
                let inverse = best.pose_covariance().try_inverse().expect("a covariance");
                nees += (off.transpose() * inverse * off)[0] / 3.0;
                count += 1.0;
                assert!(off.xy().norm() < 0.01, "seed {seed}: {off:?}");
            }
            found += filter.best().map_or(0.0, |best| best.state[3]) / 40.0;
        }
        let nees = nees / count;
        assert!((0.5..1.5).contains(&nees), "{nees}");
        assert!(
            (found + 0.01).abs() < 0.004,
            "the wheels turn {found} rad/s too little"
        );
    }

    /// Largest and mean error in metres over drives in which `change` was made, and the share of blocks that were sure;
    /// the map is learnt from such a drive too.
    fn changed(change: impl Fn(&mut Drive)) -> (f64, f64, f64, usize) {
        let mut own = Drive::new(77, simulated::shapes());
        change(&mut own);
        let seen: Vec<_> = own.take(390).map(|block| block.sighting).collect();
        let map = LandmarkMap {
            landmarks: learn::landmarks(&seen, 0.0),
            ..map()
        };
        let (mut worst_m, mut sum_m, mut sure, mut count) = (0.0_f64, 0.0, 0.0, 0.0);
        for seed in 1..=20 {
            let mut drive = Drive::new(seed, simulated::shapes());
            change(&mut drive);
            drive.wheel_errors = [0.01, 0.01];
            let start = Start::Known {
                pose: drive.pose(),
                sigma_m: 0.001,
                sigma_rad: 0.002,
            };
            let mut filter = LandmarkFilter::new(&start, Noise::default());
            for block in drive.by_ref().take(300) {
                step(&mut filter, &block, &map);
                let best = filter.best().expect("a known start");
                let off_m = best.pose().distance_m(&block.truth);
                worst_m = worst_m.max(off_m);
                sum_m += off_m;
                sure += f64::from(u8::from(filter.status() == Status::Sure));
                count += 1.0;
            }
        }
        (worst_m, sum_m / count, sure / count, map.landmarks.len())
    }

    #[test]
    fn a_person_who_walks_around_and_a_round_pillar_do_not_take_the_pose_along() {
        let alone = changed(|_| {});
        assert_eq!(alone.3, simulated::shapes().len());
        let person = changed(|drive| drive.person = true);
        // Whoever walks is no landmark.
        assert_eq!(person.3, simulated::shapes().len());
        let pillar = changed(|drive| drive.pillar = Some(([-1.5, 1.0], 0.2)));
        for (what, found) in [("a person", person), ("a pillar", pillar)] {
            let (worst_m, mean_m, sure, _) = found;
            assert!(
                worst_m < 0.01 && mean_m < 1.2 * alone.1,
                "{what}: {found:?}, alone {alone:?}"
            );
            assert!(sure > alone.2 - 0.1, "{what}: {found:?}, alone {alone:?}");
        }
    }

    #[test]
    fn an_unknown_start_is_found_and_a_kidnapped_robot_again() {
        let map = map();
        let (mut found, mut again) = (0, 0);
        for seed in 1..=10 {
            let mut drive = Drive::new(seed, simulated::shapes());
            let mut filter = LandmarkFilter::new(&Start::Unknown, Noise::default());
            assert_eq!(filter.status(), Status::Converging);
            let off = |filter: &LandmarkFilter, truth: &Pose| {
                filter
                    .best()
                    .map_or(f64::INFINITY, |best| best.pose().distance_m(truth))
            };
            for block in drive.by_ref().take(100) {
                step(&mut filter, &block, &map);
            }
            found +=
                usize::from(off(&filter, &drive.pose()) < 0.05 && filter.status() == Status::Sure);
            let [x_m, y_m] =
                [0.8 - drive.pose().x_m, -0.7 - drive.pose().y_m].map(|to| to.clamp(-0.9, 0.9));
            drive.kidnap(Pose {
                x_m,
                y_m,
                heading_rad: wrap_angle(drive.pose().heading_rad + 2.0),
            });
            let mut lost = false;
            for block in drive.by_ref().take(100) {
                step(&mut filter, &block, &map);
                lost |= filter.status() == Status::Lost;
            }
            assert!(lost, "seed {seed}: it says so");
            let back = off(&filter, &drive.pose()) < 0.05;
            again += usize::from(back);
            assert!(
                back || filter.status() != Status::Sure,
                "seed {seed}: sure and wrong"
            );
        }
        // Four landmarks tell where it is, one in ten is hidden, and there is time for two searches.
        assert!(found >= 9 && again >= 7, "{found} and {again} of 10");
    }

    #[test]
    fn without_echoes_the_uncertainty_grows_and_nothing_is_sure_for_long() {
        let map = map();
        let start = Start::Known {
            pose: Pose::default(),
            sigma_m: 0.001,
            sigma_rad: 0.002,
        };
        let mut filter = LandmarkFilter::new(&start, Noise::default());
        let mut drive = Drive::new(5, Vec::new());
        let mut sigma_m = 0.0;
        for block in drive.by_ref().take(120) {
            step(&mut filter, &block, &map);
            sigma_m = filter
                .best()
                .map_or(0.0, |best| best.covariance[(0, 0)].sqrt());
        }
        assert!(sigma_m > 0.02, "{sigma_m}");
        assert_ne!(filter.status(), Status::Sure);
    }
}
