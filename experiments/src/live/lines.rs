//! Wheel odometry in lines `t_s,v_mps,omega_radps`.

use localizer::odometry::OdometrySample;

/// Longest part of a line that is told, in characters.
const LONGEST: usize = 60;

/// What a line says.
#[derive(Debug, Clone, PartialEq)]
pub enum Line {
    /// Speeds at a time.
    Sample(OdometrySample),
    /// Nothing that can be used; why.
    Bad(String),
}

/// Reads a line; none for an empty one, the header, and what begins with `#`.
pub fn parse(line: &str) -> Option<Line> {
    let line = line.trim().trim_start_matches('\u{feff}');
    if line.is_empty() || line.starts_with("t_s") || line.starts_with('#') {
        return None;
    }
    let numbers: Option<Vec<f64>> = line
        .split(',')
        .map(|part| {
            part.trim()
                .parse()
                .ok()
                .filter(|number: &f64| number.is_finite())
        })
        .collect();
    match numbers.as_deref() {
        Some(&[t_s, v_mps, omega_radps]) => Some(Line::Sample(OdometrySample {
            t_s,
            v_mps,
            omega_radps,
        })),
        _ => {
            let letters = line.chars().filter(|letter| !letter.is_control());
            let short: String = letters.take(LONGEST).collect();
            Some(Line::Bad(format!("`{short}` is not three finite numbers")))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_three_numbers() {
        let sample = Line::Sample(OdometrySample {
            t_s: 1.5,
            v_mps: -0.25,
            omega_radps: 3e-2,
        });
        assert_eq!(parse("\u{feff}1.5, -0.25,3e-2\r\n"), Some(sample));
        for line in ["", "  \n", "t_s,v_mps,omega_radps", "# wheels"] {
            assert_eq!(parse(line), None);
        }
        for line in [
            "1,2",
            "1,2,3,4",
            "1,2,nan",
            "1,2,1e999",
            "x",
            &"9,".repeat(500),
        ] {
            match parse(line) {
                Some(Line::Bad(problem)) => assert!(problem.len() < 100, "{problem}"),
                other => panic!("{line}: {other:?}"),
            }
        }
    }
}
