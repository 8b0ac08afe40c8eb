//! Progress, control and end of a run.

/// How far a run is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Progress {
    /// Steps done, warm-ups of a free field's segments included.
    pub step: u64,
    /// Steps in all, likewise.
    pub steps_total: u64,
}

/// Decision of an observer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Flow {
    /// Go on.
    Continue,
    /// Go on with this many threads, which changes no byte.
    OnThreads(usize),
    /// Stop after this step; the run can be continued.
    Stop,
}

/// How a run ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// All steps are done.
    Finished,
    /// The observer stopped it.
    Stopped,
}

/// Times of calls of an observer: every so many steps of the drive, each to the nearest step.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rhythm {
    /// Steps between two looks, one or more, not whole in general.
    steps: f64,
}

impl Rhythm {
    /// A look every `period_s` seconds of steps of `dt_s`; every step when that is shorter.
    pub(super) fn new(period_s: f64, dt_s: f64) -> Self {
        Self {
            steps: (period_s / dt_s).max(1.0),
        }
    }

    /// The first step after `step` at which to look.
    pub(super) fn next_after(self, step: u64) -> u64 {
        let at = |look: f64| (look * self.steps).round() as u64;
        let look = (step as f64 / self.steps).floor();
        // The look at or before `step` may round up beyond it.
        [0.0, 1.0, 2.0]
            .map(|later| at(look + later))
            .into_iter()
            .find(|&next| next > step)
            .unwrap_or(u64::MAX)
    }

    /// Whether `step` is one at which to look; the start is none.
    pub(super) fn is_on(self, step: u64) -> bool {
        step > 0 && self.next_after(step - 1) == step
    }
}

#[cfg(test)]
mod tests {
    use super::Rhythm;

    #[test]
    fn looks_come_at_the_nearest_steps_and_none_is_left_out() {
        for steps in [1.0, 1.5, 2.5, 7.3, 119.999_999, 120.0] {
            let rhythm = Rhythm::new(steps * 0.25, 0.25);
            let mut step = 0;
            for look in 1..400 {
                step = rhythm.next_after(step);
                assert_eq!(step, (f64::from(look) * steps).round() as u64, "{steps}");
                assert!(rhythm.is_on(step));
            }
        }
        let rhythm = Rhythm::new(2.0, 0.5);
        assert_eq!(
            [0, 3, 4, 5, 8].map(|step| rhythm.is_on(step)),
            [false, false, true, false, true]
        );
    }

    #[test]
    fn periods_out_of_reach_are_harmless() {
        assert_eq!(Rhythm::new(1e-300, 1e-6).next_after(7), 8);
        assert_eq!(Rhythm::new(1e300, 1e-6).next_after(7), u64::MAX);
    }
}
