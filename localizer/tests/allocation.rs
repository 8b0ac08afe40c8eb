//! Domain: the streaming localizer in steady operation. A step that allocates may wait for the system at any time,
//! which a robot that has to keep up with its signal cannot afford. After M + 1 steps (the first block and one more)
//! `step` must not touch the heap: count of allocations exactly 0, with every way of removing the direct wave that
//! can stream, with every method, and while the particles spread over more and more cells of the map. The same for the
//! localizer among landmarks from a known start, until it is lost: a search over the map allocates. Errors may
//! allocate.

#![expect(clippy::unwrap_used, reason = "a failed test may panic")]
#![expect(
    unsafe_code,
    reason = "a global allocator is an unsafe trait; this one only counts and passes on to the system's"
)]

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering};

use localizer::echo::DopplerBank;
use localizer::image::map_builder;
use localizer::landmarks::{
    Landmark, LandmarkLocalizer, LandmarkMap, Noise, Shape, Start, Visibility,
};
use localizer::parameters::{FilterParameters, MeasurementParameters};
use localizer::signal::waveform::transmit_period;
use localizer::{
    DirectWave, EchoBlock, EchoSequence, Localizer, MapImage, Method, Odometry, Parameters, Pose,
};

/// The system's allocator with a count of its calls, by all threads. This file holds one test, so that no
/// other one counts along.
struct Counting;

static COUNT: AtomicUsize = AtomicUsize::new(0);

// SAFETY: every call is passed on unchanged to the system's allocator, which keeps the contract.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        COUNT.fetch_add(1, Ordering::Relaxed);
        // SAFETY: the caller's promise.
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        COUNT.fetch_add(1, Ordering::Relaxed);
        // SAFETY: the caller's promise.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        COUNT.fetch_add(1, Ordering::Relaxed);
        // SAFETY: the caller's promise.
        unsafe { System.realloc(pointer, layout, size) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        COUNT.fetch_add(1, Ordering::Relaxed);
        // SAFETY: the caller's promise.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Calls to the allocator, to take or give back memory, during `work`.
fn allocations(work: impl FnOnce()) -> usize {
    let before = COUNT.load(Ordering::Relaxed);
    work();
    COUNT.load(Ordering::Relaxed) - before
}

/// A signal without structure.
fn noise(length: usize) -> Vec<f32> {
    let mut state = 1_u32;
    (0..length)
        .map(|_| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / 8_388_608.0 - 1.0
        })
        .collect()
}

const ODOMETRY: Odometry = Odometry {
    v_mps: 0.3,
    omega_radps: 0.1,
};

/// The map that one block of noise draws around the origin.
fn map(parameters: &Parameters) -> MapImage {
    let bank = DopplerBank::new(parameters).unwrap();
    let mut intensity = bank.intensity();
    let block = noise(bank.block_length());
    bank.measure(&block, ODOMETRY.v_mps, &mut bank.scratch(), &mut intensity);
    let block = EchoBlock {
        index: 0,
        t_s: 0.0,
        odometry: ODOMETRY,
        stationary: false,
        toa_intensity: vec![1.0; intensity.ncols()],
        intensity,
    };
    let sequence = EchoSequence {
        parameters: parameters.clone(),
        blocks: vec![block],
        odometry: vec![ODOMETRY],
    };
    map_builder::build(&[(&sequence, &[Pose::default()])]).unwrap()
}

