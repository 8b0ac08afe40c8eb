//! Progress with the remaining time: bars on a terminal, a line from time to time elsewhere.

use std::io::IsTerminal;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use indicatif::{MultiProgress, ProgressBar, ProgressStyle};

/// Pause between two lines when there is no terminal.
const LINE_PERIOD: Duration = Duration::from_secs(60);

/// The bars of one command, one below the other.
#[derive(Clone)]
pub struct Board {
    bars: MultiProgress,
    terminal: bool,
}

/// Progress of one task.
pub struct Task {
    bars: MultiProgress,
    bar: ProgressBar,
    label: String,
    length: AtomicU64,
    terminal: bool,
    started: Instant,
    first: Mutex<Option<u64>>,
    spoken: Mutex<Instant>,
}

impl Default for Board {
    fn default() -> Self {
        Self::new()
    }
}

impl Board {
    /// A board on standard error.
    pub fn new() -> Self {
        Self {
            bars: MultiProgress::new(),
            terminal: std::io::stderr().is_terminal(),
        }
    }

    /// Starts a task of `length` equal parts.
    pub fn task(&self, label: impl Into<String>, length: u64) -> Task {
        let label = label.into();
        let bar = if self.terminal {
            let bar = self.bars.add(ProgressBar::new(length));
            if let Ok(style) = ProgressStyle::with_template(
                "{prefix:28!} {wide_bar} {percent:>3} %  {elapsed_precise}, {eta_precise} left",
            ) {
                bar.set_style(style);
            }
            bar.set_prefix(label.clone());
            bar
        } else {
            ProgressBar::hidden()
        };
        let now = Instant::now();
        Task {
            bars: self.bars.clone(),
            bar,
            label,
            length: AtomicU64::new(length),
            terminal: self.terminal,
            started: now,
            first: Mutex::new(None),
            spoken: Mutex::new(now),
        }
    }

    /// Prints a line on standard error above the bars.
    pub fn say(&self, line: impl AsRef<str>) {
        say(&self.bars, self.terminal, line.as_ref());
    }
}

fn say(bars: &MultiProgress, terminal: bool, line: &str) {
    if terminal {
        bars.suspend(|| eprintln!("{line}"));
    } else {
        eprintln!("{line}");
    }
}

impl Task {
    /// Corrects the number of parts, once it is known.
    pub fn set_length(&self, length: u64) {
        self.length.store(length, Ordering::Relaxed);
        self.bar.set_length(length);
    }

    /// Reports that `done` parts are done.
    pub fn set(&self, done: u64) {
        if self.terminal {
            // The first report of a resumed task says nothing about speed.
            if let Ok(mut first) = self.first.lock()
                && first.is_none()
            {
                *first = Some(done);
                self.bar.set_position(done);
                self.bar.reset_eta();
            }
            self.bar.set_position(done);
            return;
        }
        let (Ok(mut first), Ok(mut spoken)) = (self.first.lock(), self.spoken.lock()) else {
            return;
        };
        let first = *first.get_or_insert(done);
        if spoken.elapsed() >= LINE_PERIOD && done > first {
            *spoken = Instant::now();
            let length = self.length.load(Ordering::Relaxed);
            let left = self.started.elapsed().as_secs_f64() * (length.saturating_sub(done)) as f64
                / (done - first) as f64;
            eprintln!(
                "{}: {} %, about {} left",
                self.label,
                100 * done / length.max(1),
                duration(left)
            );
        }
    }

    /// Prints a line on standard error above the bars.
    pub fn say(&self, line: impl AsRef<str>) {
        say(&self.bars, self.terminal, line.as_ref());
    }

    /// Removes the bar.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

impl Drop for Task {
    fn drop(&mut self) {
        self.finish();
    }
}

/// A duration for people: `3.2 s`, `48 s`, `12 min 5 s`, `1 h 3 min`.
pub fn duration(seconds: f64) -> String {
    let whole = seconds.max(0.0).round() as u64;
    match whole {
        0..10 => format!("{:.1} s", seconds.max(0.0)),
        10..120 => format!("{whole} s"),
        120..3600 => format!("{} min {} s", whole / 60, whole % 60),
        _ => format!("{} h {} min", whole / 3600, whole % 3600 / 60),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn durations_read_well() {
        assert_eq!(duration(3.21), "3.2 s");
        assert_eq!(duration(48.4), "48 s");
        assert_eq!(duration(725.0), "12 min 5 s");
        assert_eq!(duration(3780.0), "1 h 3 min");
        assert_eq!(duration(-1.0), "0.0 s");
    }
}
