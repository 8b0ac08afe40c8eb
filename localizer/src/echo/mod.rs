//! Echoes: from samples to the intensity H of every direction and delay (eqs. (1)-(3)).

pub mod block_buffer;
pub mod block_stream;
pub mod doppler_bank;
pub mod echo_blocks;
pub mod noise_sweep;
pub(crate) mod recording_blocks;

pub use doppler_bank::DopplerBank;
pub use echo_blocks::{EchoBlock, EchoSequence, measure};
