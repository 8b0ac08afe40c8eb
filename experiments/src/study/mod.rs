//! Studies as files: what is simulated, what varies, by which methods, and what is claimed of it.
//!
//! A study file ([`file`]) becomes [`cells`], each with every method and everything that is drawn: the [`plan`].
//! [`run`](run()) simulates what is missing, runs the trials and writes the results, which [`compare`] sets beside
//! others.

pub mod cells;
pub mod claims;
pub mod compare;
pub mod file;
mod forecast;
pub mod interval;
mod maps;
mod plan;
mod run;
pub mod scores;
pub(crate) mod settings;
pub mod slurm;
mod summary;
pub mod tasks;

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};

use self::cells::Cell;
use self::file::{FigureChoice, MethodName, Settings, StudyFile};
use crate::data::json;
use crate::recordings::spec::Engine;

pub use self::plan::{Plan, time_of};
pub use self::run::{gather, run};
pub use self::summary::{CellScores, StudySummary, table};

/// A study that has been checked.
#[derive(Debug, Clone)]
pub struct Study {
    /// What its file holds.
    pub file: StudyFile,
    /// Its cells.
    pub cells: Vec<Cell>,
    /// Folder of the file.
    folder: PathBuf,
}

impl Study {
    /// Reads a study file.
    ///
    /// # Errors
    /// One line that names the file, the field and the remedy: unknown or contradictory fields, names that do not
    /// exist, values that cannot be used, tests that could not be carried out.
    pub fn load(path: &Path) -> Result<Self> {
        let text = std::fs::read_to_string(path).with_context(|| path.display().to_string())?;
        Self::parse(&text, path)
    }

    /// Reads the text of a study file; errors name `origin`, in whose folder its scenes are looked for.
    ///
    /// # Errors
    /// As [`Study::load`].
    pub fn parse(text: &str, origin: &Path) -> Result<Self> {
        if is_of_papers(text) {
            bail!(
                "{}: papers: these studies have no cells and run in one piece; use echolot run",
                origin.display()
            );
        }
        let file: StudyFile = json::parse(text, origin)?;
        let folder = origin.parent().unwrap_or(Path::new("")).to_path_buf();
        Self::checked(file, folder).with_context(|| origin.display().to_string())
    }

    /// The study that a summary holds; its scenes need not be there any more.
    ///
    /// # Errors
    /// As [`Study::load`].
    pub fn of_results(file: &StudyFile) -> Result<Self> {
        Self::checked(file.clone(), PathBuf::new())
    }

    /// Numbers of the cells that figures show, by what they name of a figure.
    fn cells_of(&self, named: fn(&FigureChoice) -> Option<&Settings>) -> Vec<usize> {
        let figures = self.figures();
        let cells = figures.iter().filter_map(named);
        cells
            .filter_map(|cell| self.cells.iter().position(|known| known.has(cell)))
            .collect()
    }

    /// Numbers of the cells whose paths are drawn.
    fn drawn_cells(&self) -> Vec<usize> {
        self.cells_of(|figure| match figure {
            FigureChoice::Paths { cell } => Some(cell),
            _ => None,
        })
    }

    /// Numbers of the cells whose maps are drawn.
    fn mapped_cells(&self) -> Vec<usize> {
        self.cells_of(|figure| match figure {
            FigureChoice::Map { cell } => Some(cell),
            _ => None,
        })
    }

    /// The cell of whose recordings a report shows what was heard.
    fn shown_cell(&self) -> Option<usize> {
        self.drawn_cells().first().copied()
    }

