//! Study files that commands are given, by themselves or as folders.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};

use crate::papers::Papers;
use crate::study::{Study, is_of_papers};

/// What a study file holds.
pub(super) enum Loaded {
    /// Cells, methods and draws.
    Study(Study),
    /// The papers' studies.
    Papers(Papers),
}

impl Loaded {
    /// Reads a study file.
    pub(super) fn read(path: &Path) -> Result<Self> {
        let text = std::fs::read_to_string(path).with_context(|| path.display().to_string())?;
        match is_of_papers(&text) {
            true => Papers::parse(&text, path).map(Self::Papers),
            false => Study::parse(&text, path).map(Self::Study),
        }
    }

    /// Its name.
    pub(super) fn name(&self) -> &str {
        match self {
            Self::Study(study) => &study.file.name,
            Self::Papers(papers) => &papers.file.name,
        }
    }

    /// What it asks.
    pub(super) fn about(&self) -> &str {
        match self {
            Self::Study(study) => &study.file.about,
            Self::Papers(papers) => &papers.file.about,
        }
    }
}

/// The study files that are named, those of folders in the order of their names.
pub(super) fn files(paths: &[PathBuf]) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for path in paths {
        if !path.is_dir() {
            files.push(path.clone());
            continue;
        }
        let name = path.display().to_string();
        let mut found = Vec::new();
        for entry in std::fs::read_dir(path).with_context(|| name.clone())? {
            let file = entry.with_context(|| name.clone())?.path();
            if file.extension().is_some_and(|ending| ending == "json")
                && !file.to_string_lossy().ends_with(".schema.json")
            {
                found.push(file);
            }
        }
        if found.is_empty() {
            bail!("{name}: holds no study file; name a folder with .json files");
        }
        found.sort();
        files.extend(found);
    }
    Ok(files)
}
