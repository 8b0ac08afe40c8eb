//! Where in a JSON text a parser stopped, as the path of a field.

use crate::error::Error;
use std::path::Path;

/// An object or array around a place in a JSON text.
enum Frame {
    /// In an object, at or after this key (empty before the first).
    Object(String),
    /// In an array, at this element.
    Array(usize),
}

/// The parser's complaint as an [`Error::Invalid`] of one line: file, path of the field, line and column.
pub(super) fn describe(text: &str, error: &serde_json::Error, origin: &Path) -> Error {
    let (line, column) = (error.line(), error.column());
    let message = error.to_string();
    let place = format!(" at line {line} column {column}");
    let problem = single_line(message.strip_suffix(&place).unwrap_or(&message));
    let remedy = if error.is_data() {
        "see docs/reference/scene.md for the fields of a scene"
    } else {
        "write valid JSON"
    };
    let lines_before: usize = text
        .split_inclusive('\n')
        .take(line.saturating_sub(1))
        .map(str::len)
        .sum();
    let frames = frames_at(&text.as_bytes()[..(lines_before + column).min(text.len())]);
    let mut field = single_line(&path(&frames, &problem));
    if field.is_empty() {
        field = "the scene".to_string();
    }
    Error::invalid(
        origin.display(),
        format!("{field} (line {line}, column {column})"),
        problem,
        remedy,
    )
}

/// The stack of objects and arrays that are open at the end of `text`, the beginning of a JSON text.
fn frames_at(text: &[u8]) -> Vec<Frame> {
    let mut frames: Vec<Frame> = Vec::new();
    let mut key_next = false;
    let mut index = 0;
    while index < text.len() {
        match text[index] {
            b'{' => {
                frames.push(Frame::Object(String::new()));
                key_next = true;
            }
            b'[' => {
                frames.push(Frame::Array(0));
                key_next = false;
            }
            b'}' | b']' => {
                frames.pop();
                key_next = false;
            }
            b',' => match frames.last_mut() {
                Some(Frame::Array(element)) => *element += 1,
                Some(Frame::Object(_)) => key_next = true,
                None => {}
            },
            b'"' => {
                let start = index + 1;
                index = start;
                while index < text.len() && text[index] != b'"' {
                    index += 1 + usize::from(text[index] == b'\\');
                }
                if let (true, Some(Frame::Object(key))) = (key_next, frames.last_mut()) {
                    *key =
                        String::from_utf8_lossy(&text[start..index.min(text.len())]).into_owned();
                    key_next = false;
                }
            }
            _ => {}
        }
        index += 1;
    }
    frames
}

/// `paths.mapping.legs[3].v_mps`; of a missing field the path it would have (the parser stops behind its object).
fn path(frames: &[Frame], problem: &str) -> String {
    let missing = problem
        .strip_prefix("missing field `")
        .and_then(|rest| rest.strip_suffix('`'));
    let mut path = String::new();
    let mut join = |key: &str| {
        if !path.is_empty() && !key.is_empty() && !key.starts_with('[') {
            path.push('.');
        }
        path.push_str(key);
    };
    for frame in frames {
        match frame {
            Frame::Object(key) => join(key),
            Frame::Array(element) => join(&format!("[{element}]")),
        }
    }
    join(missing.unwrap_or_default());
    path
}

/// Without line breaks and other control characters, and not longer than an error message should be.
fn single_line(text: &str) -> String {
    let line: String = text
        .chars()
        .map(|letter| if letter.is_control() { ' ' } else { letter })
        .collect();
    match line.char_indices().nth(300) {
        Some((end, _)) => format!("{}...", &line[..end]),
        None => line,
    }
}
