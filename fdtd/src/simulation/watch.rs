//! Stability watch of a run: a field that no source can have made ends it.
//!
//! The scheme is stable for every step that a scene may have (`docs/theory/stability.md`), so that the
//! watch is for the unforeseen: a defect of the solver or of the machine, or a domain assembled by hand. Two quantities
//! of the field are checked some ten times in a second of sound, and the microphone's samples at every call of the
//! observer. *Pressure*: of the source's strength `q` one step adds at most `A = rho c^2 dt |q| / (2 dx^2)` to a cell;
//! near the source the pressure stays within a few times that, and where it meets nothing but rigid walls and a
//! resonance, it grows by `4 rho c^2 / S` times the integral of `|q|` at most, `S` being the area of the air. *Energy*:
//! while the source is silent it must not grow; it is the invariant of the leapfrog step, `|p' - p|^2 / 2 - p' . (p' -
//! 2 p + p'') / 2`.

use super::domain::Domain;
use super::segments::Window;
use crate::error::Error;
use crate::field::{FieldState, StepForcing};

/// Steps between two looks: a tenth of a second on the papers' grid, in which a mode that grows by 75 1/s does so by 65
/// dB.
const STRIDE: u64 = 12_000;
/// Pressure near the source over the increment of one step.
const NEAR: f64 = 10.0;
/// Energy in silence over that when it began.
const GROWTH: f64 = 4.0;
/// Pressure, as a part of what the source can make, below which energy is rounding.
const FLOOR: f64 = 1e-6;

/// State of the watch of a run.
#[derive(Debug, Clone, Default)]
pub(super) struct Watch {
    /// Step, warm-ups included, from which on the next look is due.
    next: u64,
    /// The most that the source has added to a cell in one step so far, Pa.
    loudest: f64,
    /// Whether the source has been silent since the last look.
    silent: bool,
    /// Energy when this silence began.
    first: Option<f64>,
}

/// Context of a check of the field.
pub(super) struct FieldView<'a> {
    pub(super) domain: &'a Domain,
    pub(super) window: Window,
    pub(super) origin_m: [f64; 2],
    /// Steps of the drive until now.
    pub(super) steps: u64,
}

impl Watch {
    /// Accounts for the source's contribution.
    pub(super) fn follow(&mut self, steps: &[StepForcing]) {
        let amplitudes = steps.iter().flat_map(|step| step.injections);
        let loudest = amplitudes.fold(0.0, |most, injection| injection.amplitude.abs().max(most));
        self.note(f64::from(loudest));
    }

    /// As [`Watch::follow`], for a source that added up to `loudest` Pa.
    pub(super) fn note(&mut self, loudest: f64) {
        if loudest > 0.0 {
            self.silent = false;
            self.first = None;
        }
        self.loudest = self.loudest.max(loudest);
    }

    /// Whether a look is due at `step`; if so, whether the energy is to be looked at, for which the field must be known
    /// a step before.
    pub(super) fn is_due(&self, step: u64) -> [bool; 2] {
        let due = step >= self.next;
        [due, due && self.silent]
    }

    /// Pressure that the source can have made in so many steps with so many cells of air, Pa; without end while it has
    /// made no sound, for a field may be given a pressure to start with.
    pub(super) fn most(&self, steps: u64, cells: usize) -> f64 {
        if self.loudest == 0.0 {
            return f64::INFINITY;
        }
        self.loudest * (NEAR + 8.0 * steps as f64 / cells as f64)
    }

    /// Looks at a field at `step`, and at its energy when `before` is the field a step earlier.
    ///
    /// # Errors
    /// [`Error::Unstable`] when no source can have made it.
    pub(super) fn look(
        &mut self,
        step: u64,
        before: Option<&FieldState>,
        now: &FieldState,
        view: &FieldView<'_>,
    ) -> Result<(), Error> {
        let cells = view.window.nx * view.window.ny;
        let most = self.most(view.steps, cells);
        let (cell, peak) = peak(&now.pressure);
        if !peak.is_finite() || f64::from(peak) > most {
            let cause =
                format!("{peak:e} Pa, where the source can have made {most:.3e} Pa at most");
            return Err(view.unstable(cell, cause));
        }
        if let Some(before) = before {
            let energy = energy(before, &now.pressure);
            let first = *self.first.get_or_insert(energy);
            let floor = (FLOOR * self.loudest).powi(2) * cells as f64;
            if energy > GROWTH * first.max(floor) {
                let cause = format!(
                    "the energy has grown {:.3e} times while the source was silent",
                    energy / first
                );
                return Err(view.unstable(cell, cause));
            }
        }
        self.next = step + STRIDE;
        self.silent = true;
        Ok(())
    }
}

impl FieldView<'_> {
    fn unstable(&self, cell: usize, cause: String) -> Error {
        let (Window { first, nx, ny }, layer) = (self.window, self.domain.layer_cells);
        let at = [cell % nx, cell / nx];
        let place = |axis: usize| {
            (first[axis] as f64 + at[axis] as f64 + 0.5) * self.domain.grid.dx_m
                + self.origin_m[axis]
        };
        let inside = |at: usize, cells: usize| (layer..cells - layer).contains(&at);
        Error::Unstable {
            time_s: self.steps as f64 * self.domain.grid.dt_s,
            place_m: [place(0), place(1)],
            in_layer: !(inside(at[0], nx) && inside(at[1], ny)),
            cause,
        }
    }
}

