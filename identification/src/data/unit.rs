//! Units of recordings, with their factors to the units used here.

use super::Quantity;

/// Units of times, in s.
const TIMES: [(&str, f64); 13] = [
    ("s", 1.0),
    ("ms", 1e-3),
    ("us", 1e-6),
    ("ns", 1e-9),
    ("min", 60.0),
    ("sec", 1.0),
    ("second", 1.0),
    ("secs", 1.0),
    ("seconds", 1.0),
    ("msec", 1e-3),
    ("millis", 1e-3),
    ("usec", 1e-6),
    ("µs", 1e-6),
];
/// Units of angles, in deg; of the stroke of a linear actuator, in mm, which then stands for deg.
const ANGLES: [(&str, f64); 15] = [
    ("deg", 1.0),
    ("mdeg", 1e-3),
    ("rad", 180.0 / std::f64::consts::PI),
    ("mrad", 0.18 / std::f64::consts::PI),
    ("turn", 360.0),
    ("count12", 360.0 / 4096.0),
    ("mm", 1.0),
    ("m", 1e3),
    ("°", 1.0),
    ("degree", 1.0),
    ("degrees", 1.0),
    ("radians", 180.0 / std::f64::consts::PI),
    ("rev", 360.0),
    ("revs", 360.0),
    ("turns", 360.0),
];
/// Units of lengths.
const LENGTHS: [&str; 2] = ["mm", "m"];
/// Names that are not of a length.
const ANGULAR: [&str; 3] = ["angle", "theta", "q"];
/// Units of rates, in deg/s.
const RATES: [(&str, f64); 11] = [
    ("deg_s", 1.0),
    ("mdeg_s", 1e-3),
    ("deg/s", 1.0),
    ("rad_s", 180.0 / std::f64::consts::PI),
    ("rad/s", 180.0 / std::f64::consts::PI),
    ("rpm", 6.0),
    ("turn/s", 360.0),
    ("rev/s", 360.0),
    ("°/s", 1.0),
    ("mm/s", 1.0),
    ("m/s", 1e3),
];
/// Units of the duty, in %.
const DUTIES: [(&str, f64); 5] = [
    ("pct", 1.0),
    ("mpct", 1e-3),
    ("%", 1.0),
    ("permille", 0.1),
    ("1", 100.0),
];
/// Units of currents, in mA.
const CURRENTS: [(&str, f64); 2] = [("a", 1e3), ("ma", 1.0)];
/// Units of voltages, in V.
const VOLTAGES: [(&str, f64); 2] = [("v", 1.0), ("mv", 1e-3)];

/// The units of a quantity, with their factors.
fn units(quantity: Quantity) -> &'static [(&'static str, f64)] {
    match quantity {
        Quantity::Time => &TIMES,
        Quantity::Command | Quantity::Angle => &ANGLES,
        Quantity::Rate => &RATES,
        Quantity::Duty => &DUTIES,
        Quantity::Current => &CURRENTS,
        Quantity::Supply => &VOLTAGES,
        Quantity::Enabled => &[],
    }
}

/// The factor of a unit by name, or given as a number.
pub fn factor(quantity: Quantity, unit: &str) -> Option<f64> {
    let number = || unit.trim().parse().ok();
    known(quantity, unit).or_else(|| number().filter(|f: &f64| f.is_finite() && *f != 0.0))
}

/// The factor of a unit by name.
fn known(quantity: Quantity, unit: &str) -> Option<f64> {
    let lower = unit.trim().to_ascii_lowercase();
    let found = units(quantity).iter().find(|(name, _)| *name == lower);
    found.map(|(_, factor)| *factor)
}

/// Whether the field of a line of units is one.
pub fn is_known(field: &str) -> bool {
    let field = bare(field).to_ascii_lowercase();
    let of = |quantity: &Quantity| units(*quantity).iter().any(|(name, _)| *name == field);
    Quantity::ALL.iter().any(of)
}

/// A unit without its brackets.
pub fn bare(field: &str) -> &str {
    field.trim().trim_matches(['(', ')', '[', ']'])
}

/// Whether an angle in a column with this name or unit is a length, as of a linear actuator.
pub fn is_length(text: &str) -> bool {
    let text = text.trim_end_matches([')', ']']).to_ascii_lowercase();
    LENGTHS.iter().any(|unit| {
        let base = text.strip_suffix(unit);
        base.is_some_and(|base| base.is_empty() || base.ends_with(['_', ' ', '(', '[']))
    })
}

/// The units of a quantity, in words.
pub fn expected(quantity: Quantity) -> String {
    let names: Vec<&str> = units(quantity).iter().map(|(name, _)| *name).collect();
    match names.first() {
        Some(first) => format!("{}, or a number of {first}", names.join(", ")),
        None => "a number".to_owned(),
    }
}

/// Whether a name ends with the index of an item: a number right behind it, in square brackets, or
/// in round ones where it is no unit.
fn is_item(name: &str) -> bool {
    let Some((base, index)) = name.rsplit_once(['(', '[']) else {
        return false;
    };
    let index = index.trim_end_matches([')', ']']);
    let is_number = !index.is_empty() && index.bytes().all(|c| c.is_ascii_digit());
    let is_unit = name.ends_with(')') && known(Quantity::Duty, index).is_some();
    is_number && !is_unit && !base.ends_with(' ')
}

/// Splits the unit from a column's name: `pos (rad)`, `pos [rad]`, `pos_rad`. The index of an item,
/// as in `position[3]`, is no unit.
pub fn split(quantity: Quantity, name: &str) -> (String, Option<f64>) {
    let name = name.trim().to_ascii_lowercase();
    if let Some((base, unit)) = name.rsplit_once(['(', '[']) {
        let unit = unit.trim_end_matches([')', ']']);
        let is_index = is_item(&name);
        let factor = factor(quantity, unit).filter(|_| !is_index);
        if is_index || factor.is_some() {
            let base = base.trim();
            let (item, _) = base
                .rsplit_once('[')
                .filter(|_| is_item(base))
                .unwrap_or((base, ""));
            return (item.replace([' ', '-'], "_"), factor);
        }
    }
    let name = name.replace([' ', '-'], "_");
    let suffix = units(quantity)
        .iter()
        .filter(|(unit, _)| unit.chars().all(|c| c.is_ascii_alphabetic() || c == '_'))
        .filter_map(|(unit, factor)| {
            let base = name.strip_suffix(unit)?.strip_suffix('_')?;
            // `theta_m` is a measured angle, not metres.
            let is_angle = *unit == "m" && ANGULAR.iter().any(|angle| base.ends_with(angle));
            (!is_angle).then(|| (base.to_owned(), *factor))
        })
        // The longer one of `rad_s` and `s`.
        .min_by_key(|(base, _)| base.len());
    match suffix {
        Some((base, factor)) => (base, Some(factor)),
        None => (name, None),
    }
}
