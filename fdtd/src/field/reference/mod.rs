//! The plain engine: one sweep over the rows per step, nothing rearranged; in `f32`, and in `f64` with the same
//! weights.

mod rows;

use self::rows::{RIM, absorb, d25_row, layered_row, m13_row, slf_row};
use super::setup::FieldSetup;
use super::stencil::Splat;
use super::step::{
    Field, FieldState, Injection, StepForcing, combine_rows, flush_subnormals, layer_row,
};
use crate::boundary::Reaction;
use crate::number::Real;
use crate::pml::Profile;
use crate::scheme::Scheme;
use crate::spread::{Stencil, TAPS};

/// Square root of the restoring quantum: the angular frequency of a constant pressure in radians a step.
const SWING: f64 = 3.452_669_830_012_439e-4;

/// Two time levels in plain row order with a rim of zeros.
#[derive(Debug, Clone)]
struct PlainField<N> {
    setup: FieldSetup,
    high: Profile,
    now: Vec<N>,
    /// The past before a step, the new pressure after it.
    other: Vec<N>,
    layer_x: Vec<N>,
    layer_y: Vec<N>,
    surfaces: Vec<N>,
    /// Quantity whose second difference the layers take, for the cells of three rows.
    layered: [Vec<N>; 3],
    /// The same for the cells of one row beside a side, with their neighbours.
    beside: Vec<N>,
}

impl<N: Real> PlainField<N> {
    /// A silent field.
    fn new(setup: FieldSetup) -> Self {
        let padded = (setup.nx + 2 * RIM) * (setup.ny + 2 * RIM);
        let (cells, width) = (setup.layer.cells(), setup.layer.width());
        Self {
            high: setup.layer.mirrored(),
            now: vec![N::default(); padded],
            other: vec![N::default(); padded],
            layer_x: vec![N::default(); setup.ny * 6 * width],
            layer_y: vec![N::default(); 2 * cells * 3 * setup.nx],
            surfaces: vec![N::default(); setup.surfaces.memory_count()],
            layered: std::array::from_fn(|_| vec![N::default(); setup.nx]),
            beside: vec![N::default(); width + 2],
            setup,
        }
    }

    fn stride(&self) -> usize {
        self.setup.nx + 2 * RIM
    }

    /// Takes one step, a flushing one or not, and leaves the new pressure in `now`.
    fn step(&mut self, flush: bool) {
        #[cfg(target_arch = "x86_64")]
        if std::arch::is_x86_feature_detected!("avx2") && std::arch::is_x86_feature_detected!("fma")
        {
            // Without the hint the closure stays a function of its own, compiled without fused multiply-adds.
            super::fast::with_avx2(
                #[inline(always)]
                || self.rows(flush),
            );
            std::mem::swap(&mut self.now, &mut self.other);
            return;
        }
        self.rows(flush);
        std::mem::swap(&mut self.now, &mut self.other);
    }

