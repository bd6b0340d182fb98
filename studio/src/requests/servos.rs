//! Requests at a bus of servos.

use std::sync::Arc;

use host_sim::servo_bus::client::{Client, Device, ServoError, position, register, value};
use model_core::parameter::Shown;
use serde_json::{Value, json};
use servo_bus::Register;

use super::{Context, Request, files, motion, network};
use crate::core::{Core, State};
use crate::node::Node;
use crate::quantity;
use crate::record::MINUTES;
use crate::servos::{GAP_S, Servo, WATCHDOG, attach};
use crate::web::PageId;

const NOT_ENABLED: &str = "the servo is not enabled";

/// Registers that move a shaft with torque, or at which a stop is not acknowledged.
const WITHOUT_TORQUE: [&str; 8] = [
    "homing_offset",
    "operating_mode",
    "drive_mode",
    "phase",
    "min_position_limit",
    "max_position_limit",
    "status_return_level",
    "response_level",
];

/// Registers without which the servo is not reached as before.
const ADDRESSES: [&str; 2] = ["id", "baud_rate"];

pub fn hello(page: PageId, core: &Core, state: &State, bus: &str) -> Value {
    json!({
        "event": "hello", "kind": "servos", "page": page, "bus": bus,
        "now_s": core.now_s(), "version": env!("CARGO_PKG_VERSION"), "minutes": MINUTES,
        "quantities": quantity::of(core), "gap_s": GAP_S, "objects": [], "simulated": 0,
        "parquet": cfg!(feature = "parquet"), "log": state.log,
    })
}

pub fn dispatch(context: Context, request: Request) {
    match request {
        Request::Alive => network::alive(&context),
        Request::TakeControl => network::take_control(&context),
        Request::AnswerControl { give } => network::answer_control(&context, give),
        Request::Scan => {
            context.core.servos.iter().for_each(|servos| servos.scan());
            context.reply.result(Ok(json!(null)));
        }
        Request::Cancel { .. } => {
            context
                .core
                .servos
                .iter()
                .for_each(|servos| servos.end_scan());
        }
        Request::Stop => motion::stop(&context),
        Request::Enable { node } => context.move_servo(node, true, enable),
        Request::Disable { node } => disable(context, node),
        Request::Move { node, deg } => go(context, node, deg),
        Request::ReadAll { node } => context.at_servo(node, |_, client, device| {
            let values = read_all(client, device)?;
            Ok(json!({ "model": device.table.name, "registers": values }))
        }),
        Request::Write {
            node,
            object,
            value,
        } => write(context, node, &object, &value),
        Request::Record { nodes, is_on } => files::record(&context, &nodes, is_on),
        Request::SaveRecording(recording) => files::save_recording(context, recording),
        _ => {
            let why = "a bus of servos has no such request";
            context.reply.result(Err(why.into()));
        }
    }
}

impl Context {
    /// Does work with a servo, in turn, and answers with its result.
    fn at_servo(
        self,
        number: u8,
        work: impl FnOnce(&Core, &mut Client, Device) -> Result<Value, String> + Send + 'static,
    ) {
        let (core, reply) = (Arc::clone(&self.core), self.reply.clone());
        let requested = self.core.servos.as_ref().map(|servos| {
            servos.request(move |client| {
                let device =
                    core.with(|state| servo_of(state, number).map(|(servo, _)| servo.device));
                let result = client.and_then(|client| work(&core, client, device?));
                core.with(|state| state.has_changed = true);
                reply.result(result);
            })
        });
        self.reply.busy(requested.unwrap_or(Ok(())));
    }

    /// The same for work that moves the shaft, or `enables` it: a stop since the request refuses
    /// it, and what it has begun ends with a later stop or with this page.
    fn move_servo(
        self,
        number: u8,
        enables: bool,
        work: impl FnOnce(&Core, &mut Client, Device) -> Result<Value, String> + Send + 'static,
    ) {
        let (guard, page) = (self.core.guard(number), self.page);
        self.at_servo(number, move |core, client, device| {
            let refusal = core.with_node(number, |node| {
                if guard.is_stopped() || node.is_stopping {
                    return Some("stopped");
                }
                // A goal would turn the torque of an STS on that was released meanwhile.
                let is_enabled = node.is_powered() && node.enabled_by.is_some();
                if !enables && !is_enabled {
                    return Some(NOT_ENABLED);
                }
                // Before the work: a stop during the work halts the servo behind it.
                node.enabled_by = Some(page);
                None
            });
            match refusal.flatten() {
                Some(why) => Err(why.to_owned()),
                None => work(core, client, device),
            }
        });
    }
}

/// A servo that answers, and its node without it.
fn servo_of(state: &State, number: u8) -> Result<(&Servo, &Node), String> {
    let node = state.nodes.get(&number);
    let servo = node.and_then(|node| Some((node.servo.as_ref()?, node)));
    let servo = servo.ok_or_else(|| format!("there is no servo {number}"))?;
    match servo.1.is_lost {
        true => Err(format!("servo {number} does not answer")),
        false => Ok(servo),
    }
}

/// A servo that a page has enabled.
fn enabled(state: &State, number: u8) -> Result<&Servo, String> {
    let (servo, node) = servo_of(state, number)?;
    let is_enabled = servo.is_torque_on && node.enabled_by.is_some() && !node.is_stopping;
    is_enabled
        .then_some(servo)
        .ok_or_else(|| NOT_ENABLED.to_owned())
}

