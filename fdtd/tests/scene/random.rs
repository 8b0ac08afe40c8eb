//! Layouts drawn at random are scenes like any other, with drives that keep clear of their walls.

use std::collections::BTreeSet;

use fdtd::scene::{LayoutKind, Scene, random};

/// Distance in metres of a point from a segment.
fn distance_m([a, b]: [[f64; 2]; 2], p: [f64; 2]) -> f64 {
    // A fine walk along the wall: an oracle that shares nothing with the formula under test.
    (0..=2000)
        .map(|k| f64::from(k) / 2000.0)
        .map(|s| (a[0] + s * (b[0] - a[0]) - p[0]).hypot(a[1] + s * (b[1] - a[1]) - p[1]))
        .fold(f64::INFINITY, f64::min)
}

#[test]
fn every_seed_gives_a_scene_whose_drives_keep_clear_of_its_walls() {
    let mut airs = BTreeSet::new();
    for kind in [LayoutKind::Open, LayoutKind::Room] {
        for seed in 1..=25 {
            let file = random::layout(kind, seed);
            let scene = Scene::from_json(&file.to_string(), "random".as_ref()).expect("a scene");
            airs.insert((scene.medium.c_mps * 1e3) as u64);
            if kind == LayoutKind::Open {
                assert!(
                    (3..=5).contains(&scene.walls.len()),
                    "{} walls",
                    scene.walls.len()
                );
            }
            for name in ["mapping", "localization"] {
                let path = &scene.paths[name];
                let off_s = path.duration_s() - 40.0;
                assert!(off_s.abs() < 1e-9, "{kind:?} {seed} {name}: {off_s} s");
                let nearest_m = (0..=160)
                    .map(|k| path.point_at(0.25 * f64::from(k), [0.0; 2]))
                    .flat_map(|point| {
                        scene.walls.iter().map(move |wall| {
                            distance_m([wall.points_m[0], wall.points_m[1]], point)
                        })
                    })
                    .fold(f64::INFINITY, f64::min);
                assert!(nearest_m >= 0.30, "{kind:?} {seed} {name}: {nearest_m} m");
            }
        }
    }
    assert!(airs.len() > 15, "the air is drawn too");
}

#[test]
fn equal_seeds_give_equal_scenes_and_others_do_not() {
    let text = |kind, seed| random::layout(kind, seed).to_string();
    for kind in [LayoutKind::Open, LayoutKind::Room] {
        assert_eq!(text(kind, 3), text(kind, 3));
        assert_ne!(text(kind, 3), text(kind, 4));
    }
}
