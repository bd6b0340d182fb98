//! The paper's three models: with the paper's numbers, and fitted to the runs.

use host_sim::{
    identify::{
        Experiment, Fit, Model, Options, Problem, Quiet, engine, models::named, statistics::Quality,
    },
    input::{Command, Sequence},
    settings::{self, ModelKind, PlantKind, Settings},
    simulate::Simulation,
};
use model_core::{named::Named as _, time::TICKS_PER_SECOND};
use std::sync::Arc;

use crate::{Failure, bench::Controller, runs::Run};

/// The models, from the least to the most complex as the paper orders them.
pub const MODELS: [&str; 3] = ["black-box-1", "black-box-2", "grey-box"];
/// The presets that are the paper's numbers; of the grey box as it is printed, in the paper's unit.
const PRINTED: [&str; 3] = ["paper", "paper", "as-printed"];

/// How all models are searched for: the look at the data starts near the optimum, and three
/// scattered starts beside it would find another.
pub fn search() -> Options {
    Options {
        starts: 4,
        ..Options::default()
    }
}

/// A model by its place in [`MODELS`].
///
/// # Errors
/// [`Failure::NoModel`] of a name that identification does not know.
pub fn model(index: usize) -> Result<Arc<dyn Model>, Failure> {
    let name = MODELS[index];
    named(name).ok_or(Failure::NoModel(name))
}

/// The parameters that are known beforehand: of the grey box the gains of its controller.
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
    /// How near it comes to the runs that it was fitted to.
    pub quality: Quality,
    /// How near it comes to those of each input, its own included; `None` of an input without runs.
    pub predicted: Vec<Option<Quality>>,
}

impl Fitted {
    /// The estimate of a parameter; NaN where the model has none.
    pub fn value(&self, name: &str) -> f64 {
        self.fit.value(name).unwrap_or(f64::NAN)
    }

    /// Fits a model to the runs of one input, and predicts those of all.
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
        let mut fit = engine::fit(&problem, &search(), &Quiet)?;
        if let Some(nested) = from_first_order(index, &problem)? {
            fit = if nested.cost < fit.cost { nested } else { fit };
        }
        let quality = |pairs: &[(&Experiment, Vec<f64>)]| {
            let measured = pairs
                .iter()
                .flat_map(|(e, _)| e.recording.angle_deg.clone());
            let answers = pairs.iter().flat_map(|(_, angles)| angles.clone());
            Quality::of(&measured.collect::<Vec<_>>(), &answers.collect::<Vec<_>>())
                .ok_or(Failure::Nothing)
        };
        let own: Vec<_> = (own.iter().zip(&fit.experiments))
            .map(|(experiment, fit)| (experiment, fit.predicted_deg.clone()))
            .collect();
        let predict = |runs: &Vec<Experiment>| {
            let one = |run| Ok((run, engine::predict(&problem, &fit, run)?.predicted_deg));
            let answers = runs.iter().map(one).collect::<Result<Vec<_>, Failure>>()?;
            match answers.is_empty() {
                true => Ok(None),
                false => quality(&answers).map(Some),
            }
        };
        Ok(Self {
            quality: quality(&own)?,
            predicted: all.iter().map(predict).collect::<Result<_, _>>()?,
            fit,
        })
    }
}

/// Black box 2 from where it is as good as black box 1, which it can be with a quick inner loop: where
/// the limits rule, searches from elsewhere may end in a worse optimum. `None` of other models.
fn from_first_order(index: usize, problem: &Problem) -> Result<Option<Fit>, Failure> {
    /// Inner loop over pole.
    const QUICK: f64 = 10.0;
    if MODELS[index] != "black-box-2" {
        return Ok(None);
    }
    let simple = Problem::try_new(model(0)?, problem.experiments.clone())?;
    let simple = engine::fit(&simple, &search(), &Quiet)?;
    let value = |name: &str| simple.value(name).unwrap_or(f64::NAN);
    let mut problem = problem.clone();
    let inner = QUICK * value("pole_rad_s");
    let same = [
        "delay_s",
        "rate_limit_up_deg_s",
        "rate_limit_down_deg_s",
        "gain",
        "offset_deg",
    ];
    let same = same.map(|name| (name, value(name)));
    let gains = [
        ("position_gain_per_s2", inner * value("pole_rad_s")),
        ("rate_gain_per_s", inner),
    ];
    for (name, value) in same.into_iter().chain(gains) {
        let spec = problem
            .specs
            .iter()
            .find(|spec| spec.parameter.name == name);
        // A limit that is not reached may have none.
        if let Some(spec) = spec.filter(|_| value.is_finite()) {
            problem.start(name, value.clamp(spec.low, spec.high))?;
        }
    }
    let options = Options {
        starts: 1,
        ..Options::default()
    };
    Ok(Some(engine::fit(&problem, &options, &Quiet)?))
}

/// What a model with the paper's numbers answers to the commands of a run, at each control period,
/// deg.
///
/// # Errors
/// Those of the simulator.
pub fn printed(index: usize, run: &Run) -> Result<Vec<f64>, Failure> {
    let name = MODELS[index];
    let kind = ModelKind::named(name).ok_or(Failure::NoModel(name))?;
    let mut settings = Settings::new(kind, PlantKind::FirstOrder);
    settings::apply(&mut settings, PRINTED[index])?;
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
    }
    .record()?;
    let angles = trace.column("angle_deg").unwrap_or_default();
    Ok(angles.iter().take(run.len()).copied().collect())
}
