//! The fast engine: several steps per pass through memory, vectors of eight or sixteen cells, one strip of rows per
//! thread.
//!
//! * `instructions`: the instruction sets; `line`, `level`: cache lines, and a time level made of them;
//! * `blocking`: how much of the field a step takes at once, by the first-level cache;
//! * `layout`: lane-transposed rows, so that loads are aligned and shared between columns;
//! * `pml_memory`: memory of the absorbing layers; `walls`: changes at walls; `plan`: all of this for one field;
//! * `tiles`: time blocks of strips of rows, so that threads meet once per block; `team`: these threads;
//! * `kernel`: the sweeps, a wavefront of short blocks of rows that keeps the rows of all steps of a block in cache,
//!   and the vectors of eight or sixteen numbers they are written with.

mod blocking;
mod instructions;
mod kernel;
mod layout;
mod level;
mod line;
mod plan;
mod pml_memory;
mod team;
mod tiles;
mod walls;

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

pub use blocking::Machine;
pub use instructions::InstructionSet;
#[cfg(target_arch = "x86_64")]
pub(in crate::field) use kernel::{with_avx2, with_avx512};

use self::kernel::Shared;
use self::layout::RowLayout;
use self::level::Level;
use self::plan::Plan;
use self::team::Team;
use super::setup::FieldSetup;
use super::step::{Field, FieldState, Injection, StepForcing, combine_rows};
use crate::spread::{Stencil, TAPS};

/// Steps per time block, times the stencil's radius: the rows in flight of all steps (about `2 BLOCK` rows, 350 KiB at
/// 1000 columns) stay in the second-level cache.
const BLOCK: usize = 32;

/// Two time levels in lane-transposed rows.
#[derive(Debug)]
pub struct FastField {
    plan: Arc<Plan>,
    team: Team,
    threads: usize,
    now: Level,
    other: Level,
    layer_x: Level,
    layer_y: Level,
    surfaces: Vec<f32>,
}

impl FastField {
    /// A silent field advanced by `threads` threads (at least one).
    ///
    /// # Panics
    /// When the threads cannot be started.
    pub fn new(setup: FieldSetup, threads: usize) -> Self {
        Self::on(Machine::detect(), setup, threads)
    }

    /// As [`FastField::new`], laid out for a machine of choice, which changes no byte; instructions that this one lacks
    /// are replaced by the best it has.
    ///
    /// # Panics
    /// When the threads cannot be started.
    pub fn on(machine: Machine, setup: FieldSetup, threads: usize) -> Self {
        let best = InstructionSet::detect();
        let instructions = match (machine.instructions, best) {
            (InstructionSet::Portable, _) => InstructionSet::Portable,
            (InstructionSet::Avx2, InstructionSet::Avx512) => InstructionSet::Avx2,
            _ => best,
        };
        let machine = Machine {
            instructions,
            ..machine
        };
        let threads = threads.max(1);
        let layout = RowLayout::new(
            setup.nx,
            setup.layer.width(),
            instructions.lanes(),
            setup.scheme.radius(),
        );
        let numbers = (setup.ny + 2 * layout.halo) * layout.stride;
        let plan = Plan::new(setup, layout, machine);
        Self {
            now: Level::silent(numbers, 0),
            other: Level::silent(numbers, 32),
            layer_x: Level::silent(plan.setup.ny * plan.memory_x.stride(), 0),
            layer_y: Level::silent(plan.memory_y.len(), 0),
            surfaces: vec![0.0; plan.setup.surfaces.memory_count()],
            plan: Arc::new(plan),
            team: Team::new(threads),
            threads,
        }
    }

    /// The instruction set in use.
    pub fn instructions(&self) -> InstructionSet {
        self.plan.instructions
    }

    /// One time block.
    fn block(&mut self, steps: &[StepForcing], received: &mut Vec<f32>) {
        let plan = Arc::clone(&self.plan);
        let sums: Vec<[AtomicU64; TAPS]> = steps.iter().map(|_| Default::default()).collect();
        let shared = Shared {
            levels: [
                self.now.numbers_mut().as_mut_ptr(),
                self.other.numbers_mut().as_mut_ptr(),
            ],
            layer_x: self.layer_x.numbers_mut().as_mut_ptr(),
            layer_y: self.layer_y.numbers_mut().as_mut_ptr(),
            surfaces: self.surfaces.as_mut_ptr(),
        };
        let tiles = tiles::tiles(
            plan.setup.ny,
            self.threads,
            steps.len(),
            plan.setup.scheme.radius(),
            plan.setup.layer.cells(),
        );
        kernel::run_block(&plan, shared, &tiles, steps, &sums, &self.team);
        if steps.len() % 2 == 1 {
            std::mem::swap(&mut self.now, &mut self.other);
        }
        received.extend(steps.iter().zip(&sums).map(|(forcing, rows)| {
            let rows: [f64; TAPS] =
                std::array::from_fn(|j| f64::from_bits(rows[j].load(Ordering::Relaxed)));
            combine_rows(&forcing.receiver, &rows)
        }));
    }

