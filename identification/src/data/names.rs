//! Usual names of the columns of recordings: of this project, of servo buses, of ODrive, of ROS and
//! of LeRobot.

use super::{Quantity, unit};

/// Usual names of its column without the unit, by precedence.
fn usual_names(quantity: Quantity) -> &'static [&'static str] {
    match quantity {
        Quantity::Time => &[
            "t",
            "time",
            "timestamp",
            "time_stamp",
            "stamp",
            "header_stamp",
            "time_since_start",
            "elapsed",
            "tout",
            "zeit",
            "micros",
            "millis",
            "x_value",
            "frame_timestamp",
        ],
        Quantity::Command => &[
            "command",
            "commands",
            "cmd",
            "commanded",
            "angle_command",
            "command_angle",
            "reference",
            "ref",
            "setpoint",
            "target",
            "goal_position",
            "goal",
            "target_position",
            "input",
            "u",
            "demand",
            "soll",
            "sollwert",
            "desired",
            "input_pos",
            "pos_setpoint",
            "position_setpoint",
            "control_position",
            "q_des",
            "q_target",
            "q_d",
            "joint_pos_target",
            "command_position",
            "cmd_pos",
            "position_command",
            "target_pos",
            "action",
            "joint_command",
            "joint_commands",
            "joint_cmd",
        ],
        Quantity::Angle => &[
            "angle_meas",
            "angle_measured",
            "measured",
            "measured_angle",
            "angle",
            "position",
            "pos",
            "theta",
            "shaft_angle",
            "encoder",
            "output",
            "y",
            "actual",
            "ist",
            "istwert",
            "present_position",
            "actual_position",
            "position_actual",
            "pos_estimate",
            "position_estimate",
            "current_position",
            "measured_position",
            "q",
            "q_meas",
            "joint_pos",
            "feedback",
            "observation_state",
            "state",
        ],
        Quantity::Rate => &[
            "rate_meas",
            "rate",
            "angular_rate",
            "speed",
            "velocity",
            "omega",
            "vel_estimate",
            "present_velocity",
            "joint_vel",
            "dq",
            "qd",
        ],
        Quantity::Duty => &["duty", "motor_duty", "pwm"],
        Quantity::Current => &["current_meas", "current", "motor_current"],
        Quantity::Supply => &[
            "supply",
            "input_volts",
            "supply_voltage",
            "voltage",
            "vin",
            "vbus_voltage",
            "vbus",
            "present_voltage",
        ],
        Quantity::Enabled => &[
            "enabled",
            "enable",
            "motor_on",
            "torque_enable",
            "torque_enabled",
        ],
    }
}

/// Names with a unit that their programs always use.
const USUAL_UNITS: [(&str, &str); 12] = [
    // Arduino.
    ("micros", "us"),
    ("millis", "ms"),
    // ODrive.
    ("pos_estimate", "turn"),
    ("input_pos", "turn"),
    ("pos_setpoint", "turn"),
    ("vel_estimate", "turn/s"),
    // Robots and their simulators.
    ("q", "rad"),
    ("q_des", "rad"),
    ("q_target", "rad"),
    ("q_meas", "rad"),
    ("joint_pos", "rad"),
    ("joint_pos_target", "rad"),
];

/// The unit that is usual for a name.
pub fn usual_unit(name: &str) -> Option<&'static str> {
    let name = unit::split(Quantity::Angle, name).0;
    let mut units = USUAL_UNITS.iter();
    let found = units.find(|(usual, _)| ends_with(&name, usual));
    found.map(|(_, unit)| *unit)
}

/// Whether a name, or the last part of a path, is this one.
fn ends_with(name: &str, usual: &str) -> bool {
    let before = name.strip_suffix(usual);
    before.is_some_and(|before| before.is_empty() || before.ends_with(['/', '.']))
}

