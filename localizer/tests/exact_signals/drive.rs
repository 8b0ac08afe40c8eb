//! Whole drives among plane walls: map, localization, and the agreement of streaming and offline runs.

use std::sync::LazyLock;

use crate::signals::{Drive, localization_drive, mapping_drive, mean_error_m, record, room};
use localizer::echo::{EchoSequence, measure};
use localizer::image::map_builder;
use localizer::offline::localize;
use localizer::parameters::{FilterParameters, MeasurementParameters, SignalParameters};
use localizer::{DirectWave, Localizer, MapImage, Method, Odometry, Parameters, Pose, Recording};

struct Fixture {
    map: MapImage,
    drive: Drive,
    recording: Recording,
    echoes: EchoSequence,
}

fn parameters() -> Parameters {
    Parameters {
        transmitted: None,
        signal: SignalParameters {
            speed_of_sound_mps: 343.2,
            ..SignalParameters::default()
        },
        measurement: MeasurementParameters {
            max_range_m: 4.3,
            ..MeasurementParameters::default()
        },
        filter: FilterParameters {
            window_half_width_m: 3.0,
            ..FilterParameters::default()
        },
    }
}

/// Made once for all tests of this file.
static FIXTURE: LazyLock<Fixture> = LazyLock::new(|| {
    let parameters = parameters();
    let mapping = record(&parameters, &mapping_drive(30.0), &room(), 4.0, 0.0);
    let echoes = measure(&mapping, &parameters).unwrap();
    let poses = echoes.poses(mapping.truth.as_ref().unwrap());
    let map = map_builder::build(&[(&echoes, &poses)]).unwrap();
    let drive = localization_drive(18.0);
    let recording = record(&parameters, &drive, &room(), 4.0, 0.01);
    let echoes = measure(&recording, &parameters).unwrap();
    Fixture {
        map,
        drive,
        recording,
        echoes,
    }
});

/// The first periods of the fixture's recording.
fn short(periods: usize) -> Recording {
    let recording = &FIXTURE.recording;
    Recording {
        signal: recording.signal[..4092 * periods].to_vec(),
        direct: None,
        ..recording.clone()
    }
}

#[test]
fn doppler_follows_the_drive_where_odometry_drifts() {
    let Fixture {
        map, drive, echoes, ..
    } = &*FIXTURE;
    let start = drive.pose_at(0.0);
    let error = |method, likelihood_exponent| {
        let parameters = Parameters {
            filter: FilterParameters {
                method,
                likelihood_exponent,
                ..parameters().filter
            },
            ..parameters()
        };
        let seeds = 0..3;
        let sum: f64 = seeds
            .clone()
            .map(|seed| {
                mean_error_m(
                    &localize(echoes, map, &parameters, start, seed).unwrap(),
                    drive,
                )
            })
            .sum();
        sum / seeds.count() as f64
    };
    let odometry = error(Method::Odometry, 1.0);
    let printed = error(Method::Doppler, 1.0);
    assert!(printed < 0.06, "eq. (17) to the letter: {printed} m");
    let tempered = error(Method::Doppler, 4.0);
    assert!(tempered < 0.035, "tempered: {tempered} m");
    assert!(odometry > 3.0 * tempered, "odometry: {odometry} m");
    let toa = error(Method::ToaOnly, 4.0);
    assert!(toa > tempered && toa < odometry, "range only: {toa} m");
}

#[test]
fn streaming_and_offline_give_the_same_estimates() {
    let Fixture { map, drive, .. } = &*FIXTURE;
    let recording = short(20);
    let start = drive.pose_at(0.0);
    for periods in [1, 3, 6] {
        let parameters = Parameters {
            measurement: MeasurementParameters {
                periods,
                direct_wave: DirectWave::GatedMean,
                ..parameters().measurement
            },
            ..parameters()
        };
        let echoes = measure(&recording, &parameters).unwrap();
        for method in [Method::Doppler, Method::ToaOnly, Method::Odometry] {
            let parameters = Parameters {
                filter: FilterParameters {
                    method,
                    ..parameters.filter
                },
                ..parameters.clone()
            };
            let offline = localize(&echoes, map, &parameters, start, 7).unwrap();
            let mut streaming = Localizer::new(&parameters, map.clone(), start, 7).unwrap();
            let mut online = Vec::new();
            let samples = recording
                .signal
                .chunks_exact(parameters.samples_per_period());
            for (samples, &odometry) in samples.zip(&echoes.odometry) {
                online.extend(streaming.step(samples, odometry).unwrap());
            }
            assert_eq!(online.len(), 21 - periods);
            assert_eq!(online, offline);
        }
    }
}

