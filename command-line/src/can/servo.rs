//! `scan`, `get`, `set`, `move`, `stop`, `monitor` and `record` of servos on a serial bus.

use std::sync::atomic::Ordering;
use std::thread;
use std::time::{Duration, Instant};

use host_sim::can::client::ClientError;
use host_sim::servo_bus::client::{
    Client, ServoError, angle_deg, in_units, position, register, value,
};
use host_sim::table::{Cell, Table};
use serde_json::json;
use servo_bus::Register;

use super::objects::pair;
use super::print_json;
use super::record::Sink;
use crate::error::Error;
use crate::interrupt;
use crate::output::{print, print_table};

/// Requests in turn without an answer that end a recording.
const MOST_LOST: u64 = 10;

/// Deviation from a goal that is reached, deg: ten steps of the encoder.
const REACHED_DEG: f64 = 1.0;

/// Time between two looks at the position.
const LOOK: Duration = Duration::from_millis(20);

/// A servo and its control table.
pub struct Servo {
    client: Client,
    id: u8,
    table: &'static servo_bus::Table,
}

/// Columns of a recording: the name, the registers that may have it, and the value of one in its
/// unit.
const COLUMNS: [(&str, &[&str]); 6] = [
    ("command_deg", &["goal_position"]),
    ("angle_deg", &["present_position"]),
    ("rate_deg_s", &["present_velocity"]),
    ("duty_pct", &["present_load", "present_pwm"]),
    ("current_ma", &["present_current"]),
    ("supply_mv", &["present_voltage", "present_input_voltage"]),
];

/// Lists the servos of a bus.
pub fn scan(client: &mut Client, json: bool) -> Result<(), Error> {
    let found = client.scan()?;
    if json {
        let servos = found
            .iter()
            .map(|(id, table)| json!({"id": id, "model": table.name}));
        return print_json(&servos.collect());
    }
    let mut table = Table::new("", &[("servo", ""), ("model", "")]);
    for (id, model) in found {
        table.push([
            Cell::Number(id.into(), 0),
            Cell::Text(model.name.to_owned()),
        ]);
    }
    print_table(&table)
}

impl Servo {
    /// The servo with this ID.
    ///
    /// # Errors
    /// Without an answer; those of the bus.
    pub fn find(mut client: Client, id: u8) -> Result<Self, Error> {
        let table = client.table(id)?;
        Ok(Self { client, id, table })
    }

