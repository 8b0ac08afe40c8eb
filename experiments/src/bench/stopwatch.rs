//! Processor time of this thread: on a shared machine a far better measure of one thread's work than the wall clock.

use std::time::Instant;

/// A running stopwatch, read by [`Stopwatch::seconds`].
pub(super) struct Stopwatch {
    wall: Instant,
    running_s: Option<f64>,
}

impl Stopwatch {
    /// Starts.
    pub(super) fn start() -> Self {
        Self {
            running_s: running_s(),
            wall: Instant::now(),
        }
    }

    /// Processor time of this thread since the start, seconds; wall-clock time where the system does not report it.
    pub(super) fn seconds(&self) -> f64 {
        let wall = self.wall.elapsed().as_secs_f64();
        match (self.running_s, running_s()) {
            (Some(from), Some(to)) => to - from,
            _ => wall,
        }
    }
}

/// Processor time of this thread so far, seconds.
#[cfg(unix)]
fn running_s() -> Option<f64> {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    Some(time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64)
}

/// Processor time of this thread so far, seconds; `None` where the system does not report it.
#[cfg(not(unix))]
fn running_s() -> Option<f64> {
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_thread_does_not_run_longer_than_the_time_on_the_wall() {
        let stopwatch = Stopwatch::start();
        let wall = Instant::now();
        let mut sum = 0.0_f64;
        while wall.elapsed().as_secs_f64() < 0.05 {
            sum = std::hint::black_box(sum + 1.0);
        }
        let seconds = stopwatch.seconds();
        assert!(seconds > 0.0 && seconds <= wall.elapsed().as_secs_f64() + 1e-3);
    }
}
