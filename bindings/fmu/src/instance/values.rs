//! Reading and writing of variables.

use super::{BEFORE_STEPPING, Instance, Phase, Pwm, Quantity, Reading, Result, Type};
use super::{Settings, Variable};
use crate::variables::{Inputs, finite, unlimited};
use model_core::actuator::InputLevel;
use model_core::named::Named;
use model_core::parameter::Parameters;

/// The phases in which outputs are valid.
const READABLE: &[Phase] = &[
    Phase::Initialization,
    Phase::Stepping,
    Phase::Event,
    Phase::Continuous,
    Phase::Terminated,
    Phase::Failed,
];

/// The phases in which inputs can be set.
const WRITABLE: &[Phase] = &[
    Phase::Instantiated,
    Phase::Initialization,
    Phase::Stepping,
    Phase::Event,
    Phase::Continuous,
];

/// A value of any type.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Value {
    /// `fmi2Real`.
    Real(f64),
    /// `fmi2Integer`.
    Integer(i32),
    /// `fmi2Boolean`.
    Boolean(bool),
}

impl Value {
    fn of_type(self) -> Type {
        match self {
            Self::Real(_) => Type::Real,
            Self::Integer(_) => Type::Integer,
            Self::Boolean(_) => Type::Boolean,
        }
    }
}

fn of(values: Vec<f64>, index: usize) -> Value {
    Value::Real(values.get(index).copied().unwrap_or_default())
}

/// The writable part of the state.
struct Draft {
    settings: Settings,
    inputs: Inputs,
    level: InputLevel,
}

impl Instance {
    fn variable(&self, reference: u32, of_type: Type) -> Result<&Variable> {
        let variable = usize::try_from(reference).ok();
        let variable = variable.and_then(|index| self.variables.get(index));
        let variable = variable.ok_or_else(|| {
            let last = self.variables.len().saturating_sub(1);
            format!("value reference {reference} is unknown, expected 0 to {last}")
        })?;
        match variable.quantity.of_type() {
            known if known == of_type => Ok(variable),
            known => Err(format!("{} is {known:?}, not {of_type:?}", variable.name).into()),
        }
    }

    /// Reads variables of a type, one after the other, into `take`.
    ///
    /// # Errors
    /// Before the initialization, and for references of another type.
    pub fn read(
        &self,
        of_type: Type,
        references: &[u32],
        mut take: impl FnMut(usize, Value),
    ) -> Result<()> {
        self.expect(READABLE)?;
        for reference in references {
            self.variable(*reference, of_type)?;
        }
        let (settings, now_s) = (&self.state.settings, self.state.time.now_s);
        let reading = match (&self.state.actuator, &self.state.exchange) {
            (Some(actuator), _) => actuator.reading(),
            (None, Some(exchange)) => exchange.reading(settings, now_s),
            (None, None) => Reading::default(),
        };
        for (place, reference) in references.iter().enumerate() {
            let variable = self.variable(*reference, of_type)?;
            take(place, self.value(variable, &reading));
        }
        Ok(())
    }

    fn value(&self, variable: &Variable, reading: &Reading) -> Value {
        let settings = &self.state.settings;
        match variable.quantity {
            Quantity::Output(of) => Value::Real(of(reading)),
            Quantity::Input(parameter) => Value::Real(self.state.inputs.named(parameter)),
            Quantity::State(index) => of(self.evaluation().states, index),
            Quantity::Derivative(index) => of(self.evaluation().derivatives, index),
            Quantity::Indicator(index) => of(self.evaluation().indicators, index),
            Quantity::Level => Value::Integer(self.state.level as i32),
            Quantity::Parameter(parameter) | Quantity::Gain(parameter) => {
                let mut values = settings.values();
                let value = values.find(|v| v.parameter.name == parameter.name);
                Value::Real(finite(value.map_or(parameter.default, |v| v.value)))
            }
            // Seeds are set as positive integers; that of the start values may be larger.
            Quantity::Seed => Value::Integer(settings.seed.try_into().unwrap_or(i32::MAX)),
            Quantity::SwitchedPwm => Value::Boolean(settings.pwm == Pwm::Switched),
        }
    }

    /// Writes variables; if one is refused, none is written.
    ///
    /// # Errors
    /// For references of another type, variables that cannot be written in this phase, and values
    /// out of range; the message names the variable.
    pub fn write(&mut self, values: impl IntoIterator<Item = (u32, Value)>) -> Result<()> {
        self.expect(WRITABLE)?;
        let mut draft = Draft {
            settings: self.state.settings,
            inputs: self.state.inputs,
            level: self.state.level,
        };
        for (reference, value) in values {
            let variable = self.variable(reference, value.of_type())?;
            let is_fixed = matches!(
                variable.quantity,
                Quantity::Parameter(_) | Quantity::Seed | Quantity::SwitchedPwm
            );
            if is_fixed && !BEFORE_STEPPING.contains(&self.state.phase) {
                return Err(format!(
                    "{} is fixed, expected to be set before the end of the initialization",
                    variable.name
                )
                .into());
            }
            let is_of_event = matches!(variable.quantity, Quantity::Gain(_) | Quantity::Level);
            if is_of_event && self.state.phase == Phase::Continuous {
                return Err(format!("{} changes at events only", variable.name).into());
            }
            draft.write(variable, value)?;
        }
        let controller = |settings: &Settings| (settings.control, settings.grey_box);
        if let Some(actuator) = &mut self.state.actuator
            && controller(&draft.settings) != controller(&self.state.settings)
        {
            let tuned = actuator.retune(&draft.settings);
            tuned.map_err(|error| error.to_string())?;
        }
        let now_s = self.state.time.now_s;
        if let Some(exchange) = &mut self.state.exchange {
            if draft.settings.grey_box != self.state.settings.grey_box {
                let checked = draft.settings.grey_box.check();
                checked.map_err(|error| error.to_string())?;
                exchange.retune(&self.state.settings, &draft.settings, now_s);
            }
            if self.state.phase == Phase::Continuous {
                exchange.set_command(now_s, draft.inputs.command(draft.level));
            }
        }
        (self.state.settings, self.state.inputs) = (draft.settings, draft.inputs);
        self.state.level = draft.level;
        Ok(())
    }
}

impl Draft {
    fn write(&mut self, variable: &Variable, value: Value) -> Result<()> {
        let name = variable.name;
        match (variable.quantity, value) {
            (Quantity::Input(_), Value::Real(value)) => {
                let set = self.inputs.set(name, value);
                set.map_err(|error| error.to_string())?;
            }
            (Quantity::Parameter(_) | Quantity::Gain(_), Value::Real(value)) => {
                let set = self.settings.set(name, unlimited(value));
                set.map_err(|error| error.to_string())?;
            }
            (Quantity::Level, Value::Integer(value)) => {
                let (model, plant) = (self.settings.model, self.settings.plant);
                let level = InputLevel::ALL.iter().find(|level| **level as i32 == value);
                let level = level.filter(|level| level.is_of(model, plant));
                self.level = *level.ok_or_else(|| {
                    format!("{name} is {value}, which is no quantity that the model has")
                })?;
            }
            (Quantity::Seed, Value::Integer(value)) => {
                let seed = value.try_into();
                self.settings.seed =
                    seed.map_err(|_| format!("{name} is {value}, expected 0 or more"))?;
            }
            (Quantity::SwitchedPwm, Value::Boolean(is_switched)) => {
                self.settings.pwm = if is_switched {
                    Pwm::Switched
                } else {
                    Pwm::Average
                };
            }
            _ => return Err(format!("{name} is calculated and cannot be set").into()),
        }
        Ok(())
    }
}
