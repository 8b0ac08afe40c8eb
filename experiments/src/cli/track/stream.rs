//! Sound on standard input, read by a thread of its own.

use std::io::{BufReader, Read};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::time::Duration;

use anyhow::{Context, Result};

use crate::live::pcm::Layout;
use crate::run::interrupt;

/// Frames that are read at a time: 10 ms at 48 kHz.
const FRAMES: usize = 480;

/// Pieces that wait; more wait in the pipe.
const WAITING: usize = 64;

/// A stream that a thread reads.
pub(super) struct Stream {
    pieces: Receiver<std::io::Result<Vec<f32>>>,
}

impl Stream {
    /// Starts to read.
    pub(super) fn start(stream: BufReader<impl Read + Send + 'static>, layout: Layout) -> Self {
        let (sender, pieces) = sync_channel(WAITING);
        std::thread::spawn(move || pump(stream, layout, &sender));
        Self { pieces }
    }

    /// The next samples of all channels, frame by frame; none at the end.
    pub(super) fn next(&self) -> Result<Option<Vec<f32>>> {
        loop {
            interrupt::check()?;
            match self.pieces.recv_timeout(Duration::from_millis(100)) {
                Ok(piece) => return piece.map(Some).context("standard input"),
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
