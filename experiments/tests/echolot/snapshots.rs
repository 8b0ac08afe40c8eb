//! Pictures of the field while it is simulated.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use crate::room::{echolot, expect, refuse, scene, scene_file};

const SIMULATE: [&str; 6] = ["simulate", "room.json", "--path", "short", "-o", "take"];

/// Red, green and blue of the pixel over a place of the room in metres.
type Look = Box<dyn Fn([f64; 2]) -> [u8; 3]>;

/// A picture of the whole room.
fn picture(file: &Path) -> Look {
    let mut reader = png::Decoder::new(BufReader::new(File::open(file).unwrap()))
        .read_info()
        .unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut pixels).unwrap();
    assert_eq!((info.width, info.height), (500, 500));
    Box::new(move |[x, y]| {
        // The first row is the room's far side.
        let [column, row] = [(x / 0.005) as usize, 499 - (y / 0.005) as usize];
        let first = 3 * (500 * row + column);
        pixels[first..first + 3].try_into().unwrap()
    })
}

#[test]
fn pictures_show_walls_robot_and_sound_and_are_joined_to_an_animation() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    scene_file(at);
    let every = ["--snapshots", "field", "--every", "0.0301"];
    expect(at, &[&SIMULATE[..], &every].concat());
    let mut files: Vec<_> = std::fs::read_dir(at.join("field"))
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|file| file.extension().is_some_and(|ending| ending == "png"))
        .collect();
    files.sort();
    assert_eq!(files.len(), 3, "{files:?}");
    for (index, file) in files.iter().enumerate() {
        let name = file.file_stem().unwrap().to_str().unwrap();
        let digits = name.trim_start_matches("pressure_").trim_end_matches("us");
        let t_s = 1e-6 * digits.parse::<f64>().unwrap();
        // To the nearest step, and the name to the nearest microsecond.
        assert!((t_s - 0.0301 * (index + 1) as f64).abs() < 5.2e-6, "{t_s}");
        let look = picture(file);
        let robot_m = scene().path("short").unwrap().point_at(t_s, [0.0; 2]);
        assert_eq!(look(robot_m), [0, 158, 115]);
        // The middle of the second wall, and the open room beside it.
        assert_eq!(look([2.175, 1.3]), [0, 0, 0]);
        assert_ne!(look([2.1, 1.3]), [0, 0, 0]);
    }
    // At the end the sound fills the room: of the places on a line through it, some are above and some below the mean.
    let look = picture(files.last().unwrap());
    let line: Vec<[u8; 3]> = (60..200)
        .map(|i| look([0.01 * f64::from(i), 1.5]))
        .collect();
    let red = line.iter().filter(|[red, _, blue]| red > blue).count();
    let blue = line.iter().filter(|[red, _, blue]| blue > red).count();
    assert!(red > 20 && blue > 20, "{red} {blue}");

    let animation = File::open(at.join("field/pressure.apng")).unwrap();
    let mut reader = png::Decoder::new(BufReader::new(animation))
        .read_info()
        .unwrap();
    let frames = reader.info().animation_control().unwrap().num_frames;
    assert_eq!(frames as usize, files.len());
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    for file in &files {
        reader.next_frame(&mut pixels).unwrap();
        let shown = pixels[3 * (500 * 100 + 100)..][..3].to_vec();
        assert_eq!(picture(file)([0.5025, 1.9975]).to_vec(), shown);
    }

    // The recording is the same without pictures.
    let bytes = || std::fs::read(at.join("take/signal.wav")).unwrap();
    let pictured = bytes();
    assert!(echolot(at, &SIMULATE).status.success());
    assert_eq!(bytes(), pictured);
}

/// The domain of a free field is the drive's own; the robot is in it wherever it is in the room.
#[test]
fn a_free_field_shows_the_robot_too() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    scene_file(at);
    let free = ["--free-field", "--snapshots", "field", "--every", "0.1"];
    expect(at, &[&SIMULATE[..], &free].concat());
    let file = File::open(at.join("field/pressure_000100000us.png")).unwrap();
    let mut reader = png::Decoder::new(BufReader::new(file)).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut pixels).unwrap();
    assert!(info.width < 200 && info.height < 200, "{info:?}");
    let robot = pixels
        .chunks_exact(3)
        .filter(|pixel| *pixel == [0, 158, 115])
        .count();
    // A disc of radius 5 pixels.
    assert!((70..90).contains(&robot), "{robot}");
}

#[test]
fn a_time_between_pictures_that_is_none_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    scene_file(folder.path());
    for every in ["0", "nan"] {
        let flags = ["--snapshots", "field", "--every", every];
        let complaint = refuse(folder.path(), &[&SIMULATE[..], &flags].concat());
        assert!(complaint.contains("--every"), "{complaint}");
    }
    assert!(!folder.path().join("field").exists());
}
