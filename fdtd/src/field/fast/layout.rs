//! Where the cells of a row lie in memory.
//!
//! A row is cut in three: a strip at low x and one at high x in plain order, which hold the absorbing layers, and
//! between them the *centre* in lane-transposed order: cut into as many equal lanes as a vector has numbers, vector `j`
//! holds the `j`-th cell of every lane. There the neighbour along x is the neighbouring vector, so that every load is aligned and vectors pass
//! from column to column in registers. Each part has a halo of cells (vectors) that repeats its neighbours.

/// Lanes of vectors of 256 bits, the narrowest in use.
pub(super) const NARROW: usize = 8;
/// Lanes of vectors of 512 bits.
pub(super) const WIDE: usize = 16;
/// Narrowest halo.
const HALO: usize = 2;
/// Narrowest strip that is worth a part of its own.
const STRIP: usize = 24;

/// Sizes and offsets of a row, in `f32`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct RowLayout {
    pub(super) nx: usize,
    /// Cells per vector: [`NARROW`] or [`WIDE`].
    pub(super) lanes: usize,
    /// Vectors of halo on each side of the centre, and rows of rim below and above the grid: what the stencil reaches.
    pub(super) halo: usize,
    /// Cells of the low strip.
    pub(super) low: usize,
    /// Vectors of the centre; zero in narrow grids, where the low strip is the whole row.
    pub(super) centre: usize,
    /// Cells of the high strip.
    pub(super) high: usize,
    pub(super) low_at: usize,
    pub(super) centre_at: usize,
    pub(super) high_at: usize,
    /// Distance between rows; a whole number of vectors and no multiple of 4 KiB.
    pub(super) stride: usize,
}

impl RowLayout {
    /// Layout of rows of `nx` cells with absorbing layers `layer` cells wide, in vectors of `lanes` cells, for a stencil of
    /// `radius`.
    pub(super) fn new(nx: usize, layer: usize, lanes: usize, radius: usize) -> Self {
        let halo = radius.max(HALO);
        let strip = layer.max(STRIP).next_multiple_of(lanes);
        let centre = nx.saturating_sub(2 * strip) / lanes;
        let (low, centre, high) = if centre < 2 * halo {
            (nx, 0, 0)
        } else {
            (strip, centre, nx - strip - lanes * centre)
        };
        let low_at = lanes;
        let centre_at = low_at + low.next_multiple_of(lanes) + (1 + halo) * lanes;
        let high_at = centre_at + (centre + halo + 1) * lanes;
        let end = high_at + high.next_multiple_of(lanes) + lanes;
        let mut stride = end.next_multiple_of(2 * lanes) + lanes;
        if stride % 1024 < 2 * lanes {
            stride += 2 * lanes;
        }
        Self {
            nx,
            lanes,
            halo,
            low,
            centre,
            high,
            low_at,
            centre_at,
            high_at,
            stride,
        }
    }

    /// Offset of cell `ix` in its row.
    pub(super) fn offset(&self, ix: usize) -> usize {
        if ix < self.low {
            self.low_at + ix
        } else if ix < self.low + self.lanes * self.centre {
            let cell = ix - self.low;
            self.centre_at + (cell % self.centre) * self.lanes + cell / self.centre
        } else {
            self.high_at + ix - self.low - self.lanes * self.centre
        }
    }

    /// Rebuilds the halos of a row of `stride` cells, and clears the padding beyond its end.
    #[inline(always)]
    pub(super) fn refresh_halos(&self, row: &mut [f32]) {
        match self.lanes {
            WIDE => self.refresh::<WIDE>(row),
            _ => self.refresh::<NARROW>(row),
        }
    }

    #[inline(always)]
    fn refresh<const LANES: usize>(&self, row: &mut [f32]) {
        let row = &mut row[..self.stride];
        if self.centre == 0 {
            row[self.low_at + self.low..self.low_at + self.low.next_multiple_of(LANES)].fill(0.0);
            return;
        }
        let (first, last) = (
            self.centre_at,
            self.centre_at + (self.centre - self.halo) * LANES,
        );
        let after = self.centre_at + self.centre * LANES;
        for h in 0..self.halo {
            // Strips see the lanes next to them.
            row[self.low_at + self.low + h] = row[first + h * LANES];
            row[self.high_at - self.halo + h] = row[last + h * LANES + LANES - 1];
            // Lane l continues in lane l + 1; the outer lanes continue in the strips.
            let (from_low, from_high) = (
                row[self.low_at + self.low - self.halo + h],
                row[self.high_at + h],
            );
            let before = self.centre_at - (self.halo - h) * LANES;
            // Whole vectors, read one cell off: cell by cell would wait for stores that loads cannot be forwarded from.
            let tail = last + h * LANES - 1;
            row.copy_within(tail..tail + LANES, before);
            row[before] = from_low;
            let head = first + h * LANES + 1;
            row.copy_within(head..head + LANES, after + h * LANES);
            row[after + h * LANES + LANES - 1] = from_high;
        }
        row[self.high_at + self.high..self.high_at + self.high.next_multiple_of(LANES)].fill(0.0);
    }

    /// Copies a plain row in and rebuilds the halos.
    pub(super) fn pack(&self, plain: &[f32], row: &mut [f32]) {
        for (ix, &p) in plain.iter().enumerate() {
            row[self.offset(ix)] = p;
        }
        self.refresh_halos(row);
    }

    /// Copies a row out in plain order.
    pub(super) fn unpack(&self, row: &[f32], plain: &mut [f32]) {
        for (ix, p) in plain.iter_mut().enumerate() {
            *p = row[self.offset(ix)];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packing_is_a_permutation_and_halos_repeat_the_neighbours() {
        for (nx, lanes, radius) in [30, 64, 87, 88, 97, 151, 1000].into_iter().flat_map(|nx| {
            [
                (nx, NARROW, 2),
                (nx, WIDE, 2),
                (nx, NARROW, 3),
                (nx, WIDE, 3),
            ]
        }) {
            let layout = RowLayout::new(nx, 20, lanes, radius);
            let plain: Vec<f32> = (1..=nx).map(|i| i as f32).collect();
            let mut row = vec![0.0; layout.stride];
            layout.pack(&plain, &mut row);
            let mut back = vec![0.0; nx];
            layout.unpack(&row, &mut back);
            assert_eq!(plain, back);
            let at = |ix: isize| {
                if ix < 0 || ix >= nx as isize {
                    0.0
                } else {
                    plain[ix as usize]
                }
            };
            for ix in 0..nx as isize {
                let offset = layout.offset(ix as usize);
                let in_centre =
                    (layout.low..layout.low + lanes * layout.centre).contains(&(ix as usize));
                let step = if in_centre { lanes } else { 1 };
                for d in 1..=layout.halo {
                    assert_eq!(
                        row[offset + d * step],
                        at(ix + d as isize),
                        "nx {nx} ix {ix} +{d}"
                    );
                    assert_eq!(
                        row[offset - d * step],
                        at(ix - d as isize),
                        "nx {nx} ix {ix} -{d}"
                    );
                }
            }
        }
    }
}
