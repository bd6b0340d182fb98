//! Registers by name, and angles.

use servo_bus::{Order, Register, Table};

use super::ServoError;
use crate::error::Error;

/// The register of a table with this name, in any case and with hyphens or underscores.
///
/// # Errors
/// For an unknown name.
pub fn register(table: &'static Table, name: &str) -> Result<&'static Register, Error> {
    let wanted = name.trim().to_lowercase().replace(['-', ' '], "_");
    table.register(&wanted).ok_or_else(|| {
        let names = table.registers.iter().map(|register| register.name);
        let expected = format!("a register of the model {}; `get` lists them", table.name);
        Error::unknown("register", &wanted, names, expected)
    })
}

/// The value of a text for a register.
///
/// # Errors
/// For a text that is not an integer in the range, or a register that cannot be written.
pub fn value(register: &'static Register, text: &str) -> Result<i32, ServoError> {
    if !register.is_writable {
        return Err(ServoError::ReadOnly(register.name));
    }
    let (min, max) = (register.min, register.max);
    let value = text
        .trim()
        .parse()
        .ok()
        .filter(|value| (min..=max).contains(value));
    value.ok_or_else(|| ServoError::Value {
        name: register.name,
        value: text.trim().to_owned(),
        min,
        max,
        unit: register.unit,
    })
}

/// Angle of a position, deg: 0 in the middle.
pub fn angle_deg(table: &Table, position: f64) -> f64 {
    let (middle, step_deg) = scale(table);
    (position - middle) * step_deg
}

/// Position of an angle.
pub fn position(table: &Table, angle_deg: f64) -> f64 {
    let (middle, step_deg) = scale(table);
    middle + angle_deg / step_deg
}

/// Position in the middle, and angle of a step. The potentiometer of the SCS0009 turns 300 deg.
fn scale(table: &Table) -> (f64, f64) {
    match table.order {
        Order::Little => (2048.0, 360.0 / 4096.0),
        Order::Big => (512.0, 300.0 / 1024.0),
    }
}