#[test]
fn a_step_does_not_allocate_once_it_is_warm() {
    assert_ne!(
        allocations(|| drop(std::hint::black_box(vec![1_u8]))),
        0,
        "the counter counts"
    );
    let common = Parameters {
        measurement: MeasurementParameters {
            periods: 3,
            max_range_m: 3.0,
            ..MeasurementParameters::default()
        },
        filter: FilterParameters {
            window_half_width_m: 1.0,
            // Wide noise: the particles reach new cells with every step.
            sigma_v_mps: 3.0,
            sigma_omega_radps: 3.0,
            ..FilterParameters::default()
        },
        ..Parameters::default()
    };
    let map = map(&common);
    let samples = noise(common.samples_per_period());
    for direct_wave in [
        DirectWave::Keep,
        DirectWave::RunningMean,
        DirectWave::GatedMean,
    ] {
        for method in [Method::Doppler, Method::ToaOnly, Method::Odometry] {
            let parameters = Parameters {
                measurement: MeasurementParameters {
                    direct_wave,
                    ..common.measurement
                },
                filter: FilterParameters {
                    method,
                    // No resampling at all would keep the particles spreading; the usual one has to be without
                    // allocations too.
                    resample_threshold: if method == Method::ToaOnly { 1.0 } else { 0.1 },
                    ..common.filter
                },
                ..common.clone()
            };
            let mut localizer =
                Localizer::new(&parameters, map.clone(), Pose::default(), 1).unwrap();
            let mut estimates = 0;
            let mut step = || {
                if localizer.step(&samples, ODOMETRY).unwrap().is_some() {
                    estimates += 1;
                }
            };
            (0..=parameters.measurement.periods).for_each(|_| step());
            let count = allocations(|| (0..12).for_each(|_| step()));
            assert_eq!(
                count, 0,
                "{direct_wave:?}, {method:?}: calls to the allocator in 12 steps"
            );
            assert_eq!(estimates, 14);
        }
    }
    among_landmarks();
}

/// Four walls around the origin, seen from everywhere near it.
fn landmarks(parameters: &Parameters) -> LandmarkMap {
    let wall = |quarter: u32| {
        let shape = Shape::Wall {
            normal_rad: f64::from(quarter) * std::f64::consts::FRAC_PI_2,
            distance_m: 1.5,
        };
        let places = (-10..10).map(|k| 0.1 * f64::from(k));
        let looks = places.map(|x_m| {
            let pose = Pose {
                x_m,
                y_m: x_m,
                heading_rad: 0.0,
            };
            (pose, true)
        });
        Landmark {
            shape,
            covariance: [[1e-6, 0.0], [0.0, 1e-6]],
            range_sigma_m: 0.001,
            visibility: Visibility::count(&shape, looks),
            blocks: 20,
        }
    };
    LandmarkMap {
        parameters: parameters.clone(),
        landmarks: (0..4).map(wall).collect(),
        area_m: [[-1.0, 1.0]; 2],
        explained: 0.5,
    }
}

fn among_landmarks() {
    for periods in [1, 2, 4] {
        let parameters = Parameters {
            measurement: MeasurementParameters {
                periods,
                max_range_m: 3.0,
                // A mean over time would take an echo that stays away.
                direct_wave: DirectWave::Keep,
                ..MeasurementParameters::default()
            },
            ..Parameters::default()
        };
        let start = Start::Known {
            pose: Pose::default(),
            sigma_m: 0.01,
            sigma_rad: 0.02,
        };
        let map = landmarks(&parameters);
        let mut localizer =
            LandmarkLocalizer::new(&parameters, map, &start, Noise::default()).unwrap();
        // One echo, 1 m away and from the side.
        let period = transmit_period(&parameters.signal);
        let delay = parameters.signal.delay_of_range(1.0);
        let samples: Vec<f32> = (0..period.len())
            .map(|k| 0.1 * period[(k + period.len() - delay) % period.len()] as f32)
            .collect();
        let mut step = || localizer.step(&samples, ODOMETRY).unwrap();
        for _ in 0..=periods {
            step();
        }
        let count = allocations(|| {
            for _ in 0..8 {
                assert!(step().is_some());
            }
        });
        let peaks = localizer.tracker().peaks().len();
        assert_eq!(
            count, 0,
            "{periods} periods: calls to the allocator in 8 steps"
        );
        assert!(peaks > 0, "there was something to hold against the map");
    }
}
