//! WAV files: 32-bit float, or 16, 24 and 32-bit integers scaled to full scale 1.

mod read;
#[cfg(test)]
mod tests;
mod write;

use std::path::Path;

pub(crate) use read::check_rate;
pub use read::{WavStream, read};
pub use write::{write, write_integers, write_pcm16, write_scaled};

use crate::error::Error;

/// Most channels of a file.
const MOST_CHANNELS: u16 = 64;

fn of_hound(path: &Path, error: hound::Error) -> Error {
    match error {
        hound::Error::IoError(source) => Error::io(path, source),
        other => Error::invalid(
            path.display(),
            "WAV format",
            other,
            "write mono 32-bit float or 16-bit PCM",
        ),
    }
}
