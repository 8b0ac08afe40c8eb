//! The plain engine: one sweep over the rows per step, nothing rearranged.

mod rows;

use self::rows::{absorb, d25_row, layered_row, m13_row, slf_row};
use super::stencil::Splat;
use super::{Field, FieldSetup, FieldState, StepForcing, combine_rows, layer_row, quieten};
use crate::boundary::Reaction;
use crate::pml::Profile;
use crate::scheme::Scheme;
use crate::spread::TAPS;

/// Cells of zero pressure around the grid, as many as the widest stencil reaches.
const RIM: usize = 3;

/// Two time levels in plain row order with a rim of zeros.
#[derive(Debug, Clone)]
pub struct ReferenceField {
    setup: FieldSetup,
    high: Profile,
    now: Vec<f32>,
    /// The past before a step, the new pressure after it.
    other: Vec<f32>,
    layer_x: Vec<f32>,
    layer_y: Vec<f32>,
    surfaces: Vec<f32>,
    /// What the layers take the second difference of, for the cells of three rows or of one with its neighbours.
    layered: [Vec<f32>; 3],
}

impl ReferenceField {
    /// A silent field.
    pub fn new(setup: FieldSetup) -> Self {
        let padded = (setup.nx + 2 * RIM) * (setup.ny + 2 * RIM);
        let (cells, width) = (setup.layer.cells(), setup.layer.width());
        Self {
            high: setup.layer.mirrored(),
            now: vec![0.0; padded],
            other: vec![0.0; padded],
            layer_x: vec![0.0; setup.ny * 6 * width],
            layer_y: vec![0.0; 2 * cells * 3 * setup.nx],
            surfaces: vec![0.0; setup.surfaces.memory_count()],
            layered: std::array::from_fn(|_| vec![0.0; setup.nx]),
            setup,
        }
    }

    fn stride(&self) -> usize {
        self.setup.nx + 2 * RIM
    }

    /// Takes one step, a quiet one or not, and leaves the new pressure in `now`.
    fn step(&mut self, quiet: bool) {
        #[cfg(target_arch = "x86_64")]
        if std::arch::is_x86_feature_detected!("avx2") && std::arch::is_x86_feature_detected!("fma")
        {
            // Without the hint the closure stays a function of its own, compiled without fused multiply-adds: twenty times
            // slower.
            super::fast::with_avx2(
                #[inline(always)]
                || self.rows(quiet),
            );
            std::mem::swap(&mut self.now, &mut self.other);
            return;
        }
        self.rows(quiet);
        std::mem::swap(&mut self.now, &mut self.other);
    }

    #[inline(always)]
    fn rows(&mut self, quiet: bool) {
        let (nx, ny, stride) = (self.setup.nx, self.setup.ny, self.stride());
        let (cells, width) = (self.setup.layer.cells(), self.setup.layer.width());
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
                Scheme::M13 | Scheme::O13 => m13_row(
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
                for (dy, layered) in [-1, 0, 1].into_iter().zip(&mut self.layered) {
                    let at = |along: isize, across: isize| {
                        &row(dy + along)[(RIM as isize + across) as usize..]
                    };
                    layered_row(scheme, &weights, at, layered);
                }
                let memory = &mut self.layer_y[at * 3 * nx..(at + 1) * 3 * nx];
                if quiet {
                    quieten(memory);
                }
                let [lower, here, upper] = &self.layered;
                let decay = |_| decay;
                absorb([lower, here, upper], decay, open, memory, linear, next);
            }
            let sides = [(&self.setup.layer, 0), (&self.high, nx - width)];
            let memory = &mut self.layer_x[iy * 6 * width..(iy + 1) * 6 * width];
            if quiet {
                quieten(memory);
            }
            let memory = memory.chunks_exact_mut(3 * width.max(1));
            for ((profile, first), memory) in sides.into_iter().zip(memory) {
                let at = |along: isize, across: isize| {
                    &row(across)[((RIM + first) as isize - 1 + along) as usize..]
                };
                let layered = &mut self.layered[0][..width + 2];
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
            if quiet {
                quieten(next);
            }
            for correction in &self.setup.walls.corrections[iy] {
                let mut sum = 0.0_f32;
                for &(dy, ix, weight) in &correction.entries {
                    sum = weight.mul_add(row(dy)[RIM + ix], sum);
                }
                next[correction.ix] += sum;
            }
            for surface in self.setup.surfaces.of_row(iy) {
                let own = surface.memory..surface.memory + surface.memory_count();
                let memory = &mut self.surfaces[own];
                let mut sum = match surface.reaction {
                    Reaction::Decay(decay) => decay * memory[0],
                    Reaction::Branches(_) => 0.0,
                };
                for &(dy, ix, weight) in &surface.taps {
                    sum = weight.mul_add(row(dy)[RIM + ix], sum);
                }
                let change = match &surface.reaction {
                    Reaction::Decay(_) => std::mem::replace(&mut memory[0], sum) - sum,
                    Reaction::Branches(branches) => branches.step(sum, memory),
                };
                for &(ix, gain) in &surface.gains {
                    next[ix] = gain.mul_add(change, next[ix]);
                }
            }
            if quiet {
                for correction in &self.setup.walls.corrections[iy] {
                    quieten(&mut next[correction.ix..=correction.ix]);
                }
                for surface in self.setup.surfaces.of_row(iy) {
                    let own = surface.memory..surface.memory + surface.memory_count();
                    quieten(&mut self.surfaces[own]);
                    for &(ix, _) in &surface.gains {
                        quieten(&mut next[ix..=ix]);
                    }
                }
            }
        }
    }
}

