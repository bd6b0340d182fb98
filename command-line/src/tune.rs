//! `actuator tune`.

mod group;
mod options;
mod result;

use std::path::PathBuf;

use clap::Args;

use super::{
    output,
    parameters::{self, ParameterOptions},
};
use crate::error::Error;
use host_sim::{
    file, plot,
    scenario::Setting,
    settings::ModelKind,
    tune::{self, Language, TuneError},
};
use options::TuneOptions;

/// Computes gains for a motor and a target bandwidth
///
/// The target is either the bandwidth of the rate loop, with the position gain as a share of it, or
/// the bandwidth and the phase margin of the position loop. The default is the rate loop of the
/// paper. The margins of the sampled loop are printed; margins below common practice cause warnings
/// on standard error.
#[derive(Debug, Args)]
pub struct Tune {
    /// Motor and board of a preset [default: consistent]
    #[arg(long, value_name = "NAME", value_parser = parameters::preset_names(ModelKind::Board.presets()))]
    preset: Option<String>,
    /// Steady-state gain of the motor, (deg/s)/%
    #[arg(long, value_name = "K")]
    gain: Option<f64>,
    /// Time constant of the motor, s
    #[arg(long, value_name = "SECONDS")]
    time_constant: Option<f64>,
    /// Bandwidth of the rate loop, rad/s
    #[arg(long, value_name = "RAD_S",
        conflicts_with_all = ["bandwidth", "phase_margin"])]
    inner_bandwidth: Option<f64>,
    /// Position gain as a share of the bandwidth of the rate loop; a quarter is critical damping
    #[arg(long, value_name = "SHARE",
        conflicts_with_all = ["bandwidth", "phase_margin"])]
    position_share: Option<f64>,
    /// Bandwidth from position command to angle, Hz
    #[arg(long, value_name = "HZ")]
    bandwidth: Option<f64>,
    /// Least phase margin of the sampled loop, deg
    #[arg(long, value_name = "DEG")]
    phase_margin: Option<f64>,
    #[command(flatten)]
    parameters: ParameterOptions,
    #[command(flatten)]
    json: output::Json,
    /// Writes gains and loops as code: .m for MATLAB and Octave, .py for python-control
    #[arg(long, value_name = "FILE", value_parser = code_file)]
    code: Option<CodeFile>,
    /// Plots the Bode diagram with the margins, as .svg or interactive .html
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
}

/// A file of code.
#[derive(Debug, Clone)]
struct CodeFile {
    path: PathBuf,
    language: Language,
}

fn code_file(text: &str) -> Result<CodeFile, String> {
    let path = PathBuf::from(text);
    let language = match path.extension().and_then(|end| end.to_str()) {
        Some("m") => Language::Matlab,
        Some("py") => Language::Python,
        _ => return Err("expected a file that ends in .m or .py".into()),
    };
    Ok(CodeFile { path, language })
}

impl Tune {
    pub(super) fn run(self) -> Result<(), Error> {
        let options = TuneOptions::new(self.preset.as_deref(), &self.settings())?;
        if self.parameters.list {
            return parameters::print(&options.parameters(), &self.json);
        }
        if let Some(path) = &self.plot {
            plot::Format::of(path)?;
        }
        let files = [
            ("--plot", self.plot.as_deref()),
            ("--code", self.code.as_ref().map(|code| code.path.as_path())),
            ("--json", self.json.file()),
        ];
        let given = files.into_iter().filter_map(|(o, path)| Some((o, path?)));
        file::check(&given.collect::<Vec<_>>(), [])?;
        let request = options.request();
        let tuning = tune::tune(&request).map_err(explained)?;
        for warning in &tuning.warnings {
            note!("warning: {warning}");
        }
        let command = options.simulate_command(&tuning)?;
        self.json.write(
            || result::json(&tuning, command.as_deref()),
            || result::print(&tuning, command.as_deref()),
        )?;
        if let Some(CodeFile { path, language }) = &self.code {
            let text = tune::code(&request, &tuning, *language).map_err(explained)?;
            file::write(path, text)?;
            note!("code: {}", path.display());
        }
        if let Some(path) = &self.plot {
            plot::save(&tune::bode(&request, &tuning).map_err(explained)?, path)?;
            note!("plot: {}", path.display());
        }
        Ok(())
    }

    /// The settings of the options, then those of --set.
    fn settings(&self) -> Vec<Setting> {
        let options = [
            ("motor_gain", self.gain),
            ("motor_time_constant_s", self.time_constant),
            ("inner_bandwidth_rad_s", self.inner_bandwidth),
            ("position_share", self.position_share),
            ("bandwidth_hz", self.bandwidth),
            ("phase_margin_deg", self.phase_margin),
        ];
        let options = options.into_iter();
        let options = options.filter_map(|(name, value)| Some(Setting::new(name, value?)));
        options.chain(self.parameters.set.iter().cloned()).collect()
    }
}

/// The error of the tuning; for a computed gain out of range, its cause.
fn explained(error: TuneError) -> Error {
    match error {
        TuneError::Parameter(parameter) if options::is_found(&parameter) => Error::Conflict(
            format!("the request requires a gain that the board does not accept: {parameter}"),
        ),
        TuneError::Parameter(parameter) => parameter.into(),
        out_of_reach => Error::Conflict(out_of_reach.to_string()),
    }
}
