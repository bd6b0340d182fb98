//! `actuator experiment`.

mod result;

use std::path::{Path, PathBuf};

use clap::{Args, builder::PossibleValuesParser};
use model_core::{excitation::catalogue::Input, parameter::Shown, time::CONTROL_RATE_HZ};

use super::{
    identify::model_names,
    output,
    parameters::{self, setting},
};
use crate::error::Error;
use host_sim::error::Error as SimulatorError;
use host_sim::{file, scenario::Setting, settings::ModelKind};
use identification::{
    Model, Recording,
    contradictions::ParameterOption,
    design::{
        Designed, ENCODER_DEG, ExperimentSetup, LEAST_STEP_S,
        inputs::{Limits, bandwidth_hz, best, design},
    },
    models, parameter_file,
};

/// Designs inputs for identification and predicts the uncertainty of each parameter
///
/// Each input is timed for the bandwidth, with the greatest amplitude within the rate limit and
/// with one that exceeds it. The errors are Cramer-Rao bounds for the expected parameters: the
/// least standard deviation of an unbiased estimate.
#[derive(Debug, Args)]
pub struct Experiment {
    /// Model to be fitted
    #[arg(value_name = "MODEL", value_parser = model_names())]
    model: String,
    /// Expected parameters, from a file written by `identify --parameters`
    #[arg(long = "parameters", value_name = "FILE")]
    parameter_file: Option<PathBuf>,
    /// Expected value of a parameter; repeatable
    #[arg(long, value_name = "NAME=VALUE", value_parser = setting)]
    set: Vec<Setting>,
    /// Parameter with a known value; repeatable
    #[arg(long, value_name = "NAME")]
    fix: Vec<String>,
    /// Estimates a parameter that is held by default; repeatable
    #[arg(long, value_name = "NAME")]
    free: Vec<String>,
    /// Input to design; repeatable [default: all]
    #[arg(long, value_name = "NAME", value_parser = PossibleValuesParser::new(Input::NAMES))]
    input: Vec<String>,
    /// Length of the experiment, s
    #[arg(long, value_name = "SECONDS", default_value_t = 10.0)]
    duration: f64,
    /// Samples per second
    #[arg(long, value_name = "HZ", default_value_t = CONTROL_RATE_HZ.into())]
    rate: f64,
    /// Standard deviation of the noise on the angle, deg
    #[arg(long, value_name = "DEG", default_value_t = 0.05)]
    noise: f64,
    /// Resolution of the encoder, deg; 0 for an ideal one [default: 12 bits]
    #[arg(long, value_name = "DEG", default_value_t = ENCODER_DEG, hide_default_value = true)]
    resolution: f64,
    /// Greatest command, deg
    #[arg(long, value_name = "DEG", default_value_t = 60.0)]
    amplitude: f64,
    /// Bandwidth for the timing of the inputs, Hz [default: that of the expected parameters]
    #[arg(long, value_name = "HZ")]
    band: Option<f64>,
    /// Writes the best of the designed inputs, for `simulate --input-file`
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    #[command(flatten)]
    json: output::Json,
}

/// The most samples: an hour at 1 kHz.
const MOST_SAMPLES: f64 = 3.6e6;

impl Experiment {
    pub(super) fn run(self) -> Result<(), Error> {
        let bench = self.bench()?;
        let files = [("--csv", self.csv.as_deref()), ("--json", self.json.file())];
        let given = files.into_iter().filter_map(|(o, path)| Some((o, path?)));
        file::check(&given.collect::<Vec<_>>(), &self.parameter_file)?;
        let limits = Limits {
            bandwidth_hz: self.band.unwrap_or_else(|| bandwidth_hz(&bench)),
            most_deg: self.amplitude,
        };
        let designs = self.designs(&bench, &limits)?;
        let best = best(&designs);
        if let (Some(path), Some(best)) = (&self.csv, best) {
            file::write(path, result::csv(&designs[best], bench.step_s))?;
            note!("input: {}", path.display());
        }
        let tables = || {
            output::print_table(&result::table(&designs, best))?;
            best.map_or(Ok(()), |best| {
                output::print(&format!("\n{}\n", result::verdict(&designs[best])))
            })
        };
        let json = || result::json(&bench, &limits, &designs, best);
        self.json.write(json, tables)
    }

    fn bench(&self) -> Result<ExperimentSetup, Error> {
        let within = |option, value: f64, low: f64, high: f64, expected| {
            // Written so that NaN fails.
            if value >= low && value <= high {
                return Ok(());
            }
            let value = Shown(value).to_string();
            Err(Error::Option {
                option,
                value,
                expected,
            })
        };
        within("--duration", self.duration, 0.1, 3600.0, "0.1 to 3600 s")?;
        within(
            "--rate",
            self.rate,
            1.0,
            1.0 / LEAST_STEP_S,
            "1 to 20000 Hz",
        )?;
        let samples = self.duration * self.rate;
        within(
            "--rate",
            samples,
            8.0,
            MOST_SAMPLES,
            "8 to 3600000 samples in all",
        )?;
        within("--noise", self.noise, 0.0, 1e3, "0 to 1000 deg")?;
        within("--resolution", self.resolution, 0.0, 360.0, "0 to 360 deg")?;
        within(
            "--amplitude",
            self.amplitude,
            1e-3,
            3e4,
            "0.001 to 30000 deg",
        )?;
        let band_hz = self.band.unwrap_or(1.0);
        within("--band", band_hz, 1e-3, 1e3, "0.001 to 1000 Hz")?;
        if self.noise == 0.0 && self.resolution == 0.0 {
            let problem = "without noise and with --resolution 0 every error is zero, expected one \
                           of them greater";
            return Err(Error::Conflict(problem.into()));
        }
        let unknown = "the parser has accepted an unknown model";
        let model = models::named(&self.model).expect(unknown);
        check_command(&*model)?;
        let mut bench = ExperimentSetup {
            noise_deg: self.noise,
            resolution_deg: self.resolution,
            step_s: 1.0 / self.rate,
            duration_s: self.duration,
            ..ExperimentSetup::new(model)
        };
        self.expect(&mut bench)?;
        Ok(bench)
    }

