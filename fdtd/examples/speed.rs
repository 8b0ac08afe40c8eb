//! Prints the speed of both engines on a grid of choice: `speed NX NY STEPS THREADS`.

use std::time::Instant;

use fdtd::field::{FastField, Field, FieldSetup, Injection, ReferenceField, StepForcing};
use fdtd::grid::{Grid, Medium};
use fdtd::scheme::Scheme;
use fdtd::spread::Spread;
use fdtd::walls::SolidMask;

fn main() {
    let numbers: Vec<usize> = std::env::args()
        .skip(1)
        .filter_map(|a| a.parse().ok())
        .collect();
    let [nx, ny, steps, threads] = *numbers else {
        eprintln!("usage: speed NX NY STEPS THREADS");
        std::process::exit(2);
    };
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
    let mut mask = SolidMask {
        nx,
        ny,
        cells: vec![false; nx * ny],
    };
    for k in 0..nx / 2 {
        for t in 0..4 {
            mask.cells[(ny / 5 + k / 8 + t) * nx + nx / 4 + k] = true;
            mask.cells[(ny / 4 + k * ny / nx) * nx + nx / 5 + t + k / 10] = true;
        }
    }
    for scheme in Scheme::ALL {
        let setup = FieldSetup::new(&grid, &medium, scheme, 20, &mask);
        let forcing: Vec<StepForcing> = (0..steps)
            .map(|n| {
                let x = 0.5 * nx as f64 + 1e-3 * n as f64;
                let stencil = Spread::Kaiser8.stencil([x, 0.45 * ny as f64]);
                let injection = Injection {
                    stencil,
                    amplitude: (0.5 * n as f32).sin(),
                };
                StepForcing {
                    injections: [injection; 2],
                    receiver: stencil,
                }
            })
            .collect();
        let engines: [(&str, Box<dyn Field>); 2] = [
            ("fast", Box::new(FastField::new(setup.clone(), threads))),
            ("reference", Box::new(ReferenceField::new(setup.clone()))),
        ];
        for (name, mut field) in engines {
            let mut out = Vec::new();
            field.advance(&forcing[..steps / 4], &mut out);
            let start = Instant::now();
            let forcing = if name == "fast" {
                &forcing[..]
            } else {
                &forcing[..steps / 4]
            };
            field.advance(forcing, &mut out);
            let rate = (nx * ny * forcing.len()) as f64 / start.elapsed().as_secs_f64() / 1e9;
            println!("{scheme} {name} {nx}x{ny} {threads} threads: {rate:.2} Gcell/s");
        }
    }
}