    fn checked(file: StudyFile, folder: PathBuf) -> Result<Self> {
        check_names(&file)?;
        check_folder_name(&file.name)?;
        let methods = methods_of(&file);
        if methods.is_empty() {
            bail!("methods: there are none; name at least one");
        }
        if let Some(double) = (1..methods.len()).find(|&k| methods[..k].contains(&methods[k])) {
            bail!(
                "methods[{double}]: {} is there twice; leave one out",
                methods[double].name()
            );
        }
        let cells = cells::cells(&file, &folder)?;
        check_seeds(&file, &cells)?;
        for (number, figure) in file.figures.iter().enumerate() {
            check_figure(figure, &cells, &methods).with_context(|| format!("figures[{number}]"))?;
        }
        for (number, claim) in file.claims.iter().enumerate() {
            if file.claims[..number]
                .iter()
                .any(|known| known.id == claim.id)
            {
                bail!(
                    "claims[{number}].id: {} is there twice; rename one",
                    claim.id
                );
            }
            claim
                .check(&cells, &methods)
                .with_context(|| format!("claims[{number}]"))?;
        }
        Ok(Self {
            file,
            cells,
            folder,
        })
    }

    /// A file that this one names.
    pub fn beside(&self, file: &Path) -> PathBuf {
        cells::find(file, &self.folder)
    }

    /// Takes another engine for all cells.
    ///
    /// # Errors
    /// When the engine varies in the study.
    pub fn set_engine(&mut self, engine: Engine, image_order: u8) -> Result<()> {
        let names = ["field.engine", "field.image_order"];
        let varied = self.file.vary.iter().flat_map(|entry| entry.keys());
        let chosen = self
            .file
            .alternatives
            .iter()
            .flat_map(|entry| entry.set.keys());
        if let Some(name) = varied
            .chain(chosen)
            .find(|name| names.contains(&name.as_str()))
        {
            bail!(
                "--engine: {name} varies in study {}; leave the option out",
                self.file.name
            );
        }
        let mut file = self.file.clone();
        file.set.retain(|name, _| !names.contains(&name.as_str()));
        file.set
            .insert(names[0].to_string(), serde_json::to_value(engine)?);
        if engine == Engine::ImageSource {
            file.set.insert(names[1].to_string(), image_order.into());
        }
        *self = Self::checked(file, self.folder.clone())?;
        Ok(())
    }

    /// Its methods.
    pub fn methods(&self) -> Vec<MethodName> {
        methods_of(&self.file)
    }

    /// The figures it asks for, or those that its cells suggest.
    pub(crate) fn figures(&self) -> Vec<FigureChoice> {
        if !self.file.figures.is_empty() {
            return self.file.figures.clone();
        }
        let is_number = |name: &str| {
            self.cells.iter().all(|cell| {
                let value = cell.labels.iter().find(|(known, _)| known == name);
                value.is_some_and(|(_, value)| value.parse::<f64>().is_ok())
            })
        };
        let names = self
            .file
            .vary
            .iter()
            .filter_map(|entry| entry.keys().next());
        let curves = names
            .filter(|name| is_number(name))
            .map(|name| FigureChoice::Curve {
                over: name.clone(),
                measure: scores::Measure::default(),
            });
        let bars = FigureChoice::Bars {
            measure: scores::Measure::default(),
        };
        curves.chain([bars, FigureChoice::Cdf {}]).collect()
    }
}

/// Whether the text of a study file is of the papers' studies, which [`crate::papers`] reads.
pub fn is_of_papers(text: &str) -> bool {
    serde_json::from_str::<serde_json::Value>(text).is_ok_and(|file| file.get("papers").is_some())
}

/// Refuses a name that cannot be that of a folder.
pub(crate) fn check_folder_name(name: &str) -> Result<()> {
    check_line("name", name)?;
    let is_usual = |c: char| c.is_ascii_alphanumeric() || "-_".contains(c);
    match (1..=80).contains(&name.len()) && name.chars().all(is_usual) {
        true => Ok(()),
        false => bail!("name: '{name}' cannot be a folder; use letters, digits, - and _"),
    }
}

/// Refuses a name that no line could tell: with control characters, or longer than a line.
pub(crate) fn check_line(what: &str, text: &str) -> Result<()> {
    const LONGEST: usize = 120;
    if text.len() <= LONGEST && !text.chars().any(char::is_control) {
        return Ok(());
    }
    let begin: String = text.escape_debug().take(40).collect();
    bail!("{what}: '{begin}...' cannot be a name; use up to {LONGEST} letters in one line")
}

