//! Folders of a WAV and a table of poses, as public data sets lay them out, as recordings.

use std::fmt::Write as _;
use std::path::Path;

use anyhow::{Context, Result, bail};
use localizer::pose::wrap_angle;
use localizer::{Pose, Trajectory};

/// Names of columns, in lower case, by what they hold.
const TIME: &[&str] = &[
    "t_s",
    "t",
    "time",
    "time_s",
    "timestamp",
    "timestamp_s",
    "seconds",
];
const X: &[&str] = &["x_m", "x", "px", "pos_x", "position_x", "x_pos"];
const Y: &[&str] = &["y_m", "y", "py", "pos_y", "position_y", "y_pos"];
const RADIANS: &[&str] = &[
    "heading_rad",
    "yaw_rad",
    "theta_rad",
    "heading",
    "yaw",
    "theta",
];
const DEGREES: &[&str] = &["heading_deg", "yaw_deg", "theta_deg"];
const QUATERNION: [&str; 4] = ["qx", "qy", "qz", "qw"];
const SPEED: &[&str] = &["v_mps", "v", "vx", "vx_mps", "speed", "speed_mps"];
const TURN_RADIANS: &[&str] = &["omega_radps", "omega", "yaw_rate_rad", "yaw_rate", "wz"];
const TURN_DEGREES: &[&str] = &["omega_degps", "yaw_rate_deg", "yaw_rate_degps"];

/// Longest table, in bytes.
const LONGEST: u64 = 1 << 30;

/// Longest drive, in seconds.
const LONGEST_S: f64 = 1e5;

/// Farthest place from the origin, in metres.
const FARTHEST_M: f64 = 1e5;

/// Share of the distance that a robot on wheels may go sideways before it is told.
const SIDEWAYS: f64 = 0.2;

/// A table of poses.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// The poses.
    pub path: Trajectory,
    /// Speed ahead in m/s and turn rate in rad/s at each pose, where the table has columns of them.
    pub speeds: Option<Vec<[f64; 2]>>,
}

/// Time between two lines of the odometry that is made of poses, and over which a speed is taken, in seconds.
const STEP_S: f64 = 0.05;

/// The only file of a folder that ends so, searched to a depth of 8 folders.
///
/// # Errors
/// When there is none, or several: one has to be named.
pub fn only(folder: &Path, end: &str, option: &str) -> Result<std::path::PathBuf> {
    let mut found = Vec::new();
    collect(folder, end, 8, &mut found);
    found.sort();
    match found.as_slice() {
        [one] => Ok(one.clone()),
        [] => bail!("{}: has no .{end} file; give {option}", folder.display()),
        [first, ..] => bail!(
            "{}: has {} .{end} files; give one of them with {option}, as {}",
            folder.display(),
            found.len(),
            first.strip_prefix(folder).unwrap_or(first).display()
        ),
    }
}

fn collect(folder: &Path, end: &str, depth: u32, found: &mut Vec<std::path::PathBuf>) {
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        if path.is_dir() && depth > 0 {
            collect(&path, end, depth - 1, found);
        } else if path
            .extension()
            .is_some_and(|own| own.eq_ignore_ascii_case(end))
        {
            found.push(path);
        }
    }
}

/// Reads a table of poses: a header, and rows with time, x, y and a heading or quaternion, and speeds where it has
/// them; `unit_s` is the unit of times. Rows that leave one of them empty, as those of other sensors in one table, are
/// left out.
///
/// # Errors
/// When the file cannot be read, a column is missing, or a number is none.
pub fn poses(file: &Path, unit_s: f64) -> Result<Table> {
    let of_file = || file.display().to_string();
    let length = std::fs::metadata(file).with_context(of_file)?.len();
    if length > LONGEST {
        bail!(
            "{}: has {length} bytes; give a table of at most 1 GiB",
            file.display()
        );
    }
    let text = std::fs::read_to_string(file).with_context(of_file)?;
    parse(&text, &file.display().to_string(), unit_s)
}

