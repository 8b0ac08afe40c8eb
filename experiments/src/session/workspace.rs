//! What the sessions of one run share: cache, threads, progress.

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::{Arc, Mutex};

use anyhow::Result;

use crate::data::cache::Cache;
use crate::run::progress::Board;
use crate::schedule::{self, Job};

/// What the sessions of one run share.
#[derive(Clone)]
pub struct Workspace {
    /// The cache.
    pub cache: Cache,
    /// Progress.
    pub board: Board,
    /// Threads to use.
    pub threads: usize,
    /// Simulations side by side; `None` measures which number is faster.
    pub side_by_side: Option<usize>,
    /// Fingerprints of the engines by their choices.
    pub(super) fingerprints: Arc<Mutex<HashMap<String, String>>>,
}

impl Workspace {
    /// A workspace with its cache in a folder.
    pub fn new(cache: impl Into<PathBuf>, side_by_side: Option<usize>) -> Self {
        Self {
            cache: Cache::new(cache),
            board: Board::new(),
            threads: rayon::current_num_threads(),
            side_by_side,
            fingerprints: Arc::default(),
        }
    }

    /// Simulates into the cache.
    ///
    /// # Errors
    /// When a simulation fails or is interrupted.
    pub fn simulate(&self, jobs: &[Job]) -> Result<()> {
        schedule::run(
            jobs,
            &self.cache,
            self.threads,
            self.side_by_side,
            &self.board,
        )
    }
}
