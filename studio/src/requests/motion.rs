//! Enabling, targets and excitations.

use host_sim::can::client::ClientError;
use host_sim::can::excitation;
use model_core::{
    parameter::Shown,
    time::{CONTROL_PERIOD_TICKS, seconds},
};
use serde_json::{Value, json};

use super::{Context, ExcitationValues};
use crate::motion;
use crate::node::Target;

pub fn stop(context: &Context) {
    motion::stop_all(&context.core);
    context.core.log("warning", None, "stopped from a page");
    context.reply.result(Ok(json!(null)));
}

pub fn enable(context: Context, node: u8) {
    // The supervisor ends a stop up to 50 ms after the drive is off: what is enabled in between
    // must not be stopped by it.
    let refusal = context.core.with_node(node, |node| {
        if node.is_stopping && !node.is_powered() {
            (node.is_stopping, node.enabled_by) = (false, None);
        }
        match (node.is_stopping, &node.commissioned_by) {
            (true, _) => Some("the drive is stopping"),
            (_, Some(_)) => Some("the actuator is being commissioned"),
            _ => None,
        }
    });
    if let Some(why) = refusal.flatten() {
        return context.reply.result(Err(why.into()));
    }
    let page = context.page;
    context.move_at_node(node, move |core, client| {
        motion::enable(core, client, page).map(|()| json!(null))
    });
}

pub fn disable(context: Context, node: u8) {
    context.at_node(node, |_, client| client.disable().map(|()| json!(null)));
}

/// In parts of which a unit has this many; `None` for what no object holds.
fn parts(value: f64, parts: f64) -> Option<i32> {
    let value = (value * parts).round();
    (value.abs() <= f64::from(i32::MAX)).then_some(value as i32)
}

/// Commands a target that is entered as this value; `kind` is what it has to be.
fn command_value(context: Context, node: u8, target: Option<Target>, value: &str, kind: &str) {
    match target {
        Some(target) => command(context, node, target),
        None => context
            .reply
            .result(Err(format!("the target is {value}, expected {kind}"))),
    }
}

pub fn go(context: Context, node: u8, deg: f64) {
    let target = parts(deg, 1e3).map(Target::Angle);
    command_value(
        context,
        node,
        target,
        &format!("{} deg", Shown(deg)),
        "an angle",
    );
}

pub fn turn(context: Context, node: u8, deg_s: f64) {
    let target = parts(deg_s, 1e3).map(Target::Rate);
    command_value(
        context,
        node,
        target,
        &format!("{} deg/s", Shown(deg_s)),
        "a rate",
    );
}

pub fn press(context: Context, node: u8, nm: f64) {
    let target = parts(nm, 1e6).map(Target::Torque);
    command_value(
        context,
        node,
        target,
        &format!("{} N m", Shown(nm)),
        "a torque",
    );
}

fn command(context: Context, node: u8, target: Target) {
    let is_enabled = context.core.with_node(node, |node| {
        let is_taken = node.takes_targets();
        if is_taken {
            node.target = Some(target);
        }
        is_taken
    });
    if is_enabled != Some(true) {
        return context.reply.result(Err("the drive is not enabled".into()));
    }
    let page = context.page;
    context.move_at_node(node, move |core, client| {
        // The page that commands it is the one whose loss stops it.
        core.with_node(client.node(), |node| node.enabled_by = Some(page));
        motion::go(core, client).map(|()| json!(null))
    });
}

/// Points of a preview.
const PREVIEW: u64 = 1000;

/// Time and angle of an excitation, and its duration.
fn samples(values: &ExcitationValues) -> Result<Value, String> {
    let settings = excitation::settings(&values.0).map_err(|error| error.to_string())?;
    let run = settings.run().ok_or("these settings exclude each other")?;
    let once = run.ticks.min(seconds_ticks(600.0));
    let periods = once / CONTROL_PERIOD_TICKS;
    let step = periods.div_ceil(PREVIEW).max(1) * CONTROL_PERIOD_TICKS;
    let ticks = (0..=once / step).map(|i| i * step);
    let (x, y): (Vec<_>, Vec<_>) = ticks
        .map(|tick| (seconds(tick), run.sample(tick).angle.to_f64()))
        .unzip();
    let duration_s = seconds(run.ticks) * f64::from(run.more + 1);
    Ok(json!({ "t": x, "deg": y, "duration_s": duration_s }))
}

fn seconds_ticks(time_s: f64) -> u64 {
    model_core::time::ticks(time_s)
}

pub fn preview(context: &Context, settings: &ExcitationValues) {
    context.reply.result(samples(settings));
}

pub fn excite(context: Context, node: u8, settings: ExcitationValues) {
    if let Err(error) = excitation::settings(&settings.0) {
        return context.reply.result(Err(error.to_string()));
    }
    let is_enabled = context.core.with_node(node, |node| node.takes_targets());
    if is_enabled != Some(true) {
        return context.reply.result(Err("the drive is not enabled".into()));
    }
    let page = context.page;
    context.move_at_node(node, move |core, client| {
        core.with_node(client.node(), |node| node.enabled_by = Some(page));
        motion::take_mode(core, client, motion::PROFILE_POSITION)?;
        for (sub, value) in settings.0 {
            client.write(&format!("2020:{sub}"), &value.to_string())?;
        }
        excitation::start(client)?;
        Ok::<_, ClientError>(json!({ "begun_s": core.now_s() }))
    });
}
