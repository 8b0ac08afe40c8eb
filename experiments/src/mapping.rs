//! Maps of drives whose poses are known: echo images added up, or landmarks.

use std::path::Path;

use anyhow::{Result, bail};
use localizer::image::map_builder::MapBuilder;
use localizer::landmarks::{LandmarkMap, Learner};
use localizer::parameters::SignalParameters;
use localizer::quality::CodeMeter;
use localizer::{MapImage, Parameters};

use crate::drive::Drive;
use crate::trust::{self, Cover, Warnings};

/// Kind of map.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MapKind {
    /// Echo images added up on a grid, eq. (7).
    Images,
    /// Walls and corners learnt from the peaks of the echoes.
    Landmarks,
}

impl MapKind {
    /// Names of the files of such a map.
    pub fn files(self) -> &'static [&'static str] {
        match self {
            Self::Images => &["map.json", "map.npy", "map_toa.npy", "map.pgm", "map.yaml"],
            Self::Landmarks => &[
                "landmarks.json",
                "landmarks.geojson",
                "landmarks.pgm",
                "landmarks.yaml",
            ],
        }
    }
}

/// A map of either kind.
#[derive(Debug, Clone)]
pub enum Map {
    /// Echo images on a grid.
    Images(MapImage),
    /// Walls and corners.
    Landmarks(LandmarkMap),
}

/// What a map was made of.
#[derive(Debug, Default)]
pub struct MappingReport {
    /// Share of the blocks of each drive in which its code is; none of a robot that rests.
    pub codes: Vec<Option<f64>>,
    /// Blocks of each drive that the truth covers.
    pub blocks: Vec<usize>,
}

/// A map in the making, drive by drive.
pub struct Mapping {
    kind: MapKind,
    parameters: Parameters,
    images: Option<(MapBuilder, SignalParameters)>,
    landmarks: Learner,
    report: MappingReport,
}

impl Mapping {
    /// A map of nothing. What `parameters` say of the signal is taken from the drives.
    pub fn new(kind: MapKind, parameters: Parameters) -> Self {
        Self {
            kind,
            parameters,
            images: None,
            landmarks: Learner::default(),
            report: MappingReport::default(),
        }
    }

    /// Its parameters.
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// Adds a drive: its blocks where the truth covers them.
    ///
    /// # Errors
    /// When there is no truth, or next to none of it; when the sound holds no echoes; when the drive has another code,
    /// rate or sensor than the first one in a map of images; and as [`echo::measure`].
    pub fn add(&mut self, drive: &Drive<'_>, warnings: &mut Warnings) -> Result<()> {
        let name = &drive.name;
        let Some(truth) = drive.truth() else {
            bail!(
                "{}: truth.tum: is missing; a map needs the true poses of its drive",
                name.display()
            );
        };
        drive.check_signal()?;
        let own = self.parameters.for_recording(drive.meta());
        match self.kind {
            MapKind::Images => self.begin_images(&own, name)?,
            MapKind::Landmarks => self.landmarks.begin(&own)?,
        }
        let mut code = CodeMeter::new(&own);
        let speeds = drive.odometry().iter().map(|sample| sample.v_mps);
        let mut cover = Cover::new(truth, speeds, name, warnings)?;
        drive.measure_each(&own, &mut |block, _| {
            code.add(block);
            let Some(pose) = cover.pose_at(block.t_s) else {
                return Ok(true);
            };
            match &mut self.images {
                Some((map, _)) => map.add(block, &pose)?,
                None => self.landmarks.add(block, &pose),
            }
            Ok(true)
        })?;
        let code = trust::check_echoes(drive.meta(), &code, name, warnings)?;
        self.report.codes.push(code);
        self.report.blocks.push(cover.finish(name, warnings)?);
        Ok(())
    }

    /// A map of images of nothing with the first drive; those after it have to be of its kind.
    fn begin_images(&mut self, own: &Parameters, name: &Path) -> Result<()> {
        match &self.images {
            None => self.images = Some((MapBuilder::new(own)?, own.signal)),
            Some((_, first)) if *first != own.signal => bail!(
                "{}: was recorded with another code, speed of sound, rate or sensor than the first recording; make a \
                 map of recordings of one kind",
                name.display()
            ),
            Some(_) => {}
        }
        Ok(())
    }

    /// The map.
    ///
    /// # Errors
    /// Without a drive, or when no landmark was found.
    pub fn finish(self) -> Result<(Map, MappingReport)> {
        let map = match (self.kind, self.images) {
            (MapKind::Images, Some((map, _))) => Map::Images(map.finish()?),
            (MapKind::Images, None) => bail!("map: there is no drive; give at least one"),
            (MapKind::Landmarks, _) => Map::Landmarks(self.landmarks.finish()?),
        };
        Ok((map, self.report))
    }
}
