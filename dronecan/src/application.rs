//! The interface between the node and its actuator.

use core::task::Poll;

/// Kind and value of a command (`uavcan.equipment.actuator.Command`).
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Target {
    /// A share of the travel, -1 to 1.
    Unitless(f32),
    /// An angle, rad.
    Position(f32),
    /// A torque, N m.
    Force(f32),
    /// A rate, rad/s.
    Speed(f32),
    /// Width of a servo pulse, us.
    PulseWidth(f32),
}

impl Target {
    /// The target of a type of command; `None` for a type that the standard does not have.
    pub(crate) const fn new(kind: u8, value: f32) -> Option<Self> {
        Some(match kind {
            0 => Self::Unitless(value),
            1 => Self::Position(value),
            2 => Self::Force(value),
            3 => Self::Speed(value),
            4 => Self::PulseWidth(value),
            _ => return None,
        })
    }

    /// Whether the command releases the actuator: not a number, or a pulse of no width.
    ///
    /// ```
    /// use dronecan::Target;
    /// assert!(Target::Unitless(f32::NAN).is_release() && Target::PulseWidth(0.0).is_release());
    /// assert!(!Target::Unitless(0.0).is_release());
    /// ```
    #[must_use]
    pub fn is_release(self) -> bool {
        match self {
            Self::PulseWidth(value) => value.is_nan() || value == 0.0,
            Self::Unitless(value)
            | Self::Position(value)
            | Self::Force(value)
            | Self::Speed(value) => value.is_nan(),
        }
    }
}

/// The value of a parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Value {
    /// An integer.
    Integer(i64),
    /// A real number.
    Real(f32),
}

/// A parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameter {
    /// Its present value.
    pub value: Value,
    /// Its default.
    pub default: Value,
    /// Its least and its greatest value.
    pub range: Option<(Value, Value)>,
    /// Its name.
    pub name: &'static str,
}

/// An operation on all parameters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Opcode {
    /// Store them.
    Save,
    /// Store the defaults.
    Erase,
}

/// Health of the node.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(u8)]
pub enum Health {
    /// Nothing is wrong.
    #[default]
    Ok = 0,
    /// A minor failure.
    Warning = 1,
    /// A major failure.
    Error = 2,
    /// It cannot work.
    Critical = 3,
}

/// Mode of the node.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(u8)]
pub enum Mode {
    /// Normal operation.
    #[default]
    Operational = 0,
    /// After the start.
    Initialisation = 1,
    /// A program is being received or installed.
    SoftwareUpdate = 3,
}

/// State of the node.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Status {
    /// Health.
    pub health: Health,
    /// Mode.
    pub mode: Mode,
    /// A code of the maker.
    pub code: u16,
}

/// What the node is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Identity {
    /// Version of the program, major and minor.
    pub software: (u8, u8),
    /// Version of the hardware, major and minor.
    pub hardware: (u8, u8),
    /// Name of the product.
    pub name: &'static str,
}

/// What the actuator measures.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Telemetry {
    /// Number of the actuator among those that one message commands.
    pub actuator_id: u8,
    /// Angle, rad.
    pub position_rad: f32,
    /// Torque, N m.
    pub torque_nm: f32,
    /// Rate, rad/s.
    pub rate_rad_s: f32,
    /// Load, percent of the rated one.
    pub load_pct: u8,
    /// Supply voltage, V.
    pub supply_v: f32,
    /// Motor current, A.
    pub current_a: f32,
    /// Flags of the circuit's errors.
    pub circuit_errors: u8,
    /// Temperature, K.
    pub temperature_k: f32,
    /// Whether it is too hot.
    pub is_overheated: bool,
}

/// Errors of a circuit, [`Telemetry::circuit_errors`].
pub mod circuit {
    /// The voltage is too high.
    pub const OVER_VOLTAGE: u8 = 1;
    /// The voltage is too low.
    pub const UNDER_VOLTAGE: u8 = 2;
    /// The current is too high.
    pub const OVER_CURRENT: u8 = 4;
}

/// Severity of a log message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Level {
    /// An event.
    Info = 1,
    /// An error.
    Error = 3,
}

/// The actuator behind the node.
pub trait Application {
    /// The unique identifier of the hardware.
    fn unique_id(&self) -> [u8; 16];

    /// What the node is.
    fn identity(&self) -> Identity;

    /// State of the node.
    fn status(&self) -> Status;

    /// What the actuator measures.
    fn telemetry(&self) -> Telemetry;

    /// A command to the actuator of this number.
    fn command(&mut self, actuator_id: u8, target: Target);

    /// Index of the parameter of a name.
    fn find(&self, name: &[u8]) -> Option<u16>;

    /// The parameter of an index.
    fn parameter(&mut self, index: u16) -> Option<Parameter>;

    /// Sets the parameter of an index; one that is refused keeps its value.
    fn set(&mut self, index: u16, value: Value);

    /// Executes an operation: called again and again until it is ready, with its success.
    fn perform(&mut self, opcode: Opcode) -> Poll<bool>;

    /// A program is about to be downloaded.
    ///
    /// # Errors
    /// Why this is not possible now.
    fn begin_update(&mut self) -> Result<(), &'static str>;

    /// The next bytes of the program; returns whether they are accepted.
    fn write_update(&mut self, offset: u32, bytes: &[u8]) -> bool;

    /// All bytes of the program are there; returns whether it can be installed.
    fn end_update(&mut self, size: u32) -> bool;

    /// The download has ended early.
    fn cancel_update(&mut self);

    /// A text for the log, written to `text`: its severity and length, once.
    fn take_log(&mut self, text: &mut [u8; 32]) -> Option<(Level, usize)>;
}
