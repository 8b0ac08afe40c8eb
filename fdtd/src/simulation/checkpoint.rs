//! Checkpoints: the state of a run on disk.
//!
//! A line of text that says what run it is, then the lengths of six arrays as little-endian `u64`, then the arrays as
//! little-endian `f32`: received signal, pressure, previous pressure, layer memory along x and y,
//! velocities into walls that are not rigid; then a digest of all.

use std::io::Write;
use std::path::Path;

use crate::Error;
use crate::field::FieldState;

const MAGIC: &str = "fdtd checkpoint 3";

/// FNV-1a over whole numbers: enough to tell inputs apart and to notice a damaged file.
pub(super) fn digest(numbers: impl IntoIterator<Item = u64>) -> u64 {
    numbers
        .into_iter()
        .flat_map(u64::to_le_bytes)
        .fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
        })
}

pub(super) fn save(
    file: &Path,
    fingerprint: &str,
    received: &[f32],
    state: &FieldState,
) -> Result<(), Error> {
    let temporary = file.with_extension("tmp");
    let write = || -> std::io::Result<()> {
        let mut out = std::io::BufWriter::new(std::fs::File::create(&temporary)?);
        writeln!(out, "{MAGIC} {fingerprint}")?;
        let arrays = [
            received,
            &state.pressure,
            &state.previous,
            &state.layer_x,
            &state.layer_y,
            &state.surfaces,
        ];
        for array in arrays {
            out.write_all(&(array.len() as u64).to_le_bytes())?;
        }
        for array in arrays {
            for number in array {
                out.write_all(&number.to_le_bytes())?;
            }
        }
        out.write_all(&content_digest(&arrays).to_le_bytes())?;
        out.into_inner()?.sync_all()?;
        std::fs::rename(&temporary, file)
    };
    write().map_err(|source| {
        // Nothing half-written stays behind; the first error is the one to report.
        drop(std::fs::remove_file(&temporary));
        Error::io(file, source)
    })
}

fn content_digest(arrays: &[&[f32]]) -> u64 {
    digest(
        arrays
            .iter()
            .flat_map(|array| array.iter())
            .map(|number| u64::from(number.to_bits())),
    )
}

pub(super) fn load(file: &Path, fingerprint: &str) -> Result<(Vec<f32>, FieldState), Error> {
    let bytes = std::fs::read(file).map_err(|source| Error::io(file, source))?;
    let wrong = |problem: &str| Error::Checkpoint {
        path: file.to_owned(),
        problem: problem.to_owned(),
    };
    let end = bytes
        .iter()
        .position(|&byte| byte == b'\n')
        .ok_or_else(|| wrong("is not a checkpoint"))?;
    let line = std::str::from_utf8(&bytes[..end]).map_err(|_| wrong("is not a checkpoint"))?;
    let written = line
        .strip_prefix(MAGIC)
        .ok_or_else(|| wrong("is not a checkpoint"))?;
    if written.trim_start() != fingerprint {
        return Err(wrong("belongs to a run with other inputs"));
    }
    let mut rest = &bytes[end + 1..];
    let word = |from: &mut &[u8]| -> Result<u64, Error> {
        let (head, tail) = from
            .split_first_chunk::<8>()
            .ok_or_else(|| wrong("is cut short"))?;
        *from = tail;
        Ok(u64::from_le_bytes(*head))
    };
    let mut lengths = [0usize; 6];
    for length in &mut lengths {
        *length = word(&mut rest)? as usize;
    }
    let mut arrays: [Vec<f32>; 6] = Default::default();
    for (array, length) in arrays.iter_mut().zip(lengths) {
        let size = length
            .checked_mul(4)
            .filter(|&size| size <= rest.len())
            .ok_or_else(|| wrong("is cut short"))?;
        let (head, tail) = rest.split_at(size);
        *array = head
            .as_chunks()
            .0
            .iter()
            .map(|four| f32::from_le_bytes(*four))
            .collect();
        rest = tail;
    }
    let expected = word(&mut rest)?;
    if content_digest(&arrays.each_ref().map(Vec::as_slice)) != expected {
        return Err(wrong("is damaged"));
    }
    let [received, pressure, previous, layer_x, layer_y, surfaces] = arrays;
    Ok((
        received,
        FieldState {
            pressure,
            previous,
            layer_x,
            layer_y,
            surfaces,
        },
    ))
}
