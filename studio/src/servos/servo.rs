//! What is known of a servo.

use host_sim::servo_bus::client::{Client, Columns, Device, ServoError, angle_deg, errors};
use serde_json::{Map, Value, json};

use crate::node::Node;
use crate::quantity::{COUNT, SERVO};

/// Time without a packet after which a Dynamixel that is enabled from a page stops, in units of
/// its bus watchdog, 20 ms: a turn of the thread of the bus takes less than half of it.
pub const WATCHDOG: i32 = 25;

/// A servo.
pub struct Servo {
    /// The servo.
    pub device: Device,
    /// What a sample reads.
    pub columns: Columns,
    /// Whether its motor is driven.
    pub is_torque_on: bool,
    /// Bits of its errors.
    pub errors: i32,
    /// Least and greatest goal, steps; the reason in an operating mode without angles.
    pub limits: Result<(i32, i32), String>,
    /// Its bus watchdog is on.
    pub is_watched: bool,
    /// Samples in turn that it has not answered.
    pub misses: u32,
}

impl Servo {
    /// Reads what changes rarely.
    ///
    /// # Errors
    /// Without an answer, or for a refusal; those of the bus.
    pub fn read(client: &mut Client, device: Device) -> Result<Self, ServoError> {
        let limits = match device.require_angles(client) {
            Ok(()) => Ok(device.limits(client)?),
            Err(error @ ServoError::Mode { .. }) => Err(error.to_string()),
            Err(error) => return Err(error),
        };
        let wanted = |column: &str| SERVO.iter().any(|quantity| quantity.column == column);
        Ok(Self {
            device,
            columns: Columns::of(device.table, wanted),
            is_torque_on: device.is_driven(client)?,
            errors: device.read(client, device.error_register()?.name)?,
            limits,
            is_watched: false,
            misses: 0,
        })
    }

    /// The quantities of a sample; NaN for those that the model does not measure.
    pub fn values(&self, bytes: &[u8]) -> [f32; COUNT] {
        let mut values = [f32::NAN; COUNT];
        for (name, value) in self.columns.names().zip(self.columns.values(bytes)) {
            let places = values.iter_mut().zip(&SERVO);
            for (place, quantity) in places.filter(|(_, quantity)| quantity.column == name) {
                *place = (value / quantity.column_scale) as f32;
            }
        }
        values
    }

    /// Least and greatest goal, deg, as whole hundredths within the limits; the reason in an
    /// operating mode without angles.
    pub fn limits_deg(&self) -> Result<(f64, f64), String> {
        let of = |steps: i32| angle_deg(self.device.table, steps.into()) * 100.0;
        let (least, most) = self.limits.clone()?;
        Ok((of(least).ceil() / 100.0, of(most).floor() / 100.0))
    }

    /// The errors in words.
    pub fn errors(&self) -> Vec<String> {
        let register = self.device.error_register();
        register.map_or_else(|_| Vec::new(), |register| errors(register, self.errors))
    }

    /// What a page shows of it beside the entries of each node.
    pub fn snapshot(&self, node: &Node) -> Map<String, Value> {
        let limits = self.limits_deg();
        let state = match (node.is_lost, self.is_torque_on) {
            (true, _) => "missing",
            (false, true) => "torque on",
            (false, false) => "torque off",
        };
        let snapshot = json!({
            "name": self.device.table.name, "is_actuator": true, "is_attached": true,
            "state": state, "is_torque_on": self.is_torque_on,
            "is_enabled": self.is_torque_on && node.enabled_by.is_some(),
            "errors": self.errors(), "has_fault": self.errors != 0,
            "problem": limits.as_ref().err(), "limits_deg": limits.as_ref().ok(),
        });
        match snapshot {
            Value::Object(entries) => entries,
            _ => Map::new(),
        }
    }
}