/// Refuses names that no line could tell.
fn check_names(file: &StudyFile) -> Result<()> {
    let named = check_line;
    named("name", &file.name)?;
    for choice in &file.scenes {
        if let file::SceneChoice::File(path) = choice {
            named("scenes", &path.to_string_lossy())?;
        }
    }
    for alternative in &file.alternatives {
        named("alternatives", &alternative.name)?;
    }
    let claims = file.claims.iter();
    claims
        .clone()
        .try_for_each(|claim| named("claims", &claim.id))?;
    let selected = claims.filter_map(|claim| claim.test.as_ref());
    let selected = selected
        .flat_map(|test| test.selections())
        .map(|of| &of.cell);
    let own = file.methods.iter().filter_map(|choice| choice.settings());
    let chosen = file.alternatives.iter().map(|alternative| &alternative.set);
    let drawn = file.figures.iter().filter_map(|figure| match figure {
        FigureChoice::Paths { cell } | FigureChoice::Map { cell } => Some(cell),
        _ => None,
    });
    let sets = [&file.set].into_iter().chain(own).chain(chosen);
    for (name, value) in sets.chain(drawn).chain(selected).flatten() {
        named("names of values", name)?;
        named("values", value.as_str().unwrap_or_default())?;
    }
    for entry in &file.vary {
        entry.keys().try_for_each(|name| named("vary", name))?;
        for value in entry.values() {
            if let file::Values::List(list) = value {
                let mut texts = list.iter().filter_map(serde_json::Value::as_str);
                texts.try_for_each(|text| named("vary", text))?;
            }
        }
    }
    for figure in &file.figures {
        if let FigureChoice::Curve { over, .. } = figure {
            named("figures", over)?;
        }
    }
    Ok(())
}

/// The methods of a file.
fn methods_of(file: &StudyFile) -> Vec<MethodName> {
    file.methods.iter().map(|choice| choice.method()).collect()
}

/// Refuses seeds of what nothing draws.
fn check_seeds(file: &StudyFile, cells: &[Cell]) -> Result<()> {
    let seeds = file.seeds;
    for (name, count) in [
        ("slip", seeds.slip),
        ("noise", seeds.noise),
        ("filter", seeds.filter),
    ] {
        if !(1..=cells::MOST_SEEDS).contains(&count) {
            bail!(
                "seeds.{name}: {count} is out of range; give 1 to {}",
                cells::MOST_SEEDS
            );
        }
    }
    if file.seeds.slip > 1 && file.robot.is_none() {
        bail!("seeds.slip: there is no robot whose wheels slip; name a robot file or leave it out");
    }
    let noisy = |settings: &Settings| {
        settings
            .get("noise.snr_db")
            .is_some_and(|value| !value.is_null())
    };
    let any = cells.iter().any(|cell| noisy(&cell.settings))
        || file
            .methods
            .iter()
            .any(|choice| choice.settings().is_some_and(noisy));
    if file.seeds.noise > 1 && !any {
        bail!("seeds.noise: no cell has noise; set or vary noise.snr_db or leave it out");
    }
    Ok(())
}

/// Refuses a figure of what is not in the study.
fn check_figure(figure: &FigureChoice, cells: &[Cell], methods: &[MethodName]) -> Result<()> {
    match figure {
        FigureChoice::Curve { over, .. } => {
            for cell in cells {
                let value = cell.labels.iter().find(|(name, _)| name == over);
                let Some((_, value)) = value else {
                    bail!("over: {over} does not vary; name what does");
                };
                if value.parse::<f64>().is_err() {
                    bail!(
                        "over: {over} has the value {value}, which is no number; draw bars instead"
                    );
                }
            }
        }
        FigureChoice::Paths { cell } | FigureChoice::Map { cell }
            if !cells.iter().any(|known| known.has(cell)) =>
        {
            bail!("where: no cell of the study has these values; name values that vary")
        }
        FigureChoice::Map { .. } if !methods.iter().any(|method| method.has_map()) => {
            bail!("map: no method of the study has a map; leave the figure out")
        }
        FigureChoice::Table { measures } if measures.is_empty() => {
            bail!("measures: there are none; name at least one")
        }
        _ => {}
    }
    Ok(())
}

#[cfg(test)]
mod tests;
