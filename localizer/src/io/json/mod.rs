//! JSON text to structures, with the path of the field where reading stopped.

mod objects;

use serde::de::DeserializeOwned;

use self::objects::Objects;

/// Longest problem that is told, in characters.
const LONGEST: usize = 200;

/// Reads JSON text. A byte order mark before it is skipped; an array is never taken for a structure.
///
/// # Errors
/// The path of the field (`start.x_m`, `the file` for the whole) and the problem with its line and column, each of one
/// line.
pub fn parse<T: DeserializeOwned>(text: &str) -> Result<T, (String, String)> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut reader = serde_json::Deserializer::from_str(text);
    let value = serde_path_to_error::deserialize(Objects(&mut reader)).map_err(|error| {
        let path = error.path().to_string();
        let field = match path.as_str() {
            "." | "?" => "the file".to_string(),
            _ => one_line(&path),
        };
        (field, one_line(&error.into_inner().to_string()))
    })?;
    reader
        .end()
        .map_err(|error| ("the file".to_string(), one_line(&error.to_string())))?;
    Ok(value)
}

/// Without line breaks, and not longer than a message should be.
pub(super) fn one_line(text: &str) -> String {
    let line: String = text
        .chars()
        .map(|letter| if letter.is_control() { ' ' } else { letter })
        .collect();
    match line.char_indices().nth(LONGEST) {
        // The end of a problem says where it is.
        Some((end, _)) => {
            let place = line.rfind(" at line ").filter(|&place| place > end);
            format!(
                "{}...{}",
                &line[..end],
                place.map_or("", |place| &line[place..])
            )
        }
        None => line,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::RecordingMeta;

    #[test]
    fn errors_name_the_field() {
        let whole = |start: &str| {
            format!(
                "{{\"sample_rate_hz\": 4e4, \"code_length\": 1023, \"chip_rate_hz\": 1e4,\n \"carrier_hz\": 1e4, \
                 \"speed_of_sound_mps\": 340, \"start\": {start}}}"
            )
        };
        assert!(parse::<RecordingMeta>(&whole("null")).is_ok());
        for (text, field, word) in [
            (whole("{\"x_m\": \"one\"}"), "start.x_m", "line 2"),
            (whole("{\"x_m\": 1}"), "start", "y_m"),
            (whole("null").replace("1023", "-5"), "code_length", "-5"),
            (
                whole("null").replace("340", "1e999"),
                "speed_of_sound_mps",
                "out of range",
            ),
            (whole("null") + "x", "the file", "trailing"),
            (String::new(), "the file", "EOF"),
            ("[]".into(), "the file", "sequence"),
            ("null".into(), "the file", "null"),
            (whole("[1, 2, 0.3]"), "start", "sequence"),
            ("7".into(), "the file", "line 1"),
        ] {
            let (found, problem) = parse::<RecordingMeta>(&text).unwrap_err();
            assert!(
                found.starts_with(field) && problem.contains(word),
                "{found}: {problem}"
            );
        }
        let text = whole("{\"x_m\": 1, \"y_m\": 2.5, \"heading_rad\": 0}");
        assert_eq!(
            parse::<RecordingMeta>(&text).unwrap().start.unwrap().y_m,
            2.5
        );
        let long = format!("{{\"{}\": 1}}", "x\\n".repeat(5000));
        let (_, problem) = parse::<RecordingMeta>(&long).unwrap_err();
        assert!(problem.len() < 300 && !problem.contains('\n'), "{problem}");
    }
}
