//! How the rows of several steps are shared out among threads.
//!
//! A time block of `T` steps with a stencil of radius `R` runs in two phases. In the first, every thread advances its
//! own strip of rows; away from the domain's edge the strip shrinks by `R` rows per step, because rows beyond its end
//! are another thread's. In the second, the triangles left between the strips are filled. Threads meet twice per block.
//!
//! Nothing is read while another thread writes it: two levels lie in two buffers, step `s` reads level `s` and writes
//! level `s + 1` over level `s - 1`. In phase one a strip ending at row `e` reads up to row `e + R - 1` at step 0 (a
//! level that its neighbour first overwrites at step 1, from row `e + R` on) and only its own rows later. In phase two
//! the triangle around `e` reads and writes rows within `R T` of `e`; strips are at least `2 R T` rows high, so that
//! triangles do not meet.

/// Rows that one thread advances in one phase of a time block.
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
        let first = self.first + self.lower_slope.min(0) * last;
        (first, self.end + self.upper_slope.max(0) * last)
    }
}

/// The tiles of both phases for `threads` strips of `ny` rows, `steps` steps and stencil radius `radius`. The first and the
/// last `layer` rows only belong to the first and the last strip: rows of a layer share the memory of their faces and must be taken
/// in ascending order.
///
/// With fewer than `2 radius steps` rows per strip, or `radius steps` beside a layer, fewer strips are made.
pub(super) fn tiles(
    ny: usize,
    threads: usize,
    steps: usize,
    radius: usize,
    layer: usize,
) -> [Vec<Tile>; 2] {
    let least = (radius * steps + layer.max(radius * steps)).max(1);
    let strips = threads.min(ny / least).max(1);
    let border = |k: usize| (k * ny / strips) as isize;
    let radius = radius as isize;
    let strip = |k: usize| Tile {
        first: border(k),
        end: border(k + 1),
        lower_slope: if k == 0 { 0 } else { radius },
        upper_slope: if k + 1 == strips { 0 } else { -radius },
    };
    let triangle = |k: usize| Tile {
        first: border(k),
        end: border(k),
        lower_slope: -radius,
        upper_slope: radius,
    };
    [
        (0..strips).map(strip).collect(),
        (1..strips).map(triangle).collect(),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_row_of_every_step_is_taken_once_after_what_it_needs() {
        for (ny, threads, steps, radius) in
            [(40, 1, 8, 2), (97, 3, 8, 1), (200, 4, 12, 2), (33, 8, 2, 2)]
        {
            let mut done = vec![0usize; ny];
            let layer = ny / 8;
            for phase in tiles(ny, threads, steps, radius, layer) {
                for tile in phase {
                    for step in 0..steps {
                        let (low, high) = tile.rows(step);
                        for row in low..high {
                            assert_eq!(done[row], step, "row {row} taken out of turn");
                            if row > 0 && (row < layer || row + layer > ny) {
                                let below = done[row - 1];
                                assert_eq!(
                                    below,
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
                    }
                }
            }
            assert!(
                done.iter().all(|&d| d == steps),
                "{ny} rows, {threads} threads: {done:?}"
            );
        }
    }
}
