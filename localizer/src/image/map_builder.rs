//! A map that grows block by block, eq. (7).

use ndarray::{Array2, s};

use super::echo_image::ImageWindow;
use super::map_image::{MapImage, cell_of};
use crate::echo::echo_blocks::{EchoBlock, EchoSequence};
use crate::error::Error;
use crate::parameters::{Method, Parameters};
use crate::pose::Pose;

/// Largest number of cells of a map; poses further apart than that are an error of unit.
const MOST_CELLS: i64 = 1 << 28;

/// Cells by which the layers grow beyond what is needed.
const SPARE_CELLS: i64 = 64;

/// Adds up echo images at their poses. Stationary blocks are left out.
pub struct MapBuilder {
    parameters: Parameters,
    window: ImageWindow,
    /// Cells from a pose to the map's edge.
    margin: i64,
    /// Outermost cells of the poses so far.
    ends: Option<[[i64; 2]; 2]>,
    /// World cell of the layers' first cell.
    origin: [i64; 2],
    layers: [Array2<f32>; 2],
    image: Vec<f32>,
}

impl MapBuilder {
    /// A map without blocks.
    ///
    /// # Errors
    /// Those of [`Parameters::check`], and for a range that is more cells than fit into memory.
    pub fn new(parameters: &Parameters) -> Result<Self, Error> {
        parameters.check()?;
        let measurement = &parameters.measurement;
        let reach = (measurement.max_range_m / measurement.cell_m).ceil() as usize;
        let margin = reach.max(parameters.window_cells()) as i64;
        check_size([2 * margin + 1; 2])?;
        let window = ImageWindow::new(parameters, reach);
        Ok(Self {
            image: vec![0.0; window.len()],
            window,
            margin,
            parameters: parameters.clone(),
            ends: None,
            origin: [0; 2],
            layers: [Array2::zeros((0, 0)), Array2::zeros((0, 0))],
        })
    }

    /// Adds a block at its true pose.
    ///
    /// # Errors
    /// [`Error::Invalid`] for a pose that is not finite, or so far from the others that the map does not fit into
    /// memory.
    pub fn add(&mut self, block: &EchoBlock, pose: &Pose) -> Result<(), Error> {
        if block.stationary {
            return Ok(());
        }
        if !pose.is_finite() {
            let problem = format!("pose {} is not finite", block.index);
            return Err(Error::invalid(
                "map",
                "drives",
                problem,
                "give finite poses",
            ));
        }
        let place = pose.carried(self.parameters.signal.sensor_offset_m);
        let [x, y] = cell_of(&place, self.parameters.measurement.cell_m);
        let [low, high] = self.ends.unwrap_or([[x, y]; 2]);
        self.ends = Some([
            [low[0].min(x), low[1].min(y)],
            [high[0].max(x), high[1].max(y)],
        ]);
        self.grow()?;
        for (method, layer) in [Method::Doppler, Method::ToaOnly]
            .into_iter()
            .zip(&mut self.layers)
        {
            self.window
                .draw(block.polar(method), pose.heading_rad, &mut self.image);
            let centre = [x - self.origin[0], y - self.origin[1]];
            for (&[mx, my], value) in self.window.offsets().iter().zip(&self.image) {
                layer[[
                    (centre[1] + i64::from(my)) as usize,
                    (centre[0] + i64::from(mx)) as usize,
                ]] += value;
            }
        }
        Ok(())
    }

    /// First cell and `[width, height]` of the map.
    fn extent(&self) -> Option<([i64; 2], [i64; 2])> {
        let [low, high] = self.ends?;
        let size = [0, 1].map(|axis| {
            let poses = high[axis].saturating_sub(low[axis]);
            poses.saturating_add(2 * self.margin + 1)
        });
        Some(([low[0] - self.margin, low[1] - self.margin], size))
    }

    /// Makes the layers hold the extent.
    fn grow(&mut self) -> Result<(), Error> {
        let Some((first, size)) = self.extent() else {
            return Ok(());
        };
        if !(0..2).all(|axis| size[axis] <= MOST_CELLS) {
            return check_size(size);
        }
        let (rows, columns) = self.layers[0].dim();
        let own = [columns as i64, rows as i64];
        let last = |first: [i64; 2], size: [i64; 2]| [first[0] + size[0], first[1] + size[1]];
        let (end, own_end) = (last(first, size), last(self.origin, own));
        let inside =
            (0..2).all(|axis| first[axis] >= self.origin[axis] && end[axis] <= own_end[axis]);
        if inside {
            return Ok(());
        }
        check_size(size)?;
        // Both what is there and what is needed, and some more for the next poses.
        let empty = own[0] == 0;
        let low = [0, 1].map(|axis| match empty {
            true => first[axis],
            false => first[axis].min(self.origin[axis]) - SPARE_CELLS,
        });
        let high = [0, 1].map(|axis| match empty {
            true => end[axis],
            false => end[axis].max(own_end[axis]) + SPARE_CELLS,
        });
        let shape = ((high[1] - low[1]) as usize, (high[0] - low[0]) as usize);
        let corner = [0, 1].map(|axis| (self.origin[axis] - low[axis]).max(0) as usize);
        for layer in &mut self.layers {
            let mut wider = Array2::zeros(shape);
            if !empty {
                let (y, x) = (corner[1], corner[0]);
                wider
                    .slice_mut(s![y..y + rows, x..x + columns])
                    .assign(layer);
            }
            *layer = wider;
        }
        self.origin = low;
        Ok(())
    }

    /// The map, which reaches `max_range_m` (or the window's half width, if that is more) beyond the outermost poses.
    ///
    /// # Errors
    /// [`Error::Invalid`] when no block was added in which the robot moves.
    pub fn finish(self) -> Result<MapImage, Error> {
        let Some((first, [width, height])) = self.extent() else {
            let remedy = "map with recordings of a moving robot";
            return Err(Error::invalid(
                "map",
                "drives",
                "the robot never moves",
                remedy,
            ));
        };
        let [x, y] = [0, 1].map(|axis| (first[axis] - self.origin[axis]) as usize);
        let [intensity, toa_only] = self.layers.map(|layer| {
            layer
                .slice(s![y..y + height as usize, x..x + width as usize])
                .to_owned()
        });
        Ok(MapImage {
            origin_cell: first,
            cell_m: self.parameters.measurement.cell_m,
            intensity,
            toa_only,
            parameters: self.parameters,
        })
    }
}

/// Refuses a map of more cells than an error of unit explains, or than fit into memory.
fn check_size([width, height]: [i64; 2]) -> Result<(), Error> {
    let what = format!("a map of {width} x {height} cells");
    if width.saturating_mul(height) > MOST_CELLS {
        let problem = format!("it would be {what}");
        let remedy = "give poses in metres, or choose a larger cell_m";
        return Err(Error::invalid("map", "drives", problem, remedy));
    }
    let bytes = 2.0 * size_of::<f32>() as f64 * (width * height) as f64;
    crate::memory::check("cell_m", &what, bytes)
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
    let mut map = MapBuilder::new(&parameters)?;
    for (sequence, poses) in drives {
        for (block, pose) in sequence.blocks.iter().zip(poses.iter()) {
            map.add(block, pose)?;
        }
    }
    map.finish()
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
