//! The variables of a model: inputs, outputs, and every parameter of its tables.

use model_core::actuator::{
    COMMAND_RANGE, InputLevel, LOAD_TORQUE_RANGE_NM, ModelKind, PlantKind, Reading, Settings,
};
use model_core::control::parameters::ControlParameters;
use model_core::parameter::{Parameter, Parameters};

use crate::exchange::equations::Equations;

/// The quantity of a variable.
#[derive(Debug, Clone, Copy)]
pub enum Quantity {
    /// An input, held from one communication point to the next.
    Input(&'static Parameter),
    /// An output of the actuator.
    Output(fn(&Reading) -> f64),
    /// A continuous state, by its index.
    State(usize),
    /// The derivative of the state of this index.
    Derivative(usize),
    /// The event indicator of this index.
    Indicator(usize),
    /// The quantity of the command: the index of an [`InputLevel`].
    Level,
    /// A parameter, fixed from the end of the initialization on.
    Parameter(&'static Parameter),
    /// A parameter of the controller, which may change at any communication point.
    Gain(&'static Parameter),
    /// The seed of the noise.
    Seed,
    /// Whether the switching of the bridge is simulated.
    SwitchedPwm,
}

/// The FMI types of the variables.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Type {
    /// `fmi2Real`.
    Real,
    /// `fmi2Integer`.
    Integer,
    /// `fmi2Boolean`.
    Boolean,
}

/// A variable. Its value reference is its index in the list.
#[derive(Debug, Clone, Copy)]
pub struct Variable {
    /// Its name, with the unit as its suffix if the unit is simple.
    pub name: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// Its meaning, in a sentence.
    pub meaning: &'static str,
    /// Its quantity.
    pub quantity: Quantity,
}

impl Quantity {
    /// Its type.
    pub fn of_type(self) -> Type {
        match self {
            Self::Seed | Self::Level => Type::Integer,
            Self::SwitchedPwm => Type::Boolean,
            _ => Type::Real,
        }
    }
}

const fn variable(
    name: &'static str,
    unit: &'static str,
    meaning: &'static str,
    quantity: Quantity,
) -> Variable {
    Variable {
        name,
        unit,
        meaning,
        quantity,
    }
}

model_core::parameters! {
    /// The inputs.
    pub struct Inputs {
        /// Commanded angle.
        command_deg [""]: 0.0, "deg", *COMMAND_RANGE.start(), *COMMAND_RANGE.end(), "the range of the control step's fixed-point format";
        /// Commanded rate, where input_level is 1.
        command_rate_deg_s [""]: 0.0, "deg/s", *COMMAND_RANGE.start(), *COMMAND_RANGE.end(), "the range of the control step's fixed-point format";
        /// Commanded duty of the bridge, where input_level is 2.
        command_duty_pct [""]: 0.0, "%", -100.0, 100.0, "the whole bridge";
        /// Commanded voltage at the motor's terminals, up to the supply, where input_level is 3.
        command_v [""]: 0.0, "V", -1000.0, 1000.0, "beyond every supply";
        /// Torque on the load, from the next tick on.
        load_torque_nm [""]: 0.0, "Nm", *LOAD_TORQUE_RANGE_NM.start(), *LOAD_TORQUE_RANGE_NM.end(), "the range of the parameter of this name, which the input stands in for";
        /// Inertia that moves with the load in addition to load_inertia_kg_m2, from the next tick
        /// on.
        added_inertia_kg_m2 [""]: 0.0, "kg m^2", 0.0, 1000.0, "none; a tonne at a metre";
    }
}

/// A value as hosts see it: infinity, an unlimited parameter, is the largest number.
pub fn finite(value: f64) -> f64 {
    value.clamp(f64::MIN, f64::MAX)
}

/// The value of a parameter that a host sets: the largest number is infinity.
pub fn unlimited(value: f64) -> f64 {
    match value.abs() == f64::MAX {
        true => f64::INFINITY.copysign(value),
        false => value,
    }
}

impl Inputs {
    /// The default inputs: the torque is that of the parameters.
    pub fn at_start(settings: &Settings) -> Self {
        Self {
            load_torque_nm: settings.drivetrain.load.load_torque_nm,
            ..Self::default()
        }
    }

    /// The command in a quantity.
    pub fn command(&self, level: InputLevel) -> f64 {
        match level {
            InputLevel::Position => self.command_deg,
            InputLevel::Rate => self.command_rate_deg_s,
            InputLevel::Duty => self.command_duty_pct,
            InputLevel::Voltage => self.command_v,
        }
    }

    /// Whether a model and its plant have an input.
    fn has(parameter: &Parameter, settings: &Settings) -> bool {
        let level = match parameter.name {
            "command_deg" => InputLevel::Position,
            "command_rate_deg_s" => InputLevel::Rate,
            "command_duty_pct" => InputLevel::Duty,
            "command_v" => InputLevel::Voltage,
            // The load of the bench.
            _ => return is_bench(settings),
        };
        level.is_of(settings.model, settings.plant)
    }

    /// The value of an input.
    pub fn named(&self, parameter: &Parameter) -> f64 {
        let index = Self::TABLE.iter().position(|p| p.name == parameter.name);
        let value = index.and_then(|index| self.get(index));
        value.unwrap_or(parameter.default)
    }
}

/// The outputs of every model, named as the columns of `actuator simulate`.
const OUTPUTS: [Variable; 5] = [
    variable(
        "angle_deg",
        "deg",
        "Angle of the output shaft.",
        Quantity::Output(|r| r.angle_deg),
    ),
    variable(
        "rate_deg_s",
        "deg/s",
        "Rate of the output shaft.",
        Quantity::Output(|r| r.rate_deg_s),
    ),
    variable(
        "duty_pct",
        "%",
        "Duty of the bridge; 0 for a model that has none.",
        Quantity::Output(|r| r.duty_pct),
    ),
    variable(
        "angle_meas_deg",
        "deg",
        "Angle that the board measured last; the true one for a model that measures nothing.",
        Quantity::Output(|r| r.angle_meas_deg),
    ),
    variable(
        "rate_meas_deg_s",
        "deg/s",
        "Rate that the board estimated last; the true one for a model that measures nothing.",
        Quantity::Output(|r| r.rate_meas_deg_s),
    ),
];

const BENCH_OUTPUTS: [Variable; 2] = [
    variable(
        "current_a",
        "A",
        "Motor current.",
        Quantity::Output(|r| r.current_a),
    ),
    variable(
        "back_emf_v",
        "V",
        "Back-EMF of the motor.",
        Quantity::Output(|r| r.back_emf_v),
    ),
];

const STATES: [Variable; 3] = [
    variable(
        "state_angle_deg",
        "deg",
        "Continuous state: the angle.",
        Quantity::State(0),
    ),
    variable(
        "state_rate_deg_s",
        "deg/s",
        "Continuous state: the rate before a limit that follows it.",
        Quantity::State(1),
    ),
    variable(
        "state_integral_pct",
        "%",
        "Continuous state: the integrator of the rate loop.",
        Quantity::State(2),
    ),
];

const DERIVATIVES: [Variable; 3] = [
    variable(
        "derivative_angle_deg_s",
        "deg/s",
        "Derivative of the angle.",
        Quantity::Derivative(0),
    ),
    variable(
        "derivative_rate_deg_s2",
        "deg/s^2",
        "Derivative of the rate.",
        Quantity::Derivative(1),
    ),
    variable(
        "derivative_integral_pct_s",
        "%/s",
        "Derivative of the integrator.",
        Quantity::Derivative(2),
    ),
];

/// The event indicators: those of the hard stops, then those of the other limits.
const INDICATORS: [Variable; 7] = {
    const fn indicator(name: &'static str, meaning: &'static str, index: usize) -> Variable {
        variable(name, "1", meaning, Quantity::Indicator(index))
    }
    const LIMIT: &str = "Event indicator of a limit of rate or duty.";
    [
        indicator(
            "event_upper_stop",
            "Event indicator of the upper hard stop.",
            0,
        ),
        indicator(
            "event_lower_stop",
            "Event indicator of the lower hard stop.",
            1,
        ),
        indicator("event_limit_1", LIMIT, 2),
        indicator("event_limit_2", LIMIT, 3),
        indicator("event_limit_3", LIMIT, 4),
        indicator("event_limit_4", LIMIT, 5),
        indicator("event_limit_5", LIMIT, 6),
    ]
};

const BOARD_SWITCHES: [Variable; 2] = [
    variable("seed", "1", "Seed of all that is random.", Quantity::Seed),
    variable(
        "pwm_switched",
        "1",
        "Whether the bridge switches within each PWM period; else it gives the mean voltage.",
        Quantity::SwitchedPwm,
    ),
];

const LEVEL: Variable = variable(
    "input_level",
    "1",
    "Quantity of the command: 0 angle, 1 rate, 2 duty, 3 voltage (bench only).",
    Quantity::Level,
);

fn is_bench(settings: &Settings) -> bool {
    (settings.model, settings.plant) == (ModelKind::Board, PlantKind::Drivetrain)
}

/// Parameters of the grey box's controller; the others are those of its motor.
const GREY_BOX_GAINS: [&str; 6] = [
    "proportional_gain",
    "integral_gain",
    "position_gain",
    "anti_windup_gain",
    "rate_anti_windup_gain",
    "duty_limit_pct",
];

/// Whether a model accepts another value of the parameter while it runs. Zero and direction of the
/// board's encoder would change what its angle means.
fn is_gain(model: ModelKind, parameter: &Parameter) -> bool {
    let is_it = |p: &Parameter| p.name == parameter.name;
    match model {
        ModelKind::Board => {
            ControlParameters::TABLE.iter().any(is_it) && !parameter.name.starts_with("encoder_")
        }
        ModelKind::GreyBox => GREY_BOX_GAINS.contains(&parameter.name),
        ModelKind::BlackBox1 | ModelKind::BlackBox2 => false,
    }
}

/// The variables of a model and plant, in the order of their value references. They do not depend
/// on the values of the parameters.
///
/// ```
/// use actuator_fmu::variables;
/// use model_core::actuator::{COMMAND_RANGE, InputLevel, LOAD_TORQUE_RANGE_NM, ModelKind, PlantKind, Settings};
///
/// let list = variables::of(&Settings::new(ModelKind::Board, PlantKind::FirstOrder));
/// assert_eq!(list[0].name, "command_deg");
/// assert_eq!(list.iter().position(|v| v.name == "angle_deg"), Some(4));
/// ```
pub fn of(settings: &Settings) -> Vec<Variable> {
    let is_board = settings.model == ModelKind::Board;
    let is_bench = is_bench(settings);
    let inputs = Inputs::TABLE.iter().filter(|p| Inputs::has(p, settings));
    let mut list: Vec<_> = inputs
        .map(|p| variable(p.name, p.unit, p.meaning, Quantity::Input(p)))
        .collect();
    if InputLevel::Duty.is_of(settings.model, settings.plant) {
        list.push(LEVEL);
    }
    list.extend(OUTPUTS);
    list.extend(BENCH_OUTPUTS.iter().filter(|_| is_bench));
    let parameters = settings.values().map(|value| value.parameter);
    let parameters = parameters.filter(|p| Inputs::TABLE.iter().all(|input| input.name != p.name));
    list.extend(parameters.map(|p| {
        let quantity = match is_gain(settings.model, p) {
            true => Quantity::Gain(p),
            false => Quantity::Parameter(p),
        };
        variable(p.name, p.unit, p.meaning, quantity)
    }));
    list.extend(BOARD_SWITCHES.iter().filter(|_| is_board));
    if let Some(equations) = Equations::of(settings) {
        list.extend(&STATES[..equations.states()]);
        list.extend(&DERIVATIVES[..equations.states()]);
        list.extend(&INDICATORS[..equations.indicator_count()]);
    }
    list
}

/// Refuses references of variables that a host cannot read within a step: all but outputs.
///
/// # Errors
/// Names the variable.
pub fn only_outputs(variables: &[Variable], references: &[u32]) -> Result<(), String> {
    for reference in references {
        let variable = variables.get(*reference as usize);
        if !matches!(variable.map(|v| v.quantity), Some(Quantity::Output(_))) {
            let name = variable.map_or("unknown", |v| v.name);
            return Err(format!(
                "the required intermediate variable {reference} is {name}, expected an output"
            ));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use model_core::scenario;
    use std::collections::BTreeSet;

    #[test]
    fn no_two_variables_of_a_model_share_a_name() {
        for settings in scenario::choices() {
            let list = of(&settings);
            let names: BTreeSet<_> = list.iter().map(|variable| variable.name).collect();
            assert_eq!(names.len(), list.len());
        }
    }

    #[test]
    fn only_the_bench_takes_a_load_and_shows_a_current() {
        for settings in scenario::choices() {
            let list = of(&settings);
            let has = |name| list.iter().any(|variable| variable.name == name);
            let is_bench =
                (settings.model, settings.plant) == (ModelKind::Board, PlantKind::Drivetrain);
            assert_eq!(has("load_torque_nm"), is_bench);
            assert_eq!(has("added_inertia_kg_m2"), is_bench);
            assert_eq!(has("current_a"), is_bench);
        }
    }
}
