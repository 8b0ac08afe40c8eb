//! How a run goes on and ends.

/// How far a run is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Progress {
    /// Steps done, warm-ups of a free field's pieces included.
    pub step: u64,
    /// Steps in all, likewise.
    pub steps_total: u64,
}

/// What an observer wants.
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
