//! One run of the program: progress, interruption and provenance.

pub mod interrupt;
pub mod progress;
pub mod project;
pub mod provenance;

/// The causes of an error in one line, without those that the cause before contains.
pub fn one_line(error: &anyhow::Error) -> String {
    let mut text = String::new();
    for cause in error.chain() {
        let cause = cause
            .to_string()
            .split_whitespace()
            .collect::<Vec<_>>()
            .join(" ");
        if text.is_empty() {
            text = cause;
        } else if !text.contains(&cause) {
            text = format!("{text}: {cause}");
        }
    }
    text
}
