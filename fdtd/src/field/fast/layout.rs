//! Where the cells of a row lie in memory.
//!
//! A row is cut in three: a strip at low x and one at high x in plain order, which hold the absorbing layers, and
//! between them the *centre* in lane-transposed order: cut into as many equal lanes as a vector has numbers, vector `j`
//! holds the `j`-th cell of every lane. There the neighbour along x is the neighbouring vector, so that every load is
//! aligned and vectors pass from column to column in registers. Each part has a halo of cells (vectors) that repeats
//! its neighbours.

/// Lanes of vectors of 256 bits, the narrowest in use.
pub(super) const NARROW: usize = 8;
/// Lanes of vectors of 512 bits.
pub(super) const WIDE: usize = 16;

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
    /// Vectors of the centre; zero in narrow grids, where the high strip follows the low one without a gap.
    pub(super) centre: usize,
    /// Cells of the high strip.
    pub(super) high: usize,
    pub(super) low_at: usize,
    pub(super) centre_at: usize,
    pub(super) high_at: usize,
    /// Distance between rows; a whole number of vectors and no multiple of 4 KiB.
    pub(super) stride: usize,
    /// The strips, cut into vectors; those of the layers from the outside inwards.
    pub(super) columns: Vec<Column>,
}

/// A vector of cells of a strip.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Column {
    /// Its offset in the row.
    pub(super) at: usize,
    /// Its cells: as many as a vector has lanes in the outer part of a layer, else [`NARROW`].
    pub(super) cells: usize,
    /// So many of its first cells are not its own: they lie before the strip or in another column.
    pub(super) foreign: usize,
    /// If it belongs to an absorbing layer: which one (0 low, 1 high), and its first cell in the profile.
    pub(super) layer: Option<(usize, usize)>,
}

impl RowLayout {
    /// Layout of rows of `nx` cells with absorbing layers `layer` cells wide (a multiple of [`NARROW`]), in vectors of
    /// `lanes` cells, for a stencil of `radius`.
    ///
    /// The strips are no wider than the layers, but for what is left over when the centre takes whole vectors, because
    /// the centre is swept several times faster.
    pub(super) fn new(nx: usize, layer: usize, lanes: usize, radius: usize) -> Self {
        let halo = radius;
        let strip = layer.max(NARROW);
        let centre = nx.saturating_sub(2 * strip) / lanes;
        let (low, centre) = if centre < 2 * halo {
            (layer, 0)
        } else {
            (strip, centre)
        };
        let high = nx - low - lanes * centre;
        let low_at = lanes;
        let (mut centre_at, mut high_at) = (low_at + low, low_at + low);
        if centre > 0 {
            centre_at = (centre_at + halo).next_multiple_of(lanes) + halo * lanes;
            // The layer at high x lies in whole aligned vectors.
            let end = centre_at + (centre + halo) * lanes + halo + high;
            high_at = end.next_multiple_of(lanes) - high;
        }
        let end = high_at + high + lanes;
        let mut stride = end.next_multiple_of(2 * lanes) + lanes;
        if stride % 1024 < 2 * lanes {
            stride += 2 * lanes;
        }
        // From the outside inwards, as wide as it goes: a wide vector costs less than two narrow ones.
        let mut parts = Vec::new();
        let mut first = 0;
        while first < layer {
            let cells = if first + lanes <= layer {
                lanes
            } else {
                NARROW
            };
            parts.push((first, cells));
            first += cells;
        }
        let in_layer = |side: usize, at: usize, first: usize, cells: usize| Column {
            at: at + first,
            cells,
            foreign: 0,
            layer: Some((side, first)),
        };
        let plain = |at: usize, foreign: usize| Column {
            at,
            cells: NARROW,
            foreign,
            layer: None,
        };
        let mut columns: Vec<Column> = (parts.iter())
            .map(|&(first, cells)| in_layer(0, low_at, first, cells))
            .collect();
        columns.extend((layer..low).step_by(NARROW).map(|i| plain(low_at + i, 0)));
        let layer_at = high_at + high - layer;
        let mut foreign = (layer_at - high_at).next_multiple_of(NARROW) - (layer_at - high_at);
        for at in (high_at - foreign..layer_at).step_by(NARROW) {
            columns.push(plain(at, foreign));
            foreign = 0;
        }
        columns.extend(
            (parts.iter())
                .map(|&(first, cells)| in_layer(1, layer_at, layer - first - cells, cells)),
        );
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
            columns,
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

    /// Rebuilds the halos of a row, cell by cell; the sweeps do it with vectors.
    fn refresh_halos(&self, row: &mut [f32]) {
        if self.centre == 0 {
            return;
        }
        let (halo, lanes, after) = (self.halo, self.lanes, self.low + self.lanes * self.centre);
        for h in 0..halo {
            // Strips see the lanes next to them.
            row[self.low_at + self.low + h] = row[self.offset(self.low + h)];
            row[self.high_at - halo + h] = row[self.offset(after - halo + h)];
            // Lane l continues in lane l + 1; the outer lanes continue in the strips.
            for lane in 0..lanes {
                let first = self.low + lane * self.centre;
                row[self.centre_at - (halo - h) * lanes + lane] =
                    row[self.offset(first - halo + h)];
                row[self.centre_at + (self.centre + h) * lanes + lane] =
                    row[self.offset(first + self.centre + h)];
            }
        }
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

    fn in_centre(layout: &RowLayout, ix: usize) -> bool {
        (layout.low..layout.low + layout.lanes * layout.centre).contains(&ix)
    }

    #[test]
    fn packing_is_a_permutation_and_halos_repeat_the_neighbours() {
        for (nx, lanes, radius) in [50, 64, 87, 88, 97, 151, 500, 1000]
            .into_iter()
            .flat_map(|nx| {
                [
                    (nx, NARROW, 2),
                    (nx, WIDE, 2),
                    (nx, NARROW, 3),
                    (nx, WIDE, 3),
                ]
            })
        {
            let layout = RowLayout::new(nx, 24, lanes, radius);
            let plain: Vec<f32> = (1..=nx).map(|i| i as f32).collect();
            let mut row = vec![0.0; layout.stride];
            let own = |column: &Column| column.at + column.foreign..column.at + column.cells;
            let mut in_strips: Vec<usize> = layout.columns.iter().flat_map(own).collect();
            in_strips.sort_unstable();
            let strips = (0..nx).filter(|ix| !in_centre(&layout, *ix));
            let expected: Vec<usize> = strips.map(|ix| layout.offset(ix)).collect();
            assert_eq!(in_strips, expected, "nx {nx}");
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
                let step = if in_centre(&layout, ix as usize) {
                    lanes
                } else {
                    1
                };
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
