//! Map images: echo images added up at known poses, eq. (7).

use ndarray::Array2;

use crate::error::Error;
use crate::image::echo_image::ImageWindow;
use crate::parameters::{Method, Parameters};
use crate::pose::Pose;

/// A map image and its range-only counterpart on the world's cell grid.
///
/// Cell `[iy, ix]` has its centre at `((origin_cell[0] + ix) cell_m, (origin_cell[1] + iy) cell_m)`.
///
/// ```
/// use localizer::image::map_builder;
/// use localizer::{EchoBlock, EchoSequence, Odometry, Parameters, Pose};
/// use ndarray::Array2;
///
/// // One block with an echo from 1 m ahead of a robot at the origin.
/// let parameters = Parameters::default();
/// let delays = parameters.delays();
/// let mut intensity = Array2::zeros((parameters.measurement.directions + 1, delays));
/// intensity[[0, parameters.signal.delay_of_range(1.0)]] = 5.0;
/// let block = EchoBlock {
///     index: 0,
///     t_s: 0.3,
///     odometry: Odometry::default(),
///     stationary: false,
///     intensity,
///     toa_intensity: vec![0.0; delays],
/// };
/// let echoes = EchoSequence { parameters, blocks: vec![block], odometry: Vec::new() };
/// let map = map_builder::build(&[(&echoes, &[Pose::default()])])?;
/// let [x, y] = [10, 0].map(i64::from);
/// let column = (x - map.origin_cell[0]) as usize;
/// let row = (y - map.origin_cell[1]) as usize;
/// assert_eq!(map.intensity[[row, column]], 5.0);
/// # Ok::<(), localizer::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct MapImage {
    /// World cell number `[x, y]` of the first cell.
    pub origin_cell: [i64; 2],
    /// Cell width in metres.
    pub cell_m: f64,
    /// G of eq. (7), `[iy, ix]`.
    pub intensity: Array2<f32>,
    /// The same from echoes without bearing.
    pub toa_only: Array2<f32>,
    /// The parameters with which the map was made.
    pub parameters: Parameters,
}

impl MapImage {
    /// World cell `[x, y]` in which a pose lies, rounded as in eqs. (7) and (13).
    pub fn cell_of(&self, pose: &Pose) -> [i64; 2] {
        cell_of(pose, self.cell_m)
    }

    /// Centre of the first cell in metres.
    pub fn origin_m(&self) -> [f64; 2] {
        self.origin_cell.map(|cell| cell as f64 * self.cell_m)
    }

    /// The layer `[iy, ix]` that a method is matched with.
    pub fn layer(&self, method: Method) -> &Array2<f32> {
        match method {
            Method::ToaOnly => &self.toa_only,
            Method::Doppler | Method::Odometry => &self.intensity,
        }
    }

    /// Copies the window around a world cell from a layer, eq. (13) before its quantization; zero outside of the map.
    ///
    /// `image` has `window.len()` elements in the order of `window.offsets()`.
    pub fn patch(&self, method: Method, window: &ImageWindow, centre: [i64; 2], image: &mut [f32]) {
        let layer = self.layer(method);
        let (rows, columns) = (layer.nrows() as i64, layer.ncols() as i64);
        let first = [
            centre[0].saturating_sub(self.origin_cell[0]),
            centre[1].saturating_sub(self.origin_cell[1]),
        ];
        for (pixel, &[mx, my]) in image.iter_mut().zip(window.offsets()) {
            let (x, y) = (
                first[0].saturating_add(i64::from(mx)),
                first[1].saturating_add(i64::from(my)),
            );
            let inside = (0..columns).contains(&x) && (0..rows).contains(&y);
            *pixel = if inside {
                layer[[y as usize, x as usize]]
            } else {
                0.0
            };
        }
    }

    /// Rows of the square of `2 half + 1` cells a side around a world cell; `None` unless all of it lies within the
    /// map.
    pub(crate) fn rows_around(
        &self,
        method: Method,
        half: usize,
        centre: [i64; 2],
    ) -> Option<impl Iterator<Item = &[f32]> + Clone> {
        let layer = self.layer(method);
        let cells = layer.as_slice()?;
        let (rows, columns) = layer.dim();
        let width = 2 * half + 1;
        let first = |axis: usize, size: usize| {
            let corner = centre[axis]
                .checked_sub(self.origin_cell[axis])?
                .checked_sub(half as i64)?;
            let corner = usize::try_from(corner).ok()?;
            (width <= size && corner <= size - width).then_some(corner)
        };
        let (x, y) = (first(0, columns)?, first(1, rows)?);
        Some((y..y + width).map(move |y| &cells[y * columns + x..][..width]))
    }

    /// Checks that the map suits the parameters of a localizer.
    ///
    /// # Errors
    /// [`Error::Invalid`] when the cell widths differ.
    pub fn check(&self, parameters: &Parameters) -> Result<(), Error> {
        if (self.cell_m - parameters.measurement.cell_m).abs() > 1e-9 {
            let problem = format!(
                "{} m, the parameters say {} m",
                self.cell_m, parameters.measurement.cell_m
            );
            return Err(Error::invalid(
                "map",
                "cell_m",
                problem,
                "use the map's cell width",
            ));
        }
        Ok(())
    }
}

/// World cell of a pose for a cell width.
pub(crate) fn cell_of(pose: &Pose, cell_m: f64) -> [i64; 2] {
    [
        (pose.x_m / cell_m).round() as i64,
        (pose.y_m / cell_m).round() as i64,
    ]
}
