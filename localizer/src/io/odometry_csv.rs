//! Odometry files: `odometry.csv` with the header `t_s,v_mps,omega_radps`.

use std::fmt::Write as _;
use std::path::Path;

use super::files;
use super::files::shorten;
use crate::error::Error;
use crate::odometry::OdometrySample;

/// The first line of the file.
const HEADER: &str = "t_s,v_mps,omega_radps";

/// Reads `odometry.csv`.
///
/// # Errors
/// [`Error::Io`] when it cannot be read, otherwise those of [`parse`].
pub fn read(path: &Path) -> Result<Vec<OdometrySample>, Error> {
    parse(&files::read_text(path)?, &path.display().to_string())
}

/// Reads the text of an odometry file; `origin` names it in errors.
///
/// # Errors
/// [`Error::Invalid`] with the line that is not three finite numbers or the header that is missing.
pub fn parse(text: &str, origin: &str) -> Result<Vec<OdometrySample>, Error> {
    let mut lines = text.lines().enumerate();
    let remedy = format!("start with the line `{HEADER}`, then three numbers a line");
    let header = lines
        .next()
        .map_or("", |(_, line)| line.trim().trim_start_matches('\u{feff}'));
    if header.split(',').map(str::trim).ne(HEADER.split(',')) {
        return Err(Error::invalid(
            origin,
            "line 1",
            format!("`{}` is not the header", shorten(header)),
            remedy,
        ));
    }
    lines
        .filter(|(_, line)| !line.trim().is_empty())
        .map(|(index, line)| {
            let numbers: Vec<f64> = line
                .split(',')
                .map(|part| {
                    part.trim()
                        .parse()
                        .ok()
                        .filter(|number: &f64| number.is_finite())
                })
                .collect::<Option<_>>()
                .unwrap_or_default();
            match *numbers.as_slice() {
                [t_s, v_mps, omega_radps] => Ok(OdometrySample {
                    t_s,
                    v_mps,
                    omega_radps,
                }),
                _ => {
                    let problem = format!("`{}` is not three finite numbers", shorten(line));
                    Err(Error::invalid(
                        origin,
                        format!("line {}", index + 1),
                        problem,
                        &remedy,
                    ))
                }
            }
        })
        .collect()
}

/// Writes `odometry.csv` under a temporary name and renames it.
///
/// # Errors
/// [`Error::Io`] when that fails.
pub fn write(path: &Path, samples: &[OdometrySample]) -> Result<(), Error> {
    let mut text = format!("{HEADER}\n");
    for sample in samples {
        // Writing to a string cannot fail. Display prints the shortest text that reads back to the same number.
        let _ = writeln!(
            text,
            "{},{},{}",
            sample.t_s, sample.v_mps, sample.omega_radps
        );
    }
    files::write_bytes(path, text.as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::odometry::tests::sample;
    use proptest::prelude::*;

    #[test]
    fn parse_errors_name_the_line() {
        let message = |text: &str| parse(text, "odometry.csv").unwrap_err().to_string();
        assert!(message("").contains("line 1"));
        assert!(message("t,v,w\n").contains("header"));
        assert!(message("t_s,v_mps,omega_radps\n0,1\n").contains("line 2"));
        assert!(message("t_s,v_mps,omega_radps\n0,1,2\n0,inf,2\n").contains("line 3"));
        assert_eq!(
            parse("t_s, v_mps, omega_radps\r\n0, 1, 2\r\n\r\n", "x").unwrap(),
            [sample(0.0, 1.0)]
        );
    }

    proptest! {
        #[test]
        fn text_is_read_back(values in prop::collection::vec((-10.0..10.0, -5.0..5.0, -5.0..5.0), 0..30)) {
            let written: Vec<_> = values
                .iter()
                .map(|&(t_s, v_mps, omega_radps)| OdometrySample { t_s, v_mps, omega_radps })
                .collect();
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("odometry.csv");
            write(&path, &written).unwrap();
            prop_assert_eq!(read(&path).unwrap(), written);
        }

        #[test]
        fn no_text_panics(text in "[0-9,.eE+\\-\n ]{0,200}") {
            let _ = parse(&format!("{HEADER}\n{text}"), "text");
            let _ = parse(&text, "text");
        }

    }
}
