//! A run as the Python modules describe it.

use host_sim::{
    error::Error,
    input::{
        Command, Sequence,
        file::{COMMAND, LOAD, Quantity, TIME},
    },
    scenario::{Scenario, Setting},
    settings::PlantKind,
    simulate::Simulation,
};
use model_core::{
    named::Named,
    parameter::Shown,
    scenario::{NameKind, named},
    time::ticks,
};
use numpy::PyReadonlyArray1;
use pyo3::{FromPyObject, PyResult};

use crate::exception::raised;

/// Times, s, and values that are each held from their time on.
pub type Points<'py> = (PyReadonlyArray1<'py, f64>, PyReadonlyArray1<'py, f64>);

/// A dictionary with all of these keys.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Request<'py> {
    model: String,
    plant: Option<String>,
    preset: Option<String>,
    input: Option<String>,
    command: Option<Points<'py>>,
    load: Option<Points<'py>>,
    duration: Option<f64>,
    every: u64,
    seed: u64,
    pwm: String,
    parameters: Vec<(String, f64)>,
}

/// A run, without Python types.
pub struct Plan {
    scenario: Scenario,
    command: Option<Sequence>,
    load: Option<Sequence>,
}

/// A scenario without a command.
///
/// # Errors
/// [`Error::UnknownName`] for model, plant or the switching of the bridge.
pub fn scenario(
    model: &str,
    plant: Option<&str>,
    preset: Option<String>,
    seed: u64,
    pwm: &str,
    parameters: Vec<(String, f64)>,
) -> Result<Scenario, Error> {
    let set = parameters.into_iter();
    Ok(Scenario {
        model: Some(named(NameKind::Model, model)?),
        plant: plant
            .map(|plant| named(NameKind::Plant, plant))
            .transpose()?,
        preset,
        seed: Some(seed),
        pwm: Some(named(NameKind::Pwm, pwm)?),
        set: set.map(|(name, value)| Setting::new(name, value)).collect(),
        ..Default::default()
    })
}

impl Request<'_> {
    /// The run, with the checks that are common to all actuators of a campaign.
    ///
    /// # Errors
    /// A Python exception with the argument and what is expected.
    pub fn plan(self) -> PyResult<Plan> {
        self.checked().map_err(raised)
    }

    fn checked(self) -> Result<Plan, Error> {
        let command = self.command.map(|c| sequence("command", &c, &COMMAND));
        let load = self.load.map(|l| sequence("load", &l, &LOAD));
        let plant = self.plant.as_deref();
        if load.is_some() && plant != Some(PlantKind::Drivetrain.name()) {
            let alone = "a load applies to plant=\"bench\", no other has a load";
            return Err(Error::Conflict(alone.into()));
        }
        let scenario = scenario(
            &self.model,
            plant,
            self.preset,
            self.seed,
            &self.pwm,
            self.parameters,
        )?;
        Ok(Plan {
            scenario: Scenario {
                input: self.input,
                duration_s: self.duration,
                every: Some(self.every),
                ..scenario
            },
            command: command.transpose()?,
            load: load.transpose()?,
        })
    }
}

impl Plan {
    /// Model and input by name.
    ///
    /// # Errors
    /// As [`Scenario::described`].
    pub fn described(&self) -> Result<model_core::scenario::Scenario, Error> {
        self.scenario.described()
    }

    /// The run with these additional parameters.
    ///
    /// # Errors
    /// As [`Scenario::resolve`].
    pub fn simulation(&self, more: impl Iterator<Item = Setting>) -> Result<Simulation, Error> {
        let mut scenario = self.scenario.clone();
        scenario.set.extend(more);
        let mut simulation = scenario.resolve()?;
        if let Some(command) = &self.command {
            if scenario.duration_s.is_none() {
                // The last point is the last tick of the run, as with a file.
                simulation.ticks = command.last_tick() + 1;
            }
            simulation.input = "command".into();
            simulation.command = Command::Sequence(command.clone());
        }
        simulation.load.clone_from(&self.load);
        Ok(simulation)
    }
}

/// The sequence of an argument, by the rules for files.
fn sequence(argument: &str, points: &Points, quantity: &Quantity) -> Result<Sequence, Error> {
    let (times, values) = (points.0.as_array(), points.1.as_array());
    if times.len() != values.len() || times.is_empty() {
        return Err(Error::Conflict(format!(
            "{argument} has {} times and {} values, expected as many of both, at least one",
            times.len(),
            values.len()
        )));
    }
    let mut sequence = Sequence::default();
    let mut last_s = 0.0;
    for (index, (t, value)) in times.iter().copied().zip(values).enumerate() {
        taken(argument, index, t, &TIME)?;
        if t < last_s {
            return Err(Error::Conflict(format!(
                "{argument}: t[{index}] is {t} after {last_s}, expected times that do not decrease"
            )));
        }
        last_s = t;
        sequence.push(ticks(t), taken(argument, index, *value, quantity)?);
    }
    Ok(sequence)
}

fn taken(argument: &str, index: usize, value: f64, quantity: &Quantity) -> Result<f64, Error> {
    // NaN is in no range.
    if quantity.range.contains(&value) {
        return Ok(value);
    }
    Err(Error::Conflict(format!(
        "{argument}: {}[{index}] is {}, expected {} from {} to {} {}",
        quantity.column,
        Shown(value),
        quantity.meaning,
        quantity.range.start(),
        quantity.range.end(),
        quantity.unit
    )))
}
