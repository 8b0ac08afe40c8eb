//! Time of one step: the Doppler bank of one block, the particle filter by the window's half width, and a step among
//! landmarks.

use std::hint::black_box;

use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use localizer::echo::DopplerBank;
use localizer::filter::particle_filter::ParticleFilter;
use localizer::image::{MapImage, map_builder};
use localizer::landmarks::{
    self, Landmark, LandmarkLocalizer, LandmarkMap, Noise, Shape, Start, Visibility,
};
use localizer::parameters::FilterParameters;
use localizer::{EchoBlock, EchoSequence, Method, Odometry, Parameters, Pose};

/// A signal without structure; the time does not depend on it.
fn noise(length: usize) -> Vec<f32> {
    let mut state = 1_u32;
    (0..length)
        .map(|_| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / 8_388_608.0 - 1.0
        })
        .collect()
}

/// Echoes with a few bright delays in every direction, and the map of one block at the origin.
fn echoes_and_map(parameters: &Parameters, bank: &DopplerBank) -> Option<(EchoBlock, MapImage)> {
    let mut intensity = bank.intensity();
    bank.measure(
        &noise(bank.block_length()),
        0.3,
        &mut bank.scratch(),
        &mut intensity,
    );
    intensity.mapv_inplace(|value| value.powi(4));
    let odometry = Odometry {
        v_mps: 0.3,
        omega_radps: 0.1,
    };
    let block = EchoBlock {
        index: 0,
        t_s: 0.0,
        odometry,
        stationary: false,
        toa_intensity: vec![0.0; intensity.ncols()],
        intensity,
    };
    let sequence = EchoSequence {
        parameters: parameters.clone(),
        blocks: vec![block.clone()],
        odometry: vec![odometry],
    };
    let map = map_builder::build(&[(&sequence, &[Pose::default()])]).ok()?;
    Some((block, map))
}

fn step(criterion: &mut Criterion) {
    let parameters = Parameters::default();
    let Ok(bank) = DopplerBank::new(&parameters) else {
        return;
    };
    let block = noise(bank.block_length());
    let (mut scratch, mut intensity) = (bank.scratch(), bank.intensity());
    criterion.bench_function("doppler bank, 6 periods, 30 directions", |bencher| {
        bencher.iter(|| bank.measure(black_box(&block), 0.3, &mut scratch, &mut intensity));
    });
    let Some((echoes, map)) = echoes_and_map(&parameters, &bank) else {
        return;
    };
    for half_width_m in [2.0, 4.0, 6.0] {
        let parameters = Parameters {
            filter: FilterParameters {
                window_half_width_m: half_width_m,
                ..parameters.filter
            },
            ..parameters.clone()
        };
        let mut filter = ParticleFilter::new(&parameters, Pose::default(), 1);
        criterion.bench_function(
            &format!("particle filter, 100 particles, {half_width_m} m"),
            |bencher| {
                bencher.iter(|| {
                    filter.predict(black_box(echoes.odometry), 0.01);
                    filter.weigh(echoes.polar(Method::Doppler), &map);
                    filter.resample();
                    filter.expectation()
                });
            },
        );
    }
}

/// A step among landmarks, samples to pose, and one from an unknown start while it searches the map.
fn landmark_step(criterion: &mut Criterion) {
    let mut parameters = Parameters::default();
    parameters.measurement.periods = landmarks::PERIODS;
    let odometry = Odometry {
        v_mps: 0.3,
        omega_radps: 0.1,
    };
    let samples = noise(parameters.samples_per_period());
    let wall = |number: u32| {
        let shape = Shape::Wall {
            normal_rad: 0.5 * f64::from(number),
            distance_m: 1.5 + 0.2 * f64::from(number),
        };
        let looks = (-30..30).map(|k| {
            let place_m = 0.1 * f64::from(k);
            let pose = Pose {
                x_m: place_m,
                y_m: -place_m,
                heading_rad: 0.0,
            };
            (pose, true)
        });
        Landmark {
            shape,
            covariance: [[1e-6, 0.0], [0.0, 1e-6]],
            range_sigma_m: 0.001,
            visibility: Visibility::count(&shape, looks),
            blocks: 60,
        }
    };
    let map = LandmarkMap {
        parameters: parameters.clone(),
        landmarks: (0..12).map(wall).collect(),
        area_m: [[-1.7, 1.7]; 2],
        explained: 0.5,
    };
    let known = Start::Known {
        pose: Pose::default(),
        sigma_m: 0.01,
        sigma_rad: 0.02,
    };
    for (name, start, warm) in [
        ("landmarks, one step", known, 3),
        ("landmarks, search over 4 m", Start::Unknown, 1),
    ] {
        let begin = || {
            let noise = Noise::default();
            let mut localizer =
                LandmarkLocalizer::new(&parameters, map.clone(), &start, noise).ok()?;
            for _ in 0..warm {
                localizer.step(&samples, odometry).ok()?;
            }
            Some(localizer)
        };
        criterion.bench_function(name, |bencher| {
            bencher.iter_batched(
                begin,
                |localizer| {
                    let mut localizer = localizer?;
                    localizer.step(black_box(&samples), odometry).ok()
                },
                BatchSize::LargeInput,
            );
        });
    }
}

criterion_group!(benches, step, landmark_step);
criterion_main!(benches);
