//! Signals: transmitted waveform, time scaling, matched filter, direct wave (section II-A, eqs. (1) and (2)).

pub mod direct_wave;
pub(crate) mod matched_filter;
mod spectrum;
pub mod time_scale;
pub mod waveform;
