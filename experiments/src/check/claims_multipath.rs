//! Claims of the 2021 multipath paper.

use super::claims::{Claim, metres};
use crate::summary::{Multipath, Summary};

/// Final error above which a path counts as lost, metres.
const LOST_M: f64 = 0.5;

/// The paper's claims; not reproduced where the study was not run.
pub(super) fn claims(summary: &Summary) -> Vec<Claim> {
    let found = summary.multipath.as_ref();
    let claim = |claim: &str, paper: &str, judge: &dyn Fn(&Multipath) -> (String, bool)| {
        let (ours, reproduced) = found.map_or(("study not run".to_string(), false), judge);
        Claim {
            claim: claim.to_string(),
            paper: paper.to_string(),
            ours,
            reproduced,
        }
    };
    vec![
        claim(
            "multipath, model (c) with ceiling and floor: mean error (2021)",
            "0.085 m",
            &|found| {
                let accuracy = &found.spatial.accuracy;
                (metres(accuracy), accuracy.mae_m <= 0.085)
            },
        ),
        claim(
            "multipath, (c) better than (b) better than (a)",
            "Fig. 3",
            &|found| {
                let [a, b, c] = [&found.single, &found.planar, &found.spatial]
                    .map(|followed| followed.accuracy.mae_m);
                (format!("{c:.3}, {b:.3} and {a:.3} m"), c < b && b < a)
            },
        ),
        claim(
            "multipath, (a) loses the path: more than 0.5 m off at the end, (c) not",
            "Fig. 3",
            &|found| {
                let (a, c) = (found.single.final_m, found.spatial.final_m);
                // With a narrow gate no model loses the path: the verdict depends on it, so it stands beside it.
                let narrow = found
                    .gates
                    .iter()
                    .min_by(|x, y| x.gate_m.total_cmp(&y.gate_m))
                    .map_or(String::new(), |gate| {
                        let (gate_m, error_m) = (gate.gate_m, gate.single_m);
                        format!("; MAE of (a) at a gate of {gate_m} m: {error_m:.3} m")
                    });
                (
                    format!("{a:.3} and {c:.3} m{narrow}"),
                    a > LOST_M && c < LOST_M,
                )
            },
        ),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metrics::Accuracy;
    use crate::preset::Preset;
    use crate::summary::{FollowedPath, MultipathScene};

    #[test]
    fn verdicts_follow_the_numbers() {
        let accuracy = |mae_m: f64| Accuracy::over(&[(&[mae_m], &[0.0])]);
        let followed = |mae_m: f64| FollowedPath {
            final_m: 2.0 * mae_m,
            accuracy: accuracy(mae_m),
        };
        let mut summary = Summary::new(Preset::Paper);
        let verdicts = |summary: &Summary| -> Vec<bool> {
            claims(summary)
                .iter()
                .map(|claim| claim.reproduced)
                .collect()
        };
        assert_eq!(verdicts(&summary), [false; 3]);
        summary.multipath = Some(Multipath {
            single: followed(0.4),
            planar: followed(0.1),
            spatial: followed(0.05),
            odometry: followed(0.5),
            gates: Vec::new(),
            scene: MultipathScene {
                planar: accuracy(0.1),
                doppler: accuracy(0.1),
                odometry: accuracy(0.3),
            },
        });
        assert_eq!(verdicts(&summary), [true; 3]);
        if let Some(found) = &mut summary.multipath {
            found.single = followed(0.09);
        }
        assert_eq!(verdicts(&summary), [true, false, false]);
    }
}
