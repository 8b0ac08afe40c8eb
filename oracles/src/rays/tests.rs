use super::*;
use std::f64::consts::{FRAC_PI_2, PI};

fn wall(wall: usize, a: Vec2, b: Vec2, thickness_m: f64) -> WallSegment {
    WallSegment {
        wall,
        piece: 0,
        ends_m: [a, b],
        thickness_m,
    }
}

fn close(a: f64, b: f64) {
    assert!((a - b).abs() < 1e-9, "{a} is not {b}");
}

fn kinds(paths: &[RayPath]) -> Vec<RayKind> {
    paths.iter().map(|path| path.kind).collect()
}

#[test]
fn a_single_wall_gives_the_direct_path_and_one_echo() {
    let walls = Reflectors::new([wall(0, [2.0, -1.0], [2.0, 1.0], 0.02)]);
    let paths = trace(&walls, [0.0, 0.1], [0.0, 0.1], &TraceOptions::default());
    assert_eq!(kinds(&paths), [RayKind::Direct, RayKind::Single]);
    close(paths[1].length_m, 2.0 * 1.99);
    close(paths[1].departure_rad, 0.0);
    close(paths[1].arrival_rad, 0.0);
    close(paths[1].clearance_m, 0.9);
    close(paths[1].points_m[1][0], 1.99);
}

/// Twice, folded back on itself, in parts that overlap, or with a shorter one on it: one surface, one echo.
#[test]
fn walls_drawn_over_each_other_reflect_once() {
    let (a, b) = ([2.0, -1.0], [2.0, 1.0]);
    let whole = wall(0, a, b, 0.02);
    let layouts = [
        vec![whole, wall(1, a, b, 0.02)],
        vec![whole, wall(0, b, a, 0.02)],
        vec![wall(0, a, [2.0, 0.4], 0.02), wall(1, [2.0, -0.3], b, 0.02)],
        vec![whole, wall(1, [2.0, -0.2], [2.0, 0.35], 0.02)],
        vec![
            wall(1, [2.0, -0.2], [2.0, 0.35], 0.02),
            whole,
            wall(2, b, a, 0.02),
        ],
        // Another wall of the corner must still be the neighbour.
        vec![whole, wall(1, a, b, 0.02), wall(2, b, [1.0, 1.0], 0.02)],
    ];
    for (number, layout) in layouts.into_iter().enumerate() {
        let corner = layout.len() == 3 && number == 5;
        let one: Vec<WallSegment> = match corner {
            true => vec![layout[0], layout[2]],
            false => vec![whole],
        };
        let length_m = |walls: &[WallSegment], side: f64| -> f64 {
            let faces = Reflectors::new(walls.iter().copied());
            let of_side = |face: &&Face| face.normal[0] * side > 0.5;
            faces
                .faces()
                .iter()
                .filter(of_side)
                .map(|face| face.length_m)
                .sum()
        };
        for side in [1.0, -1.0] {
            close(length_m(&layout, side), length_m(&one, side));
        }
        let at = [0.0, 0.1];
        let echoes = |walls: &[WallSegment]| -> Vec<f64> {
            let walls = Reflectors::new(walls.iter().copied());
            let paths = trace(&walls, at, at, &TraceOptions::default());
            paths.iter().map(|path| path.length_m).collect()
        };
        assert_eq!(echoes(&layout).len(), echoes(&one).len(), "layout {number}");
    }
}

#[test]
fn a_bistatic_echo_has_equal_angles() {
    let walls = Reflectors::new([wall(0, [-3.0, 0.0], [3.0, 0.0], 0.0)]);
    let paths = trace(&walls, [-1.0, 1.0], [1.0, 1.0], &TraceOptions::default());
    assert_eq!(kinds(&paths), [RayKind::Direct, RayKind::Single]);
    close(paths[1].length_m, 8f64.sqrt());
    close(paths[1].departure_rad, -PI / 4.0);
    close(paths[1].arrival_rad, -3.0 * PI / 4.0);
    assert_eq!(paths[1].points_m[1], [0.0, 0.0]);
}

