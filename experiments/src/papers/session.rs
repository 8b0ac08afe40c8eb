//! The session of the papers' studies: scene, seeds and place of the results.

use std::ops::Deref;
use std::path::{Path, PathBuf};

use anyhow::Result;
use localizer::io::temporary;

use super::file::{PaperSeeds, Papers};
use super::study::SiteStudy;
use crate::session::{Session, Setup, Workspace};

/// Prefix of the names of the site's simulations.
pub(super) const SITE: &str = "site ";

/// A session with the studies of a file, and a place for their results.
pub struct PaperSession {
    /// The file.
    pub papers: Papers,
    session: Session,
    results: PathBuf,
}

impl Deref for PaperSession {
    type Target = Session;

    fn deref(&self) -> &Session {
        &self.session
    }
}

impl PaperSession {
    /// Loads the scene of a file; results go into a folder of its name in `results`.
    ///
    /// # Errors
    /// When scene or robot cannot be used or a value is refused.
    pub fn open(papers: Papers, results: &Path, workspace: &Workspace) -> Result<Self> {
        let file = &papers.file;
        let setup = papers.setup(&file.scene, file.robot.as_deref(), &file.set, workspace)?;
        let results = results.join(&file.name);
        Self::with(papers, String::new(), setup, results, workspace)
    }

    /// The session of the experimental site: another scene and robot, results in the folder `site` of the file's.
    ///
    /// # Errors
    /// As [`PaperSession::open`].
    pub(super) fn site(&self, site: &SiteStudy) -> Result<Self> {
        let workspace = self.session.workspace();
        let of_all = |name: &&String| name.starts_with("localizer.") || name.starts_with("field.");
        let all = self.papers.file.set.iter();
        let mut set: crate::study::file::Settings = all
            .filter(|(name, _)| of_all(name))
            .map(|(name, value)| (name.clone(), value.clone()))
            .collect();
        set.extend(site.set.clone());
        let setup = (self.papers).setup(&site.scene, Some(&site.robot), &set, workspace)?;
        let results = self.results.join("site");
        Self::with(
            self.papers.clone(),
            SITE.to_string(),
            setup,
            results,
            workspace,
        )
    }

    fn with(
        papers: Papers,
        prefix: String,
        setup: Setup,
        results: PathBuf,
        workspace: &Workspace,
    ) -> Result<Self> {
        for folder in [&results, &results.join("data"), &results.join("figures")] {
            temporary::sweep(folder);
        }
        Ok(Self {
            papers,
            session: Session::new(Setup { prefix, ..setup }, workspace)?,
            results,
        })
    }

    /// How often filter and noise are drawn.
    pub fn seeds(&self) -> PaperSeeds {
        self.papers.file.seeds
    }

    /// Folder of the results.
    pub fn results(&self) -> &Path {
        &self.results
    }

    /// A data file of the results.
    pub fn data(&self, name: &str) -> PathBuf {
        self.results.join("data").join(name)
    }
}
