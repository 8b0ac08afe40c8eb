//! Wheel odometry as it comes: lines `t_s,v_mps,omega_radps` of a file, a pipe, a descriptor or a local UDP port.

use std::fs::File;
use std::io::{BufRead, BufReader};
use std::net::UdpSocket;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::time::{Duration, Instant};

use anyhow::{Context, Result};
use localizer::Odometry;
use localizer::odometry::{OdometrySample, mean_over_time};

use crate::live::lines::{Line, parse};
use crate::run::interrupt;

/// Lines that wait.
const WAITING: usize = 1024;

/// Time that is kept before the present, in seconds.
const KEPT_S: f64 = 5.0;

/// Longest line, in bytes.
const LONGEST_LINE: usize = 4096;

/// Wheels.
pub(super) struct Wheels {
    lines: Receiver<Line>,
    samples: Vec<OdometrySample>,
    /// What the wheels' clock shows at time 0.
    reading_s: f64,
    ended: bool,
    patience: Duration,
    fastest_mps: f64,
    /// Whether lines are late at present.
    late: bool,
    bad: usize,
}

impl Wheels {
    /// Starts to read `source`: a path, `fd:N`, or `udp:PORT`.
    pub(super) fn start(source: &str, patience: Duration, fastest_mps: f64) -> Result<Self> {
        let (sender, lines) = sync_channel(WAITING);
        if let Some(port) = source.strip_prefix("udp:") {
            let port: u16 = port
                .parse()
                .ok()
                .filter(|port| *port > 0)
                .with_context(|| {
                    format!("--odometry: {source}: has no port; give udp:PORT with 1 to 65535")
                })?;
            let socket = UdpSocket::bind(("127.0.0.1", port))
                .with_context(|| format!("--odometry: {source}"))?;
            std::thread::spawn(move || receive(&socket, &sender));
        } else {
            let path = match source.strip_prefix("fd:") {
                Some(number) => {
                    let number: u32 = number.parse().with_context(|| {
                        format!("--odometry: {source}: has no number; give fd:N")
                    })?;
                    format!("/dev/fd/{number}")
                }
                None => source.to_owned(),
            };
            std::fs::metadata(&path).with_context(|| format!("--odometry: {path}"))?;
            std::thread::spawn(move || read(&path, &sender));
        }
        Ok(Self {
            lines,
            samples: Vec::new(),
            reading_s: 0.0,
            ended: false,
            patience,
            fastest_mps,
            late: false,
            bad: 0,
        })
    }

    /// The log so far.
    pub(super) fn samples(&self) -> &[OdometrySample] {
        &self.samples
    }

    /// Waits for lines up to a time after the first one's, in seconds. Ends early when none come.
    pub(super) fn wait_since_first(&mut self, seconds: f64) -> Result<()> {
        let enough = |wheels: &Self| match (wheels.samples.first(), wheels.samples.last()) {
            (Some(first), Some(last)) => last.t_s - first.t_s >= seconds,
            _ => false,
        };
        self.wait(&enough)
    }

    /// Puts the log on the sound's clock.
    pub(super) fn set_clock(&mut self, reading_s: f64) {
        for sample in &mut self.samples {
            sample.t_s -= reading_s;
        }
        self.reading_s = reading_s;
    }

    /// The mean of an interval, and whether the lines for it have come. Times before it are forgotten.
    pub(super) fn mean(&mut self, start_s: f64, end_s: f64) -> Result<(Odometry, bool)> {
        let has = |wheels: &Self| wheels.samples.last().is_some_and(|last| last.t_s >= end_s);
        self.wait(&has)?;
        let came = has(self);
        if came == self.late {
            self.late = !came;
            let since = self.samples.last().map_or(0.0, |last| last.t_s);
            match (came, self.ended) {
                (true, _) => eprintln!("odometry: is there again at {end_s:.2} s"),
                (false, true) => {
                    eprintln!("odometry: has ended at {since:.2} s; its last speed goes on")
                }
                (false, false) => {
                    eprintln!("odometry: is late since {since:.2} s; its last speed goes on")
                }
            }
        }
        let mean = mean_over_time(&self.samples, start_s, end_s);
        let old = self
            .samples
            .partition_point(|sample| sample.t_s < start_s - KEPT_S);
        // Seldom, and in large pieces.
        if old > 1000 {
            self.samples.drain(..old);
        }
        Ok((mean, came))
    }

    /// Takes lines until `enough`, the end, or until the patience is at an end.
    fn wait(&mut self, enough: &dyn Fn(&Self) -> bool) -> Result<()> {
        // Late lines are not waited for again and again.
        let patience = if self.late {
            Duration::ZERO
        } else {
            self.patience
        };
        let mut began = Instant::now();
        while !enough(self) && !self.ended {
            interrupt::check()?;
            let left = patience.saturating_sub(began.elapsed());
            match self.lines.recv_timeout(left.min(Duration::from_millis(50))) {
                Ok(said) => {
                    self.take(said);
                    began = Instant::now();
                }
                Err(RecvTimeoutError::Timeout) if left.is_zero() => return Ok(()),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => self.ended = true,
            }
        }
        Ok(())
    }

    fn take(&mut self, said: Line) {
        let problem = match said {
            Line::Bad(problem) => problem,
            Line::Sample(sample) => {
                let sample = OdometrySample {
                    t_s: sample.t_s - self.reading_s,
                    ..sample
                };
                let before_s = self
                    .samples
                    .last()
                    .map_or(f64::NEG_INFINITY, |last| last.t_s);
                if sample.t_s > before_s && sample.v_mps.abs() <= self.fastest_mps {
                    self.samples.push(sample);
                    return;
                }
                format!(
                    "{} s, {} m/s does not fit what came before",
                    sample.t_s, sample.v_mps
                )
            }
        };
        self.bad += 1;
        if self.bad <= 10 {
            eprintln!("odometry: a line is left out: {problem}");
        }
    }
}

/// Reads lines of a file or pipe until its end, or until nobody listens.
fn read(path: &str, sender: &SyncSender<Line>) {
    let file = match File::open(path) {
        Ok(file) => file,
        Err(error) => {
            // Nobody listens any more, or hears of it.
            let _ = sender.send(Line::Bad(format!("{path}: {error}")));
            return;
        }
    };
    let mut reader = BufReader::new(file);
    let mut line = Vec::new();
    loop {
        line.clear();
        let mut limited = std::io::Read::take(&mut reader, LONGEST_LINE as u64);
        match limited.read_until(b'\n', &mut line) {
            Ok(0) => return,
            Ok(_) => {
                if let Some(said) = parse(&String::from_utf8_lossy(&line))
                    && sender.send(said).is_err()
                {
                    return;
                }
            }
            Err(error) => {
                let _ = sender.send(Line::Bad(format!("{path}: {error}")));
                return;
            }
        }
    }
}

/// Receives datagrams of lines for ever, or until nobody listens.
fn receive(socket: &UdpSocket, sender: &SyncSender<Line>) {
    let mut bytes = [0; 65_536];
    loop {
        let Ok(count) = socket.recv(&mut bytes) else {
            return;
        };
        for line in String::from_utf8_lossy(&bytes[..count]).lines() {
            if let Some(said) = parse(line)
                && sender.send(said).is_err()
            {
                return;
            }
        }
    }
}
