//! A file of the papers' studies, in `studies/papers` and `studies/quick`: scene, robot, seeds, and the studies with
//! the values that they try.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::limits::check;
use super::study::PaperStudy;
use crate::data::json;
use crate::recordings::spec::Engine;
use crate::session::{Setup, Workspace};
use crate::study::cells::find;
use crate::study::file::{MethodName, Settings, StudyFile};
use crate::study::settings::{Resolver, Source};

/// The papers' studies on a scene.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PapersFile {
    /// Place of the schema, for editors.
    #[serde(default, rename = "$schema", skip_serializing_if = "Option::is_none")]
    pub schema: Option<String>,
    /// Name of the studies and of their folder of results: letters, digits, `-` and `_`.
    pub name: String,
    /// What the studies ask, in a sentence.
    pub about: String,
    /// Scene file with the drives `mapping` and `localization` (as seen from this file, the working folder or the
    /// project).
    pub scene: PathBuf,
    /// Robot file; without one wheels and microphone are ideal but for a steady error of the turn rate.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub robot: Option<PathBuf>,
    /// Values other than the defaults: `scene.*`, `robot.*`, `localizer.*`, `field.engine`, `field.image_order`. Those
    /// of localizer and field hold on the site too.
    #[serde(default, skip_serializing_if = "Settings::is_empty")]
    pub set: Settings,
    /// How often filter and noise are drawn.
    #[serde(default)]
    pub seeds: PaperSeeds,
    /// The studies in the order in which they run.
    pub papers: Vec<PaperStudy>,
    /// File of errors that `echolot check` holds the results against.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub baseline: Option<PathBuf>,
    /// File of verdicts on the papers' claims (`experiments/targets.json`): with it the results are compared with the
    /// claims, and `echolot check` tells verdicts that change.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub verdicts: Option<PathBuf>,
}

/// How often filter and noise are drawn in every cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PaperSeeds {
    /// Particle filter.
    pub filter: usize,
    /// Noise, each with a filter of its own.
    pub noise: usize,
}

impl Default for PaperSeeds {
    fn default() -> Self {
        Self {
            filter: 1,
            noise: 1,
        }
    }
}

/// A file that a study is read from.
#[derive(JsonSchema)]
#[serde(untagged)]
#[expect(dead_code, reason = "for its schema")]
enum AnyFile {
    /// Cells, methods and draws.
    Study(StudyFile),
    /// The papers' studies.
    Papers(PapersFile),
}

/// The JSON schema of study files, the papers' among them.
pub fn json_schema() -> serde_json::Value {
    schemars::schema_for!(AnyFile).to_value()
}

/// The papers' studies of a file that has been checked.
#[derive(Debug, Clone)]
pub struct Papers {
    /// What the file holds.
    pub file: PapersFile,
    /// Folder of the file.
    folder: PathBuf,
}

impl Papers {
    /// Reads a file.
    ///
    /// # Errors
    /// One line that names the file, the field and the remedy: unknown fields, studies that are there twice, values
    /// that cannot be used.
    pub fn load(path: &Path) -> Result<Self> {
        let text = std::fs::read_to_string(path).with_context(|| path.display().to_string())?;
        Self::parse(&text, path)
    }

    /// Reads the text of a file; errors name `origin`, in whose folder other files are looked for.
    ///
    /// # Errors
    /// As [`Papers::load`].
    pub fn parse(text: &str, origin: &Path) -> Result<Self> {
        let file: PapersFile = json::parse(text, origin)?;
        check(&file).with_context(|| origin.display().to_string())?;
        let folder = origin.parent().unwrap_or(Path::new("")).to_path_buf();
        Ok(Self { file, folder })
    }

    /// A file that this one names.
    pub fn beside(&self, file: &Path) -> PathBuf {
        find(file, &self.folder)
    }

    /// Takes another engine.
    ///
    /// # Errors
    /// When the engine has no name.
    pub fn set_engine(&mut self, engine: Engine, image_order: u8) -> Result<()> {
        let set = &mut self.file.set;
        set.insert("field.engine".to_string(), serde_json::to_value(engine)?);
        match engine {
            Engine::ImageSource => set.insert("field.image_order".to_string(), image_order.into()),
            Engine::Fdtd => set.remove("field.image_order"),
        };
        Ok(())
    }

