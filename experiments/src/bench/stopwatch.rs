//! Time that this thread was running: on a machine that others use too, a far better measure of one thread's work than time
//! on the wall.

use std::time::Instant;

/// Started now, read by [`Stopwatch::seconds`].
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

    /// Seconds that this thread was running since the start; seconds on the wall where the system does not tell.
    pub(super) fn seconds(&self) -> f64 {
        let wall = self.wall.elapsed().as_secs_f64();
        match (self.running_s, running_s()) {
            (Some(from), Some(to)) => to - from,
            _ => wall,
        }
    }
}

/// Seconds that this thread has been running so far.
#[cfg(unix)]
fn running_s() -> Option<f64> {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    Some(time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64)
}

/// Seconds that this thread has been running so far, if the system told.
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