#[test]
fn equal_seeds_give_equal_runs_at_any_number_of_threads() {
    let Fixture { map, drive, .. } = &*FIXTURE;
    let start = drive.pose_at(0.0);
    let recording = short(20);
    let run = |threads, seed| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| {
            let echoes = measure(&recording, &parameters()).unwrap();
            localize(&echoes, map, &parameters(), start, seed).unwrap()
        })
    };
    let first = run(1, 5);
    assert_eq!(first, run(2, 5));
    assert_eq!(first, run(3, 5));
    assert_ne!(first, run(1, 6));
}

#[test]
fn estimates_tell_their_time_and_a_latest_pose() {
    let Fixture {
        map, drive, echoes, ..
    } = &*FIXTURE;
    let parameters = parameters();
    let estimates = localize(echoes, map, &parameters, drive.pose_at(0.0), 2).unwrap();
    for (index, estimate) in estimates.iter().enumerate() {
        assert!((estimate.t_s - (index as f64 + 3.0) * 0.1023).abs() < 1e-9);
        assert!(
            estimate.effective_sample_size > 1.0 && estimate.effective_sample_size <= 100.0 + 1e-9
        );
        assert!((0..3).all(|axis| estimate.covariance[axis][axis] >= 0.0));
        let ahead_m = estimate
            .latest
            .distance_m(&drive.pose_at(estimate.t_s + 3.0 * 0.1023));
        let here_m = estimate.pose.distance_m(&drive.pose_at(estimate.t_s));
        assert!(
            ahead_m < here_m + 0.08,
            "block {index}: {here_m} m, extrapolated {ahead_m} m"
        );
    }
}

#[test]
fn a_resting_robot_is_not_weighed() {
    let Fixture { map, .. } = &*FIXTURE;
    let parameters = parameters();
    let mut localizer = Localizer::new(&parameters, map.clone(), Pose::default(), 3).unwrap();
    let noise: Vec<f32> = (0..4092).map(|k| (k as f32 * 1.7).sin()).collect();
    for step in 0..10 {
        let estimate = localizer.step(&noise, Odometry::default()).unwrap();
        assert_eq!(estimate.is_some(), step >= 5);
        if let Some(estimate) = estimate {
            assert!(estimate.stationary);
            assert!((estimate.effective_sample_size - 100.0).abs() < 1e-9);
            assert!(estimate.pose.distance_m(&Pose::default()) < 1e-3);
        }
    }
}

#[test]
fn inputs_that_do_not_fit_are_refused() {
    let Fixture {
        map,
        drive,
        recording,
        echoes,
    } = &*FIXTURE;
    let start = drive.pose_at(0.0);
    let message = |parameters: Parameters| {
        localize(echoes, map, &parameters, start, 0)
            .unwrap_err()
            .to_string()
    };
    assert!(
        message(Parameters {
            measurement: MeasurementParameters {
                cell_m: 0.05,
                ..parameters().measurement
            },
            ..parameters()
        })
        .contains("cell")
    );
    assert!(
        message(Parameters {
            measurement: MeasurementParameters {
                periods: 4,
                ..parameters().measurement
            },
            ..parameters()
        })
        .contains("measure the echoes")
    );
    assert!(
        message(Parameters {
            measurement: MeasurementParameters {
                max_range_m: 8.0,
                ..parameters().measurement
            },
            ..parameters()
        })
        .contains("measure the echoes")
    );
    assert!(
        message(Parameters {
            filter: FilterParameters {
                particles: 0,
                ..parameters().filter
            },
            ..parameters()
        })
        .contains("particles")
    );
    let short = Recording {
        signal: vec![0.0; 20_000],
        direct: None,
        ..recording.clone()
    };
    assert!(
        measure(&short, &parameters())
            .unwrap_err()
            .to_string()
            .contains("4 whole periods")
    );
    let other = Parameters {
        signal: SignalParameters {
            carrier_hz: 9000.0,
            ..parameters().signal
        },
        ..parameters()
    };
    assert!(
        measure(recording, &other)
            .unwrap_err()
            .to_string()
            .contains("recording.json")
    );
    let mut localizer = Localizer::new(&parameters(), map.clone(), start, 0).unwrap();
    assert!(localizer.step(&[0.0; 10], Odometry::default()).is_err());
}
