//! What servos measure, as columns of a recording.

use servo_bus::{Register, Table};

use super::angle_deg;

/// Columns of a recording, and the registers that may have their values.
pub const COLUMNS: [(&str, &[&str]); 7] = [
    ("command_deg", &["goal_position"]),
    ("angle_deg", &["present_position"]),
    ("rate_deg_s", &["present_velocity"]),
    ("duty_pct", &["present_load", "present_pwm"]),
    ("current_ma", &["present_current"]),
    ("supply_mv", &["present_voltage", "present_input_voltage"]),
    ("temperature_degc", &["present_temperature"]),
];

/// Columns of a model, which one read of adjacent bytes has.
#[derive(Debug, Clone)]
pub struct Columns {
    table: &'static Table,
    columns: Vec<(&'static str, &'static Register)>,
    /// First address of the bytes.
    pub first: u16,
    /// Number of the bytes.
    pub length: u8,
}

impl Columns {
    /// Those of [`COLUMNS`] that this model has and whose name is wanted.
    pub fn of(table: &'static Table, is_wanted: impl Fn(&str) -> bool) -> Self {
        let find = |names: &[&str]| names.iter().find_map(|name| table.register(name));
        let wanted = COLUMNS.iter().filter(|(column, _)| is_wanted(column));
        let columns: Vec<_> = wanted
            .filter_map(|(column, names)| Some((*column, find(names)?)))
            .collect();
        let fields = || columns.iter().map(|(_, register)| register.field);
        let first = fields().map(|field| field.address).min().unwrap_or(0);
        let ends = fields().map(|field| field.address + u16::from(field.size));
        let length = ends.max().unwrap_or(first) - first;
        Self {
            table,
            first,
            length: length as u8,
            columns,
        }
    }

    /// The names of the columns.
    pub fn names(&self) -> impl Iterator<Item = &'static str> {
        self.columns.iter().map(|(column, _)| *column)
    }

    /// The values of these bytes, in the units of the columns.
    pub fn values(&self, bytes: &[u8]) -> impl Iterator<Item = f64> {
        let columns = self.columns.iter();
        columns.map(|(_, register)| self.value(register, bytes))
    }

    fn value(&self, register: &Register, bytes: &[u8]) -> f64 {
        let field = register.field;
        let start = usize::from(field.address - self.first);
        let bytes = bytes.get(start..start + usize::from(field.size));
        let value = f64::from(field.decode(bytes.unwrap_or_default(), self.table.order));
        let (number, unit) = register
            .unit
            .split_once(' ')
            .unwrap_or(("1", register.unit));
        let value_of_one: f64 = number.parse().unwrap_or(1.0);
        let step_deg = angle_deg(self.table, 1.0) - angle_deg(self.table, 0.0);
        match unit {
            _ if register.name.ends_with("position") => angle_deg(self.table, value),
            "V" => value * value_of_one * 1e3,
            "rev/min" => value * value_of_one * 6.0,
            "steps/s" => value * step_deg,
            _ => value * value_of_one,
        }
    }
}
