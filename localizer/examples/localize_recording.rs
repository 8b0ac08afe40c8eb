//! Maps a room from one recorded drive and localizes a robot on another one.
//!
//! `cargo run --release -p localizer --example localize_recording [MAPPING DRIVE]` with two recording folders; without
//! arguments those of `examples/site_robot`.

use std::error::Error;
use std::path::{Path, PathBuf};

use localizer::image::map_builder;
use localizer::{Method, Parameters, Recording, echo, offline};

fn main() -> Result<(), Box<dyn Error>> {
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/site_robot");
    let mut arguments = std::env::args_os().skip(1).map(PathBuf::from);
    let mut folder = |name| arguments.next().unwrap_or_else(|| shipped.join(name));
    let mapping = Recording::read(&folder("mapping"))?;
    let drive = Recording::read(&folder("drive"))?;

    // Eqs. (1)-(7): the echoes of a drive with known poses, added up.
    let mut parameters = Parameters::default().for_recording(&mapping.meta);
    let echoes = echo::measure(&mapping, &parameters)?;
    let truth = mapping
        .truth
        .as_ref()
        .ok_or("the map needs true poses (truth.tum)")?;
    let map = map_builder::build(&[(&echoes, &echoes.poses(truth))])?;
    println!(
        "map of {} blocks: {} x {} cells of {} m",
        echoes.blocks.len(),
        map.intensity.ncols(),
        map.intensity.nrows(),
        map.cell_m
    );

    // Eqs. (8)-(18): the particle filter on the echoes of the other drive.
    parameters = parameters.for_recording(&drive.meta);
    let echoes = echo::measure(&drive, &parameters)?;
    for method in [Method::Doppler, Method::ToaOnly, Method::Odometry] {
        parameters.filter.method = method;
        let estimates = offline::localize(&echoes, &map, &parameters, drive.start_pose(), 1)?;
        let last = estimates.last().ok_or("the drive is too short")?;
        print!(
            "{method:?}: after {:.1} s at x {:.2} m, y {:.2} m",
            last.t_s, last.pose.x_m, last.pose.y_m
        );
        let Some(truth) = &drive.truth else {
            println!();
            continue;
        };
        let errors_m = estimates.iter().filter_map(|estimate| {
            let true_pose = truth.pose_at(estimate.t_s)?;
            Some(estimate.pose.distance_m(&true_pose))
        });
        let mean_m = errors_m.sum::<f64>() / estimates.len() as f64;
        println!("; mean distance from the true positions {mean_m:.3} m");
    }
    Ok(())
}
