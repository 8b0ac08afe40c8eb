//! Checks of the numbers of a scene, and of its walls.

use super::model::{MIN_CELLS_PER_WAVELENGTH, MIN_LAYER_CELLS, MIN_WALL_CELLS, Scene};
use crate::error::Error;
use crate::grid::Grid;

/// Least memory of a cell of the field: two time levels, the next one and the layer's share, as `f32`.
const BYTES_PER_CELL: u64 = 16;
/// Most cells along one axis; positions in cells stay exact in `f32`.
const MAX_CELLS: usize = 1 << 20;

/// Refuses a scene by its numbers and walls; [`super::clearance::check`] looks at the paths.
pub(super) fn check(scene: &Scene, origin: &str) -> Result<(), Error> {
    let checker = Checker { scene, origin };
    checker.medium_and_grid()?;
    checker.memory()?;
    checker.step()?;
    checker.waveform()?;
    checker.robot()?;
    checker.walls()
}

struct Checker<'a> {
    scene: &'a Scene,
    origin: &'a str,
}

impl Checker<'_> {
    fn refuse<T>(&self, field: &str, problem: String, remedy: String) -> Result<T, Error> {
        Err(Error::invalid(self.origin, field, problem, remedy))
    }

    fn within(
        &self,
        field: &str,
        value: f64,
        low: f64,
        high: f64,
        unit: &str,
    ) -> Result<(), Error> {
        if (low..=high).contains(&value) {
            return Ok(());
        }
        self.refuse(
            field,
            format!("{value} is out of range"),
            format!("give a number from {low} to {high} {unit}"),
        )
    }

    fn medium_and_grid(&self) -> Result<(), Error> {
        let Scene { medium, grid, .. } = self.scene;
        self.within("medium.c_mps", medium.c_mps, 1.0, 1e5, "m/s")?;
        self.within("medium.rho_kgpm3", medium.rho_kgpm3, 1e-6, 1e6, "kg/m^3")?;
        self.within("grid.dx_m", grid.dx_m, 1e-6, 1e3, "m")?;
        self.within("grid.dt_s", grid.dt_s, 1e-12, 1.0, "s")?;
        if !(MIN_LAYER_CELLS..=1000).contains(&self.scene.layer_cells) {
            let problem = format!("a layer of {} cells", self.scene.layer_cells);
            return self.refuse(
                "layer_cells",
                problem,
                format!("give {MIN_LAYER_CELLS} to 1000 cells, usually 20"),
            );
        }
        let least = 2 * (self.scene.layer_cells + self.scene.reach_cells() + 1);
        for (field, cells) in [("grid.nx", grid.nx), ("grid.ny", grid.ny)] {
            if !(least..=MAX_CELLS).contains(&cells) {
                let remedy = format!(
                    "give {least} (room between the absorbing layers) to {MAX_CELLS} cells"
                );
                return self.refuse(field, format!("{cells} cells"), remedy);
            }
        }
        Ok(())
    }

    fn memory(&self) -> Result<(), Error> {
        let Grid { nx, ny, .. } = self.scene.grid;
        // Both factors are at most 2^20.
        let needed = nx as u64 * ny as u64 * BYTES_PER_CELL;
        let available = machine_memory_bytes();
        if needed <= available {
            return Ok(());
        }
        let gib = |bytes: u64| bytes as f64 / f64::from(1 << 30);
        let problem = format!(
            "a field of {nx} x {ny} cells takes at least {:.1} GiB of memory",
            gib(needed)
        );
        let remedy = format!(
            "this machine has {:.1} GiB: use fewer cells",
            gib(available)
        );
        self.refuse("grid", problem, remedy)
    }

    fn step(&self) -> Result<(), Error> {
        let Scene {
            medium,
            grid,
            scheme,
            waveform,
            ..
        } = self.scene;
        let largest_s = self.scene.largest_stable_step_s();
        if grid.dt_s > largest_s * (1.0 + 1e-12) {
            let problem = format!(
                "{:e} s is over the stability limit of the scheme {scheme}",
                grid.dt_s
            );
            let remedy = format!("the largest stable step is {} s", round_down(largest_s));
            return self.refuse("grid.dt_s", problem, remedy);
        }
        let highest_hz = medium.c_mps / (MIN_CELLS_PER_WAVELENGTH * grid.dx_m);
        let high_hz = waveform.band_hz[1];
        if high_hz > highest_hz {
            let problem = format!(
                "at {high_hz} Hz there are {:.2} cells per wavelength, fewer than {MIN_CELLS_PER_WAVELENGTH}",
                medium.c_mps / (high_hz * grid.dx_m)
            );
            let widest_m = medium.c_mps / (MIN_CELLS_PER_WAVELENGTH * high_hz);
            let remedy = format!(
                "end the band at {} Hz or lower, or use cells of {} m or less",
                highest_hz.floor(),
                round_down(widest_m)
            );
            return self.refuse("waveform.band_hz[1]", problem, remedy);
        }
        Ok(())
    }

    fn waveform(&self) -> Result<(), Error> {
        let waveform = &self.scene.waveform;
        let (length, rate_hz) = (waveform.code_length, self.scene.sample_rate_hz);
        if waveform.code_order().is_none() {
            let remedy = "give 2^n - 1 chips with n from 2 to 20, for example 1023".to_string();
            return self.refuse(
                "waveform.code_length",
                format!("there is no M-sequence of {length} chips"),
                remedy,
            );
        }
        self.within(
            "waveform.chip_rate_hz",
            waveform.chip_rate_hz,
            1e-3,
            1e9,
            "Hz",
        )?;
        let [low_hz, high_hz] = waveform.band_hz;
        self.within("waveform.band_hz[0]", low_hz, 0.0, 1e9, "Hz")?;
        self.within("waveform.band_hz[1]", high_hz, 1e-3, 1e9, "Hz")?;
        if low_hz >= high_hz {
            let problem = format!("the band from {low_hz} to {high_hz} Hz is empty");
            return self.refuse(
                "waveform.band_hz",
                problem,
                "give [lower edge, upper edge]".to_string(),
            );
        }
        self.within(
            "waveform.carrier_hz",
            waveform.carrier_hz,
            low_hz,
            high_hz,
            "Hz, inside the band",
        )?;
        if waveform.carrier_hz * waveform.period_s() < 1.0 {
            return self.refuse(
                "waveform.carrier_hz",
                format!(
                    "{} Hz makes less than one oscillation in a period of the code",
                    waveform.carrier_hz
                ),
                format!("give {} Hz or more", 1.0 / waveform.period_s()),
            );
        }
        let field_rate_hz = 1.0 / self.scene.grid.dt_s;
        self.within(
            "sample_rate_hz",
            rate_hz,
            1e-3,
            field_rate_hz * (1.0 + 1e-12),
            "Hz, the field's own rate",
        )?;
        let highest_hz = 0.495 * rate_hz;
        if high_hz > highest_hz {
            let problem = format!(
                "a band to {high_hz} Hz does not fit below half of the sampling rate {rate_hz} Hz"
            );
            let remedy = format!("end it at {highest_hz} Hz or lower, or sample faster");
            return self.refuse("waveform.band_hz[1]", problem, remedy);
        }
        let samples = waveform.period_s() * rate_hz;
        if samples.round() < 1.0 || (samples - samples.round()).abs() > 1e-6 {
            let problem = format!("one period of {length} chips has {samples} samples");
            let remedy = "choose a sampling rate that is a multiple of the chip rate".to_string();
            return self.refuse("sample_rate_hz", problem, remedy);
        }
        Ok(())
    }

    fn robot(&self) -> Result<(), Error> {
        let robot = &self.scene.robot;
        for (name, offset_m) in [
            ("loudspeaker_offset_m", robot.loudspeaker_offset_m),
            ("microphone_offset_m", robot.microphone_offset_m),
        ] {
            for (axis, value) in offset_m.into_iter().enumerate() {
                self.within(&format!("robot.{name}[{axis}]"), value, -1e3, 1e3, "m")?;
            }
        }
        Ok(())
    }

    /// Surfaces of an impedance need the scheme's margin below its stability limit.
    fn surfaces(&self) -> Result<(), Error> {
        let Scene {
            grid,
            medium,
            scheme,
            walls,
            ..
        } = self.scene;
        let Some(index) = walls.iter().position(|wall| wall.impedance.is_some()) else {
            return Ok(());
        };
        let enough = |part: f64| {
            let polynomial = scheme.polynomial(part * grid.courant(medium));
            polynomial.allows_impedance()
        };
        if enough(1.0) {
            return Ok(());
        }
        let (mut low, mut high) = (0.1, 1.0);
        for _ in 0..30 {
            let middle = 0.5 * (low + high);
            *(if enough(middle) { &mut low } else { &mut high }) = middle;
        }
        let problem = format!(
            "{:e} s is too near the stability limit of the scheme {scheme} for the impedance of walls[{index}]",
            grid.dt_s
        );
        let remedy = format!(
            "give a step of {} s or less, or a rigid wall",
            round_down(low * grid.dt_s)
        );
        self.refuse("grid.dt_s", problem, remedy)
    }

    fn walls(&self) -> Result<(), Error> {
        self.surfaces()?;
        let Scene {
            grid, layer_cells, ..
        } = self.scene;
        // The layer's slopes ignore faces that a wall closes: its stencil must not reach one.
        let reach = self.scene.scheme.radius();
        let layer_m = (layer_cells + reach) as f64 * grid.dx_m;
        let [width_m, height_m] = grid.size_m();
        // A rim on the limit is inside; rounding must not decide.
        let slack_m = 1e-9 * grid.dx_m;
        let open_air = |[x, y]: [f64; 2]| {
            (layer_m - slack_m..=width_m - layer_m + slack_m).contains(&x)
                && (layer_m - slack_m..=height_m - layer_m + slack_m).contains(&y)
        };
        let beyond = format!("m, {reach} cells off the absorbing layer");
        let thinnest_m = MIN_WALL_CELLS * grid.dx_m;
        for (index, wall) in self.scene.walls.iter().enumerate() {
            let field = format!("walls[{index}]");
            if wall.points_m.len() < 2 {
                let problem = format!("{} points", wall.points_m.len());
                return self.refuse(
                    &format!("{field}.points_m"),
                    problem,
                    "give at least two".to_string(),
                );
            }
            for (point, &[x, y]) in wall.points_m.iter().enumerate() {
                self.within(
                    &format!("{field}.points_m[{point}][0]"),
                    x,
                    layer_m,
                    width_m - layer_m,
                    &beyond,
                )?;
                self.within(
                    &format!("{field}.points_m[{point}][1]"),
                    y,
                    layer_m,
                    height_m - layer_m,
                    &beyond,
                )?;
            }
            // Written so that NaN is refused; a wall of more than the domain is caught by its outline.
            if !(wall.thickness_m >= thinnest_m * (1.0 - 1e-9) && wall.thickness_m.is_finite()) {
                let problem = format!(
                    "{} m is thinner than {MIN_WALL_CELLS} cells and could leak",
                    wall.thickness_m
                );
                return self.refuse(
                    &format!("{field}.thickness_m"),
                    problem,
                    format!("give {thinnest_m} m or more"),
                );
            }
            for (number, segment) in wall.segments_m().enumerate() {
                if segment[0] == segment[1] {
                    let problem = "the same point twice in a row".to_string();
                    return self.refuse(
                        &format!("{field}.points_m[{}]", number + 1),
                        problem,
                        "leave it out".to_string(),
                    );
                }
                if !wall.outline_m(segment).into_iter().all(open_air) {
                    let problem = format!(
                        "with its thickness the wall is in the absorbing layer or within {reach} cells of it"
                    );
                    let remedy = format!("keep walls {layer_m} m from the domain's edge");
                    return self.refuse(
                        &format!("{field}.points_m[{}]", number + 1),
                        problem,
                        remedy,
                    );
                }
            }
        }
        Ok(())
    }
}

/// Four digits, rounded towards zero, so that the number given as a limit is itself accepted.
fn round_down(value: f64) -> f64 {
    let digit = 10_f64.powi(value.log10().floor() as i32 - 3);
    format!("{:e}", (value / digit).floor() * digit)
        .parse::<f64>()
        .map_or(value, |rounded| rounded.min(value))
}

/// Memory in bytes that this process may use: the machine's, or its control group's where that is less.
fn machine_memory_bytes() -> u64 {
    // An unknown system says nothing; the allocation will.
    let Ok(mut system) = sysinfo::System::new() else {
        return u64::MAX;
    };
    system.refresh_memory();
    let group = system
        .cgroup_limits()
        .map_or(u64::MAX, |limits| limits.total_memory);
    let machine = match system.total_memory().min(group) {
        0 => u64::MAX,
        bytes => bytes,
    };
    machine.min(address_space_bytes())
}

/// Limit of the address space of this process.
#[cfg(unix)]
fn address_space_bytes() -> u64 {
    let limit = rustix::process::getrlimit(rustix::process::Resource::As);
    limit.current.unwrap_or(u64::MAX)
}

#[cfg(not(unix))]
fn address_space_bytes() -> u64 {
    u64::MAX
}
