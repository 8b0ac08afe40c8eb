//! Map images: echo images added up at known poses, eq. (7).

use ndarray::Array2;

use crate::echo::echo_blocks::EchoSequence;
use crate::error::Error;
use crate::image::echo_image::ImageWindow;
use crate::parameters::{Method, Parameters};
use crate::pose::Pose;

/// Largest number of cells of a map; poses further apart than that are an error of unit.
const MOST_CELLS: i64 = 1 << 28;

/// A map image and its range-only counterpart on the world's cell grid.
///
/// Cell `[iy, ix]` has its centre at `((origin_cell[0] + ix) cell_m, (origin_cell[1] + iy) cell_m)`.
///
/// ```
/// use localizer::image::map_image;
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
/// let map = map_image::build(&[(&echoes, &[Pose::default()])])?;
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

/// Adds up the echo images of one or several drives at their poses, eq. (7). Stationary blocks are left out.
///
/// `drives` pairs each sequence with one pose per block, see [`EchoSequence::poses`]. The map reaches `max_range_m` (or
/// the window's half width, if that is more) beyond the outermost poses.
///
/// # Errors
/// [`Error::Invalid`] when no drive has a moving block, the number of poses differs from that of the blocks, a pose
/// is not finite, the drives were measured with different parameters, or the poses lie so far apart that the map does
/// not fit into memory.
pub fn build(drives: &[(&EchoSequence, &[Pose])]) -> Result<MapImage, Error> {
    let refuse = |field: String, problem: String, remedy: &str| {
        Error::invalid("map", field, problem, remedy)
    };
    let Some((first, _)) = drives.first() else {
        return Err(refuse(
            "drives".to_owned(),
            "there are none".to_owned(),
            "give at least one recording",
        ));
    };
    let parameters = first.parameters.clone();
    for (number, (sequence, poses)) in drives.iter().enumerate() {
        let field = format!("drives[{number}]");
        if sequence.parameters != parameters {
            let problem = "was measured with other parameters than the first".to_owned();
            return Err(refuse(
                field,
                problem,
                "measure all drives of a map with the same parameters",
            ));
        }
        if sequence.blocks.len() != poses.len() {
            let problem = format!("{} poses for {} blocks", poses.len(), sequence.blocks.len());
            return Err(refuse(
                field,
                problem,
                "give the true pose of every block (truth.tum)",
            ));
        }
        if let Some(index) = poses.iter().position(|pose| !pose.is_finite()) {
            return Err(refuse(
                field,
                format!("pose {index} is not finite"),
                "give finite poses",
            ));
        }
    }
    let moving = || {
        drives
            .iter()
            .flat_map(|(sequence, poses)| sequence.blocks.iter().zip(poses.iter()))
            .filter(|(block, _)| !block.stationary)
    };
    let sensor_cell = |pose: &Pose| {
        cell_of(
            &pose.carried(parameters.signal.sensor_offset_m),
            parameters.measurement.cell_m,
        )
    };
    let cells = || moving().map(|(_, pose)| sensor_cell(pose));
    let (Some(low), Some(high)) = (
        cells().reduce(|a, b| [a[0].min(b[0]), a[1].min(b[1])]),
        cells().reduce(|a, b| [a[0].max(b[0]), a[1].max(b[1])]),
    ) else {
        let remedy = "map with recordings of a moving robot";
        return Err(refuse(
            "drives".to_owned(),
            "the robot never moves".to_owned(),
            remedy,
        ));
    };
    let reach_cells =
        (parameters.measurement.max_range_m / parameters.measurement.cell_m).ceil() as usize;
    let margin = reach_cells.max(parameters.window_cells()) as i64;
    let [width, height] = [0, 1].map(|axis| {
        high[axis]
            .saturating_sub(low[axis])
            .saturating_add(2 * margin + 1)
    });
    if width.saturating_mul(height) > MOST_CELLS {
        let problem = format!("the map would have {width} x {height} cells");
        return Err(refuse(
            "drives".to_owned(),
            problem,
            "give poses in metres, or choose a larger cell_m",
        ));
    }
    let bytes = 2.0 * size_of::<f32>() as f64 * (width * height) as f64;
    crate::memory::check(
        "cell_m",
        &format!("a map of {width} x {height} cells"),
        bytes,
    )?;
    let shape = (height as usize, width as usize);
    let mut map = MapImage {
        origin_cell: [low[0] - margin, low[1] - margin],
        cell_m: parameters.measurement.cell_m,
        intensity: Array2::zeros(shape),
        toa_only: Array2::zeros(shape),
        parameters: parameters.clone(),
    };
    let window = ImageWindow::new(&parameters, reach_cells);
    let mut image = vec![0.0; window.len()];
    for (block, pose) in moving() {
        let [x, y] = sensor_cell(pose);
        let centre = [x - map.origin_cell[0], y - map.origin_cell[1]];
        for (method, layer) in [
            (Method::Doppler, &mut map.intensity),
            (Method::ToaOnly, &mut map.toa_only),
        ] {
            window.draw(block.polar(method), pose.heading_rad, &mut image);
            for (&[mx, my], value) in window.offsets().iter().zip(&image) {
                layer[[
                    (centre[1] + i64::from(my)) as usize,
                    (centre[0] + i64::from(mx)) as usize,
                ]] += value;
            }
        }
    }
    Ok(map)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::echo::echo_blocks::EchoBlock;
    use crate::odometry::Odometry;

    /// One block with a single echo at the given direction and range.
    fn sequence(
        parameters: &Parameters,
        direction: usize,
        range_m: f64,
        stationary: bool,
    ) -> EchoSequence {
        let mut intensity =
            Array2::zeros((parameters.measurement.directions + 1, parameters.delays()));
        intensity[[direction, parameters.signal.delay_of_range(range_m)]] = 30.0;
        let mut block = EchoBlock {
            index: 0,
            t_s: 0.0,
            odometry: Odometry::default(),
            stationary,
            toa_intensity: vec![0.0; parameters.delays()],
            intensity,
        };
        block.set_toa(parameters.measurement.toa_image);
        EchoSequence {
            parameters: parameters.clone(),
            blocks: vec![block],
            odometry: Vec::new(),
        }
    }

    #[test]
    fn an_echo_ahead_lands_ahead_of_the_pose() {
        let parameters = Parameters::default();
        let sequence = sequence(&parameters, 0, 2.0, false);
        let pose = Pose {
            x_m: 1.04,
            y_m: -0.5,
            heading_rad: std::f64::consts::FRAC_PI_2,
        };
        let map = build(&[(&sequence, &[pose]), (&sequence, &[pose])]).unwrap();
        let column = (10 - map.origin_cell[0]) as usize;
        let row = (15 - map.origin_cell[1]) as usize;
        assert_eq!(map.intensity[[row, column]], 60.0);
        assert_eq!(map.toa_only[[row, column]], 2.0);
        assert_eq!(map.toa_only[[row - 40, column]], 2.0);
        assert_eq!(map.intensity[[row - 40, column]], 0.0);
        assert_eq!(map.cell_of(&pose), [10, -5]);
    }

    #[test]
    fn a_patch_reads_zero_outside() {
        let parameters = Parameters::default();
        let sequence = sequence(&parameters, 0, 2.0, false);
        let map = build(&[(&sequence, &[Pose::default()])]).unwrap();
        let window = ImageWindow::new(&parameters, 3);
        let mut image = vec![1.0; window.len()];
        map.patch(Method::Doppler, &window, [20, 0], &mut image);
        assert_eq!(window.to_array(&image)[[3, 3]], 30.0);
        for far in [[1000, 0], [0, -1000], [i64::MAX, i64::MIN]] {
            map.patch(Method::Doppler, &window, far, &mut image);
            assert!(image.iter().all(|&value| value == 0.0));
        }
    }

    #[test]
    fn drives_that_make_no_map_are_refused() {
        let parameters = Parameters::default();
        let resting = sequence(&parameters, 0, 2.0, true);
        let driving = sequence(&parameters, 0, 2.0, false);
        let message = |drives: &[(&EchoSequence, &[Pose])]| build(drives).unwrap_err().to_string();
        assert!(message(&[]).contains("none"));
        assert!(message(&[(&resting, &[Pose::default()])]).contains("never moves"));
        assert!(message(&[(&driving, &[])]).contains("0 poses for 1 blocks"));
        let lost = Pose {
            x_m: f64::NAN,
            ..Pose::default()
        };
        assert!(message(&[(&driving, &[lost])]).contains("not finite"));
        let far = Pose {
            x_m: 1e9,
            ..Pose::default()
        };
        assert!(message(&[(&driving, &[far]), (&driving, &[Pose::default()])]).contains("cells"));
    }
}
