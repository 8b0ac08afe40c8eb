//! Exact solutions of the wave equation in the plane, in f64 and slow: the references of the field.
//!
//! The velocity potential of a line source of strength q (m^2/s) at `x_s(t)` and the pressure obey
//! ```text
//! (1/c^2) phi_tt - lap phi = q(t) delta(x - x_s(t)),    p = rho phi_t
//! ```
//! A tone `q = Q cos(omega t)` at rest gives `p = (omega rho Q / 4) Re[H0^(2)(omega r / c) e^(i omega t)]` ([`tone`]);
//! any strength on any path is the retarded integral of [`monopole`]. A rigid plane wall is an image source of equal
//! sign. [`time_scale`] has the Doppler factors that images imply; [`half_plane`] has the diffraction at an edge,
//! [`cylinder`] the scattering of a round wall and the modes of a round room.

pub mod burst;
pub mod cylinder;
pub mod half_plane;
pub mod hankel;
pub mod monopole;
pub mod time_scale;
pub mod tone;