/// As [`poses`], of text; errors call it `origin`.
///
/// # Errors
/// As [`poses`].
pub fn parse(text: &str, origin: &str, unit_s: f64) -> Result<Table> {
    let mut records = records(text.trim_start_matches('\u{feff}'));
    let header: Vec<String> = (records.next().unwrap_or_default().iter())
        .map(|name| name.trim().to_lowercase())
        .collect();
    let column = |names: &[&str]| header.iter().position(|own| names.contains(&own.as_str()));
    let needed = |names: &[&str], what: &str| {
        column(names).with_context(|| {
            format!(
                "{origin}: has no column of {what}; name it one of {}",
                names.join(", ")
            )
        })
    };
    let places = [needed(TIME, "times")?, needed(X, "x")?, needed(Y, "y")?];
    let quaternion = QUATERNION.map(|name| column(&[name]));
    let heading = match (column(RADIANS), column(DEGREES), quaternion) {
        (Some(radians), ..) => vec![radians],
        (_, Some(degrees), _) => vec![degrees],
        (.., [Some(x), Some(y), Some(z), Some(w)]) => vec![x, y, z, w],
        _ => bail!(
            "{origin}: has no column of headings; name it one of {}, {}, or give {}",
            RADIANS.join(", "),
            DEGREES.join(", "),
            QUATERNION.join(", ")
        ),
    };
    let in_degrees = column(RADIANS).is_none() && column(DEGREES).is_some();
    let turn = (column(TURN_RADIANS).map(|at| (at, 1.0)))
        .or_else(|| column(TURN_DEGREES).map(|at| (at, 1_f64.to_radians())));
    let motion = column(SPEED).zip(turn);
    let (mut t_s, mut poses, mut speeds) = (Vec::new(), Vec::<Pose>::new(), Vec::new());
    for (index, record) in records.enumerate() {
        let number = |place: usize| -> Result<Option<f64>> {
            let cell = record.get(place).map_or("", |cell| cell.trim());
            if cell.is_empty() {
                return Ok(None);
            }
            let number = cell.parse().ok().filter(|number: &f64| number.is_finite());
            number.map(Some).with_context(|| {
                let short: String = cell.chars().filter(|c| !c.is_control()).take(20).collect();
                format!(
                    "{origin}: row {}: {}: `{short}` is no number",
                    index + 2,
                    header[place]
                )
            })
        };
        let mut numbers = Vec::with_capacity(7);
        for &place in places.iter().chain(&heading) {
            let Some(number) = number(place)? else {
                break;
            };
            numbers.push(number);
        }
        let heading_rad = match numbers[..] {
            [_, _, _, angle] if in_degrees => angle.to_radians(),
            [_, _, _, angle] => angle,
            [_, _, _, x, y, z, w] => (2.0 * (w * z + x * y)).atan2(1.0 - 2.0 * (y * y + z * z)),
            _ => continue,
        };
        let time_s = unit_s * numbers[0];
        if let Some(place_m) = numbers[1..3].iter().find(|place| place.abs() > FARTHEST_M) {
            bail!(
                "{origin}: row {}: {place_m:e} m is no place of a robot; give metres",
                index + 2
            );
        }
        if t_s.last().is_some_and(|last| *last >= time_s) {
            bail!(
                "{origin}: row {}: times do not increase; sort it",
                index + 2
            );
        }
        if let Some((speed, (turn, unit))) = motion
            && let (Some(speed), Some(turn)) = (number(speed)?, number(turn)?)
        {
            speeds.push([speed, turn * unit]);
        }
        t_s.push(time_s);
        poses.push(Pose {
            x_m: numbers[1],
            y_m: numbers[2],
            heading_rad: wrap_angle(heading_rad),
        });
    }
    if poses.len() < 2 {
        bail!(
            "{origin}: has {} whole poses; give two or more",
            poses.len()
        );
    }
    let length_s = t_s[t_s.len() - 1] - t_s[0];
    if length_s > LONGEST_S {
        bail!("{origin}: lasts {length_s:.0} s; give the unit of its times (--time-unit)");
    }
    let speeds = (speeds.len() == poses.len()).then_some(speeds);
    let path = Trajectory { t_s, poses };
    Ok(Table { path, speeds })
}

