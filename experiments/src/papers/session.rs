//! The session of a preset: scene, cells and place of the results of the papers' studies.

use std::ops::Deref;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::Result;
use fdtd::scene::Scene;
use localizer::io::temporary;

use super::request::Request;
use crate::recordings::robot::Robot;
use crate::recordings::spec::ODOMETRY_BIAS_RADPS;
use crate::recordings::waveform::parameters_of;
use crate::run::preset::{Plan, Preset};
use crate::run::project;
use crate::session::{Session, Setup, Workspace};

/// A session with the cells of a preset, and a place for its results.
pub struct PaperSession {
    /// The preset.
    pub preset: Preset,
    /// Cells of its studies.
    pub plan: Plan,
    session: Session,
    request: Request,
    results: PathBuf,
}

impl Deref for PaperSession {
    type Target = Session;

    fn deref(&self) -> &Session {
        &self.session
    }
}

impl PaperSession {
    /// Loads the scene of the preset.
    ///
    /// # Errors
    /// When the scene file cannot be used or the parameters are refused.
    pub fn open(request: &Request) -> Result<Self> {
        let results = request.results.join(request.preset.name());
        let workspace = Workspace::new(&request.cache, request.side_by_side);
        Self::with(request, request.preset.plan(), results, &workspace)
    }

    /// The session of the experimental site: another scene and robot, results in the folder `site` of the preset's.
    ///
    /// # Errors
    /// When the scene file or the robot file cannot be used.
    pub fn site(&self) -> Result<Self> {
        Self::with(
            &self.request,
            self.preset.site_plan(),
            self.results.join("site"),
            self.session.workspace(),
        )
    }

    /// Loads the scene of a plan.
    fn with(
        request: &Request,
        plan: Plan,
        results: PathBuf,
        workspace: &Workspace,
    ) -> Result<Self> {
        let scene = Arc::new(Scene::load(&project::file(&plan.scene))?);
        let robot = plan.robot.as_deref().map(project::file);
        let mut parameters = parameters_of(&scene, &request.parameters);
        parameters.measurement.periods = plan.periods;
        parameters.filter.window_half_width_m = plan.half_width_m;
        for folder in [&results, &results.join("data"), &results.join("figures")] {
            temporary::sweep(folder);
        }
        let setup = Setup {
            scene,
            robot: robot.as_deref().map(Robot::read).transpose()?,
            parameters,
            engine: request.engine,
            image_order: request.image_order,
            odometry_bias_radps: ODOMETRY_BIAS_RADPS,
            prefix: plan.prefix.to_string(),
        };
        Ok(Self {
            preset: request.preset,
            session: Session::new(setup, workspace)?,
            plan,
            request: request.clone(),
            results,
        })
    }

    /// Folder of the results of this preset.
    pub fn results(&self) -> &Path {
        &self.results
    }

    /// A data file of this preset.
    pub fn data(&self, name: &str) -> PathBuf {
        self.results.join("data").join(name)
    }
}
