//! Ranges from 40 kHz pulses between an omnidirectional transmitter and a receiver (Hsu et al., Sens. Mater. 2021,
//! section 4).
//!
//! Direct wave and floor echo by image sources in three dimensions, not a field: an empty site leaves nothing else to
//! compute; a 2-D field would need 1 mm cells (8.5 mm wavelength, 16 million cells) and would add the wake of a line
//! source, which point sources do not have. The robot stands at each test point while it polls the receivers, so
//! nothing moves between polls; each poll is a pulse of its own with its own noise. The paper does not give burst,
//! band, noise, threshold and timer; they are the assumptions below.

use std::f64::consts::PI;

use localizer::random::{stream, trial_seed};
use rand_distr::{Distribution, StandardNormal};

/// The link from transmitter to receiver.
#[derive(Debug, Clone, PartialEq)]
pub struct Link {
    /// Carrier, hertz (the paper's 40 kHz).
    pub carrier_hz: f64,
    /// Periods in a burst.
    pub periods: f64,
    /// Bandwidth of each transducer, a resonance of second order, hertz.
    pub bandwidth_hz: f64,
    /// Speed of sound, m/s (the paper's 340 m/s, in the air and in the ranging).
    pub c_mps: f64,
    /// Height of transmitter and receivers above the floor, metres.
    pub height_m: f64,
    /// Pressure of the floor echo against a direct wave of the same length: the cone radiates into a plane.
    pub floor_gain: f64,
    /// Noise after the receiver's resonance, root mean square; a continuous tone has amplitude 1 at 1 m.
    pub noise: f64,
    /// Level at which the rectified signal stops the timer.
    pub threshold: f64,
    /// Tick of the timer, seconds: 1 cm of one-way travel.
    pub tick_s: f64,
    /// Distance at which the delay of the threshold is calibrated, metres.
    pub reference_m: f64,
}

impl Default for Link {
    fn default() -> Self {
        Self {
            carrier_hz: 40e3,
            periods: 8.0,
            bandwidth_hz: 2e3,
            c_mps: 340.0,
            height_m: 0.3,
            floor_gain: 0.3,
            noise: 0.003,
            threshold: 0.03,
            tick_s: 0.01 / 340.0,
            reference_m: 2.5,
        }
    }
}

/// Sample rate of the simulated signal, hertz: 25 samples per period.
const RATE_HZ: f64 = 1e6;
/// Longest time waited for a pulse, seconds.
const LISTEN_S: f64 = 0.025;

/// A resonance of second order with gain 1 at its centre.
struct Resonance {
    gain: f64,
    back: [f64; 2],
    past: [f64; 2],
}

impl Resonance {
    fn new(link: &Link) -> Self {
        let radius = (-PI * link.bandwidth_hz / RATE_HZ).exp();
        let angle = 2.0 * PI * link.carrier_hz / RATE_HZ;
        let gain =
            (1.0 - radius) * (1.0 - 2.0 * radius * (2.0 * angle).cos() + radius * radius).sqrt();
        Self {
            gain,
            back: [2.0 * radius * angle.cos(), -radius * radius],
            past: [0.0; 2],
        }
    }

    fn next(&mut self, input: f64) -> f64 {
        let output = self.gain * input + self.back[0] * self.past[0] + self.back[1] * self.past[1];
        self.past = [output, self.past[0]];
        output
    }
}

/// Measures ranges over a link.
pub struct Ranging {
    link: Link,
    /// Burst through both transducers.
    pulse: Vec<f64>,
    delay_s: f64,
}

impl Ranging {
    /// Computes the pulse and calibrates the threshold's delay at the reference distance, without noise.
    pub fn new(link: Link) -> Self {
        let (mut transmitter, mut receiver) = (Resonance::new(&link), Resonance::new(&link));
        let burst_s = link.periods / link.carrier_hz;
        let pulse = (0..(2e-3 * RATE_HZ) as usize)
            .map(|n| {
                let t = n as f64 / RATE_HZ;
                let on = if t < burst_s { 1.0 } else { 0.0 };
                receiver.next(transmitter.next(on * (2.0 * PI * link.carrier_hz * t).sin()))
            })
            .collect();
        let mut ranging = Self {
            link,
            pulse,
            delay_s: 0.0,
        };
        let reference_m = ranging.link.reference_m;
        let recorded = ranging.crossing_s(reference_m, || 0.0);
        ranging.delay_s = recorded.unwrap_or(0.0) - reference_m / ranging.link.c_mps;
        ranging
    }

    /// Pressure at the receiver, metres from the transmitter, without noise.
    fn pressure(&self, distance_m: f64, t_s: f64) -> f64 {
        let echo_m = distance_m.hypot(2.0 * self.link.height_m);
        [(distance_m, 1.0), (echo_m, self.link.floor_gain)]
            .iter()
            .map(|(path_m, gain)| {
                let place = (t_s - path_m / self.link.c_mps) * RATE_HZ;
                if place < 0.0 {
                    return 0.0;
                }
                let (index, share) = (place as usize, place.fract());
                let at = |index: usize| self.pulse.get(index).copied().unwrap_or(0.0);
                gain / path_m.max(0.05) * (at(index) * (1.0 - share) + at(index + 1) * share)
            })
            .sum()
    }

    /// Time at which the rectified signal first reaches the threshold.
    fn crossing_s(&self, distance_m: f64, mut noise: impl FnMut() -> f64) -> Option<f64> {
        (0..(LISTEN_S * RATE_HZ) as usize)
            .map(|n| n as f64 / RATE_HZ)
            .find(|t_s| (self.pressure(distance_m, *t_s) + noise()).abs() >= self.link.threshold)
    }

    /// The range that poll `poll` of a trial measures, metres; `None` when no pulse reaches the threshold.
    pub fn range_m(&self, distance_m: f64, cell: &str, trial: u64, poll: usize) -> Option<f64> {
        let seed = trial_seed("dual-circle", cell, trial);
        let mut random = stream(seed, &format!("receiver noise {poll}"));
        let mut resonance = Resonance::new(&self.link);
        // White noise of power 1 leaves the resonance with power (pi/2) B / (f_s/2).
        let level = self.link.noise / (PI * self.link.bandwidth_hz / RATE_HZ).sqrt();
        let recorded = self.crossing_s(distance_m, || {
            let white: f64 = StandardNormal.sample(&mut random);
            resonance.next(level * white)
        })?;
        let ticks = ((recorded - self.delay_s) / self.link.tick_s).round();
        Some((ticks * self.link.tick_s * self.link.c_mps).max(0.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_are_within_the_rise_of_the_pulse_and_repeat() {
        let ranging = Ranging::new(Link::default());
        for distance_m in [1.0, 1.414, 2.5, 3.162, 4.243] {
            let range = ranging.range_m(distance_m, "a", 0, 0).unwrap();
            assert!((range - distance_m).abs() < 0.03, "{distance_m}: {range}");
            assert_eq!(ranging.range_m(distance_m, "a", 0, 0), Some(range));
        }
    }

    #[test]
    fn a_pulse_below_the_threshold_gives_no_range() {
        let link = Link {
            threshold: 10.0,
            ..Link::default()
        };
        assert_eq!(Ranging::new(link).range_m(2.0, "a", 0, 0), None);
    }
}
