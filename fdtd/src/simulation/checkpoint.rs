//! Checkpoints: the state of a run on disk.
//!
//! A line of text that identifies the run, then the lengths of six arrays as little-endian `u64`, then the arrays as
//! little-endian `f32`: the received signal (after every step, warm-ups included, so that its length determines the
//! segment), pressure, previous pressure, layer memory along x and y, memory of walls that are not rigid; then a digest
//! of lengths and numbers.

use std::hash::Hasher;
use std::io::Write;
use std::path::Path;

use fnv::FnvHasher;

use super::Simulation;
use super::domain::Domain;
use super::segments::Window;
use crate::error::Error;
use crate::field::FieldState;
use crate::walls::CutCell;

const MAGIC: &str = "fdtd checkpoint 7";

/// FNV-1a over the little-endian bytes of whole numbers: enough to distinguish inputs and to detect a damaged file.
fn digest(numbers: impl IntoIterator<Item = u64>) -> u64 {
    let mut hasher = FnvHasher::default();
    for number in numbers {
        hasher.write(&number.to_le_bytes());
    }
    hasher.finish()
}

fn write(
    out: &mut impl Write,
    fingerprint: &str,
    received: &[f32],
    state: &FieldState,
) -> std::io::Result<()> {
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
    out.write_all(&content_digest(&arrays).to_le_bytes())
}

fn content_digest(arrays: &[&[f32]]) -> u64 {
    let lengths = arrays.iter().map(|array| array.len() as u64);
    let numbers = arrays.iter().flat_map(|array| array.iter());
    digest(lengths.chain(numbers.map(|number| u64::from(number.to_bits()))))
}

fn parse(bytes: &[u8], fingerprint: &str, file: &Path) -> Result<(Vec<f32>, FieldState), Error> {
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
    if !rest.is_empty() || content_digest(&arrays.each_ref().map(Vec::as_slice)) != expected {
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

impl Simulation {
    /// Writes a checkpoint (to a temporary name, then renamed).
    ///
    /// # Errors
    /// [`Error::Io`] when it cannot be written.
    pub fn save_checkpoint(&self, file: &Path) -> Result<(), Error> {
        let folder = match file.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder,
            _ => Path::new("."),
        };
        let save = || -> std::io::Result<()> {
            // Removed when it is dropped, so that nothing half-written stays behind.
            let mut temporary = tempfile::NamedTempFile::new_in(folder)?;
            self.write_checkpoint(&mut std::io::BufWriter::new(&mut temporary))?;
            temporary.as_file().sync_all()?;
            temporary.persist(file)?;
            Ok(())
        };
        save().map_err(|source| Error::io(file, source))
    }

    /// Writes the bytes of a checkpoint.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn write_checkpoint(&self, out: &mut impl Write) -> std::io::Result<()> {
        write(
            out,
            &self.fingerprint(),
            &self.received,
            &self.field.state(),
        )?;
        out.flush()
    }

    /// Whether bytes begin as those of a checkpoint, of this version or another.
    pub fn is_checkpoint(bytes: &[u8]) -> bool {
        let words = MAGIC.rsplit_once(' ').map_or(MAGIC, |(words, _)| words);
        bytes.starts_with(words.as_bytes())
    }

    /// Continues from a checkpoint: the run then gives the same bytes as one without an interruption.
    ///
    /// # Errors
    /// [`Error::Io`] when it cannot be read, [`Error::Checkpoint`] when it is damaged or belongs to other inputs.
    pub fn load_checkpoint(&mut self, file: &Path) -> Result<(), Error> {
        let bytes = std::fs::read(file).map_err(|source| Error::io(file, source))?;
        self.read_checkpoint(&bytes, file)
    }

    /// As [`Self::load_checkpoint`], from the bytes of a file; errors name `origin`.
    ///
    /// # Errors
    /// [`Error::Checkpoint`] when they are damaged or belong to other inputs.
    pub fn read_checkpoint(&mut self, bytes: &[u8], origin: &Path) -> Result<(), Error> {
        let (received, state) = parse(bytes, &self.fingerprint(), origin)?;
        let wrong = |problem: &str| Error::Checkpoint {
            path: origin.to_owned(),
            problem: problem.to_owned(),
        };
        self.received = received;
        // The state is that after the last step, not yet the silence before the next segment.
        self.enter(self.plan.index_at(self.step().saturating_sub(1)));
        let lengths = |state: &FieldState| {
            let FieldState {
                pressure,
                previous,
                layer_x,
                layer_y,
                surfaces,
            } = state;
            [pressure, previous, layer_x, layer_y, surfaces].map(Vec::len)
        };
        if lengths(&self.field.state()) != lengths(&state) {
            return Err(wrong("is of another grid"));
        }
        self.field.set_state(&state);
        self.watch.note(self.pair.loudest(self.drive_step()));
        Ok(())
    }

    /// Everything that determines the run, in one line.
    fn fingerprint(&self) -> String {
        let Domain {
            grid,
            medium,
            scheme,
            spread,
            layer_cells,
            walls,
        } = &self.domain;
        let solid = walls
            .solid()
            .cells
            .iter()
            .enumerate()
            .filter(|(_, solid)| **solid)
            .map(|(cell, _)| cell as u64);
        let parts = walls.partial().flat_map(|(cell, cut)| {
            let CutCell { area, west, south } = *cut;
            [cell as u64]
                .into_iter()
                .chain([area, west, south].map(f64::to_bits))
        });
        let surfaces = walls.loads().iter().flat_map(|load| {
            let [ix, iy] = load.cell.map(|at| at as u64);
            let [x, y] = load.normal;
            let numbers = [load.length, x, y, load.distance];
            let numbers = load.impedance.numbers().into_iter().chain(numbers);
            [ix, iy].into_iter().chain(numbers.map(f64::to_bits))
        });
        let walls = digest(solid.chain(parts).chain(surfaces));
        let segments = &self.plan.segments;
        let steps = segments.last().map_or(0, |segment| segment.to);
        let drive = digest((0..=64).flat_map(|k| {
            self.pair
                .sample(k as f64 / 64.0 * steps as f64 * grid.dt_s)
                .map(f64::to_bits)
        }));
        let whole = segments.len() == 1 && segments[0].window == Window::whole(&self.domain);
        let plan = match segments.len() {
            _ if whole => String::new(),
            count => format!(" in {count} segments {:016x}", digest(self.plan.numbers())),
        };
        format!(
            "{grid:?} {medium:?} {scheme} {spread} layer {layer_cells} walls {walls:016x} \
             drive {drive:016x} steps {steps}{plan}"
        )
    }
}