    /// Sets the expected values and the parameters to estimate.
    fn expect(&self, bench: &mut ExperimentSetup) -> Result<(), Error> {
        let table = bench.model.parameters().to_vec();
        let is_motor = parameter_file::simulated(&self.model) == Some(ModelKind::Board);
        let place = |name: &str| {
            let known = table.iter().map(|p| p.name);
            let index = table.iter().position(|p| p.is_called(name));
            index.ok_or_else(|| {
                let expected: Vec<&str> = known.clone().collect();
                SimulatorError::unknown("parameter", name, known, expected.join(", ")).into()
            })
        };
        if let Some(path) = &self.parameter_file {
            for setting in fitted(path, &self.model)? {
                let index = match place(&setting.name) {
                    Ok(index) => index,
                    // The file may have parameters of the board that the model lacks.
                    Err(_) if is_motor => continue,
                    Err(error) => return Err(error),
                };
                bench.values[index] = table[index].check(setting.value)?;
            }
        }
        for setting in &self.set {
            let index = place(&setting.name)?;
            bench.values[index] = table[index].check(setting.value)?;
        }
        let free = ParameterOption::new("--free", &self.free);
        let fix = ParameterOption::new("--fix", &self.fix);
        fix.without(&free, &table).map_err(Error::Conflict)?;
        for (names, is_free) in [(&self.free, true), (&self.fix, false)] {
            for name in names {
                bench.free[place(name)?] = is_free;
            }
        }
        for (free, value) in bench.free.iter_mut().zip(&bench.values) {
            *free &= value.is_finite();
        }
        Ok(())
    }

    /// All inputs that can be designed; the others are reported on standard error.
    fn designs(&self, bench: &ExperimentSetup, limits: &Limits) -> Result<Vec<Designed>, Error> {
        let names = Input::NAMES.iter();
        let is_asked = |name: &str| self.input.is_empty() || self.input.iter().any(|i| i == name);
        let names: Vec<&str> = names.copied().filter(|name| is_asked(name)).collect();
        let bar = output::progress(2 * names.len() as u64, "inputs");
        let (mut designs, mut problems) = (Vec::<Designed>::new(), Vec::new());
        for (name, is_beyond) in names.iter().flat_map(|name| [(name, false), (name, true)]) {
            match design(bench, name, limits, is_beyond) {
                // Even the greatest command may stay within the rate limit.
                Some(Ok(design)) => {
                    let same = |d: &Designed| d.command_deg == design.command_deg;
                    if !designs.last().is_some_and(same) {
                        designs.push(design);
                    }
                }
                Some(Err(problem)) => problems.push(format!("{name}: {problem}")),
                None => {}
            }
            bar.inc(1);
        }
        bar.finish_and_clear();
        match problems.first() {
            Some(first) if designs.is_empty() => Err(Error::Conflict(first.clone())),
            _ => {
                problems.dedup();
                problems
                    .iter()
                    .for_each(|problem| note!("warning: {problem}"));
                Ok(designs)
            }
        }
    }
}

/// Refuses a model whose input is not a command.
fn check_command(model: &dyn Model) -> Result<(), Error> {
    let takes_command = |model: &dyn Model| model.accepts(&Recording::default()).is_ok();
    if takes_command(model) {
        return Ok(());
    }
    let all = models::all();
    let expected: Vec<_> = all.iter().filter(|m| takes_command(&***m)).collect();
    let expected: Vec<_> = expected.iter().map(|m| m.name()).collect();
    Err(Error::Conflict(format!(
        "inputs are designed as commands, and {} takes the duty of its motor, expected one of {}",
        model.name(),
        expected.join(", ")
    )))
}

/// The settings of a file written by `identify --parameters` for this model.
fn fitted(path: &Path, model: &str) -> Result<Vec<Setting>, Error> {
    let file = parameters::read(path)?;
    match file.model {
        Some(kind) if parameter_file::simulated(model) != Some(kind) => {
            Err(Error::Conflict(format!(
                "{} has the parameters of {kind}, expected those of {model}",
                path.display()
            )))
        }
        _ => {
            let values = file.set.into_iter().map(|s| (s.name, s.value));
            let values = parameter_file::named_for(model, values.collect());
            let setting = |(name, value)| Setting::new(name, value);
            Ok(values.into_iter().map(setting).collect())
        }
    }
}