    #[inline(always)]
    fn rows(&mut self, flush: bool) {
        let (nx, ny, stride) = (self.setup.nx, self.setup.ny, self.stride());
        let (cells, width) = (self.setup.layer.cells(), self.setup.layer.width());
        // Rows one below the other share two of their three rows of the layered quantity.
        let mut layered_below = None;
        for iy in 0..ny {
            let start = (iy + RIM) * stride + RIM;
            let row = |dy: isize| {
                let begin = (start as isize + dy * stride as isize) as usize - RIM;
                &self.now[begin..begin + nx + 2 * RIM]
            };
            let next = &mut self.other[start..start + nx];
            match self.setup.scheme {
                Scheme::Slf => slf_row(
                    &Splat::new(&self.setup.weights),
                    [row(-1), row(0), row(1)],
                    next,
                ),
                Scheme::Iwb | Scheme::M13 | Scheme::O13 => m13_row(
                    &Splat::new(&self.setup.weights),
                    [row(-2), row(-1), row(0), row(1), row(2)],
                    next,
                ),
                Scheme::D25 => d25_row(
                    &Splat::new(&self.setup.weights),
                    std::array::from_fn(|k| row(k as isize - 3)),
                    next,
                ),
            }
            let (scheme, linear) = (self.setup.scheme, self.setup.weights.linear);
            let open = self.setup.layer.open();
            let weights = Splat::new(&self.setup.weights);
            if let (Some(decay), Some(at)) =
                (self.setup.layer.row(ny, iy), layer_row(cells, ny, iy))
            {
                let is_next = iy > 0 && layered_below == Some(iy - 1);
                let new = if is_next { 2 } else { 0 };
                if is_next {
                    self.layered.rotate_left(1);
                }
                let rows = [-1, 0, 1].into_iter().zip(&mut self.layered);
                for (dy, layered) in rows.skip(new) {
                    let at = |along: isize, across: isize| {
                        &row(dy + along)[(RIM as isize + across) as usize..]
                    };
                    layered_row(scheme, &weights, at, layered);
                }
                layered_below = Some(iy);
                let memory = &mut self.layer_y[at * 3 * nx..(at + 1) * 3 * nx];
                if flush {
                    flush_subnormals(memory);
                }
                let [lower, here, upper] = &self.layered;
                let decay = |_| decay;
                absorb([lower, here, upper], decay, open, memory, linear, next);
            }
            let sides = [(&self.setup.layer, 0), (&self.high, nx - width)];
            let memory = &mut self.layer_x[iy * 6 * width..(iy + 1) * 6 * width];
            if flush {
                flush_subnormals(memory);
            }
            let memory = memory.chunks_exact_mut(3 * width.max(1));
            for ((profile, first), memory) in sides.into_iter().zip(memory) {
                let at = |along: isize, across: isize| {
                    &row(across)[((RIM + first) as isize - 1 + along) as usize..]
                };
                let layered = &mut self.beside[..width + 2];
                layered_row(scheme, &weights, at, layered);
                let layered = [&layered[..width], &layered[1..=width], &layered[2..]];
                let (lower, upper) = (&profile.face[..width], &profile.face[1..=width]);
                let cell = &profile.cell[..width];
                let decay = |i: usize| [lower[i], upper[i], cell[i]];
                absorb(
                    layered,
                    decay,
                    open,
                    memory,
                    linear,
                    &mut next[first..first + width],
                );
            }
            if flush {
                flush_subnormals(next);
            }
            for correction in &self.setup.walls.corrections[iy] {
                let mut sum = N::default();
                for &(dy, ix, weight) in &correction.entries {
                    sum = N::splat(weight).mul_add(row(dy)[RIM + ix], sum);
                }
                next[correction.ix] = next[correction.ix].add(sum);
            }
            for surface in self.setup.surfaces.of_row(iy) {
                let own = surface.memory..surface.memory + surface.memory_count();
                let memory = &mut self.surfaces[own];
                let mut sum = match surface.reaction {
                    Reaction::Decay(decay) => N::splat(decay).mul(memory[0]),
                    Reaction::Branches(_) => N::default(),
                };
                for &(dy, ix, weight) in &surface.taps {
                    sum = N::splat(weight).mul_add(row(dy)[RIM + ix], sum);
                }
                let change = match &surface.reaction {
                    Reaction::Decay(_) => std::mem::replace(&mut memory[0], sum).sub(sum),
                    Reaction::Branches(branches) => branches.step(sum, memory),
                };
                for &(ix, gain) in &surface.gains {
                    next[ix] = N::splat(gain).mul_add(change, next[ix]);
                }
            }
            if flush {
                for correction in &self.setup.walls.corrections[iy] {
                    flush_subnormals(&mut next[correction.ix..=correction.ix]);
                }
                for surface in self.setup.surfaces.of_row(iy) {
                    let own = surface.memory..surface.memory + surface.memory_count();
                    flush_subnormals(&mut self.surfaces[own]);
                    for &(ix, _) in &surface.gains {
                        flush_subnormals(&mut next[ix..=ix]);
                    }
                }
            }
        }
    }

    /// Zero pressure in solid cells.
    fn silence_walls(&mut self) {
        let stride = self.stride();
        for (iy, solid) in self.setup.walls.solid.iter().enumerate() {
            let start = (iy + RIM) * stride + RIM;
            for ix in solid {
                self.now[start + ix] = N::default();
            }
        }
    }

    /// A level without its rim, `[iy, ix]`.
    fn plain(&self, padded: &[N]) -> Vec<N> {
        let stride = self.stride();
        let rows = padded[RIM * stride..].chunks_exact(stride);
        rows.take(self.setup.ny)
            .flat_map(|row| &row[RIM..RIM + self.setup.nx])
            .copied()
            .collect()
    }
}

impl PlainField<f32> {
    fn inject(&mut self, injection: &Injection) {
        let s = &injection.stencil;
        let stride = self.stride();
        for (j, wy) in s.wy.iter().enumerate() {
            let start = (s.y0 + j + RIM) * stride + RIM + s.x0;
            let weight = wy * injection.amplitude;
            for (p, wx) in self.now[start..start + TAPS].iter_mut().zip(&s.wx) {
                *p = wx.mul_add(weight, *p);
            }
        }
    }

    fn received(&self, s: &Stencil) -> f32 {
        let stride = self.stride();
        let rows: [f64; TAPS] = std::array::from_fn(|j| {
            let start = (s.y0 + j + RIM) * stride + RIM + s.x0;
            let taps = self.now[start..start + TAPS].iter().zip(&s.wx);
            taps.map(|(&p, &w)| f64::from(w) * f64::from(p)).sum()
        });
        combine_rows(s, &rows)
    }
}

/// The plain engine in `f32`: the oracle of [`super::FastField`].
#[derive(Debug, Clone)]
pub struct ReferenceField(PlainField<f32>);