/// Where the pressure is highest or no number, and how high.
fn peak(pressure: &[f32]) -> (usize, f32) {
    let mut most = (0, 0.0_f32);
    for (cell, p) in pressure.iter().map(|p| p.abs()).enumerate() {
        if p > most.1 || (p.is_nan() && !most.1.is_nan()) {
            most = (cell, p);
        }
    }
    most
}

/// The invariant of the step, half a step before `next`.
fn energy(before: &FieldState, next: &[f32]) -> f64 {
    let levels = next.iter().zip(&before.pressure).zip(&before.previous);
    let parts = levels.map(|((&next, &now), &past)| {
        let (next, now, past) = (f64::from(next), f64::from(now), f64::from(past));
        0.5 * (next - now).powi(2) - 0.5 * next * (next - 2.0 * now + past)
    });
    parts.sum()
}

#[cfg(test)]
mod tests {
    use super::super::{Flow, MovingPair, Simulation, SimulationOptions};
    use super::*;
    use crate::field::{FastField, FieldSetup};
    use crate::grid::{Grid, Medium};
    use crate::scheme::{RESTORING_QUANTUM, Scheme};
    use crate::spread::Spread;
    use crate::walls::WallCells;

    const SIDE: usize = 64;

    fn simulation(c_mps: f64, sounds_s: f64) -> Simulation {
        let domain = Domain {
            grid: Grid {
                nx: SIDE,
                ny: SIDE,
                dx_m: 0.005,
                dt_s: 1.0 / 120_000.0,
            },
            medium: Medium {
                c_mps,
                rho_kgpm3: 1.2,
            },
            scheme: Scheme::O13,
            spread: Spread::Kaiser8,
            layer_cells: 16,
            walls: WallCells::open(SIDE, SIDE),
        };
        let place = |_: f64| [0.15, 0.17];
        let strength = move |t_s: f64| {
            if t_s < sounds_s {
                1e-3 * (5e4 * t_s).sin()
            } else {
                0.0
            }
        };
        let pair = MovingPair::new(
            &domain,
            Box::new(place),
            Box::new(place),
            Box::new(strength),
            true,
        );
        let options = SimulationOptions {
            threads: 1,
            ..SimulationOptions::default()
        };
        Simulation::from_parts(domain, pair, 1.0, 40e3, 14e3, &options).expect("it fits")
    }

    /// Runs a simulation whose step has a negative stiffness of so many quanta, so that its constant mode
    /// grows, from a little constant pressure.
    fn unstable(mut simulation: Simulation, quanta: f32) -> Error {
        let domain = simulation.domain();
        let mut setup = FieldSetup::new(
            &domain.grid,
            &domain.medium,
            domain.scheme,
            domain.layer_cells,
            &domain.walls,
        );
        setup.weights.centre += quanta * RESTORING_QUANTUM;
        simulation.field = Box::new(FastField::new(setup, 1));
        let mut state = simulation.field.state();
        state.pressure.fill(1e-6);
        state.previous.fill(1e-6);
        simulation.field.set_state(&state);
        let outcome = simulation.run(&mut |_, _| Flow::Continue);
        outcome.expect_err("no source can have made it")
    }

    #[test]
    fn a_pressure_beyond_the_source_is_told_with_time_and_place() {
        let simulation = simulation(343.2, f64::INFINITY);
        let view = FieldView {
            domain: simulation.domain(),
            window: Window::whole(simulation.domain()),
            origin_m: [1.0, 2.0],
            steps: 60_000,
        };
        let mut watch = Watch::default();
        watch.note(20.0);
        let mut state = simulation.field.state();
        state.pressure[40 * SIDE + 3] = 300.0;
        assert!(
            watch.look(1, None, &state, &view).is_ok(),
            "an echo may be so loud"
        );
        for pressure in [-1e6, f32::INFINITY, f32::NAN] {
            state.pressure[40 * SIDE + 3] = pressure;
            let error = watch
                .look(2, None, &state, &view)
                .expect_err("far too much");
            let Error::Unstable {
                time_s,
                place_m,
                in_layer,
                ..
            } = error
            else {
                panic!("{error}");
            };
            assert!(in_layer && (time_s - 0.5).abs() < 1e-12);
            let away = (place_m[0] - 1.0 - 3.5 * 0.005).hypot(place_m[1] - 2.0 - 40.5 * 0.005);
            assert!(away < 1e-9, "{place_m:?}");
        }
    }

    #[test]
    fn a_growing_field_ends_the_run_long_before_it_overflows() {
        for (c_mps, quanta) in [(333.0, 500.0), (343.2, 5000.0), (350.0, 2000.0)] {
            let error = unstable(simulation(c_mps, f64::INFINITY), quanta);
            let text = error.to_string();
            assert!(text.contains("the source can have made"), "{text}");
            let Error::Unstable { cause, .. } = error else {
                panic!("{text}");
            };
            assert!(
                !cause.starts_with("inf") && !cause.starts_with("NaN"),
                "{cause}"
            );
        }
    }

    #[test]
    fn energy_that_grows_in_silence_ends_the_run_though_it_is_small() {
        let error = unstable(simulation(338.0, 0.0), 12.0);
        assert!(error.to_string().contains("source was silent"), "{error}");
    }

    #[test]
    fn a_sound_run_is_left_alone_whether_the_source_sounds_or_not() {
        for (c_mps, sounds_s) in [(333.0, f64::INFINITY), (343.2, 0.05), (350.0, 0.0)] {
            let outcome = simulation(c_mps, sounds_s).run(&mut |_, _| Flow::Continue);
            assert!(outcome.is_ok(), "{c_mps} m/s, {sounds_s} s");
        }
    }
}
