//! The units of the columns of a trace.

/// Suffixes of names of columns, with their units; longer suffixes first.
const ENDINGS: [(&str, &str); 9] = [
    ("_deg_s", "deg/s"),
    ("_deg", "deg"),
    ("_degc", "degC"),
    ("_ma", "mA"),
    ("_pct", "%"),
    ("_nm", "N m"),
    ("_a", "A"),
    ("_v", "V"),
    ("_s", "s"),
];

/// The unit of the column of this name; `1` for a count.
pub fn of(column: &str) -> &'static str {
    ENDINGS
        .iter()
        .find(|(ending, _)| column.ends_with(ending))
        .map_or("1", |(_, unit)| unit)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        scenario::Scenario,
        settings::{ModelKind, PlantKind},
    };

    #[test]
    fn every_column_but_the_counts_of_the_timer_has_a_unit() {
        let bench = Scenario {
            model: Some(ModelKind::Board),
            plant: Some(PlantKind::Drivetrain),
            ..Scenario::default()
        };
        let columns = bench.resolve().expect("it is one").columns();
        let plain: Vec<_> = columns.iter().filter(|name| of(name) == "1").collect();
        assert_eq!(plain, [&"compare_counts"]);
        let some = ["rate_command_deg_s", "load_angle_deg", "current_meas_a"];
        assert_eq!(some.map(of), ["deg/s", "deg", "A"]);
        assert_eq!(of("time_s"), "s");
    }
}
