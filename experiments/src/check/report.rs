//! The claims and verdicts as a table on the terminal and as the generated file `report.md` of the results.

use std::path::Path;

use anyhow::Result;

use super::targets::{Measure, Targets};
use super::verdicts::{Judged, Verdict};
use crate::data::atomic;
use crate::data::table::aligned;
use crate::summary::Summary;

/// Our number with its interval.
pub fn ours(judged: &Judged) -> String {
    match judged.interval {
        Some([low, high]) => format!("{} [{low:.3}, {high:.3}]", judged.ours),
        None => judged.ours.clone(),
    }
}

/// The verdict, bold where a claim is not reproduced.
pub(super) fn verdict(judged: &Judged) -> &'static str {
    match judged.verdict {
        Verdict::NotReproduced => "**not reproduced**",
        other => other.name(),
    }
}

/// Number of claims with each verdict, as text.
pub fn count(judged: &[Judged]) -> String {
    [
        Verdict::Reproduced,
        Verdict::Consistent,
        Verdict::NotReproduced,
        Verdict::NotRun,
        Verdict::CannotBeTested,
    ]
    .iter()
    .map(|verdict| {
        let count = judged
            .iter()
            .filter(|judged| judged.verdict == *verdict)
            .count();
        (count, verdict.name().to_lowercase())
    })
    .filter(|(count, _)| *count > 0)
    .map(|(count, name)| format!("{count} {name}"))
    .collect::<Vec<_>>()
    .join(", ")
}

/// The claims as a table for a terminal.
pub fn table(judged: &[Judged]) -> String {
    let mut rows = vec![
        ["id", "claim", "paper", "ours [95 % interval]", "verdict"]
            .map(String::from)
            .to_vec(),
    ];
    rows.extend(judged.iter().map(|judged| {
        vec![
            judged.target.id.clone(),
            judged.target.claim.clone(),
            judged.target.claimed.clone(),
            ours(judged),
            judged.verdict.name().to_string(),
        ]
    }));
    aligned(&rows)
}

/// The report as Markdown: one table per paper, then the way to each number.
pub fn markdown(targets: &Targets, judged: &[Judged], summary: &Summary) -> String {
    let cell = |text: &str| text.replace('|', "\\|");
    let mut text = format!(
        "# The papers' claims\n\nWritten by `echolot check` from `summary.json` (revision {}) and\n\
         `experiments/targets.json`; do not edit.\n\n{}.\n",
        summary.provenance.commit,
        count(judged)
    );
    for (key, citation) in targets.papers.iter().rev() {
        text.push_str(&format!(
            "\n## {citation}\n\n| id | where | claim | paper | ours (95 % interval) | trials | verdict |\n\
             |---|---|---|---|---|---|---|\n"
        ));
        for judged in judged.iter().filter(|judged| judged.target.paper == *key) {
            let target = &judged.target;
            let verdict = verdict(judged);
            let trials = judged.our_trials.or(target.trials);
            text.push_str(&format!(
                "| `{}` | {} | {} | {} | {} | {} | {verdict} |\n",
                target.id,
                cell(&target.source),
                cell(&target.claim),
                cell(&target.claimed),
                cell(&ours(judged)),
                trials.map_or(String::new(), |count| count.to_string()),
            ));
        }
    }
    text.push_str("\n## How each is measured\n\n| id | measure | value | tolerance | why |\n|---|---|---|---|---|\n");
    for judged in judged {
        let target = &judged.target;
        let measure = match &target.measure {
            Measure::Path { summary, bound } => {
                let side = match bound {
                    super::targets::Bound::AtMost => "at most",
                    super::targets::Bound::Near => "near",
                };
                format!("`{summary}`, {side} the value")
            }
            Measure::Rule { rule } => cell(rule),
            Measure::Untestable { .. } => "cannot be tested".to_string(),
        };
        text.push_str(&format!(
            "| `{}` | {measure} | {} | {} | {} |\n",
            target.id,
            target
                .value
                .map_or(String::new(), |value| value.to_string()),
            target.tolerance,
            cell(&target.why),
        ));
    }
    text
}

/// Writes `report.md` beside the summary.
///
/// # Errors
/// When the file cannot be written.
pub fn write(folder: &Path, targets: &Targets, judged: &[Judged], summary: &Summary) -> Result<()> {
    let text = markdown(targets, judged, summary);
    atomic::write(&folder.join("report.md"), text.as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::verdicts::judge;

    #[test]
    fn the_report_names_every_claim_and_paper() {
        let targets = Targets::load().unwrap();
        let summary = Summary::named("paper");
        let judged = judge(&targets, &summary).unwrap();
        let folder = tempfile::tempdir().unwrap();
        write(folder.path(), &targets, &judged, &summary).unwrap();
        let text = std::fs::read_to_string(folder.path().join("report.md")).unwrap();
        for target in &targets.targets {
            assert_eq!(
                text.matches(&format!("| `{}` |", target.id)).count(),
                2,
                "{}",
                target.id
            );
        }
        assert!(
            targets
                .papers
                .values()
                .all(|citation| text.contains(citation))
        );
        let wide = text.lines().filter(|line| line.starts_with('|'));
        assert!(wide.clone().count() > 2 * targets.targets.len());
        assert!(table(&judged).contains("cannot be tested"));
        assert!(count(&judged).contains("not run"));
    }
}