    /// The studies with these names, in the file's order; all when there are none.
    ///
    /// # Errors
    /// When the file has no study of a name.
    pub fn chosen(&self, names: &[String]) -> Result<Vec<&PaperStudy>> {
        let studies = &self.file.papers;
        if let Some(name) = (names.iter()).find(|name| studies.iter().all(|s| s.name() != **name)) {
            let known: Vec<&str> = studies.iter().map(PaperStudy::name).collect();
            bail!(
                "--only {name}: is no study of {}; choose from {}",
                self.file.name,
                known.join(", ")
            );
        }
        let is_chosen =
            |study: &&PaperStudy| names.is_empty() || names.iter().any(|n| n == study.name());
        Ok(studies.iter().filter(is_chosen).collect())
    }

    /// A scene and a robot with the values of the file, and those of `set` over them.
    ///
    /// # Errors
    /// When scene or robot cannot be used, or a value is refused.
    pub(super) fn setup(
        &self,
        scene: &Path,
        robot: Option<&Path>,
        set: &Settings,
        workspace: &Workspace,
    ) -> Result<Setup> {
        let robot = robot.map(|file| self.beside(file));
        let source = Source::File(self.beside(scene));
        let resolver = Resolver::new(&workspace.cache);
        let resolved = resolver.resolve(&source, robot.as_deref(), set, MethodName::Doppler, 0)?;
        Ok(resolved.setup)
    }

    /// Whether results of another file belong beside those of this one: all but the choice of studies is equal.
    pub(super) fn agrees_with(&self, other: &PapersFile) -> bool {
        let place = |file: &PapersFile| {
            let (scene, robot) = (file.scene.clone(), file.robot.clone());
            (scene, robot, file.set.clone(), file.seeds)
        };
        place(&self.file) == place(other)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::is_of_papers;

    const FILE: &str = r#"{"name": "mine", "about": "?", "scene": "room.json", "papers": [
        {"study": "layout"}, {"study": "window-size", "half_widths_m": [1, 2.5]}]}"#;

    fn parse(text: &str) -> Result<Papers> {
        Papers::parse(text, Path::new("mine.json"))
    }

    #[test]
    fn wrong_files_are_refused_by_name() {
        parse(FILE).unwrap();
        assert!(is_of_papers(FILE) && !is_of_papers(r#"{"name": "x"}"#) && !is_of_papers("{"));
        let layout = r#"{"study": "layout"}"#;
        for (from, to, word) in [
            ("mine", "a/b", "name"),
            ("[1, 2.5]", "[]", "half_widths_m"),
            ("2.5", "-3", "half_widths_m[1]"),
            ("2.5", "1e300", "half_widths_m[1]"),
            ("window-size", "window-sizes", "window-sizes"),
            ("half_widths_m", "widths", "widths"),
            (
                layout,
                r#"{"study": "periods", "periods": [0]}"#,
                "periods[0]",
            ),
            (layout, r#"{"study": "snr", "snr_db": [1e9]}"#, "snr_db"),
            (layout, r#"{"study": "layout", "x": 1}"#, "x"),
            (
                layout,
                r#"{"study": "window-size", "half_widths_m": [1]}"#,
                "twice",
            ),
            (
                layout,
                r#"{"study": "step-time", "half_widths_m": [1], "blocks": 0}"#,
                "blocks",
            ),
            (
                r#""papers""#,
                r#""set": {"noise.snr_db": 3}, "papers""#,
                "noise.snr_db",
            ),
            (
                r#""papers""#,
                r#""set": {"robot.seed": 3}, "papers""#,
                "robot.seed",
            ),
            (
                r#""papers""#,
                r#""seeds": {"filter": 0, "noise": 1}, "papers""#,
                "seeds.filter",
            ),
        ] {
            let refused = format!("{:#}", parse(&FILE.replacen(from, to, 1)).unwrap_err());
            assert!(
                refused.starts_with("mine.json: ") && refused.contains(word),
                "{from} -> {to}: {refused}"
            );
        }
    }

    #[test]
    fn studies_are_chosen_by_name() {
        let papers = parse(FILE).unwrap();
        assert_eq!(papers.chosen(&[]).unwrap().len(), 2);
        let one = papers.chosen(&["window-size".to_string()]).unwrap();
        assert_eq!(
            one.iter().map(|s| s.name()).collect::<Vec<_>>(),
            ["window-size"]
        );
        let refused = papers.chosen(&["snr".to_string()]).unwrap_err().to_string();
        assert!(
            refused.contains("snr") && refused.contains("window-size"),
            "{refused}"
        );
    }

    #[test]
    fn the_projects_files_can_be_read() {
        for file in [
            "../studies/papers/paper.json",
            "../studies/quick/quick.json",
        ] {
            let papers = Papers::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join(file)).unwrap();
            assert!(papers.beside(&papers.file.scene).exists(), "{file}");
        }
    }
}
