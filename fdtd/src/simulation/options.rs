//! Choices of a run that are not the scene's.

use crate::scheme::Scheme;
use crate::spread::Spread;
use crate::walls::WallModel;

/// Choices of a run that are not the scene's.
#[derive(Debug, Clone, Default)]
pub struct SimulationOptions {
    /// Scheme instead of the scene's.
    pub scheme: Option<Scheme>,
    /// Spreading kernel instead of the scene's.
    pub spread: Option<Spread>,
    /// How walls become cells, instead of the scene's way.
    pub wall_model: Option<WallModel>,
    /// Threads; 0 for all cores.
    pub threads: usize,
    /// Without walls, in segments of time whose domains are cropped to where the drive is then.
    pub free_field: bool,
    /// All of the scene's domain, air beyond the walls and the drive too; for a free field, one segment around the
    /// whole drive. The reference of cropped domains and segments.
    pub whole_domain: bool,
    /// Source strength times the time since the middle of the drive, which gives travel times
    /// ([`crate::medium::absorbed`]).
    pub stamped: bool,
    /// Use the plain engine, the oracle of the fast one.
    pub reference_engine: bool,
}
