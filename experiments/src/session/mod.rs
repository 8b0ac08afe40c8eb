//! A session: scene, parameters, recordings and measurements that trials on one scene share. Sessions of one run share
//! a workspace.

mod measurements;
mod recordings;
mod workspace;

use std::sync::Arc;

use anyhow::Result;
use fdtd::scene::Scene;
use localizer::Parameters;

use crate::data::cache::Cache;
use crate::recordings::robot::Robot;
use crate::recordings::spec::Engine;
use crate::run::progress::Board;
use crate::schedule::Job;

pub use self::measurements::{Measurements, map_of, measurement_of};
pub use self::recordings::{ANECHOIC, Recordings};
pub use self::workspace::Workspace;

/// What a session is opened with: a scene and how its sound is made and recorded.
#[derive(Debug, Clone)]
pub struct Setup {
    /// The scene.
    pub scene: Arc<Scene>,
    /// The robot whose instruments the recordings get; ideal but for a steady error of the turn rate when `None`.
    pub robot: Option<Robot>,
    /// Parameters of the localizer, those of the scene's signal among them.
    pub parameters: Parameters,
    /// Engine that computes the sound.
    pub engine: Engine,
    /// Most reflections of an image source's echo.
    pub image_order: usize,
    /// Steady error of the ideal robot's turn rate, rad/s.
    pub odometry_bias_radps: f64,
    /// Prefix of the names of its simulations.
    pub prefix: String,
}

/// Scene, parameters, recordings and measurements that trials share.
pub struct Session {
    /// The scene.
    pub scene: Arc<Scene>,
    /// Parameters of the localizer where trials do not change them.
    pub parameters: Parameters,
    /// Recordings of the scene.
    pub recordings: Arc<Recordings>,
    /// Echoes and maps of the recordings.
    pub measurements: Measurements,
    /// Progress.
    pub board: Board,
    /// The cache.
    pub cache: Cache,
    /// Threads to use.
    pub threads: usize,
    workspace: Workspace,
}

impl Session {
    /// A session in a workspace.
    ///
    /// # Errors
    /// When the parameters are refused.
    pub fn new(setup: Setup, workspace: &Workspace) -> Result<Self> {
        setup.parameters.check()?;
        let (scene, parameters) = (Arc::clone(&setup.scene), setup.parameters.clone());
        let recordings = Arc::new(Recordings::new(setup, workspace));
        Ok(Self {
            scene,
            measurements: Measurements::new(Arc::clone(&recordings), &parameters),
            parameters,
            recordings,
            board: workspace.board.clone(),
            cache: workspace.cache.clone(),
            threads: workspace.threads,
            workspace: workspace.clone(),
        })
    }

    /// Simulates into the cache, also jobs of other sessions of the same workspace.
    ///
    /// # Errors
    /// When a simulation fails or is interrupted.
    pub fn simulate(&self, jobs: &[Job]) -> Result<()> {
        self.workspace.simulate(jobs)
    }

    /// The workspace.
    pub fn workspace(&self) -> &Workspace {
        &self.workspace
    }
}