/// Parts of the paths of commands and states that are no angles.
const OTHER_STATES: [&str; 6] = [
    "velocity",
    "velocities",
    "acceleration",
    "accelerations",
    "effort",
    "efforts",
];
/// The same of their last parts.
const OTHER_VALUES: [&str; 5] = ["current", "temperature", "time", "t", "timestamp"];

/// Whether columns are joints as ROS publishes them, in radians; PlotJuggler keeps their topic.
pub fn are_of_ros(names: &[String]) -> bool {
    names.iter().any(|name| name.starts_with("/joint_states/"))
}

/// Whether a part of a path is a usual name of a quantity other than the time.
#[cfg(feature = "mcap")]
pub fn is_usual(path: &str) -> bool {
    let quantities = || Quantity::ALL.into_iter().filter(|q| *q != Quantity::Time);
    let is_name = |part: &str| quantities().any(|q| usual_names(q).contains(&part));
    path.to_lowercase().split(['/', '.']).any(is_name)
}

/// The index of the column with a usual name of a quantity: the whole name, or else the last, the
/// first or any part of a path such as `/joint_states/position`.
///
/// # Errors
/// The indices of two columns that may both be it.
pub fn find(quantity: Quantity, names: &[String]) -> Result<Option<usize>, [usize; 2]> {
    let paths = names.iter().map(|name| {
        let (name, _) = unit::split(quantity, name);
        let parts = name.split(['/', '.']).filter(|part| !part.is_empty());
        parts
            .map(|part| part.trim_matches('_').to_owned())
            .collect()
    });
    let paths: Vec<Vec<String>> = paths.collect();
    let is_part: [fn(&[String], &str) -> bool; 4] = [
        |parts, usual| parts.join("_") == usual,
        |parts, usual| parts.last().is_some_and(|part| part == usual),
        |parts, usual| parts.first().is_some_and(|part| part == usual),
        |parts, usual| parts.iter().any(|part| part == usual),
    ];
    // `/command/position` is no measured position, nor `reference.velocities` a commanded one.
    let commands = usual_names(Quantity::Command);
    let has = |parts: &[String], names: &[&str]| {
        parts.len() > 1 && parts.iter().any(|part| names.contains(&part.as_str()))
    };
    let is_other = |parts: &[String]| {
        let last = parts.last().filter(|_| parts.len() > 1);
        has(parts, &OTHER_STATES) || last.is_some_and(|it| OTHER_VALUES.contains(&it.as_str()))
    };
    let may_be = |parts: &[String]| match quantity {
        Quantity::Angle => !has(parts, commands) && !is_other(parts),
        Quantity::Command => !is_other(parts),
        _ => true,
    };
    for is_it in is_part {
        for usual in usual_names(quantity) {
            let matches = |i: &usize| may_be(&paths[*i]) && is_it(&paths[*i], usual);
            let mut found = (0..paths.len()).filter(matches);
            match (found.next(), found.next()) {
                (None, _) => {}
                (Some(index), None) => return Ok(Some(index)),
                (Some(a), Some(b)) => return Err([a, b]),
            }
        }
    }
    Ok(None)
}

/// The names of the columns of a joint without it; those of others are empty.
pub fn of_joint(names: &[String], joint: &str) -> Vec<String> {
    let is_separator = |c: char| "/._[]\"'".contains(c);
    let without = |name: &String| {
        let place = name.find(joint)?;
        let (before, after) = (&name[..place], &name[place + joint.len()..]);
        // `arm` is not in `forearm` nor in `arm2`.
        let stands_alone = before.is_empty() || before.ends_with(is_separator);
        let ends = after.is_empty() || after.starts_with(is_separator);
        let [before, after] = [before, after].map(|part| part.trim_matches(is_separator));
        let both = [before, after].into_iter().filter(|part| !part.is_empty());
        (stands_alone && ends).then(|| both.collect::<Vec<_>>().join("."))
    };
    names
        .iter()
        .map(|name| without(name).unwrap_or_default())
        .collect()
}
