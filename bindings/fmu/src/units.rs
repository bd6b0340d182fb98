//! The units of the parameter tables in SI base units, for hosts that convert units.

use std::f64::consts::PI;

/// A unit as a factor and powers of kg, m, s, A and rad.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unit {
    /// Its name in the parameter tables.
    pub name: &'static str,
    /// Its factor to the base unit.
    pub factor: f64,
    /// The base units and their powers.
    pub powers: &'static [(&'static str, i32)],
}

const DEG: f64 = PI / 180.0;
const PCT: f64 = 0.01;

const fn unit(name: &'static str, factor: f64, powers: &'static [(&'static str, i32)]) -> Unit {
    Unit {
        name,
        factor,
        powers,
    }
}

/// Every unit of the parameter tables and of the inputs and outputs.
pub const UNITS: &[Unit] = &[
    unit("1", 1.0, &[]),
    unit("choice", 1.0, &[]),
    unit("%", PCT, &[]),
    unit("deg", DEG, &[("rad", 1)]),
    unit("deg/s", DEG, &[("rad", 1), ("s", -1)]),
    unit("deg/s^2", DEG, &[("rad", 1), ("s", -2)]),
    unit("rad/s", 1.0, &[("rad", 1), ("s", -1)]),
    unit("s", 1.0, &[("s", 1)]),
    unit("1/s", 1.0, &[("s", -1)]),
    unit("1/s^2", 1.0, &[("s", -2)]),
    unit("Hz", 1.0, &[("s", -1)]),
    unit("%/s", PCT, &[("s", -1)]),
    unit("%/deg", PCT / DEG, &[("rad", -1)]),
    unit("%/(deg/s)", PCT / DEG, &[("rad", -1), ("s", 1)]),
    unit("(deg/s)/%", DEG / PCT, &[("rad", 1), ("s", -1)]),
    unit("m", 1.0, &[("m", 1)]),
    unit("kg", 1.0, &[("kg", 1)]),
    unit("kg m^2", 1.0, &[("kg", 1), ("m", 2)]),
    unit("A", 1.0, &[("A", 1)]),
    unit("V", 1.0, &[("kg", 1), ("m", 2), ("s", -3), ("A", -1)]),
    unit("V/V", 1.0, &[]),
    unit("V/A", 1.0, &[("kg", 1), ("m", 2), ("s", -3), ("A", -2)]),
    unit("ohm", 1.0, &[("kg", 1), ("m", 2), ("s", -3), ("A", -2)]),
    unit("H", 1.0, &[("kg", 1), ("m", 2), ("s", -2), ("A", -2)]),
    unit("Nm", 1.0, &[("kg", 1), ("m", 2), ("s", -2)]),
    unit("1/Nm", 1.0, &[("kg", -1), ("m", -2), ("s", 2)]),
    unit("Nm/A", 1.0, &[("kg", 1), ("m", 2), ("s", -2), ("A", -1)]),
    unit(
        "Nm/deg",
        1.0 / DEG,
        &[("kg", 1), ("m", 2), ("s", -2), ("rad", -1)],
    ),
    unit(
        "Nm s/deg",
        1.0 / DEG,
        &[("kg", 1), ("m", 2), ("s", -1), ("rad", -1)],
    ),
];

/// The unit of this name.
///
/// ```
/// let percent_per_degree = actuator_fmu::units::named("%/deg").unwrap();
/// assert!((percent_per_degree.factor - 0.5729578).abs() < 1e-7);
/// ```
pub fn named(name: &str) -> Option<&'static Unit> {
    UNITS.iter().find(|unit| unit.name == name)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::variables;
    use model_core::scenario;

    #[test]
    fn every_unit_that_a_model_shows_is_known() {
        for settings in scenario::choices() {
            for variable in variables::of(&settings) {
                assert!(named(variable.unit).is_some(), "{variable:?}");
            }
        }
    }
}
