//! The whole method on exact signals of a moving pair among plane walls.

#![expect(clippy::unwrap_used, reason = "a failed test may panic")]

mod drive;
mod moving_echo;
mod signals;
