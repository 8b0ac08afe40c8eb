//! Sound that comes: of standard input, read by a thread of its own, or of a sound device.

use std::io::{BufReader, Read};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::time::Duration;

use anyhow::{Context, Result};

use crate::live::pcm::Layout;
use crate::run::interrupt;

/// Frames that are read at a time: 10 ms at 48 kHz.
const FRAMES: usize = 480;

/// Pieces that wait; more wait in the pipe.
const WAITING: usize = 64;

/// Sound that comes in pieces.
pub(super) struct Stream {
    pieces: Receiver<std::io::Result<Vec<f32>>>,
    /// Where it comes from, in errors.
    origin: &'static str,
    /// Samples that wait, where the sender counts them.
    waiting: Option<Arc<AtomicU64>>,
}

impl Stream {
    /// Starts to read.
    pub(super) fn start(stream: BufReader<impl Read + Send + 'static>, layout: Layout) -> Self {
        let (sender, pieces) = sync_channel(WAITING);
        std::thread::spawn(move || pump(stream, layout, &sender));
        Self {
            pieces,
            origin: "standard input",
            waiting: None,
        }
    }

    /// What a sound device records.
    #[cfg(feature = "audio")]
    pub(super) fn of_device(pieces: crate::live::audio::Pieces) -> Self {
        Self {
            pieces: pieces.receiver,
            origin: "--audio",
            waiting: Some(pieces.waiting),
        }
    }

    /// The next samples of all channels, frame by frame; none at the end.
    pub(super) fn next(&self) -> Result<Option<Vec<f32>>> {
        loop {
            interrupt::check()?;
            match self.pieces.recv_timeout(Duration::from_millis(100)) {
                Ok(piece) => {
                    if let (Some(waiting), Ok(piece)) = (&self.waiting, &piece) {
                        waiting.fetch_sub(piece.len() as u64, Ordering::Relaxed);
                    }
                    return piece.map(Some).context(self.origin);
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return Ok(None),
            }
        }
    }
}

/// Reads until the end, or until nobody listens.
fn pump(
    mut stream: BufReader<impl Read>,
    layout: Layout,
    sender: &SyncSender<std::io::Result<Vec<f32>>>,
) {
    let frame = layout.format.bytes() * layout.channels;
    let mut bytes = vec![0; FRAMES * frame];
    let mut held = 0;
    loop {
        match stream.read(&mut bytes[held..]) {
            Ok(0) => return,
            Ok(count) => held += count,
            Err(error) if error.kind() == std::io::ErrorKind::Interrupted => continue,
            Err(error) => {
                // Nobody listens any more, or hears of it.
                let _ = sender.send(Err(error));
                return;
            }
        }
        let whole = held - held % frame;
        let samples = layout.samples(&bytes[..whole]);
        bytes.copy_within(whole..held, 0);
        held -= whole;
        if !samples.is_empty() && sender.send(Ok(samples)).is_err() {
            return;
        }
    }
}