    fn register(&self, name: &str) -> Result<&'static Register, Error> {
        Ok(register(self.table, name)?)
    }

    /// Prints registers; without names all.
    ///
    /// # Errors
    /// For an unknown name; those of the bus.
    pub fn get(&mut self, names: &[String], json: bool) -> Result<(), Error> {
        let registers: Vec<&Register> = if names.is_empty() {
            self.table.registers.iter().collect()
        } else {
            let found = names.iter().map(|name| self.register(name));
            found.collect::<Result<_, _>>()?
        };
        let mut values = Vec::new();
        for register in registers {
            values.push((
                register,
                self.client.read(self.id, self.table, register.field)?,
            ));
        }
        if json {
            let object = values
                .iter()
                .map(|(register, value)| (register.name.to_owned(), json!(value)));
            return print_json(&serde_json::Value::Object(object.collect()));
        }
        if let [(register, value)] = values[..] {
            return print(&format!("{value}{}\n", in_units(register.unit)));
        }
        let columns = [
            ("register", ""),
            ("address", ""),
            ("value", ""),
            ("unit of one", ""),
        ];
        let mut table = Table::new("", &columns);
        for (register, value) in values {
            table.push([
                Cell::Text(register.name.to_owned()),
                Cell::Number(register.field.address.into(), 0),
                Cell::Text(value.to_string()),
                Cell::Text(register.unit.to_owned()),
            ]);
        }
        print_table(&table)
    }

    /// Writes registers, after all have been checked.
    ///
    /// # Errors
    /// For an unknown name or an invalid value; those of the bus and the servo.
    pub fn set(&mut self, values: &[String], json: bool) -> Result<(), Error> {
        let writes = values.iter().map(|text| {
            let (name, text) = pair(text)?;
            let register = self.register(name)?;
            Ok((register, value(register, text)?))
        });
        let writes = writes.collect::<Result<Vec<_>, Error>>()?;
        for (register, value) in &writes {
            self.write(register, *value)?;
        }
        if json {
            let written: Vec<_> = writes.iter().map(|(register, _)| register.name).collect();
            print_json(&json!({ "written": written }))?;
        }
        Ok(())
    }

    fn write(&mut self, register: &Register, value: i32) -> Result<(), Error> {
        self.client.write(self.id, self.table, register, value)?;
        if register.name == "id" {
            self.id = value as u8;
        }
        Ok(())
    }

    /// Turns to an angle, and returns that which is reached within this time; without a time, the
    /// present one. The servo stops if it is not reached or the program is interrupted.
    ///
    /// # Errors
    /// For an angle beyond the limits, or an operating mode without angles; those of the bus and
    /// the servo; if it is not reached.
    pub fn turn_to(&mut self, goal_deg: f64, within: Option<Duration>) -> Result<f64, Error> {
        let goal = self.register("goal_position")?;
        let wanted = position(self.table, goal_deg).round();
        let wanted = value(goal, &wanted.to_string())?;
        self.require_angles()?;
        self.write(self.register("torque_enable")?, 1)?;
        self.write(goal, wanted)?;
        let Some(within) = within else {
            return self.angle_deg();
        };
        let arrived = self.arrive(goal_deg, within);
        if arrived.is_err() {
            // Its error is more informative than that of the halt.
            let _ = self.halt();
        }
        arrived
    }

    fn arrive(&mut self, goal_deg: f64, within: Duration) -> Result<f64, Error> {
        let (id, start, stop) = (self.id, Instant::now(), interrupt::stop()?);
        while !stop.load(Ordering::Relaxed) {
            let angle_deg = self.angle_deg()?;
            if (angle_deg - goal_deg).abs() < REACHED_DEG {
                return Ok(angle_deg);
            }
            if start.elapsed() > within {
                let late = ServoError::NotReached {
                    id,
                    angle_deg,
                    goal_deg,
                };
                return Err(late.into());
            }
            thread::sleep(LOOK);
        }
        Err(ClientError::Interrupted.into())
    }

    /// Ends the motion: by a goal of 0, or the present position as the goal.
    ///
    /// # Errors
    /// Those of the bus and the servo.
    pub fn halt(&mut self) -> Result<(), Error> {
        let (goal, value) = match (self.is_dynamixel(), self.mode()?) {
            (_, 1) => ("goal_velocity", 0),
            (false, 2) => ("goal_time", 0),
            // An increment is added to the goal, and the position is the way that is left.
            (false, 3) => ("goal_position", -self.read("present_position")?),
            (true, 0) => ("goal_current", 0),
            (true, 16) => ("goal_pwm", 0),
            _ => ("goal_position", self.read("present_position")?),
        };
        self.write(self.register(goal)?, value)
    }

    fn require_angles(&mut self) -> Result<(), Error> {
        let (modes, expected) = match self.is_dynamixel() {
            true => (3..=5, "3, 4 or 5"),
            false => (0..=0, "0"),
        };
        let (id, mode) = (self.id, self.mode()?);
        if modes.contains(&mode) {
            return Ok(());
        }
        Err(ServoError::Mode { id, mode, expected }.into())
    }

    /// The operating mode; an SCS0009 only has that of the position.
    fn mode(&mut self) -> Result<i32, Error> {
        match self.table.register("operating_mode") {
            Some(mode) => Ok(self.client.read(self.id, self.table, mode.field)?),
            None => Ok(0),
        }
    }

    fn is_dynamixel(&self) -> bool {
        self.table.register("goal_pwm").is_some()
    }

    fn read(&mut self, name: &str) -> Result<i32, Error> {
        let register = self.register(name)?;
        Ok(self.client.read(self.id, self.table, register.field)?)
    }

    fn angle_deg(&mut self) -> Result<f64, Error> {
        Ok(angle_deg(self.table, self.read("present_position")?.into()))
    }

    /// Turns the torque off.
    ///
    /// # Errors
    /// Those of the bus and the servo.
    pub fn release(&mut self) -> Result<(), Error> {
        self.write(self.register("torque_enable")?, 0)
    }

    /// What it measures: columns of a recording and their registers.
    fn columns(&self) -> Vec<(&'static str, &'static Register)> {
        let find = |names: &[&str]| names.iter().find_map(|name| self.table.register(name));
        let columns = COLUMNS.iter();
        columns
            .filter_map(|(column, names)| Some((*column, find(names)?)))
            .collect()
    }

    /// Names of the values of [`Servo::watch`].
    pub fn measured(&self) -> impl Iterator<Item = &'static str> {
        self.columns().into_iter().map(|(column, _)| column)
    }

    /// Reads what it measures as fast as the bus allows, with the time since the begin, until it is
    /// over; returns the number of requests without an answer.
    ///
    /// # Errors
    /// Those of `each` and of the bus, and a servo that no longer answers.
    pub fn watch(
        &mut self,
        is_over: impl Fn(Duration) -> bool,
        mut each: impl FnMut(&mut Self, Duration, &[f64]) -> Result<(), Error>,
    ) -> Result<u64, Error> {
        let columns = self.columns();
        let fields = || columns.iter().map(|(_, register)| register.field);
        let first = fields().map(|field| field.address).min().unwrap_or(0);
        let end = fields()
            .map(|field| field.address + u16::from(field.size))
            .max();
        let length = end.map_or(0, |end| end - first) as u8;
        let start = Instant::now();
        let (mut lost, mut in_turn) = (0, 0);
        while !is_over(start.elapsed()) {
            let before = start.elapsed();
            match self.client.read_bytes(self.id, first, length) {
                Ok(bytes) => {
                    in_turn = 0;
                    let at = (before + start.elapsed()) / 2;
                    let values: Vec<f64> = columns
                        .iter()
                        .map(|(_, register)| self.value(register, first, &bytes))
                        .collect();
                    each(self, at, &values)?;
                }
                Err(ServoError::NoAnswer(_)) if in_turn < MOST_LOST => {
                    (lost, in_turn) = (lost + 1, in_turn + 1)
                }
                Err(error) => return Err(error.into()),
            }
        }
        Ok(lost)
    }

    /// Records for this time; returns the number of requests without an answer.
    ///
    /// # Errors
    /// For a file that cannot be written; those of [`Servo::watch`].
    pub fn record(&mut self, time: Duration, sink: &mut Sink) -> Result<u64, Error> {
        sink.header(self.measured().map(str::to_owned))?;
        let stop = interrupt::stop()?;
        let is_over = |now| now >= time || stop.load(Ordering::Relaxed);
        self.watch(is_over, |_, at, values| {
            sink.row(at.as_secs_f64(), values.iter().copied())
        })
    }

    /// Torque, temperature and errors in words.
    ///
    /// # Errors
    /// Those of the bus.
    pub fn state(&mut self) -> Result<String, Error> {
        let errors = match self.is_dynamixel() {
            true => "hardware_error_status",
            false => "status",
        };
        let is_on = self.read("torque_enable")? != 0;
        let (temperature, errors) = (self.read("present_temperature")?, self.read(errors)?);
        let torque = if is_on { "on" } else { "off" };
        Ok(format!(
            "torque {torque}, {temperature} degC, errors {errors:02X}h"
        ))
    }

    /// The value of a register within bytes from an address on, in the unit of its column.
    fn value(&self, register: &Register, first: u16, bytes: &[u8]) -> f64 {
        let field = register.field;
        let start = usize::from(field.address - first);
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
