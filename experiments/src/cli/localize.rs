//! `echolot localize`.

use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use clap::ValueEnum;
use localizer::echo::EchoBlock;
use localizer::io::recording_source::RecordingSource;
use localizer::landmarks::LandmarkMap;
use localizer::{MapImage, Method, Parameters, Pose, offline};

use super::alignment::AlignmentArguments;
use super::arguments::{ForceArgument, ParameterArguments, files_of_map, files_of_recording};
use super::estimates::{self, Clock, Scored};
use super::landmarks;
use super::output::{print, print_json};
use super::shown::{self, ShownArguments};
use super::start::{self, StartArgument, start, start_sigma};
use crate::data::atomic;
use crate::data::estimate;
use crate::data::place::Place;
use crate::drive::Drive;
use crate::figures::localization::{Background, Localization};
use crate::localization::{self, ByImages};
use crate::metrics::{quantile, rounded};
use crate::run::progress::Board;
use crate::scores::Scores;
use crate::trust::{self, Warnings};

/// Method of localization.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum MethodArgument {
    /// Echoes in range and bearing.
    Doppler,
    /// Echoes in range only.
    ToaOnly,
    /// Wheel odometry alone.
    Odometry,
    /// Peaks of the echoes among the landmarks of `map --method landmarks`.
    Landmarks,
}

impl MethodArgument {
    /// The method among echo images; none for landmarks.
    pub(super) fn of_images(self) -> Option<Method> {
        match self {
            Self::Doppler => Some(Method::Doppler),
            Self::ToaOnly => Some(Method::ToaOnly),
            Self::Odometry => Some(Method::Odometry),
            Self::Landmarks => None,
        }
    }
}

/// Arguments of `localize`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example:\n  echolot localize recordings/drive --map maps/room -o drive.tum --seed 1\n  \
    echolot localize recordings/drive --map maps/room -o drive.tum --method landmarks --start unknown\n\n\
    With truth.tum in the recording the mean absolute error is printed. Unless given, the start is the truth at time \
    0, the start of recording.json, or the origin. A table with covariance, fit and status is written beside EST.tum. \
    The last line says whether the code was found, how well the echoes fit the map, and for how much of the drive the \
    pose is sure; a signal without the code is refused."
)]
pub(crate) struct Arguments {
    /// Recording folder.
    recording: PathBuf,
    /// Map folder.
    #[arg(long)]
    map: PathBuf,
    /// Estimated trajectory (TUM).
    #[arg(short, long, value_name = "EST.tum")]
    output: PathBuf,
    /// Method.
    #[arg(long, value_enum, default_value_t = MethodArgument::Doppler)]
    method: MethodArgument,
    /// Periods M in a block; the map's unless given.
    #[arg(long, value_name = "M")]
    periods: Option<usize>,
    /// Half-width of the matched window, metres.
    #[arg(long, value_name = "METRES")]
    window: Option<f64>,
    /// Number of particles.
    #[arg(long, value_name = "N")]
    particles: Option<usize>,
    /// Seed of the filter's random numbers.
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Start of the drive: x and y in metres and the heading in degrees, or unknown (landmarks only).
    #[arg(long, value_name = "X,Y,DEG|unknown", allow_hyphen_values = true, value_parser = start)]
    start: Option<StartArgument>,
    /// Standard deviations of the start in metres and degrees; a known start unless given.
    #[arg(long, value_name = "M,DEG", value_parser = start_sigma)]
    start_sigma: Option<[f64; 2]>,
    /// Clock of the estimates' times; the truth's where there is one, else the wheels'.
    #[arg(long, value_enum)]
    clock: Option<Clock>,
    #[command(flatten)]
    shown: ShownArguments,
    #[command(flatten)]
    parameters: ParameterArguments,
    #[command(flatten)]
    alignment: AlignmentArguments,
    #[command(flatten)]
    force: ForceArgument,
}

/// Share of sure estimates below which a run is told to be doubtful.
const SURE_ENOUGH: f64 = 0.8;

