//! The paper's three models: with the paper's numbers, and fitted to the runs.

use host_sim::{
    input::{Command, Sequence},
    settings::{ModelKind, PlantKind, Settings},
    simulate::Simulation,
};
use identification::{
    Experiment, Fit, Model, Options, Problem, Quiet, engine, models::named, statistics::Quality,
};
use model_core::{named::Named as _, scenario, time::TICKS_PER_SECOND};
use std::sync::Arc;

use crate::{Failure, runs::Run, test_bench::Controller};

/// The models in the paper's order of complexity.
pub const MODELS: [&str; 3] = ["black-box-1", "black-box-2", "grey-box"];
/// The presets with the paper's numbers; for the grey box as printed, in the paper's unit.
const PRINTED: [&str; 3] = ["paper", "paper", "as-printed"];

/// Search options of all models: one start from the regression, which is near the optimum, and
/// three random starts to detect other optima.
pub fn search() -> Options {
    Options {
        starts: 4,
        ..Options::default()
    }
}

/// A model by its index in [`MODELS`].
///
/// # Errors
/// [`Failure::NoModel`] for a name that is unknown to `identification`.
pub fn model(index: usize) -> Result<Arc<dyn Model>, Failure> {
    let name = MODELS[index];
    named(name).ok_or(Failure::NoModel(name))
}

/// Parameters with known values: for the grey box the gains of its controller.
pub fn known(index: usize, controller: Controller) -> Vec<(&'static str, f64)> {
    match MODELS[index] {
        "grey-box" => controller.settings(),
        _ => Vec::new(),
    }
}

/// A model that was fitted to several runs of one input.
#[derive(Debug, Clone)]
pub struct Fitted {
    /// The fit.
    pub fit: Fit,
    /// Quality on the runs that it was fitted to.
    pub quality: Quality,
    /// Quality on the runs of each input, including its own; `None` for an input without runs.
    pub predicted: Vec<Option<Quality>>,
}

impl Fitted {
    /// The estimate of a parameter; NaN if the model does not have it.
    pub fn value(&self, name: &str) -> f64 {
        self.fit.value(name).unwrap_or(f64::NAN)
    }

    /// Fits a model to the runs of one input, and predicts the runs of all inputs.
    ///
    /// # Errors
    /// Those of the fit.
    pub fn of(
        index: usize,
        controller: Controller,
        own: &[Experiment],
        all: &[Vec<Experiment>],
    ) -> Result<Self, Failure> {
        let mut problem = Problem::try_new(model(index)?, own.to_vec())?;
        for (name, value) in known(index, controller) {
            problem.fix(name, value)?;
        }
        let fit = engine::fit(&problem, &search(), &Quiet)?;
        let quality = |pairs: &[(&Experiment, Vec<f64>)]| {
            let measured = pairs
                .iter()
                .flat_map(|(e, _)| e.recording.angle_deg.clone());
            let responses = pairs.iter().flat_map(|(_, angles)| angles.clone());
            Quality::of(
                &measured.collect::<Vec<_>>(),
                &responses.collect::<Vec<_>>(),
            )
            .ok_or(Failure::Nothing)
        };
        let own: Vec<_> = (own.iter().zip(&fit.experiments))
            .map(|(experiment, fit)| (experiment, fit.predicted_deg.clone()))
            .collect();
        let predict = |runs: &Vec<Experiment>| {
            let one = |run| Ok((run, engine::predict(&problem, &fit, run)?.predicted_deg));
            let responses = runs.iter().map(one).collect::<Result<Vec<_>, Failure>>()?;
            match responses.is_empty() {
                true => Ok(None),
                false => quality(&responses).map(Some),
            }
        };
        Ok(Self {
            quality: quality(&own)?,
            predicted: all.iter().map(predict).collect::<Result<_, _>>()?,
            fit,
        })
    }
}

/// Response of a model with the paper's numbers to the commands of a run, at each control period,
/// deg.
///
/// # Errors
/// Those of the simulator.
pub fn printed(index: usize, run: &Run) -> Result<Vec<f64>, Failure> {
    let name = MODELS[index];
    let kind = ModelKind::named(name).ok_or(Failure::NoModel(name))?;
    let mut settings = Settings::new(kind, PlantKind::FirstOrder);
    scenario::apply_preset(&mut settings, PRINTED[index]).map_err(host_sim::error::Error::from)?;
    let (every, host_ticks) = (TICKS_PER_SECOND / 250, TICKS_PER_SECOND / 50);
    let mut sequence = Sequence::default();
    for (index, deg) in run.commands_deg().enumerate() {
        sequence.push(index as u64 * host_ticks, deg);
    }
    let trace = Simulation {
        settings,
        command: Command::Sequence(sequence),
        input: name.into(),
        load: None,
        ticks: run.len() as u64 * every,
        every,
        progress: None,
    }
    .record()?;
    let angles = trace.column("angle_deg").unwrap_or_default();
    Ok(angles.iter().take(run.len()).copied().collect())
}