fn text(error: impl ToString) -> String {
    error.to_string()
}

/// Notes what a servo is known to be.
fn note(core: &Core, device: Device, change: impl FnOnce(&mut Node, &mut Servo)) {
    core.with_node(device.id, |node| {
        if let Some(mut servo) = node.servo.take() {
            change(node, &mut servo);
            node.servo = Some(servo);
        }
    });
}

/// Turns the torque on at the present position.
fn enable(core: &Core, client: &mut Client, device: Device) -> Result<Value, String> {
    let enabled = turn_on(core, client, device).map_err(text);
    note(core, device, |node, servo| match &enabled {
        Ok(()) => servo.is_torque_on = true,
        Err(_) => node.enabled_by = None,
    });
    enabled.map(|()| json!(null))
}

fn turn_on(core: &Core, client: &mut Client, device: Device) -> Result<(), ServoError> {
    device.require_angles(client)?;
    device.require_answers(client)?;
    if device.table.register("bus_watchdog").is_some() {
        // One that has expired refuses all else.
        device.write(client, "bus_watchdog", 0)?;
        device.write(client, "bus_watchdog", WATCHDOG)?;
        note(core, device, |_, servo| servo.is_watched = true);
    }
    // Before the torque, which would turn to an earlier goal.
    device.hold(client)?;
    device.write(client, "torque_enable", 1)
}

fn disable(context: Context, number: u8) {
    context.at_servo(number, |core, client, device| {
        device.write(client, "torque_enable", 0).map_err(text)?;
        note(core, device, |node, servo| {
            (node.enabled_by, servo.is_torque_on) = (None, false);
        });
        Ok(json!(null))
    });
}

/// Commands an angle.
fn go(context: Context, number: u8, deg: f64) {
    let goal = context.core.with(|state| {
        let servo = enabled(state, number)?;
        let (least, most) = servo.limits.clone()?;
        let goal = position(servo.device.table, deg).round();
        if (f64::from(least)..=f64::from(most)).contains(&goal) {
            return Ok(goal as i32);
        }
        let (least, most) = servo.limits_deg()?;
        let [deg, least, most] = [deg, least, most].map(Shown);
        Err(format!(
            "the goal is {deg} deg, expected {least} to {most} deg"
        ))
    });
    match goal {
        Ok(goal) => context.move_servo(number, false, move |_, client, device| {
            let written = device.write(client, "goal_position", goal);
            written.map(|()| json!(null)).map_err(text)
        }),
        Err(why) => context.reply.result(Err(why)),
    }
}

fn describe(register: &Register, value: i32) -> Value {
    json!({
        "name": register.name, "address": register.field.address, "value": value,
        "unit": register.unit, "min": register.min, "max": register.max,
        "default": register.default, "is_writable": register.is_writable,
        "is_eeprom": register.is_eeprom, "meaning": register.meaning,
    })
}

fn read_all(client: &mut Client, device: Device) -> Result<Vec<Value>, String> {
    let values = device.read_all(client).map_err(text)?;
    let described = values
        .iter()
        .map(|(register, value)| describe(register, *value));
    Ok(described.collect())
}

/// Writes a register, and answers with its value. What moves the shaft needs a servo that is
/// enabled.
fn write(context: Context, number: u8, name: &str, entered: &str) {
    let checked = context.core.with(|state| {
        let (servo, node) = servo_of(state, number)?;
        let register = register(servo.device.table, name).map_err(text)?;
        let value = value(register, entered).map_err(text)?;
        let is_goal = register.name.starts_with("goal_") || register.name == "torque_enable";
        if is_goal {
            enabled(state, number)?;
        }
        if ADDRESSES.contains(&register.name) && node.enabled_by.is_some() {
            return Err(format!(
                "{}: the servo is enabled, release it first",
                register.name
            ));
        }
        if register.name == "bus_watchdog" && servo.is_watched {
            return Err("bus_watchdog: it is on while the servo is enabled".into());
        }
        let is_taken = |id: i32| state.nodes.keys().any(|known| i32::from(*known) == id);
        if register.name == "id" && value != i32::from(number) && is_taken(value) {
            return Err(format!("there is a servo {value} already"));
        }
        Ok((register, value, is_goal))
    });
    let (register, value, is_goal) = match checked {
        Ok(checked) => checked,
        Err(why) => return context.reply.result(Err(why)),
    };
    let work = move |core: &Core, client: &mut Client, device: Device| {
        let table = device.table;
        let name = register.name;
        if WITHOUT_TORQUE.contains(&name) && device.is_driven(client).map_err(text)? {
            return Err(format!("{name}: the torque is on, turn it off first"));
        }
        let id = if name == "id" { value as u8 } else { device.id };
        let is_new = id != device.id;
        if is_new && client.probe(id).map_err(text)?.is_some() {
            return Err(format!("there is a servo {id} already"));
        }
        client
            .write(device.id, table, register, value)
            .map_err(text)?;
        if is_new {
            // The answer to the write may be lost.
            client.table(id).map_err(text)?;
            core.with(|state| state.nodes.remove(&device.id));
        }
        // Limits, mode and torque may be others now.
        attach(core, client, id, table).map_err(text)?;
        let value = client.read(id, table, register.field).map_err(text)?;
        Ok(describe(register, value))
    };
    match is_goal {
        true => context.move_servo(number, false, work),
        false => context.at_servo(number, work),
    }
}
