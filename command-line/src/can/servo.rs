//! `scan`, `get`, `set`, `move`, `stop`, `monitor` and `record` of servos on a serial bus.

use std::sync::atomic::Ordering;
use std::thread;
use std::time::{Duration, Instant};

use host_sim::can::client::ClientError;
use host_sim::servo_bus::client::{
    Client, Columns, Device, ServoError, angle_deg, errors, in_units, position, register, value,
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
    device: Device,
}

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
        let device = Device { id, table };
        Ok(Self { client, device })
    }

    fn register(&self, name: &str) -> Result<&'static Register, Error> {
        Ok(register(self.device.table, name)?)
    }

    /// Prints registers; without names all.
    ///
    /// # Errors
    /// For an unknown name; those of the bus.
    pub fn get(&mut self, names: &[String], json: bool) -> Result<(), Error> {
        let registers: Vec<&Register> = if names.is_empty() {
            self.device.table.registers.iter().collect()
        } else {
            let found = names.iter().map(|name| self.register(name));
            found.collect::<Result<_, _>>()?
        };
        let mut values = Vec::new();
        for register in registers {
            let Device { id, table } = self.device;
            values.push((register, self.client.read(id, table, register.field)?));
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
        let Device { id, table } = self.device;
        self.client.write(id, table, register, value)?;
        if register.name == "id" {
            self.device.id = value as u8;
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
        let wanted = position(self.device.table, goal_deg).round();
        let wanted = value(goal, &wanted.to_string())?;
        self.device.require_angles(&mut self.client)?;
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
        let (id, start, stop) = (self.device.id, Instant::now(), interrupt::stop()?);
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
        Ok(self.device.halt(&mut self.client)?)
    }

    fn read(&mut self, name: &'static str) -> Result<i32, Error> {
        Ok(self.device.read(&mut self.client, name)?)
    }

    fn angle_deg(&mut self) -> Result<f64, Error> {
        let position = self.read("present_position")?;
        Ok(angle_deg(self.device.table, position.into()))
    }

    /// Turns the torque off.
    ///
    /// # Errors
    /// Those of the bus and the servo.
    pub fn release(&mut self) -> Result<(), Error> {
        self.write(self.register("torque_enable")?, 0)
    }

    /// What a recording has: all columns but the temperature, which needs no curve.
    fn columns(&self) -> Columns {
        Columns::of(self.device.table, |column| column != "temperature_degc")
    }

    /// Names of the values of [`Servo::watch`].
    pub fn measured(&self) -> impl Iterator<Item = &'static str> {
        self.columns().names().collect::<Vec<_>>().into_iter()
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
        let start = Instant::now();
        let (mut lost, mut in_turn) = (0, 0);
        while !is_over(start.elapsed()) {
            let before = start.elapsed();
            match (self.client).read_bytes(self.device.id, columns.first, columns.length) {
                Ok(bytes) => {
                    in_turn = 0;
                    let at = (before + start.elapsed()) / 2;
                    let values: Vec<f64> = columns.values(&bytes).collect();
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
        let is_on = self.read("torque_enable")? != 0;
        let temperature = self.read("present_temperature")?;
        let register = self.device.error_register()?;
        let errors = errors(register, self.read(register.name)?).join(", ");
        let torque = if is_on { "on" } else { "off" };
        let errors = if errors.is_empty() { "none" } else { &errors };
        Ok(format!(
            "torque {torque}, {temperature} degC, errors: {errors}"
        ))
    }
}
