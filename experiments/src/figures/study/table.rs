//! Measures of every cell and method as a table.

use crate::study::StudySummary;
use crate::study::cells::all_in_words;
use crate::study::scores::Measure;

/// The table's rows, its head first: cell, method, and each measure's mean with its interval.
pub(crate) fn rows(summary: &StudySummary, measures: &[Measure]) -> Vec<Vec<String>> {
    let titles = measures.iter().map(|measure| measure.title().to_string());
    let mut rows = vec![
        ["cell", "method"]
            .map(String::from)
            .into_iter()
            .chain(titles)
            .collect::<Vec<_>>(),
    ];
    for scores in &summary.cells {
        let cell = match scores.labels.is_empty() {
            true => "all".to_string(),
            false => all_in_words(&scores.labels),
        };
        let numbers = measures.iter().map(|measure| {
            let mean = scores.mean.get(measure.name());
            let interval = scores.interval.get(measure.name());
            match (mean, interval.filter(|_| scores.trials > 1)) {
                (None, _) => "\u{2013}".to_string(),
                (Some(mean), None) => super::number(*mean),
                (Some(mean), Some(&[low, high])) => {
                    let [mean, low, high] = [*mean, low, high].map(super::number);
                    format!("{mean} [{low}, {high}]")
                }
            }
        });
        let names = [cell, scores.method.name().to_string()];
        rows.push(names.into_iter().chain(numbers).collect());
    }
    rows
}