impl Table {
    /// `odometry.csv`: the table's own speeds, or those of its poses.
    pub fn odometry(&self) -> String {
        let Some(speeds) = &self.speeds else {
            return odometry(&self.path);
        };
        let mut text = String::from("t_s,v_mps,omega_radps\n");
        for (t_s, [speed_mps, turn_radps]) in self.path.t_s.iter().zip(speeds) {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "{t_s:.9},{speed_mps},{turn_radps}");
        }
        text
    }

    /// What one has to know of wheels from this table.
    pub fn warnings(&self) -> Vec<String> {
        let mut warnings = Vec::new();
        if self.speeds.is_none() {
            warnings.push(
                "the wheels are made of the poses: they are as good as the truth; replace odometry.csv by a log of \
                 wheels if there is one"
                    .to_string(),
            );
        }
        let (mut ahead_m, mut sideways_m) = (0.0, 0.0);
        for pair in self.path.poses.windows(2) {
            let turn = wrap_angle(pair[1].heading_rad - pair[0].heading_rad);
            let (sine, cosine) = (pair[0].heading_rad + 0.5 * turn).sin_cos();
            let (x_m, y_m) = (pair[1].x_m - pair[0].x_m, pair[1].y_m - pair[0].y_m);
            ahead_m += (x_m * cosine + y_m * sine).abs();
            sideways_m += (y_m * cosine - x_m * sine).abs();
        }
        if sideways_m > SIDEWAYS * (ahead_m + sideways_m) {
            warnings.push(format!(
                "it goes {sideways_m:.2} m sideways and {ahead_m:.2} m ahead; a robot on wheels goes ahead: look \
                 whether headings are right, and expect no good poses of one that hovers"
            ));
        }
        warnings
    }
}

/// Cells of rows separated by commas or semicolons; a quoted cell may hold both, and line breaks.
fn records(text: &str) -> impl Iterator<Item = Vec<String>> {
    let first = text.lines().next().unwrap_or_default();
    let separator = if first.contains(';') { ';' } else { ',' };
    let mut letters = text.chars().peekable();
    std::iter::from_fn(move || {
        letters.peek()?;
        let (mut cells, mut quoted) = (vec![String::new()], false);
        for letter in letters.by_ref() {
            match letter {
                '"' => quoted = !quoted,
                '\n' if !quoted => break,
                '\r' if !quoted => {}
                own if own == separator && !quoted => cells.push(String::new()),
                own => {
                    if let Some(cell) = cells.last_mut() {
                        cell.push(own);
                    }
                }
            }
        }
        Some(cells)
    })
}

