//! How the rows of several steps are shared out among threads.
//!
//! In a time block of `T` steps with a stencil of radius `R` every thread advances its own strip of rows, whose bounds
//! move up by `R` rows per step: all that a strip needs from below are then rows that it has advanced itself, or that
//! are as they were before the block. From above it needs the first rows of the next strip. A thread works from low to
//! high rows, and when it comes to the end of its strip, the next one has long left its first rows behind; it waits for
//! that (`Tile::waits_from`), and there is no other wait within a block. The first strip starts with as many rows less
//! as it gains.
//!
//! Nothing is read while another thread writes it: two levels lie in two buffers, step `s` reads level `s` and writes
//! level `s + 1` over level `s - 1`. Around the bound `e + R s` of two strips at step `s`, the upper one reads level
//! `s` from row `e + R (s - 1)` on, which it wrote itself at step `s - 1` (or nobody, when `s` is zero), and the lower
//! one writes over it at step `s + 1` once the upper strip has left all rows below `e + R (s + 2)` behind at step `s`.
//! The lower one reads level `s` up to row `e + R (s + 1) - 1`, which the upper one wrote at step `s - 1` and never
//! writes again. Strips are at least `2 R T` rows high, so that only neighbours meet.

/// Rows that one thread advances in a time block.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Tile {
    /// Rows at step 0.
    first: isize,
    end: isize,
    /// How the lower and the upper bound move per step.
    lower_slope: isize,
    upper_slope: isize,
}

impl Tile {
    /// Rows of step `step`, half open.
    pub(super) fn rows(&self, step: usize) -> (usize, usize) {
        let step = step as isize;
        let (low, high) = (
            self.first + self.lower_slope * step,
            self.end + self.upper_slope * step,
        );
        (low.max(0) as usize, high.max(0) as usize)
    }

    /// Bounds over all `steps` from which a wavefront must start and at which it may end.
    pub(super) fn sweep(&self, steps: usize) -> (isize, isize) {
        let last = steps.saturating_sub(1) as isize;
        (self.first, self.end + self.upper_slope * last)
    }

    /// Before a wavefront of `steps` steps touches the first of these rows, that of the tile above must have reached
    /// the second.
    pub(super) fn waits_from(&self, steps: usize) -> (isize, isize) {
        let radius = self.upper_slope;
        (
            self.end - radius,
            self.end + 2 * radius * (steps + 1) as isize,
        )
    }
}

/// The strips for `threads` threads of `ny` rows, `steps` steps and stencil radius `radius`. The first and the last
/// `layer` rows only belong to the first and the last strip: rows of a layer share the memory of their faces and must
/// be taken in ascending order.
///
/// With fewer than `2 radius steps` rows per strip, or `radius steps` beside a layer, fewer strips are made.
pub(super) fn tiles(
    ny: usize,
    threads: usize,
    steps: usize,
    radius: usize,
    layer: usize,
) -> Vec<Tile> {
    let reach = radius * steps;
    let least = (reach + layer.max(reach)).max(1);
    let strips = threads.min(ny / least).max(1);
    // Half the way that the bound moves, so that all strips have the same number of rows over all steps.
    let border = |k: usize| match k {
        0 => 0,
        _ if k == strips => ny as isize,
        _ => (k * ny / strips) as isize - (radius * steps.saturating_sub(1) / 2) as isize,
    };
    let slope = |k: usize| {
        if k == 0 || k == strips {
            0
        } else {
            radius as isize
        }
    };
    let strip = |k: usize| Tile {
        first: border(k),
        end: border(k + 1),
        lower_slope: slope(k),
        upper_slope: slope(k + 1),
    };
    (0..strips).map(strip).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Runs the wavefronts of all tiles in turns, as fast as the waits allow: `turns` says which goes on.
    fn run(ny: usize, tiles: &[Tile], steps: usize, radius: usize, turns: &[usize]) -> Vec<usize> {
        let mut done = vec![0usize; ny];
        let layer = ny / 8;
        let mut fronts: Vec<isize> = tiles.iter().map(|tile| tile.sweep(steps).0).collect();
        let mut turns = turns.iter().cycle();
        let ended = |k: usize, front: isize| {
            let end: isize = tiles[k].sweep(steps).1;
            front >= end + (radius * steps) as isize
        };
        while fronts
            .iter()
            .enumerate()
            .any(|(k, &front)| !ended(k, front))
        {
            let k = turns.next().expect("turns go on") % tiles.len();
            let (row, needed) = tiles[k].waits_from(steps);
            let blocked = k + 1 < tiles.len()
                && fronts[k] >= row
                && fronts[k + 1] < needed
                && !ended(k + 1, fronts[k + 1]);
            if ended(k, fronts[k]) || blocked {
                continue;
            }
            for step in 0..steps {
                let (low, high) = tiles[k].rows(step);
                let row = fronts[k] - (radius * step) as isize;
                if row < low as isize || row >= high as isize {
                    continue;
                }
                let row = row as usize;
                assert_eq!(done[row], step, "row {row} taken out of turn");
                if row > 0 && (row < layer || row + layer > ny) {
                    assert_eq!(
                        done[row - 1],
                        step + 1,
                        "layer's row {row} before the one below"
                    );
                }
                let near = row.saturating_sub(radius)..(row + radius + 1).min(ny);
                assert!(
                    done[near].iter().all(|d| (step..=step + 1).contains(d)),
                    "row {row} taken when a neighbour was not ready"
                );
                done[row] += 1;
            }
            fronts[k] += 1;
        }
        done
    }

    #[test]
    fn every_row_of_every_step_is_taken_once_after_what_it_needs() {
        for (ny, threads, steps, radius) in [
            (40, 1, 8, 2),
            (97, 3, 8, 1),
            (200, 4, 12, 2),
            (33, 8, 2, 2),
            (150, 3, 7, 3),
        ] {
            let tiles = tiles(ny, threads, steps, radius, ny / 8);
            for turns in [
                &[0, 1, 2, 3, 4, 5, 6, 7][..],
                &[0],
                &[3, 2, 1, 0],
                &[0, 0, 0, 1, 2, 3, 4, 5, 6, 7],
            ] {
                // Every tile has its turn sooner or later.
                let turns: Vec<usize> = turns.iter().flat_map(|&k| [k; 90]).chain(0..8).collect();
                let done = run(ny, &tiles, steps, radius, &turns);
                assert!(
                    done.iter().all(|&d| d == steps),
                    "{ny} rows, {threads} threads: {done:?}"
                );
            }
        }
    }
}