impl ReferenceField {
    /// A silent field.
    pub fn new(setup: FieldSetup) -> Self {
        Self(PlainField::new(setup))
    }
}

/// The plain engine in `f64` with the weights as they are in `f32`: the discrete operator without the roundings of a
/// step. Its growth or decay over silence shows the spectrum of the step of both engines.
#[derive(Debug, Clone)]
pub struct PreciseField(PlainField<f64>);

impl PreciseField {
    /// A silent field.
    pub fn new(setup: FieldSetup) -> Self {
        Self(PlainField::new(setup))
    }

    /// Takes one step without source or receiver, all of the step's roundings in `f64`.
    pub fn step(&mut self) {
        self.0.step(false);
        self.0.silence_walls();
    }

    /// All that the field remembers, as one vector: pressure `[iy, ix]`, its change over the last step in units of
    /// `sqrt(2^-23)`, the memory of the layers along x and y, and that of the surfaces. In these units what the
    /// restoring quantum alone makes swing keeps its length.
    pub fn vector(&self) -> Vec<f64> {
        let field = &self.0;
        let (now, past) = (field.plain(&field.now), field.plain(&field.other));
        let change = now
            .iter()
            .zip(&past)
            .map(|(now, past)| (now - past) / SWING);
        let mut vector: Vec<f64> = now.iter().copied().chain(change).collect();
        for memory in [&field.layer_x, &field.layer_y, &field.surfaces] {
            vector.extend_from_slice(memory);
        }
        vector
    }

    /// Takes over what [`PreciseField::vector`] gave, or a sum of such vectors; of another one, zero in solid cells,
    /// what a step can have left.
    ///
    /// # Panics
    /// When the length is another.
    pub fn set_vector(&mut self, vector: &[f64]) {
        let field = &mut self.0;
        let (stride, nx) = (field.stride(), field.setup.nx);
        let (now, rest) = vector.split_at(nx * field.setup.ny);
        let (change, rest) = rest.split_at(nx * field.setup.ny);
        let (layer_x, rest) = rest.split_at(field.layer_x.len());
        let (layer_y, surfaces) = rest.split_at(field.layer_y.len());
        for (iy, (now, change)) in now
            .chunks_exact(nx)
            .zip(change.chunks_exact(nx))
            .enumerate()
        {
            let at = (iy + RIM) * stride + RIM;
            field.now[at..at + nx].copy_from_slice(now);
            let past = field.other[at..at + nx].iter_mut();
            for (past, (now, change)) in past.zip(now.iter().zip(change)) {
                *past = now - change * SWING;
            }
        }
        for _ in 0..2 {
            field.silence_walls();
            std::mem::swap(&mut field.now, &mut field.other);
        }
        field.layer_x.copy_from_slice(layer_x);
        field.layer_y.copy_from_slice(layer_y);
        field.surfaces.copy_from_slice(surfaces);
    }
}

impl Field for ReferenceField {
    fn advance(&mut self, steps: &[StepForcing], received: &mut Vec<f32>) {
        let field = &mut self.0;
        for forcing in steps {
            field.step(forcing.flush);
            for injection in &forcing.injections {
                field.inject(injection);
            }
            field.silence_walls();
            received.push(field.received(&forcing.receiver));
        }
    }

    fn add(&mut self, injection: &Injection) {
        self.0.inject(injection);
        self.0.silence_walls();
    }

    fn read(&self, receiver: &Stencil) -> f32 {
        self.0.received(receiver)
    }

    fn preferred_block(&self) -> usize {
        8
    }

    fn state(&self) -> FieldState {
        let field = &self.0;
        FieldState {
            pressure: field.plain(&field.now),
            previous: field.plain(&field.other),
            layer_x: field.layer_x.clone(),
            layer_y: field.layer_y.clone(),
            surfaces: field.surfaces.clone(),
        }
    }

    fn set_state(&mut self, state: &FieldState) {
        let field = &mut self.0;
        let (stride, nx) = (field.stride(), field.setup.nx);
        for (padded, plain) in [
            (&mut field.now, &state.pressure),
            (&mut field.other, &state.previous),
        ] {
            assert_eq!(plain.len(), nx * field.setup.ny, "state of another grid");
            for (row, from) in padded[RIM * stride..]
                .chunks_exact_mut(stride)
                .zip(plain.chunks_exact(nx))
            {
                row[RIM..RIM + nx].copy_from_slice(from);
            }
        }
        field.layer_x.copy_from_slice(&state.layer_x);
        field.layer_y.copy_from_slice(&state.layer_y);
        field.surfaces.copy_from_slice(&state.surfaces);
    }

    fn row_is_finite(&self, turn: usize) -> bool {
        let field = &self.0;
        let start = (turn % field.setup.ny + RIM) * field.stride();
        field.now[start..start + field.stride()]
            .iter()
            .all(|p| p.is_finite())
    }
}