#[test]
fn beside_the_end_of_a_wall_there_is_no_echo() {
    let walls = Reflectors::new([wall(0, [2.0, 0.0], [2.0, 1.0], 0.02)]);
    let beside = [0.0, -0.02];
    assert_eq!(
        kinds(&trace(&walls, beside, beside, &TraceOptions::default())),
        [RayKind::Direct]
    );
    let slack = TraceOptions {
        slack_m: 0.03,
        ..TraceOptions::default()
    };
    let paths = trace(&walls, beside, beside, &slack);
    assert_eq!(kinds(&paths), [RayKind::Direct, RayKind::Single]);
    close(paths[1].clearance_m, -0.02);
}

#[test]
fn a_screen_hides_what_is_behind_it() {
    let walls = Reflectors::new([
        wall(0, [2.0, -1.0], [2.0, 1.0], 0.02),
        wall(1, [1.0, -0.2], [1.0, 0.2], 0.02),
    ]);
    let paths = trace(&walls, [0.0, 0.0], [0.0, 0.0], &TraceOptions::default());
    assert_eq!(kinds(&paths), [RayKind::Direct, RayKind::Single]);
    assert_eq!(paths[1].walls, [(1, 0)]);
    let behind = trace(&walls, [0.0, 0.0], [1.5, 0.0], &TraceOptions::default());
    assert!(behind.iter().all(|path| path.kind != RayKind::Direct));
}

#[test]
fn a_right_angled_corner_sends_the_sound_back_once() {
    let (wall_x, wall_y) = (
        wall(0, [0.0, 0.0], [3.0, 0.0], 0.0),
        wall(1, [0.0, 0.0], [0.0, 3.0], 0.0),
    );
    let walls = Reflectors::new([wall_x, wall_y]);
    let pair = [1.2, 0.5];
    let paths = trace(&walls, pair, pair, &TraceOptions::default());
    assert_eq!(
        kinds(&paths),
        [
            RayKind::Direct,
            RayKind::Single,
            RayKind::Single,
            RayKind::Corner
        ]
    );
    close(paths[3].length_m, 2.0 * 1.3);
    close(paths[3].departure_rad, (-0.5f64).atan2(-1.2));
    close(paths[3].arrival_rad, (-0.5f64).atan2(-1.2));
    // A pair apart sees it in one order of the walls only.
    let apart = trace(&walls, [1.2, 0.5], [1.1, 0.8], &TraceOptions::default());
    assert_eq!(apart.iter().filter(|path| path.is_corner()).count(), 1);
}

#[test]
fn thick_walls_meet_at_the_inner_apex_and_at_the_outer_one() {
    let walls = Reflectors::new([
        wall(0, [0.0, 0.0], [3.0, 0.0], 0.02),
        wall(1, [0.0, 3.0], [0.0, 0.0], 0.02),
    ]);
    let inside = trace(&walls, [1.01, 1.01], [1.01, 1.01], &TraceOptions::default());
    let corner = inside
        .iter()
        .find(|path| path.is_corner())
        .expect("an inner corner");
    close(corner.length_m, 2.0 * 2f64.sqrt());
    close(corner.points_m[1][0], 0.01);
    let longest = walls
        .faces()
        .iter()
        .map(|face| face.length_m)
        .fold(0.0, f64::max);
    close(longest, 3.01);
    // Outside, the corner is convex and sends nothing back.
    let outside = trace(&walls, [-1.0, -1.0], [-1.0, -1.0], &TraceOptions::default());
    assert_eq!(kinds(&outside), [RayKind::Direct]);
}

#[test]
fn a_polyline_of_collinear_pieces_echoes_once_and_hides() {
    let walls = Reflectors::new([
        wall(0, [2.0, -1.0], [2.0, 0.3], 0.02),
        wall(0, [2.0, 0.3], [2.0, 1.0], 0.02),
    ]);
    let paths = trace(&walls, [0.0, 0.0], [0.0, 0.0], &TraceOptions::default());
    assert_eq!(kinds(&paths), [RayKind::Direct, RayKind::Single]);
    close(walls.transmission([0.0, 0.3], [3.0, 0.3], &[], 0.05), 0.0);
    close(walls.transmission([0.0, 1.0], [3.0, 1.0], &[], 0.05), 0.5);
}

