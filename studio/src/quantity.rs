//! The quantities that are displayed and recorded, in the order of their columns.

use host_sim::can::telemetry::Telemetry;
use serde::Serialize;

use crate::core::Core;

/// A quantity of the telemetry.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Quantity {
    /// Its short name in the messages to the page.
    pub key: &'static str,
    /// Its name on the page.
    pub label: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// Name of its column in a file.
    pub column: &'static str,
    /// Units of the column in one of the quantity.
    #[serde(skip)]
    pub column_scale: f64,
    /// Start of the column's name in the telemetry.
    #[serde(skip)]
    source: &'static str,
    /// Factor from the unit of the telemetry.
    #[serde(skip)]
    scale: f64,
}

const fn quantity(
    key: &'static str,
    label: &'static str,
    unit: &'static str,
    column: &'static str,
    source: &'static str,
    scale: f64,
) -> Quantity {
    Quantity {
        key,
        label,
        unit,
        column,
        column_scale: 1.0,
        source,
        scale,
    }
}

/// Number of quantities.
pub const COUNT: usize = 8;

/// All quantities.
pub const ALL: [Quantity; COUNT] = [
    quantity("angle", "Angle", "deg", "angle_deg", "angle", 1.0),
    quantity("demand", "Demand", "deg", "command_deg", "command_deg", 1.0),
    quantity("rate", "Rate", "deg/s", "rate_deg_s", "angular_rate", 1.0),
    quantity(
        "current",
        "Motor current",
        "mA",
        "current_ma",
        "motor_current",
        1.0,
    ),
    quantity("back_emf", "Back-EMF", "V", "back_emf_v", "back_emf", 1e-3),
    quantity("duty", "Duty", "%", "duty_pct", "motor_duty", 1.0),
    quantity("supply", "Supply", "V", "supply_v", "dc_link", 1e-3),
    quantity(
        "temperature",
        "Temperature",
        "degC",
        "temperature_degc",
        "board_temperature",
        1.0,
    ),
];

/// Those of servos: their columns are those of `host_sim::servo_bus::client::COLUMNS`.
pub const SERVO: [Quantity; COUNT - 1] = [
    quantity("angle", "Angle", "deg", "angle_deg", "", 1.0),
    quantity("demand", "Goal", "deg", "command_deg", "", 1.0),
    quantity("rate", "Rate", "deg/s", "rate_deg_s", "", 1.0),
    quantity("current", "Current", "mA", "current_ma", "", 1.0),
    quantity("duty", "Duty", "%", "duty_pct", "", 1.0),
    Quantity {
        column_scale: 1e3,
        ..quantity("supply", "Supply", "V", "supply_mv", "", 1.0)
    },
    quantity(
        "temperature",
        "Temperature",
        "degC",
        "temperature_degc",
        "",
        1.0,
    ),
];

/// Those of the samples of this bus.
pub fn of(core: &Core) -> &'static [Quantity] {
    match core.servos {
        Some(_) => &SERVO,
        None => &ALL,
    }
}

/// Places of quantities of actuators that the program itself uses.
pub mod place {
    /// The angle.
    pub const ANGLE: usize = 0;
    /// The demand.
    pub const DEMAND: usize = 1;
    /// The rate.
    pub const RATE: usize = 2;
    /// The current.
    pub const CURRENT: usize = 3;
    /// The back-EMF.
    pub const BACK_EMF: usize = 4;
    /// The duty.
    pub const DUTY: usize = 5;
    /// The supply voltage.
    pub const SUPPLY: usize = 6;
}

/// The last value of each quantity; NaN where the actuator does not send it.
pub fn values(telemetry: &Telemetry) -> [f32; COUNT] {
    ALL.map(|quantity| {
        let value = telemetry.value(quantity.source);
        value.map_or(f32::NAN, |value| (value * quantity.scale) as f32)
    })
}

#[cfg(test)]
mod tests {
    use host_sim::servo_bus::client::COLUMNS;

    use super::*;

    #[test]
    fn each_quantity_of_a_servo_is_a_column_of_a_recording() {
        for quantity in SERVO {
            let is_column = |(name, _): &(&str, &[&str])| *name == quantity.column;
            assert!(COLUMNS.iter().any(is_column), "{}", quantity.column);
        }
    }
}
