//! The motor, the board and the target of a tuning, from presets and settings.

use model_core::{
    control::parameters::ControlParameters,
    parameter::{Group, Parameter, ParameterError, Parameters, Value},
    scenario,
};

use super::group;

use crate::error::Error;
use host_sim::{
    analysis::linear_models::{Motor, Timing},
    scenario::Setting,
    settings::{ModelKind, PlantKind, Settings},
    tune::{Goal, InnerLoop, PositionLoop, Ripple, TuneRequest, Tuning},
};

/// Number of parameters of the control step that tuning computes: the first ones of its table.
pub const FOUND: usize = 4;

/// The parameters of the control step that tuning does not compute.
#[derive(Debug)]
struct Given(ControlParameters);

impl Group for Given {
    fn table(&self) -> &'static [Parameter] {
        &ControlParameters::TABLE[FOUND..]
    }

    fn value(&self, index: usize) -> Option<Value> {
        self.0.value(FOUND + index)
    }

    fn assign(&mut self, name: &str, value: f64) -> Result<(), ParameterError> {
        if is_found_name(name) {
            return Err(ParameterError::Unknown);
        }
        self.0.assign(name, value)
    }
}

fn is_found_name(name: &str) -> bool {
    let mut found = ControlParameters::TABLE[..FOUND].iter();
    found.any(|parameter| parameter.is_called(name))
}

/// Whether the error is about a parameter that tuning computes.
pub fn is_found(error: &ParameterError) -> bool {
    matches!(error, ParameterError::OutOfRange { parameter, .. } if is_found_name(parameter.name))
}

/// Motor, board and target of a tuning.
pub struct TuneOptions {
    preset: Option<String>,
    board: Settings,
    motor: Motor,
    inner: InnerLoop,
    position: PositionLoop,
    /// Whether the target is that of the position loop, not of the rate loop.
    is_position: bool,
    ripple: Ripple,
    timing: Timing,
    control: Given,
}

impl TuneOptions {
    /// The request of a preset and settings.
    pub fn new(preset: Option<&str>, settings: &[Setting]) -> Result<Self, Error> {
        let board = board(preset)?;
        let (upward, downward) = directions(&board);
        let is_set = |table: &[Parameter]| {
            let mut names = settings.iter().map(|setting| &setting.name);
            names.any(|name| table.iter().any(|parameter| parameter.is_called(name)))
        };
        let is_position = is_set(PositionLoop::TABLE);
        if is_position && is_set(InnerLoop::TABLE) {
            let both = "targets for both the rate loop and the position loop, expected one of them";
            return Err(Error::Conflict(both.into()));
        }
        let mut request = Self {
            preset: preset.map(str::to_owned),
            // The direction with the greater gain is the less stable one.
            motor: if upward.motor_gain < downward.motor_gain {
                downward
            } else {
                upward
            },
            control: Given(board.control),
            board,
            inner: InnerLoop::default(),
            position: PositionLoop::default(),
            is_position,
            ripple: Ripple::default(),
            timing: Timing::default(),
        };
        for setting in settings {
            request.set(setting)?;
        }
        Ok(request)
    }

    fn groups(&mut self) -> [&mut dyn Group; 6] {
        [
            &mut self.motor,
            &mut self.inner,
            &mut self.position,
            &mut self.ripple,
            &mut self.timing,
            &mut self.control,
        ]
    }

    fn set(&mut self, setting: &Setting) -> Result<(), Error> {
        if is_found_name(&setting.name) {
            let name = &setting.name;
            let problem =
                format!("`{name}` is computed by tuning, expected a parameter of its input");
            return Err(Error::Conflict(problem));
        }
        group::set(&mut self.groups(), &setting.name, setting.value, "tune")
    }

    /// Every parameter with its value.
    pub fn parameters(mut self) -> Vec<(String, Value)> {
        let groups = self.groups();
        group::values(&groups)
            .map(|v| (v.parameter.name.into(), v))
            .collect()
    }

    /// The request for the tuning.
    pub fn request(&self) -> TuneRequest {
        TuneRequest {
            motor: self.motor,
            timing: self.timing,
            control: self.control.0,
            goal: if self.is_position {
                Goal::Position(self.position)
            } else {
                Goal::Inner(self.inner)
            },
            ripple: self.ripple,
        }
    }

    /// The command line that simulates the board with this motor and these gains; `None` where the
    /// timing is not the board's.
    pub fn simulate_command(&self, tuning: &Tuning) -> Result<Option<String>, Error> {
        if self.timing != Timing::default() {
            return Ok(None);
        }
        let mut tuned = self.board;
        tuned.control = tuning.control;
        let (upward, downward) = directions(&self.board);
        if self.motor != upward && self.motor != downward {
            tuned.first_order.motor_gain_up = self.motor.motor_gain;
            tuned.first_order.motor_gain_down = self.motor.motor_gain;
            tuned.first_order.motor_time_constant_s = self.motor.motor_time_constant_s;
        }
        let mut command = String::from("actuator simulate board");
        if let Some(preset) = &self.preset {
            command += &format!(" --preset {preset}");
        }
        for (name, value) in changes(&self.board, &tuned) {
            command += &format!(" --set {name}={value}");
        }
        Ok(Some(command))
    }
}

/// The board of a preset.
fn board(preset: Option<&str>) -> Result<Settings, Error> {
    let mut settings = Settings::new(ModelKind::Board, PlantKind::FirstOrder);
    if let Some(preset) = preset {
        scenario::apply_preset(&mut settings, preset)?;
    }
    Ok(settings)
}

fn directions(board: &Settings) -> (Motor, Motor) {
    let motor = &board.first_order;
    (Motor::upward(motor), Motor::downward(motor))
}

/// The parameters of `to` that differ from those of `from`, to six digits.
fn changes(from: &Settings, to: &Settings) -> Vec<(&'static str, f64)> {
    let pairs = from.values().zip(to.values());
    let rounded = pairs.map(|(from, to)| (from.value, to.parameter.name, six_digits(to.value)));
    rounded
        .filter(|(from, _, to)| six_digits(*from) != *to)
        .map(|(_, name, value)| (name, value))
        .collect()
}

fn six_digits(value: f64) -> f64 {
    format!("{value:.5e}").parse().unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_found_parameters_are_the_gains_that_a_request_replaces() {
        let names = ControlParameters::TABLE[..FOUND].iter().map(|p| p.symbol);
        assert_eq!(names.collect::<Vec<_>>(), ["P", "Kp", "Ki", "Kaw"]);
    }
}
