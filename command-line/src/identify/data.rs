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
    data::{ColumnSelection, Columns, Delimiter, Import, Note},
    models,
    request::{check_files, known_constants, may_lack_command},
};

#[derive(Debug, Args)]
pub struct DataOptions {
    /// Recordings to fit
    #[arg(required = true, value_name = "DATA")]
    pub data: Vec<PathBuf>,
    /// Recordings for validation: predicted by the fitted models, but not fitted
    #[arg(long, value_name = "FILE", num_args = 1..)]
    pub validate: Vec<PathBuf>,
    /// Assigns a column to a quantity, as angle=pos:rad or time=1; the quantities are time,
    /// command, angle, rate, duty, current and supply; a unit may be a factor; repeatable
    #[arg(long = "column", value_name = "WHAT=COLUMN[:UNIT]")]
    columns: Vec<ColumnSelection>,
    /// Delimiter between two fields [default: detected in the first line]
    #[arg(long)]
    delimiter: Option<DelimiterName>,
    /// First and last time of the files that are used, s
    #[arg(long, value_name = "FROM:TO", value_parser = window)]
    window: Option<(f64, f64)>,
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
    /// Known constant of the runs by the name of a parameter, as pendulum_mass_kg=0.5; repeatable
    #[arg(long, value_name = "NAME=VALUE", value_parser = setting)]
    known: Vec<Setting>,
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
            eprintln!("warning: {note}");
        }
        Ok(loaded)
    }

    /// Whether the recordings are of a pendulum.
    pub fn are_of_a_pendulum(&self) -> Result<bool, Error> {
        let loaded = self.read(&models::all(), false)?;
        let has_pendulum = |e: &Experiment| e.recording.constants.contains_key("pendulum_mass_kg");
        Ok(loaded.fitted.iter().any(has_pendulum))
    }

    fn read(&self, models: &[Arc<dyn Model>], has_friction: bool) -> Result<Loaded, Error> {
        let mut import = self.import(models)?;
        import.keep_clipped |= has_friction;
        let mut notes = Vec::new();
        let mut read = |paths: &[PathBuf]| -> Result<Vec<Experiment>, Error> {
            let one = |path: &PathBuf| read(&import, path, &mut notes);
            paths.iter().map(one).collect()
        };
        let fitted = read(&self.data)?;
        let held_out = read(&self.validate)?;
        Ok(Loaded {
            fitted,
            held_out,
            notes,
        })
    }

    /// Refuses files that are named twice, and known constants that none of the models has or that
    /// are not finite.
    pub fn check(&self, models: &[Arc<dyn Model>]) -> Result<(), Error> {
        let [fitted, held_out] = [&self.data, &self.validate].map(|files| files.iter());
        check_files(fitted.map(PathBuf::as_path), held_out.map(PathBuf::as_path))?;
        self.constants(models).map(drop)
    }

    fn constants(&self, models: &[Arc<dyn Model>]) -> Result<BTreeMap<String, f64>, Error> {
        let known = self.known.iter().map(|s| (s.name.clone(), s.value));
        Ok(known_constants(models, &known.collect::<Vec<_>>())?)
    }

    fn import(&self, models: &[Arc<dyn Model>]) -> Result<Import, Error> {
        let character = |c| Delimiter::Character(c);
        Ok(Import {
            columns: Columns(self.columns.clone()),
            delimiter: self.delimiter.map(|name| match name {
                DelimiterName::Comma => character(b','),
                DelimiterName::Semicolon => character(b';'),
                DelimiterName::Tab => character(b'\t'),
                DelimiterName::Blanks => Delimiter::Blanks,
            }),
            window_s: self.window,
            keep_clipped: self.keep_clipped,
            keep_bad: self.keep_bad,
            hold: match self.hold {
                None => Hold::Auto,
                Some(HoldName::Zero) => Hold::Zero,
                Some(HoldName::Smooth) => Hold::Smooth,
            },
            constants: self.constants(models)?,
            may_lack_command: may_lack_command(models),
        })
    }
}

/// Reads a file, with a progress bar.
fn read(import: &Import, path: &Path, notes: &mut Vec<Note>) -> Result<Experiment, Error> {
    let bar = output::progress(0, "bytes read");
    let imported = import.read(path, &mut |done, of| {
        bar.set_length(of);
        bar.set_position(done);
    });
    bar.finish_and_clear();
    let imported = imported?;
    notes.extend(imported.notes);
    let unusable = |error| IdentifyError::Recording {
        name: path.display().to_string(),
        error,
    };
    Ok(Experiment::try_new(imported.recording).map_err(unusable)?)
}
