//! Sound as it comes, in periods of the code, by the first channel that has it.

use std::collections::VecDeque;

use anyhow::Result;
use localizer::Parameters;
use localizer::align::{SoundAligner, SoundClock, SoundReport};

use super::stream::Stream;
use crate::live::pcm::Layout;

/// Samples of a period and whether the code was heard in it.
pub(super) type Period = (Vec<f32>, bool);

/// Sound as it comes, in periods.
pub(super) struct Sound {
    stream: Stream,
    channels: usize,
    /// The channels that may hold the code, in their order; one from when it is found.
    candidates: Vec<Candidate>,
    samples: Vec<f32>,
    ended: bool,
    gaps: usize,
}

impl Sound {
    /// The sound of a stream in the layout, for periods of the parameters.
    pub(super) fn start(
        stream: Stream,
        layout: Layout,
        parameters: &Parameters,
        clock: SoundClock,
    ) -> Result<Self> {
        let channels = layout
            .channel
            .map_or(1..=layout.channels, |channel| channel..=channel);
        let candidates = channels.map(|channel| {
            Ok(Candidate {
                channel,
                aligner: SoundAligner::new(parameters, layout.rate_hz, clock)?,
                ready: VecDeque::new(),
            })
        });
        Ok(Self {
            candidates: candidates.collect::<Result<_>>()?,
            channels: layout.channels,
            samples: Vec::new(),
            stream,
            ended: false,
            gaps: 0,
        })
    }

    /// The next period and whether the code was heard in it; none at the end.
    pub(super) fn next(&mut self) -> Result<Option<Period>> {
        while self.candidates[0].ready.is_empty() && !self.ended {
            let had = self.candidates[0].aligner.has_code();
            let piece = self.stream.next()?;
            self.ended = piece.is_none();
            let mut trouble = None;
            for candidate in &mut self.candidates {
                self.samples.clear();
                let own = piece.iter().flatten().skip(candidate.channel - 1);
                self.samples.extend(own.step_by(self.channels));
                if let Err(error) = candidate.take(&self.samples, self.ended) {
                    trouble.get_or_insert(error);
                }
            }
            // Another channel counts only while this one has nothing to say.
            if let Some(found) = self
                .candidates
                .iter()
                .position(|own| own.aligner.has_code())
            {
                self.candidates.swap(0, found);
                self.candidates.truncate(1);
            } else if let Some(error) = trouble {
                return Err(error.into());
            }
            let Candidate {
                aligner, channel, ..
            } = &self.candidates[0];
            let report = aligner.report();
            if !had && report.code_db.is_some() {
                eprintln!(
                    "sound: channel {channel}: the first period begins {:.3} ms after the first sample, the \
                     recorder runs {:+.2} ppm",
                    1e3 * report.late_s,
                    report.drift_ppm
                );
            }
            for gap in &report.gaps[self.gaps..] {
                eprintln!(
                    "sound: {:.0} samples are missing at period {}",
                    gap.samples, gap.period
                );
            }
            self.gaps = report.gaps.len();
        }
        Ok(self.candidates[0].ready.pop_front())
    }

    /// What was found so far.
    pub(super) fn report(&self) -> &SoundReport {
        self.candidates[0].aligner.report()
    }
}

/// A channel that may hold the code.
struct Candidate {
    channel: usize,
    aligner: SoundAligner,
    ready: VecDeque<Period>,
}

impl Candidate {
    fn take(&mut self, samples: &[f32], ended: bool) -> Result<(), localizer::Error> {
        let ready = &mut self.ready;
        let mut emit = |period: &[f32], heard: bool| {
            ready.push_back((period.to_vec(), heard));
            Ok(())
        };
        self.aligner.push(samples, &mut emit)?;
        match ended {
            true => self.aligner.finish(&mut emit),
            false => Ok(()),
        }
    }
}
