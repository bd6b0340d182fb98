//! The description of a run, which is stored with its trace.

use model_core::{excitation::catalogue::Input, named::Named};

use crate::{
    error::Error,
    scenario::Scenario,
    settings::{ModelKind, Settings},
    simulate::Simulation,
};

/// Everything that is needed to repeat a run.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Description {
    /// Names with text.
    pub texts: Vec<(&'static str, String)>,
    /// Named groups of numbers, as `parameters`.
    pub groups: Vec<(&'static str, Vec<(&'static str, f64)>)>,
}

impl Description {
    /// Describes the run that a scenario was resolved to.
    ///
    /// # Errors
    /// Those of [`Scenario::resolve`].
    pub fn of(scenario: &Scenario, simulation: &Simulation) -> Result<Self, Error> {
        let settings = &simulation.settings;
        let mut texts = vec![
            ("program", "actuator".to_owned()),
            ("version", env!("CARGO_PKG_VERSION").to_owned()),
            ("model", settings.model.name().to_owned()),
        ];
        if settings.model == ModelKind::Board {
            texts.push(("plant", settings.plant.name().to_owned()));
            texts.push(("pwm", settings.pwm.name().to_owned()));
        }
        texts.push(("preset", preset(scenario, settings)));
        texts.push(("input", simulation.input.clone()));
        if let Some(load) = &scenario.load_file {
            texts.push(("load", load.display().to_string()));
        }
        // As text: a double has only 53 bits.
        texts.push(("seed", settings.seed.to_string()));
        let values = settings.values().map(|v| (v.parameter.name, v.value));
        let mut groups = vec![("parameters", values.collect())];
        if let Some(input) = scenario.standard_input()? {
            groups.push(("input_parameters", input_parameters(&input)));
        }
        Ok(Self { texts, groups })
    }
}

/// The preset of the scenario, by default the first of the model.
fn preset(scenario: &Scenario, settings: &Settings) -> String {
    let first = || settings.model.presets().next().map(|preset| preset.name);
    let name = scenario.preset.as_deref().or_else(first);
    name.unwrap_or_default().to_owned()
}

fn input_parameters(input: &Input) -> Vec<(&'static str, f64)> {
    let table = input.table().iter().enumerate();
    table
        .filter_map(|(i, parameter)| Some((parameter.name, input.get(i)?)))
        .collect()
}
