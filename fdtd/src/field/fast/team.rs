//! The threads of a field: they share out the tiles of a time block and wait for each other.
//!
//! A block takes well under a millisecond and the threads finish it within microseconds of each other, less than waking
//! a sleeping thread takes. Waits therefore begin with a short spin; the calling thread takes tiles like the others.

use std::sync::atomic::{AtomicIsize, AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use super::tiles::Tile;

/// How long a thread without work spins for the others to finish before it sleeps.
const PATIENCE: Duration = Duration::from_micros(100);
/// Looks at what is waited for between two looks at the clock, or before others get the processor.
const LOOKS: usize = 256;

/// How far the wavefront of a tile has come: all steps are done up to here, less the radius per step. On lines of its
/// own, because another thread looks at it.
#[derive(Debug)]
#[repr(align(128))]
pub(super) struct Front(AtomicIsize);

impl Front {
    fn new() -> Self {
        Self(AtomicIsize::new(isize::MIN))
    }

    /// Publishes that the wavefront has reached `row`.
    pub(super) fn reached(&self, row: isize) {
        self.0.store(row, Ordering::Release);
    }

    /// Waits until the wavefront has reached `row`.
    pub(super) fn wait_for(&self, row: isize) {
        while !(0..LOOKS).any(|_| self.is_at(row)) {
            std::thread::yield_now();
        }
    }

    fn is_at(&self, row: isize) -> bool {
        std::hint::spin_loop();
        self.0.load(Ordering::Acquire) >= row
    }
}

/// Publishes the end of a tile when dropped, also in a panic.
struct Done<'a>(&'a Front, &'a AtomicUsize);

impl Drop for Done<'_> {
    fn drop(&mut self) {
        self.0.reached(isize::MAX);
        self.1.fetch_add(1, Ordering::Release);
    }
}

/// The threads beside the calling one.
#[derive(Debug)]
pub(super) struct Team(Option<rayon::ThreadPool>);

impl Team {
    /// `threads` threads, the calling one among them.
    ///
    /// # Panics
    /// When the threads cannot be started.
    pub(super) fn new(threads: usize) -> Self {
        Self((threads > 1).then(|| {
            rayon::ThreadPoolBuilder::new()
                .num_threads(threads - 1)
                .thread_name(|k| format!("field-{k}"))
                .build()
                .expect("the operating system gives threads")
        }))
    }

    /// Runs `run` on every tile with its own front and that of the tile above. Tiles are taken from the last to the
    /// first, so that the tile above one that is running is done or running itself, and waiting for it ends.
    pub(super) fn run(
        &self,
        tiles: &[Tile],
        run: impl Fn(&Tile, &Front, Option<&Front>) + Sync + Send,
    ) {
        let fronts: Vec<Front> = tiles.iter().map(|_| Front::new()).collect();
        let (taken, done) = (AtomicUsize::new(0), AtomicUsize::new(0));
        let work = || {
            while let Some(k) = tiles
                .len()
                .checked_sub(taken.fetch_add(1, Ordering::Relaxed) + 1)
            {
                let _done = Done(&fronts[k], &done);
                run(&tiles[k], &fronts[k], fronts.get(k + 1));
            }
            let start = Instant::now();
            while start.elapsed() < PATIENCE
                && !(0..LOOKS).any(|_| {
                    std::hint::spin_loop();
                    done.load(Ordering::Acquire) == tiles.len()
                })
            {}
        };
        match &self.0 {
            Some(pool) if tiles.len() > 1 => pool.in_place_scope(|scope| {
                for _ in 1..tiles.len() {
                    scope.spawn(|_| work());
                }
                work();
            }),
            _ => work(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::tiles::tiles;
    use super::*;

    #[test]
    fn every_tile_is_run_once_by_any_number_of_threads_and_a_wait_ends() {
        for (threads, strips) in [(1, 1), (2, 2), (2, 5), (4, 3)] {
            let tiles = tiles(1000, strips, 4, 2, 20);
            assert_eq!(tiles.len(), strips);
            let runs = AtomicUsize::new(0);
            Team::new(threads).run(&tiles, |_, own, above| {
                if let Some(above) = above {
                    above.wait_for(7);
                }
                own.reached(7);
                runs.fetch_add(1, Ordering::Relaxed);
            });
            assert_eq!(runs.into_inner(), strips);
        }
    }
}
