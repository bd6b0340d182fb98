//! Options for recordings and the format of their files.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::{Args, ValueEnum};

use crate::error::Error;
use crate::{output, parameters::setting};
use host_sim::scenario::Setting;
use identification::{
    Experiment, Hold, IdentifyError, Model,
    data::{ColumnSelection, Columns, Delimiter, Import, Note, joints_of},
    models,
    request::{check_files, known_constants, may_lack_command},
};

#[derive(Debug, Args)]
pub struct DataOptions {
    /// Recordings to fit: files, folders of LeRobot data sets, or - for standard input
    #[arg(required = true, value_name = "DATA")]
    pub data: Vec<PathBuf>,
    /// Recordings for validation: predicted by the fitted models, but not fitted
    #[arg(long, value_name = "FILE", num_args = 1..)]
    pub validate: Vec<PathBuf>,
    /// Assigns a column to a quantity, as angle=pos:rad or time=1; the quantities are time,
    /// command, angle, rate, duty, current and supply; a unit may be a factor; repeatable
    #[arg(long = "column", value_name = "WHAT=COLUMN[:UNIT]")]
    columns: Vec<ColumnSelection>,
    /// Joint of a robot whose columns have its name [default for a data set: each of its joints]
    #[arg(long, value_name = "NAME")]
    pub joint: Option<String>,
    /// Rate of samples at equal intervals, Hz, for files without a time or with a wrong one
    #[arg(long = "rate", value_name = "HZ", value_parser = rate)]
    rate_hz: Option<f64>,
    /// Delimiter between two fields [default: detected]
    #[arg(long)]
    delimiter: Option<DelimiterName>,
    /// First and last time of the files that are used, s; with FILE@ of this file; repeatable
    #[arg(long, value_name = "[FILE@]FROM:TO", value_parser = of_file(window))]
    window: Vec<OfFile<(f64, f64)>>,
    /// Also compares samples at which the angle is saturated
    #[arg(long)]
    keep_clipped: bool,
    /// Also compares samples that look like faults of the sensor or the link: isolated readings,
    /// frozen readings, and the response to a change of the command within a gap
    #[arg(long)]
    keep_bad: bool,
    /// Course of the command between samples [default: detected]
    #[arg(long)]
    hold: Option<HoldName>,
    /// Known constant of the runs by the name of a parameter, as pendulum_mass_kg=0.5; with FILE@
    /// of the run in this file, as heavy.csv@load_torque_nm=0.2; repeatable
    #[arg(long, value_name = "[FILE@]NAME=VALUE", value_parser = of_file(setting))]
    known: Vec<OfFile<Setting>>,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum DelimiterName {
    Comma,
    Semicolon,
    Tab,
    Blanks,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum HoldName {
    /// Constant until the next sample
    Zero,
    /// Smooth from sample to sample
    Smooth,
}

/// The value of an option for one file, or for all.
#[derive(Debug, Clone)]
struct OfFile<T> {
    /// `None` for all files.
    file: Option<PathBuf>,
    value: T,
}

/// Parses a value with the name of its file before it, if there is one.
fn of_file<T>(
    value: fn(&str) -> Result<T, String>,
) -> impl Fn(&str) -> Result<OfFile<T>, String> + Clone {
    move |text| {
        let (file, text) = match text.rsplit_once('@') {
            Some((file, text)) => (Some(file.into()), text),
            None => (None, text),
        };
        let value = value(text)?;
        Ok(OfFile { file, value })
    }
}

fn rate(text: &str) -> Result<f64, String> {
    let rate = text.trim().parse().ok();
    let rate = rate.filter(|rate: &f64| rate.is_finite() && *rate > 0.0);
    rate.ok_or_else(|| format!("`{text}` is not a rate, expected a positive number of Hz"))
}

fn window(text: &str) -> Result<(f64, f64), String> {
    let ends = text.split_once(':').ok_or("expected FROM:TO")?;
    let number = |text: &str| {
        let number: Result<f64, _> = text.trim().parse();
        number.map_err(|_| format!("`{text}` is not a number"))
    };
    let (from, to) = (number(ends.0)?, number(ends.1)?);
    if from < to {
        Ok((from, to))
    } else {
        Err("expected FROM before TO".into())
    }
}

/// Imported recordings.
pub struct Loaded {
    /// Those to fit.
    pub fitted: Vec<Experiment>,
    /// Those to predict.
    pub held_out: Vec<Experiment>,
    /// Remarks of the import.
    pub notes: Vec<Note>,
}

impl DataOptions {
    /// The files of all recordings.
    pub fn files(&self) -> impl Iterator<Item = &PathBuf> {
        self.data.iter().chain(&self.validate)
    }

    /// Reads all files for these models, and prints the remarks of the import to standard error.
    /// Where one of the models describes friction, saturated angles are compared: a shaft that
    /// friction holds looks the same.
    pub fn load(&self, models: &[Arc<dyn Model>]) -> Result<Loaded, Error> {
        let has_friction = models.iter().any(|model| model.has_friction());
        let loaded = self.read(models, has_friction)?;
        for note in &loaded.notes {
            note!("warning: {note}");
        }
        Ok(loaded)
    }

    /// The joints of a data set of which none is chosen; none for other recordings.
    pub fn joints(&self) -> Result<Vec<String>, Error> {
        let is_chosen = self.joint.is_some() || !self.columns.is_empty();
        match self.data.first() {
            Some(folder) if !is_chosen && self.data.iter().all(|path| path.is_dir()) => {
                Ok(joints_of(folder)?)
            }
            _ => Ok(Vec::new()),
        }
    }

    /// Whether the recordings are of a pendulum.
    pub fn are_of_a_pendulum(&self) -> Result<bool, Error> {
        let loaded = self.read(&models::all(), false)?;
        let has_pendulum = |e: &Experiment| e.recording.constants.contains_key("pendulum_mass_kg");
        Ok(loaded.fitted.iter().any(has_pendulum))
    }

    fn read(&self, models: &[Arc<dyn Model>], has_friction: bool) -> Result<Loaded, Error> {
        let mut notes = Vec::new();
        let mut read = |paths: &[PathBuf]| -> Result<Vec<Experiment>, Error> {
            let mut experiments = Vec::new();
            for path in paths {
                let mut import = self.import(models, path)?;
                import.keep_clipped |= has_friction;
                experiments.extend(read(&import, path, &mut notes)?);
            }
            Ok(experiments)
        };
        let fitted = read(&self.data)?;
        let held_out = read(&self.validate)?;
        Ok(Loaded {
            fitted,
            held_out,
            notes,
        })
    }

    /// Refuses files that are named twice, values for files that are not read, two windows for one
    /// file, and known constants that none of the models has or that are not finite.
    pub fn check(&self, models: &[Arc<dyn Model>]) -> Result<(), Error> {
        let [fitted, held_out] = [&self.data, &self.validate].map(|files| files.iter());
        check_files(fitted.map(PathBuf::as_path), held_out.map(PathBuf::as_path))?;
        let windows: Vec<_> = self.window.iter().map(|w| w.file.as_deref()).collect();
        let known = self.known.iter().map(|k| k.file.as_deref());
        let windowed = windows.iter().map(|file| ("--window", *file));
        for (option, file) in windowed.chain(known.map(|file| ("--known", file))) {
            self.check_is_read(option, file)?;
        }
        for (index, file) in windows.iter().enumerate() {
            if windows[..index].contains(file) {
                let file = file.map_or("all files".into(), Path::to_string_lossy);
                let problem = format!("--window is given twice for {file}, expected it once");
                return Err(Error::Conflict(problem));
            }
        }
        self.constants(models, &self.known.iter().collect::<Vec<_>>())
            .map(drop)
    }

    /// Refuses an option whose file is not one of the recordings.
    fn check_is_read(&self, option: &str, file: Option<&Path>) -> Result<(), Error> {
        match file {
            Some(file) if !self.files().any(|read| read == file) => {
                let files: Vec<_> = self.files().map(|read| read.to_string_lossy()).collect();
                let (file, files) = (file.display(), files.join(", "));
                let problem = format!("{option} is for {file}, expected one of {files}");
                Err(Error::Conflict(problem))
            }
            _ => Ok(()),
        }
    }

    fn constants(
        &self,
        models: &[Arc<dyn Model>],
        known: &[&OfFile<Setting>],
    ) -> Result<BTreeMap<String, f64>, Error> {
        let known = known.iter().map(|k| (k.value.name.clone(), k.value.value));
        Ok(known_constants(models, &known.collect::<Vec<_>>())?)
    }

    /// The options for a file: its own values have precedence over those for all files.
    fn import(&self, models: &[Arc<dyn Model>], path: &Path) -> Result<Import, Error> {
        let for_all = |file: &Option<PathBuf>| file.is_none();
        let for_this = |file: &Option<PathBuf>| file.as_deref() == Some(path);
        let window = self.window.iter().find(|w| for_this(&w.file));
        let window = window.or_else(|| self.window.iter().find(|w| for_all(&w.file)));
        let known = self.known.iter().filter(|k| for_all(&k.file));
        let own = self.known.iter().filter(|k| for_this(&k.file));
        let known: Vec<_> = known.chain(own).collect();
        let character = |c| Delimiter::Character(c);
        Ok(Import {
            columns: Columns {
                selected: self.columns.clone(),
                joint: self.joint.clone(),
            },
            rate_hz: self.rate_hz,
            delimiter: self.delimiter.map(|name| match name {
                DelimiterName::Comma => character(b','),
                DelimiterName::Semicolon => character(b';'),
                DelimiterName::Tab => character(b'\t'),
                DelimiterName::Blanks => Delimiter::Blanks,
            }),
            window_s: window.map(|window| window.value),
            keep_clipped: self.keep_clipped,
            keep_bad: self.keep_bad,
            hold: match self.hold {
                None => Hold::Auto,
                Some(HoldName::Zero) => Hold::Zero,
                Some(HoldName::Smooth) => Hold::Smooth,
            },
            constants: self.constants(models, &known)?,
            may_lack_command: may_lack_command(models),
        })
    }
}

/// Reads the recordings of a path, with a progress bar.
fn read(import: &Import, path: &Path, notes: &mut Vec<Note>) -> Result<Vec<Experiment>, Error> {
    let bar = output::progress(0, "bytes read");
    let imported = import.read_all(path, &mut |done, of| {
        bar.set_length(of);
        bar.set_position(done);
    });
    bar.finish_and_clear();
    let mut experiments = Vec::new();
    for imported in imported? {
        notes.extend(imported.notes);
        let unusable = |error| IdentifyError::Recording {
            name: path.display().to_string(),
            error,
        };
        experiments.push(Experiment::try_new(imported.recording).map_err(unusable)?);
    }
    Ok(experiments)
}