/// Speeds of a path as `odometry.csv`.
pub fn odometry(path: &Trajectory) -> String {
    let mut text = String::from("t_s,v_mps,omega_radps\n");
    let (Some(&first_s), Some(&last_s)) = (path.t_s.first(), path.t_s.last()) else {
        return text;
    };
    let steps = ((last_s - first_s) / STEP_S)
        .floor()
        .clamp(0.0, LONGEST_S / STEP_S) as u32;
    for step in 0..=steps {
        let t_s = first_s + f64::from(step) * STEP_S;
        let ends_s = [
            (t_s - 0.5 * STEP_S).max(first_s),
            (t_s + 0.5 * STEP_S).min(last_s),
        ];
        let [Some(a), Some(b)] = ends_s.map(|t_s| path.pose_at(t_s)) else {
            continue;
        };
        let length_s = (ends_s[1] - ends_s[0]).max(1e-9);
        let turn = wrap_angle(b.heading_rad - a.heading_rad);
        let (sine, cosine) = (a.heading_rad + 0.5 * turn).sin_cos();
        let ahead = (b.x_m - a.x_m) * cosine + (b.y_m - a.y_m) * sine;
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{t_s:.9},{},{}", ahead / length_s, turn / length_s);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn poses_are_read_whatever_their_columns_are_called() {
        for (text, unit_s) in [
            ("t_s,x_m,y_m,heading_rad\n1,2,3,0.5\n2,2.5,3,0.5\n", 1.0),
            (
                "Timestamp;X;Y;Yaw_deg\r\n1000;2;3;28.6478897565\r\n2000;2.5;3;28.6478897565\r\n",
                1e-3,
            ),
            (
                "qx,qy,qz,qw,time,x,y\n0,0,0.247403959,0.968912422,1,2,3\n0,0,0.247403959,0.968912422,2,2.5,3\n",
                1.0,
            ),
            // Rows of another sensor, with line breaks in a cell.
            (
                "spectrum,timestamp,topic,x,y,yaw\n,1,pose,2,3,0.5\n\"[1,\n 2]\",1.5,audio,,,\n,2,pose,2.5,3,0.5\n",
                1.0,
            ),
        ] {
            let path = parse(text, "a.csv", unit_s).unwrap().path;
            assert_eq!(path.t_s, [1.0, 2.0], "{text}");
            let [first, second] = path.poses[..] else {
                panic!("{text}");
            };
            assert!((first.x_m, first.y_m, second.x_m) == (2.0, 3.0, 2.5));
            assert!((first.heading_rad - 0.5).abs() < 1e-6, "{text}");
        }
        for (text, word) in [
            ("", "times"),
            ("t,dx,dy,yaw_deg\n1,0,4,-6\n", "column of x"),
            ("t,x,y\n1,2,3\n", "headings"),
            ("t,x,y,yaw\n1,2,3,north\n", "row 2: yaw: `north`"),
            ("t,x,y,yaw\n1,2,3,0\n1,2,3,0\n", "row 3: times"),
            ("t,x,y,yaw\n1,2,3,0\n2,2,-3e7,0\n", "row 3: -3e7 m"),
            ("t,x,y,yaw\n1,2,3,0\n", "1 whole poses"),
            ("t,x,y,yaw\n1e9,2,3,0\n2e9,2,3,0\n", "--time-unit"),
        ] {
            let error = parse(text, "a.csv", 1.0).unwrap_err().to_string();
            assert!(error.contains("a.csv") && error.contains(word), "{error}");
        }
    }

    #[test]
    fn speeds_are_those_of_the_path() {
        // A circle of 1 m at 0.3 m/s, backwards.
        let t_s: Vec<f64> = (0..200).map(|k| 10.0 + 0.02 * f64::from(k)).collect();
        let pose = |t_s: &f64| {
            let angle = -0.3 * (t_s - 10.0);
            Pose {
                x_m: angle.sin(),
                y_m: -angle.cos(),
                heading_rad: wrap_angle(angle),
            }
        };
        let poses = t_s.iter().map(pose).collect();
        let text = odometry(&Trajectory { t_s, poses });
        let rows: Vec<Vec<f64>> = (text.lines().skip(1))
            .map(|line| line.split(',').map(|x| x.parse().unwrap()).collect())
            .collect();
        assert_eq!(rows.len(), 80);
        for row in rows {
            assert!(
                (row[1] + 0.3).abs() < 1e-3 && (row[2] + 0.3).abs() < 1e-3,
                "{row:?}"
            );
        }
    }

    #[test]
    fn a_tables_own_speeds_are_the_wheels() {
        // Columns in the order of audioROS's tables: sorted, with rows of sound between.
        let text = "audio_timestamp,index,timestamp,topic,vx,vy,x,y,yaw_deg,yaw_rate_deg,z\n\
            5,0,10,audio/signals_f,,,,,,,\n\
            ,1,20,geometry/pose_raw,0.2,0,1,2,0,90,0.4\n\
            ,2,120,geometry/pose_raw,0.25,0,1.02,2,9,45,0.4\n";
        let table = parse(text, "a.csv", 1e-3).unwrap();
        let turn = std::f64::consts::FRAC_PI_2;
        assert_eq!(table.speeds, Some(vec![[0.2, turn], [0.25, 0.5 * turn]]));
        assert!(table.warnings().is_empty(), "{:?}", table.warnings());
        let lines: Vec<String> = table.odometry().lines().map(str::to_owned).collect();
        assert_eq!(lines[1], format!("0.020000000,0.2,{turn}"));
        // A row without speeds: none of them.
        let gap = text.replace("0.25,0,1.02", ",,1.02");
        let table = parse(&gap, "a.csv", 1e-3).unwrap();
        assert_eq!(table.speeds, None);
        assert!(table.warnings()[0].contains("made of the poses"));
        let crab = "t,x,y,yaw\n0,0,0,0\n1,0,1,0\n2,0.1,2,0\n";
        let warnings = parse(crab, "a.csv", 1.0).unwrap().warnings();
        assert!(
            warnings.iter().any(|own| own.contains("sideways")),
            "{warnings:?}"
        );
    }
}
