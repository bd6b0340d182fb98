//! Changes of the state of a servo that the thread of the bus detects.

use host_sim::servo_bus::client::{Client, Device, ServoError, TORQUE_ON};
use servo_bus::Table;

use super::Servo;
use crate::core::{Core, State};
use crate::node::Node;

/// Samples in turn without an answer after which a servo counts as missing.
const MOST_MISSES: u32 = 5;

/// What a servo has answered; only errors of the bus are errors here.
pub fn answer<T>(answered: Result<T, ServoError>) -> Result<Option<T>, ServoError> {
    match answered {
        Ok(value) => Ok(Some(value)),
        Err(error @ ServoError::Bus { .. }) => Err(error),
        Err(_) => Ok(None),
    }
}

/// The servos of which this is true.
pub fn numbers(core: &Core, is_one: impl Fn(&Node) -> bool) -> Vec<u8> {
    core.with(|state| {
        let nodes = state.nodes.iter().filter(|(_, node)| is_one(node));
        nodes.map(|(number, _)| *number).collect()
    })
}

/// A servo is not reached: what a page has commanded ends when it is reached again.
pub fn abandon(node: &mut Node) {
    node.is_stopping |= node.enabled_by.take().is_some();
}

/// A servo has not answered.
pub fn missed(core: &Core, number: u8) {
    let is_news = core.with(|state| {
        let State {
            nodes, has_changed, ..
        } = state;
        let node = nodes.get_mut(&number)?;
        node.record.lost += 1;
        let servo = node.servo.as_mut()?;
        servo.misses += 1;
        let is_news = servo.misses == MOST_MISSES;
        if is_news {
            node.is_lost = true;
            abandon(node);
        }
        *has_changed |= is_news;
        Some(is_news)
    });
    if is_news == Some(true) {
        core.log("fault", Some(number), "does not answer");
    }
}

/// Takes the torque or the errors of a servo; returns the change in words, and whether its bus
/// watchdog is on without need.
pub fn take_state(
    state: &mut State,
    number: u8,
    is_torque: bool,
    value: i32,
) -> (Option<(&'static str, String)>, bool) {
    let State {
        nodes, has_changed, ..
    } = state;
    let Some(node) = nodes.get_mut(&number) else {
        return (None, false);
    };
    let Some(servo) = &mut node.servo else {
        return (None, false);
    };
    let mut change = None;
    if is_torque {
        let is_on = value == TORQUE_ON;
        if std::mem::replace(&mut servo.is_torque_on, is_on) != is_on {
            let text = if is_on { "torque on" } else { "torque off" };
            change = Some(("info", text.to_owned()));
        }
        if !is_on {
            node.enabled_by = None;
        }
    } else if std::mem::replace(&mut servo.errors, value) != value {
        let errors = servo.errors();
        change = Some(match errors.is_empty() {
            true => ("info", "no errors".to_owned()),
            false => ("fault", format!("errors: {}", errors.join(", "))),
        });
    }
    *has_changed |= change.is_some();
    (change, servo.is_watched && node.enabled_by.is_none())
}

/// A sample of a servo.
pub fn take(state: &mut State, number: u8, at_s: f64, bytes: &[u8]) {
    let count = state.nodes.len();
    let Some(node) = state.nodes.get_mut(&number) else {
        return;
    };
    if let Some(servo) = &mut node.servo {
        servo.misses = 0;
        node.record.push(None, at_s, servo.values(bytes), count);
    }
}

/// Reads a servo that has answered, or that was written to, and adds it to those that are known.
///
/// # Errors
/// Those of the bus.
pub fn attach(
    core: &Core,
    client: &mut Client,
    id: u8,
    table: &'static Table,
) -> Result<(), ServoError> {
    let Some(mut servo) = answer(Servo::read(client, Device { id, table }))? else {
        return Ok(());
    };
    let is_news = core.with(|state| {
        let node = state.nodes.entry(id).or_default();
        let before = node.servo.take();
        servo.is_watched = before.as_ref().is_some_and(|before| before.is_watched);
        node.servo = Some(servo);
        state.has_changed = true;
        std::mem::take(&mut node.is_lost) || before.is_none()
    });
    if is_news {
        core.log("info", Some(id), &format!("found: {}", table.name));
    }
    Ok(())
}
