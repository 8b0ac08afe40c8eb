//! Position from the arrival times of multipath echoes (Tsuchiya et al., 2021): planes as map, image sources as
//! prediction, an extended Kalman filter as estimator.
//!
//! | process of Fig. 1 | equations | module |
//! |---|---|---|
//! | map | (2) | [`planes`] |
//! | predicted arrival times | (3) | [`prediction`] |
//! | impulse response and its peaks | process (iii) | [`arrivals`], [`peaks`] |
//! | association | (4), (5) | [`association`] |
//! | motion and correction | (1), (6) | [`ekf`] |

pub mod arrivals;
pub mod association;
pub mod ekf;
pub mod peaks;
pub mod planes;
pub mod prediction;