    fn row<'a>(&self, level: &'a Level, iy: usize) -> &'a [f32] {
        let (stride, halo) = (self.plan.layout.stride, self.plan.layout.halo);
        &level.numbers()[(iy + halo) * stride..(iy + halo + 1) * stride]
    }
}

impl Field for FastField {
    fn advance(&mut self, steps: &[StepForcing], received: &mut Vec<f32>) {
        for block in steps.chunks(self.preferred_block()) {
            self.block(block, received);
        }
    }

    fn add(&mut self, injection: &Injection) {
        let plan = Arc::clone(&self.plan);
        let (layout, s) = (&plan.layout, &injection.stencil);
        let numbers = self.now.numbers_mut();
        let mut plain = vec![0.0; layout.nx];
        for (iy, wy) in (s.y0..).zip(&s.wy) {
            let start = (iy + layout.halo) * layout.stride;
            let row = &mut numbers[start..start + layout.stride];
            layout.unpack(row, &mut plain);
            let weight = wy * injection.amplitude;
            for (p, wx) in plain[s.x0..s.x0 + TAPS].iter_mut().zip(&s.wx) {
                *p = wx.mul_add(weight, *p);
            }
            for &ix in plan.setup.walls.solid_within(iy, s.x0..s.x0 + TAPS) {
                plain[ix] = 0.0;
            }
            // Its neighbours' copies in the halos too.
            layout.pack(&plain, row);
        }
    }

    fn read(&self, s: &Stencil) -> f32 {
        let layout = &self.plan.layout;
        let rows: [f64; TAPS] = std::array::from_fn(|j| {
            let row = self.row(&self.now, s.y0 + j);
            let taps = (s.x0..).zip(&s.wx);
            taps.map(|(ix, &w)| f64::from(w) * f64::from(row[layout.offset(ix)]))
                .sum()
        });
        combine_rows(s, &rows)
    }

    fn set_threads(&mut self, threads: usize) {
        let threads = threads.max(1);
        if threads != self.threads {
            self.team = Team::new(threads);
            self.threads = threads;
        }
    }

    fn preferred_block(&self) -> usize {
        BLOCK / self.plan.setup.scheme.radius()
    }

    fn state(&self) -> FieldState {
        let (layout, nx, ny) = (&self.plan.layout, self.plan.setup.nx, self.plan.setup.ny);
        let plain = |level: &Level| {
            let mut out = vec![0.0; nx * ny];
            for (iy, to) in out.chunks_exact_mut(nx).enumerate() {
                layout.unpack(self.row(level, iy), to);
            }
            out
        };
        FieldState {
            pressure: plain(&self.now),
            previous: plain(&self.other),
            layer_x: self.plan.memory_x.state(self.layer_x.numbers()),
            layer_y: self.plan.memory_y.state(layout, self.layer_y.numbers()),
            surfaces: self.surfaces.clone(),
        }
    }

    fn set_state(&mut self, state: &FieldState) {
        let plan = Arc::clone(&self.plan);
        let (layout, nx, ny) = (&plan.layout, plan.setup.nx, plan.setup.ny);
        for (level, plain) in [
            (&mut self.now, &state.pressure),
            (&mut self.other, &state.previous),
        ] {
            assert_eq!(plain.len(), nx * ny, "state of another grid");
            let rows =
                level.numbers_mut()[layout.halo * layout.stride..].chunks_exact_mut(layout.stride);
            for (from, to) in plain.chunks_exact(nx).zip(rows) {
                layout.pack(from, to);
            }
        }
        plan.memory_x
            .set_state(&state.layer_x, self.layer_x.numbers_mut());
        plan.memory_y
            .set_state(layout, &state.layer_y, self.layer_y.numbers_mut());
        self.surfaces.copy_from_slice(&state.surfaces);
    }

    fn row_is_finite(&self, turn: usize) -> bool {
        self.row(&self.now, turn % self.plan.setup.ny)
            .iter()
            .all(|p| p.is_finite())
    }
}
