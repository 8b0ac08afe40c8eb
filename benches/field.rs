//! Speed of the field engines with everything on (layers on four sides, a slanted wall, moving source and receiver), in
//! cells per second, and of the spreading kernels. `echolot bench` measures more sizes, threads and the machine's peaks
//! beside them.

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use fdtd::field::{
    FastField, Field, FieldSetup, Injection, ReferenceField, StepForcing, flushes_subnormals,
};
use fdtd::grid::{Grid, Medium};
use fdtd::scheme::Scheme;
use fdtd::spread::Spread;
use fdtd::walls::SolidMask;

/// Cells of the absorbing layers.
const LAYER_CELLS: usize = 20;
/// Steps of one timed run; whole blocks of both engines.
const STEPS: usize = 64;
/// Sides of the squares: in the second-level cache, and the papers' grid.
const SIDES: [usize; 2] = [256, 1000];

fn setup(side: usize, scheme: Scheme) -> FieldSetup {
    let grid = Grid {
        nx: side,
        ny: side,
        dx_m: 0.005,
        dt_s: 1.0 / 120_000.0,
    };
    let medium = Medium {
        c_mps: 340.0,
        rho_kgpm3: 1.293,
    };
    let mut cells = vec![false; side * side];
    for k in 0..side / 2 {
        for thickness in 0..4 {
            cells[(side / 5 + k / 8 + thickness) * side + side / 4 + k] = true;
        }
    }
    let mask = SolidMask {
        nx: side,
        ny: side,
        cells,
    };
    FieldSetup::new(&grid, &medium, scheme, LAYER_CELLS, &mask.into())
}

fn forcing(scheme: Scheme, side: usize) -> Vec<StepForcing> {
    let at = |n: usize| {
        let x = 0.5 * side as f64 + 1e-3 * n as f64;
        let stencil = Spread::Kaiser8.stencil([x, 0.45 * side as f64]);
        let injection = Injection {
            stencil,
            amplitude: (0.5 * n as f32).sin(),
        };
        StepForcing {
            flush: flushes_subnormals(scheme, n as u64),
            injections: [injection; 2],
            receiver: stencil,
        }
    };
    (0..STEPS).map(at).collect()
}

fn engines(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("field");
    group.sample_size(10);
    for side in SIDES {
        group.throughput(Throughput::Elements((side * side * STEPS) as u64));
        for scheme in Scheme::ALL {
            let forcing = forcing(scheme, side);
            let fields: [(&str, Box<dyn Field>); 2] = [
                (
                    "reference",
                    Box::new(ReferenceField::new(setup(side, scheme))),
                ),
                ("fast", Box::new(FastField::new(setup(side, scheme), 1))),
            ];
            for (engine, mut field) in fields {
                let name = BenchmarkId::new(format!("{engine} {scheme}"), side);
                let mut received = Vec::with_capacity(STEPS);
                group.bench_function(name, |bencher| {
                    bencher.iter(|| {
                        received.clear();
                        field.advance(black_box(&forcing), &mut received);
                    });
                });
            }
        }
    }
    group.finish();
}

fn spreading(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("spread");
    for spread in Spread::ALL {
        group.bench_function(spread.name(), |bencher| {
            let mut x = 100.0;
            bencher.iter(|| {
                x += 1e-3;
                spread.stencil(black_box([x, 200.4]))
            });
        });
    }
    group.finish();
}

criterion_group!(benches, engines, spreading);
criterion_main!(benches);