impl Arguments {
    /// Localizes among landmarks.
    fn among_landmarks(&self, source: RecordingSource, json: bool) -> Result<()> {
        let clock = self.clock.unwrap_or_else(|| Clock::usual(&source));
        let reading_s = clock.reading_s(&source);
        for (option, given) in [
            ("--window", self.window.is_some()),
            ("--particles", self.particles.is_some()),
        ] {
            if given {
                bail!("{option}: is for echo images; leave it out with --method landmarks");
            }
        }
        let map = LandmarkMap::read(&self.map)?;
        let mut parameters = match self.parameters.parameters {
            Some(_) => self.parameters.read()?,
            None => map.parameters.clone(),
        }
        .for_recording(&source.meta);
        parameters.measurement.periods = self.periods.unwrap_or(parameters.measurement.periods);
        parameters.check()?;
        let start = start::among_landmarks(self.start, self.start_sigma, source.start_pose());
        landmarks::localize(
            &self.recording,
            &source,
            &map,
            &parameters,
            &start,
            &landmarks::Wanted {
                output: &self.output,
                shown: &self.shown,
                reading_s,
                json,
            },
        )
    }

    /// Checks the places of the trajectory, of the table beside it, and of the picture.
    fn check_output(&self) -> Result<()> {
        let mut inputs = files_of_recording(&self.recording);
        inputs.extend(files_of_map(&self.map));
        inputs.extend(self.parameters.parameters.clone());
        inputs.extend(self.alignment.files());
        let table = self.output.with_extension("csv");
        let place = |path: &Path| Place {
            inputs: inputs.clone(),
            ..Place::of(path, self.force.force)
        };
        place(&self.output).file(estimate::is_ours)?;
        if table == self.output {
            bail!(
                "{}: is the name of the table beside the trajectory; give one that ends in .tum",
                table.display()
            );
        }
        place(&table).file(estimates::is_table)?;
        let others = [self.output.clone(), table];
        self.shown.check(&|path| Place {
            inputs: [inputs.as_slice(), &others].concat(),
            ..Place::of(path, self.force.force)
        })
    }

    /// Warnings on what the recording and the parameters say.
    fn words(&self, source: &RecordingSource, map: &MapImage, parameters: &Parameters) -> Warnings {
        let mut warnings = Warnings::default();
        warnings.extend(trust::changed(&self.recording));
        warnings.extend(trust::changed(&self.map));
        warnings.extend(trust::ignored(
            self.parameters.parameters.as_deref(),
            parameters,
        ));
        warnings.extend(trust::contradictions(&map.parameters, parameters));
        if self.start.is_none() && source.known_start().is_none() {
            warnings.add(
                "no start is known, the origin is taken; give --start, or start in recording.json",
            );
        }
        warnings
    }

