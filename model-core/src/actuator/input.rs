//! What a caller commands: an angle, or one of the quantities inside the loops.

use core::ops::RangeInclusive;

use super::kind::{ModelKind, PlantKind};
use crate::named::{Named, named};

/// The commands that an actuator accepts, in the unit of their quantity: the range of the control
/// step's fixed-point format.
pub const COMMAND_RANGE: RangeInclusive<f64> = -32768.0..=32767.0;

/// The load torques that an actuator accepts, Nm: the range of the constant one of the drivetrain.
pub const LOAD_TORQUE_RANGE_NM: RangeInclusive<f64> = -100.0..=100.0;

named! {
    /// Quantity that an actuator is commanded in.
    InputLevel {
        /// Angle of the output shaft, deg: both loops are closed.
        Position = "position",
        /// Rate of the output shaft, deg/s: the rate loop alone is closed.
        Rate = "rate",
        /// Duty of the bridge, %: no loop is closed; it takes effect at the next PWM edge.
        Duty = "duty",
        /// Voltage at the motor's terminals, V, up to the supply: neither loop nor PWM.
        Voltage = "voltage",
    }
}

impl InputLevel {
    /// The unit of its values.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Position => "deg",
            Self::Rate => "deg/s",
            Self::Duty => "%",
            Self::Voltage => "V",
        }
    }

    /// Whether a model has this quantity: a black box has a position command alone, a grey box has
    /// no supply, and of the board's plants only the drivetrain has a winding.
    pub fn is_of(self, model: ModelKind, plant: PlantKind) -> bool {
        match (model, self) {
            (_, Self::Position) => true,
            (ModelKind::BlackBox1 | ModelKind::BlackBox2, _) => false,
            (ModelKind::GreyBox | ModelKind::Board, Self::Rate | Self::Duty) => true,
            (ModelKind::GreyBox, Self::Voltage) => false,
            (ModelKind::Board, Self::Voltage) => plant == PlantKind::Drivetrain,
        }
    }
}

/// A signal to an actuator that it does not accept; the actuator is unchanged.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CommandError {
    /// A command or a torque is out of its range, a motion is not finite, or an inertia is
    /// negative.
    Value,
    /// The model has no such input.
    Level(InputLevel),
}

impl core::fmt::Display for CommandError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Value => f.write_str("the value is out of range, or it is an inertia below zero"),
            Self::Level(level) => write!(
                f,
                "the model has no input `{}`, expected an input that its equations contain",
                level.name()
            ),
        }
    }
}

impl core::error::Error for CommandError {}
