//! Errors of a client.

use std::io;

/// Why a request to a servo failed.
#[derive(Debug, thiserror::Error)]
pub enum ServoError {
    /// The bus cannot be opened or used.
    #[error("bus {bus}: {source}")]
    Bus {
        /// Its name.
        bus: String,
        /// The error of the operating system.
        source: io::Error,
    },
    /// The name of a bus has an invalid bit rate.
    #[error("bus {0}: expected sts:PORT or dxl:PORT, of which PORT may end in @ and a bit rate")]
    Name(String),
    /// A servo does not answer.
    #[error("servo {0} does not answer")]
    NoAnswer(u8),
    /// A value that a register cannot have.
    #[error("{name} is {value}, expected {min} to {max}{}", in_units(unit))]
    Value {
        /// The register.
        name: &'static str,
        /// The value.
        value: String,
        /// Least value.
        min: i32,
        /// Greatest value.
        max: i32,
        /// Unit of one.
        unit: &'static str,
    },
    /// A goal was not reached in time.
    #[error("servo {id} is at {angle_deg:.1} deg, expected {goal_deg} deg to be reached")]
    NotReached {
        /// The servo.
        id: u8,
        /// Its angle, deg.
        angle_deg: f64,
        /// The goal, deg.
        goal_deg: f64,
    },
    /// The operating mode has no absolute position.
    #[error("servo {id} has operating_mode {mode}, expected one with angles: {expected}")]
    Mode {
        /// The servo.
        id: u8,
        /// The mode.
        mode: i32,
        /// The modes that have one.
        expected: &'static str,
    },
    /// It does not answer writes.
    #[error("servo {id} has {name} {level}, expected {expected}: it does not answer writes")]
    Silent {
        /// The servo.
        id: u8,
        /// The register.
        name: &'static str,
        /// Its value.
        level: i32,
        /// That with which it does.
        expected: i32,
    },
    /// A register that only the servo writes.
    #[error("{0} is read only")]
    ReadOnly(&'static str),
    /// A register that the model lacks.
    #[error("{model} has no register {name}")]
    Lacks {
        /// The model.
        model: &'static str,
        /// The register.
        name: &'static str,
    },
    /// The servo has refused.
    #[error("servo {id} refuses {what}: error {error}{}", in_words(*error))]
    Refused {
        /// The servo.
        id: u8,
        /// The request.
        what: String,
        /// The error number of Dynamixel's protocol.
        error: u8,
    },
}

/// The meaning of an error number of Dynamixel's protocol 2.0.
fn in_words(error: u8) -> &'static str {
    match error {
        1 => ", the instruction failed",
        2 => ", unknown instruction",
        3 => ", wrong checksum",
        4 => ", value out of range",
        5 => ", wrong length",
        6 => ", value beyond the limit in another register",
        7 => ", not writable now (EEPROM only with the torque off)",
        _ => "",
    }
}

/// A unit behind a value; nothing without one.
pub fn in_units(unit: &str) -> String {
    if unit.is_empty() {
        String::new()
    } else {
        format!(" in units of {unit}")
    }
}