#[test]
fn parallel_walls_give_double_reflections_in_both_orders() {
    let walls = Reflectors::new([
        wall(0, [0.0, -1.0], [0.0, 1.0], 0.0),
        wall(1, [3.0, -1.0], [3.0, 1.0], 0.0),
    ]);
    let pair = [1.0, 0.0];
    let options = TraceOptions {
        max_order: 3,
        ..TraceOptions::default()
    };
    let paths = trace(&walls, pair, pair, &options);
    let lengths = |kind| -> Vec<f64> {
        let mut all: Vec<f64> = paths
            .iter()
            .filter(|path| path.kind == kind)
            .map(|path| path.length_m)
            .collect();
        all.sort_by(f64::total_cmp);
        all
    };
    assert_eq!(lengths(RayKind::Single), [2.0, 4.0]);
    assert_eq!(lengths(RayKind::Double), [6.0, 6.0]);
    assert_eq!(lengths(RayKind::Multiple), [8.0, 10.0]);
}

#[test]
fn swapping_the_ends_reverses_every_path() {
    let walls = Reflectors::new([
        wall(0, [0.0, 0.0], [3.0, 0.3], 0.02),
        wall(1, [0.0, 0.0], [-0.2, 2.5], 0.02),
        wall(2, [2.0, 2.8], [3.0, 1.9], 0.02),
    ]);
    let (a, b) = ([1.0, 0.9], [1.6, 1.4]);
    let there = trace(&walls, a, b, &TraceOptions::default());
    let back = trace(&walls, b, a, &TraceOptions::default());
    assert_eq!(there.len(), back.len());
    assert!(there.len() > 4);
    for path in &there {
        let twin = back
            .iter()
            .find(|other| other.walls.iter().rev().eq(path.walls.iter()))
            .expect("a path and its reverse");
        close(twin.length_m, path.length_m);
        close(twin.departure_rad, path.arrival_rad);
        close(twin.arrival_rad, path.departure_rad);
    }
    let folded: f64 = there[3]
        .points_m
        .windows(2)
        .map(|leg| length(sub(leg[1], leg[0])))
        .sum();
    close(folded, there[3].length_m);
}

#[test]
fn fading_is_complementary() {
    close(fade(0.0, 0.05), 0.5);
    close(fade(0.0, 0.0), 1.0);
    close(fade(0.02, 0.05) + fade(-0.02, 0.05), 1.0);
    close((FRAC_PI_2 * 0.4).sin() * 0.5 + 0.5, fade(0.02, 0.05));
}

#[test]
fn walls_drawn_into_each_other_close_a_corner() {
    // Neither shares an end with the other; the apex of the faces is at (0.01, 0.01).
    let walls = Reflectors::new([
        wall(0, [-0.01, 0.0], [3.0, 0.0], 0.02),
        wall(1, [0.0, -0.01], [0.0, 3.0], 0.02),
    ]);
    let pair = [1.01, 0.51];
    let paths = trace(&walls, pair, pair, &TraceOptions::default());
    assert_eq!(
        kinds(&paths),
        [
            RayKind::Direct,
            RayKind::Single,
            RayKind::Single,
            RayKind::Corner
        ]
    );
    close(paths[3].length_m, 2.0 * 1.25f64.sqrt());
    assert!(paths[3].clearance_m.abs() < 1e-5);
}

#[test]
fn a_wall_that_ends_on_another_splits_its_face() {
    let walls = Reflectors::new([
        wall(0, [0.0, 0.0], [4.0, 0.0], 0.02),
        wall(1, [1.0, 0.0], [1.0, 2.0], 0.02),
    ]);
    let upper = |face: &&Face| face.segment == 0 && face.normal[1] > 0.5;
    let mut lengths: Vec<f64> = walls
        .faces()
        .iter()
        .filter(upper)
        .map(|face| face.length_m)
        .collect();
    lengths.sort_by(f64::total_cmp);
    assert_eq!(lengths.len(), 2);
    assert!((lengths[0] - 0.99).abs() < 1e-5 && (lengths[1] - 2.99).abs() < 1e-5);
    let pair = [2.0, 1.0];
    let paths = trace(&walls, pair, pair, &TraceOptions::default());
    assert!(paths.iter().any(RayPath::is_corner));
}
