//! Motor parameters from a fit, and the values that it requires.

use host_sim::can::client::{Client, ClientError};
use host_sim::can::{motor_objects, names};
use host_sim::scenario::Scenario;
use identification::assessment::Assessment;
use identification::parameter_file;
use serde_json::{Value, json};

use crate::quantity::place;
use crate::record::Row;
use crate::requests::objects::address;

/// The parameter that is measured and not fitted: without a known load, an angle determines
/// only the ratios of torque constant, inertia and friction.
pub const TORQUE_CONSTANT: &str = "torque_constant_nm_a";

/// Rate below which the noise of rate and back-EMF is significant, deg/s.
const SLOWEST_DEG_S: f64 = 30.0;

/// The torque constant at the output: back-EMF per rate, by least squares over the samples in
/// motion; `None` if there are too few.
pub fn torque_constant(rows: &[Row]) -> Option<f64> {
    const FEWEST: usize = 50;
    let pairs = rows.iter().map(|row| {
        let rate_deg_s = f64::from(row.values[place::RATE]);
        (rate_deg_s, f64::from(row.values[place::BACK_EMF]))
    });
    let moving = pairs.filter(|(rate, emf)| rate.abs() > SLOWEST_DEG_S && emf.is_finite());
    let (count, products, squares) = moving.fold((0, 0.0, 0.0), |(n, xy, xx), (rate, emf)| {
        let rate_rad_s = rate.to_radians();
        (n + 1, xy + rate_rad_s * emf, xx + rate_rad_s * rate_rad_s)
    });
    Some(products / squares).filter(|k| count >= FEWEST && *k > 0.0)
}
/// Motor parameters that are stored in the actuator and that an experiment cannot determine: the
/// angle depends only on the ratio of the torque constant to the resistance, and on its product
/// with the gear ratio.
#[derive(Debug, Clone, Copy)]
pub struct Known {
    /// Armature resistance.
    pub resistance_ohm: f64,
    /// Gear ratio.
    pub gear_ratio: f64,
}

pub fn known(client: &mut Client) -> Result<Known, ClientError> {
    let mut real = |path| match client.get(names::of_value(path)?)? {
        names::Value::Real(value) => Ok(f64::from(value)),
        other => Err(ClientError::NotAnInteger(other.to_string())),
    };
    Ok(Known {
        resistance_ohm: real("values.model.resistance_ohm")?,
        gear_ratio: real("values.model.gear_ratio")?,
    })
}
/// The fitted motor as objects of the board's model, and as the motor of the tuning.
pub fn motor(assessment: &Assessment, known: Known, rows: &[Row]) -> Result<Value, String> {
    let text = parameter_file::text(&assessment.fit).map_err(|error| error.to_string())?;
    let scenario: Scenario = toml::from_str(&text).map_err(|error| error.to_string())?;
    let settings = scenario.settings().map_err(|error| error.to_string())?;
    let objects = motor_objects::determined(&scenario).map_err(|error| error.to_string())?;
    let [ohm, nm_a, ratio, inertia, viscous, _] = objects.map(|((_, value), _)| value);
    // The motor of the fit is at the output.
    let k = nm_a * ratio;
    // Resistance and gear ratio are those of the actuator.
    let [_, (torque_constant, _), _, fitted @ ..] = objects;
    let of_the_actuator = (torque_constant.0, k / known.gear_ratio);
    let (written, open): (Vec<_>, Vec<_>) = std::iter::once((of_the_actuator, true))
        .chain(fitted)
        .partition(|(_, is_determined)| *is_determined);
    let open: Vec<_> = open
        .iter()
        .map(|((row, _), _)| row.entry.as_str())
        .collect();
    let supplies = rows.iter().map(|row| f64::from(row.values[place::SUPPLY]));
    let supply_v = supplies.sum::<f64>() / rows.len().max(1) as f64;
    // Without Coulomb friction and inductance: J w' = k (u - k w)/R - b w, where the duty is
    // u as a share of the supply voltage.
    let damping = viscous + k * k / ohm;
    let gain_rad_s_v = k / ohm / damping;
    let values = written.iter().map(|((row, value), _)| {
        json!({ "object": address(row), "name": names::name(row), "unit": row.unit, "value": value })
    });
    Ok(json!({
        "objects": values.collect::<Vec<_>>(),
        "open": open,
        "remark": motor_objects::omitted_friction(&settings),
        "motor_gain": (gain_rad_s_v * supply_v / 100.0).to_degrees(),
        "motor_time_constant_s": inertia / damping,
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_torque_constant_is_that_of_the_back_emf() {
        let row = |i: i32| {
            let mut values = [0.0; crate::quantity::COUNT];
            values[place::RATE] = 2.0 * i as f32;
            values[place::BACK_EMF] = 1.16 * values[place::RATE].to_radians();
            Row {
                time_s: f64::from(i),
                values,
            }
        };
        let rows: Vec<_> = (-60..=60).map(row).collect();
        assert!((torque_constant(&rows).unwrap() - 1.16).abs() < 1e-6);
        assert_eq!(torque_constant(&rows[50..70]), None, "at rest");
    }
}