impl Field for ReferenceField {
    fn advance(&mut self, steps: &[StepForcing], received: &mut Vec<f32>) {
        let stride = self.stride();
        for forcing in steps {
            self.step(forcing.quiet);
            for injection in &forcing.injections {
                let s = &injection.stencil;
                for (j, wy) in s.wy.iter().enumerate() {
                    let start = (s.y0 + j + RIM) * stride + RIM + s.x0;
                    let weight = wy * injection.amplitude;
                    for (p, wx) in self.now[start..start + TAPS].iter_mut().zip(&s.wx) {
                        *p = wx.mul_add(weight, *p);
                    }
                }
            }
            for (iy, solid) in self.setup.walls.solid.iter().enumerate() {
                let start = (iy + RIM) * stride + RIM;
                for ix in solid {
                    self.now[start + ix] = 0.0;
                }
            }
            let s = &forcing.receiver;
            let rows: [f64; TAPS] = std::array::from_fn(|j| {
                let start = (s.y0 + j + RIM) * stride + RIM + s.x0;
                let taps = self.now[start..start + TAPS].iter().zip(&s.wx);
                taps.map(|(&p, &w)| f64::from(w) * f64::from(p)).sum()
            });
            received.push(combine_rows(s, &rows));
        }
    }

    fn preferred_block(&self) -> usize {
        8
    }

    fn state(&self) -> FieldState {
        let stride = self.stride();
        let plain = |padded: &[f32]| {
            let rows = padded[RIM * stride..]
                .chunks_exact(stride)
                .take(self.setup.ny);
            rows.flat_map(|row| &row[RIM..RIM + self.setup.nx])
                .copied()
                .collect()
        };
        FieldState {
            pressure: plain(&self.now),
            previous: plain(&self.other),
            layer_x: self.layer_x.clone(),
            layer_y: self.layer_y.clone(),
            surfaces: self.surfaces.clone(),
        }
    }

    fn set_state(&mut self, state: &FieldState) {
        let (stride, nx) = (self.stride(), self.setup.nx);
        for (padded, plain) in [
            (&mut self.now, &state.pressure),
            (&mut self.other, &state.previous),
        ] {
            assert_eq!(plain.len(), nx * self.setup.ny, "state of another grid");
            for (row, from) in padded[RIM * stride..]
                .chunks_exact_mut(stride)
                .zip(plain.chunks_exact(nx))
            {
                row[RIM..RIM + nx].copy_from_slice(from);
            }
        }
        self.layer_x.copy_from_slice(&state.layer_x);
        self.layer_y.copy_from_slice(&state.layer_y);
        self.surfaces.copy_from_slice(&state.surfaces);
    }

    fn row_is_finite(&self, turn: usize) -> bool {
        let start = (turn % self.setup.ny + RIM) * self.stride();
        self.now[start..start + self.stride()]
            .iter()
            .all(|p| p.is_finite())
    }
}
