//! A session: scene, parameters, recordings and measurements that the studies of one run share.

mod measurements;
mod recordings;
mod request;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::Result;
use fdtd::scene::Scene;
use localizer::Parameters;
use localizer::io::temporary;

use crate::data::cache::Cache;
use crate::recordings::robot::Robot;
use crate::recordings::waveform::parameters_of;
use crate::run::preset::{Plan, Preset};
use crate::run::progress::Board;
use crate::schedule::{self, Job};

pub use self::measurements::{Measurements, map_of, measurement_of};
pub use self::recordings::{ANECHOIC, Recordings};
pub use self::request::Request;

/// All that the studies of one run share.
pub struct Session {
    /// The preset.
    pub preset: Preset,
    /// Cells of its studies.
    pub plan: Plan,
    /// The scene.
    pub scene: Arc<Scene>,
    /// Parameters of the localizer at the preset's default window and periods.
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
    request: Request,
    results: PathBuf,
}

impl Session {
    /// Loads the scene of the preset.
    ///
    /// # Errors
    /// When the scene file cannot be used or the parameters are refused.
    pub fn open(request: &Request) -> Result<Self> {
        let results = request.results.join(request.preset.name());
        Self::with(request, request.preset.plan(), results)
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
        )
    }

    /// Loads the scene of a plan.
    fn with(request: &Request, plan: Plan, results: PathBuf) -> Result<Self> {
        let scene = Arc::new(Scene::load(&of_project(&plan.scene))?);
        let robot = plan.robot.as_deref().map(of_project);
        let robot = robot.as_deref().map(Robot::read).transpose()?;
        let mut parameters = parameters_of(&scene, &request.parameters);
        parameters.measurement.periods = plan.periods;
        parameters.filter.window_half_width_m = plan.half_width_m;
        parameters.check()?;
        let cache = Cache::new(&request.cache);
        for folder in [&results, &results.join("data"), &results.join("figures")] {
            temporary::sweep(folder);
        }
        let recordings = Arc::new(Recordings::new(
            Arc::clone(&scene),
            robot,
            &parameters,
            request,
            &plan,
        ));
        Ok(Self {
            preset: request.preset,
            plan,
            scene,
            measurements: Measurements::new(Arc::clone(&recordings), &parameters),
            parameters,
            recordings,
            board: Board::new(),
            cache,
            threads: rayon::current_num_threads(),
            results,
            request: request.clone(),
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

    /// Simulates into the cache, also jobs of other sessions with the same cache.
    ///
    /// # Errors
    /// When a simulation fails or is interrupted.
    pub fn simulate(&self, jobs: &[Job]) -> Result<()> {
        schedule::run(
            jobs,
            &self.cache,
            self.threads,
            self.request.side_by_side,
            &self.board,
        )
    }
}

/// A file of the project: in the folder in which the program runs, else in the project's own, wherever that is.
fn of_project(path: &Path) -> PathBuf {
    let program = std::env::current_exe().unwrap_or_default();
    let built = Path::new(env!("CARGO_MANIFEST_DIR")).parent();
    let folders = program.ancestors().skip(1).chain(built);
    let elsewhere = folders
        .map(|folder| folder.join(path))
        .find(|found| found.exists());
    match path.exists() {
        true => path.to_owned(),
        false => elsewhere.unwrap_or_else(|| path.to_owned()),
    }
}
