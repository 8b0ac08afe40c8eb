//! Perfectly matched layer for second-order schemes, by recursive convolution.
//!
//! In the layer a second difference `D D p` along the absorbed axis becomes `(1/g) D (1/g) D p` with the stretching
//! `1/g = b (z - 1)/(z - b)`, `b = exp(-sigma dt)`: the exact symbol of a one-pole recursion, so that the layer is an
//! analytic stretching of the coordinate for any step (Pasalic and McGarry 2010, in the form of Komatitsch and Martin
//! 2007). Only what the stretching *changes* is added to the plain step, therefore the layer continues whatever wide
//! stencil the interior uses without a jump. With the 13-point scheme `D D` acts on the smoothed pressure of
//! [`crate::scheme::Weights::layer`], so that all of the scheme is stretched. The grid beyond the layer is zero
//! pressure.
//!
//! This module holds the profile; the recursions are in [`crate::field`]. They work row by row, and each row owns both
//! of its faces, so that rows can be advanced in any order that respects the stencil.

/// Reflection-controlling strength of the profile at the outer edge, in units of `c/dx`: 2.65e5 1/s at 5 mm, 340 m/s.
const SIGMA_MAX: f64 = 2.65e5 * 0.005 / 340.0;

/// Frequency shift `alpha` of the stretching in units of `c/dx`: a layer of 20 cells absorbs waves of 1500 cells and
/// less as without it. The recursions of the layer forget with the time constant `dx / (ALPHA c)`.
pub const ALPHA: f64 = 4e-3;

/// Widths along x are rounded up to whole vectors of this many cells; the added cells do not absorb.
const VECTOR: usize = 8;

/// Recursion coefficients over the cells and faces of a layer, outermost first.
#[derive(Debug, Clone, PartialEq)]
pub struct Profile {
    cells: usize,
    /// Decay where nothing absorbs.
    open: f32,
    /// Decay of the face recursion; `face[i]` lies on the outer side of cell `i`; `width + 1` faces.
    pub face: Vec<f32>,
    /// Decay of the cell recursion; `width` cells.
    pub cell: Vec<f32>,
}

impl Profile {
    /// Cubic profile of a layer `cells` wide at Courant number `courant`.
    pub fn new(cells: usize, courant: f64) -> Self {
        let n = cells as f64;
        let width = cells.next_multiple_of(VECTOR);
        let decay = |position: f64| {
            let depth = ((n - position) / n).max(0.0);
            (-(ALPHA + SIGMA_MAX * 20.0 / n * depth.powi(3)) * courant).exp() as f32
        };
        let open = (-ALPHA * courant).exp() as f32;
        Self {
            cells,
            open,
            face: (0..=width)
                .map(|i| if cells == 0 { open } else { decay(i as f64) })
                .collect(),
            cell: (0..width).map(|i| decay(i as f64 + 0.5)).collect(),
        }
    }

    /// Width of the layer in cells.
    pub fn cells(&self) -> usize {
        self.cells
    }

    /// Decay `a = exp(-alpha dt)` of cells and faces that do not absorb: with it a recursion remembers nothing.
    pub fn open(&self) -> f32 {
        self.open
    }

    /// The width rounded up to whole vectors: how many cells the recursions along x take.
    pub fn width(&self) -> usize {
        self.cell.len()
    }

    /// Mirror image for the layer at high x: entries in order of increasing x.
    pub fn mirrored(&self) -> Self {
        Self {
            cells: self.cells,
            open: self.open,
            face: self.face.iter().rev().copied().collect(),
            cell: self.cell.iter().rev().copied().collect(),
        }
    }

    /// Recursion coefficients of row `iy` of `ny`: lower face, upper face, cell; `None` outside both layers.
    pub fn row(&self, ny: usize, iy: usize) -> Option<[f32; 3]> {
        if iy < self.cells {
            Some([self.face[iy], self.face[iy + 1], self.cell[iy]])
        } else if iy + self.cells >= ny {
            let j = ny - 1 - iy;
            Some([self.face[j + 1], self.face[j], self.cell[j]])
        } else {
            None
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_profile_is_strongest_outside_and_meets_the_interior_at_zero() {
        let profile = Profile::new(20, 0.5667);
        assert_eq!((profile.cells(), profile.width()), (20, 24));
        assert_eq!(profile.face[20..], [profile.open(); 5]);
        assert_eq!(profile.cell[20..], [profile.open(); 4]);
        assert!(profile.face[..21].windows(2).all(|pair| pair[0] < pair[1]));
        assert!((f64::from(profile.face[0]) - (-2.65e5_f64 / 120_000.0).exp()).abs() < 1e-3);
        assert_eq!(profile.row(100, 20), None);
        assert_eq!(
            profile.row(100, 0).map(|d| (d[0], d[1])),
            profile.row(100, 99).map(|d| (d[1], d[0]))
        );
    }
}
