//! The measured case: layers on four sides, slanted rigid walls, source and receiver that move with twelve-point
//! spreading.

use fdtd::field::{FieldSetup, FieldState, Injection, StepForcing};
use fdtd::grid::{Grid, Medium};
use fdtd::scheme::Scheme;
use fdtd::spread::Spread;
use fdtd::walls::SolidMask;

/// Cells of the absorbing layers.
const LAYER_CELLS: usize = 20;
/// Fewest cells along a side: the layers (in whole vectors) and the spreading between them.
pub const SMALLEST: usize = 64;
/// Steps whose forcing is computed beforehand and repeated.
pub(super) const FORCING: usize = 1024;
/// Setup of the field.
pub(super) fn setup(nx: usize, ny: usize, scheme: Scheme) -> FieldSetup {
    let grid = Grid {
        nx,
        ny,
        dx_m: 0.005,
        dt_s: 1.0 / 120_000.0,
    };
    let medium = Medium {
        c_mps: 340.0,
        rho_kgpm3: 1.293,
    };
    let mut cells = vec![false; nx * ny];
    for k in 0..nx / 2 {
        for t in 0..4 {
            let walls = [
                (ny / 5 + k / 8 + t, nx / 4 + k),
                (ny / 4 + k * ny / nx, nx / 5 + t + k / 10),
            ];
            for (iy, ix) in walls {
                if iy < ny && ix < nx {
                    cells[iy * nx + ix] = true;
                }
            }
        }
    }
    let mask = SolidMask { nx, ny, cells };
    FieldSetup::new(&grid, &medium, scheme, LAYER_CELLS, &mask.into())
}

/// Forcing of source and receiver, which drift along x. No step flushes, as in a long drive.
pub(super) fn forcing(nx: usize, ny: usize) -> Vec<StepForcing> {
    let at = |n: usize| {
        let stencil =
            Spread::Kaiser12.stencil([0.5 * nx as f64 + 1e-3 * n as f64, 0.45 * ny as f64]);
        let injection = Injection {
            stencil,
            amplitude: (0.5 * n as f32).sin(),
        };
        StepForcing {
            flush: false,
            injections: [injection; 2],
            receiver: stencil,
        }
    };
    (0..FORCING).map(at).collect()
}

/// A field of uniform noise between -1 and 1, of the magnitude that it has in nearly all of a drive.
pub(super) fn noise(state: FieldState) -> FieldState {
    let mut seed = 1_u32;
    let pressure: Vec<f32> = (0..state.pressure.len())
        .map(|_| {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (seed >> 8) as f32 / 8_388_608.0 - 1.0
        })
        .collect();
    FieldState {
        previous: pressure.clone(),
        pressure,
        ..state
    }
}
