//! WAV files: 32 and 64-bit float, or integers of 8 to 32 bits scaled to full scale 1, as recorders write them.
//! Integers of fewer valid bits than they take in the file are at its upper end, as WAVE_FORMAT_EXTENSIBLE says.

mod read;
#[cfg(test)]
mod tests;
mod write;

use std::path::Path;

pub(crate) use read::check_rate;
pub use read::{WavStream, parse, read};
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