    /// Runs the command.
    pub(crate) fn run(self, json: bool) -> Result<()> {
        self.check_output()?;
        let source = self.alignment.open(&self.recording)?;
        let Some(method) = self.method.of_images() else {
            return self.among_landmarks(source, json);
        };
        let start = match self.start {
            Some(StartArgument::Unknown) => {
                bail!("--start unknown: needs --method landmarks; give X,Y,DEG")
            }
            Some(StartArgument::Pose(pose)) => pose,
            None => source.start_pose(),
        };
        let map = MapImage::read(&self.map)?;
        let drive = Drive::of_folder(&source, &self.recording);
        let parameters = self.of_images(&map, &drive, method)?;
        let mut warnings = self.words(&source, &map, &parameters);
        let task = Board::new().task("localize", 1);
        let mut frames = self.shown.frames(&parameters, source.duration_s());
        let mut look_on = |block: &EchoBlock, poses: &[Pose]| {
            if let Some(frames) = &mut frames {
                frames.add(block, poses);
            }
        };
        let begin = (start, self.seed);
        let ByImages {
            estimates,
            fits,
            code,
        } = localization::by_images(
            &drive,
            &map,
            &parameters,
            begin,
            &mut warnings,
            &mut look_on,
        )?;
        task.finish();
        let table = self.output.with_extension("csv");
        let clock = self.clock.unwrap_or_else(|| Clock::usual(&source));
        let reading_s = clock.reading_s(&source);
        estimate::write(&self.output, &estimates::trajectory(&estimates, reading_s))?;
        let text = estimates::table(&estimates, &fits, &parameters, reading_s);
        atomic::write(&table, text.as_bytes())?;
        let sure = fits.iter().filter(|fit| fit.sure).count() as f64 / fits.len().max(1) as f64;
        let fit = quantile(&fits.iter().map(|fit| fit.fit).collect::<Vec<_>>(), 0.5);
        if sure < SURE_ENOUGH {
            warnings.add(format!(
                "the echoes fit the map for {:.0} % of the drive only; check start, map, speed of sound and odometry",
                100.0 * sure
            ));
        }
        let poses: Vec<(f64, Pose)> = estimates
            .iter()
            .map(|estimate| (estimate.t_s, estimate.pose))
            .collect();
        let found = source.truth.as_ref().map(|truth| Scores::of(&poses, truth));
        let (scores, coverage) = found.unwrap_or_default();
        let scored = Scored {
            scores,
            coverage,
            has_truth: source.truth.is_some(),
        };
        scored.warn(&mut warnings);
        let code_told = code.map_or("no code looked for".to_string(), |share| {
            format!("code found in {:.0} % of the blocks", 100.0 * share)
        });
        let told = format!(
            "{code_told}; fit {fit:.1} sigma; sure {:.0} % of the time\n",
            100.0 * sure
        );
        let fit_of_each: Vec<f64> = fits.iter().map(|fit| fit.fit).collect();
        let shown = Localization {
            map: Background::Image(&map),
            path: &offline::trajectory(&estimates),
            truth: source.truth.as_ref(),
            wheels: &shown::wheels(&source, &parameters, start),
            fit: &fit_of_each,
            fit_label: ["sigma", "(c) fit of the echoes"],
        };
        let name = self.recording.display().to_string();
        let method = self.method.to_possible_value();
        let method = method.as_ref().map_or("", |value| value.get_name());
        let status = fits.iter().map(estimates::trust).collect();
        let words = shown::words([&name, method], &scored, &told, &warnings, status);
        self.shown.show(&shown, frames, words)?;
        if json {
            let report = serde_json::json!({
                "estimate": self.output,
                "table": table,
                "poses": estimates.len(),
                "status": {"sure": rounded(sure), "doubtful": rounded(1.0 - sure)},
                "fit": rounded(fit),
                "code_found": code.map(rounded),
                "warnings": warnings.tell(),
            });
            return print_json(&scored.put_into(report));
        }
        eprintln!(
            "wrote {} and {} ({} poses)",
            self.output.display(),
            table.display(),
            estimates.len()
        );
        print(&told)?;
        scored.tell()?;
        warnings.tell();
        Ok(())
    }

    /// Parameters of a localization by echo images.
    fn of_images(&self, map: &MapImage, drive: &Drive<'_>, method: Method) -> Result<Parameters> {
        let base = match self.parameters.parameters {
            Some(_) => Some(self.parameters.read()?),
            None => None,
        };
        let mut parameters = localization::image_parameters(base.as_ref(), map, drive, method);
        parameters.measurement.periods = self.periods.unwrap_or(parameters.measurement.periods);
        parameters.filter.window_half_width_m =
            self.window.unwrap_or(parameters.filter.window_half_width_m);
        parameters.filter.particles = self.particles.unwrap_or(parameters.filter.particles);
        if let Some([sigma_m, sigma_rad]) = self.start_sigma {
            parameters.filter.start_sigma_m = sigma_m;
            parameters.filter.start_sigma_rad = sigma_rad;
        }
        parameters.check()?;
        Ok(parameters)
    }
}
