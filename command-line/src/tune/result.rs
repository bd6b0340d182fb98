//! Gains and the margins of the loop, as tables and as JSON.

use model_core::{control::parameters::ControlParameters, parameter::Parameters};
use serde_json::json;

use super::options::FOUND;
use crate::error::Error;
use crate::output;
use host_sim::{
    analysis::loop_gain::Margin,
    table::{Cell, Table},
    tune::{Tuning, stable_margins},
};

/// Prints the gains, the margins, and the command line that simulates them.
pub fn print(tuning: &Tuning, command: Option<&str>) -> Result<(), Error> {
    output::print_table(&gains(tuning))?;
    output::print_table(&outcome(tuning))?;
    match command {
        Some(command) => output::print(&format!("\nTo simulate it:\n{command}\n")),
        None => Ok(()),
    }
}

fn gains(tuning: &Tuning) -> Table {
    let mut table = Table::new(
        "Gains",
        &["gain", "symbol", "value", "unit"].map(|name| (name, "")),
    );
    for (index, parameter) in ControlParameters::TABLE[..FOUND].iter().enumerate() {
        let value = tuning.control.get(index).unwrap_or(f64::NAN);
        table.push([
            parameter.name.into(),
            parameter.symbol.into(),
            Cell::Number(value, 4),
            parameter.unit.into(),
        ]);
    }
    table
}

fn outcome(tuning: &Tuning) -> Table {
    let columns = [("", ""), ("value", ""), ("unit", ""), ("at", "Hz")];
    let mut table = Table::new("The loop on the board", &columns);
    let number = |value: Option<f64>| value.map_or(Cell::None, |value| Cell::Number(value, 3));
    let margins = stable_margins(tuning);
    let value = |margin: Option<Margin>| margin.map(|m| m.value);
    let place = |margin: Option<Margin>| margin.map(|m| m.frequency_hz);
    let (gain, phase) = (margins.gain_db, margins.phase_deg);
    let delay_ms = margins.delay_s.map(|s| 1e3 * s);
    let rows = [
        (
            "bandwidth of the rate loop, continuous",
            Some(tuning.inner_bandwidth_rad_s),
            "rad/s",
            None,
        ),
        (
            "bandwidth, command to angle",
            tuning.bandwidth_hz,
            "Hz",
            None,
        ),
        ("gain margin", value(gain), "dB", place(gain)),
        ("phase margin", value(phase), "deg", place(phase)),
        ("delay margin", delay_ms, "ms", None),
        (
            "jump of the duty per encoder count",
            Some(tuning.duty_jump_pct),
            "%",
            None,
        ),
    ];
    for (name, value, unit, at) in rows {
        table.push([name.into(), number(value), unit.into(), number(at)]);
    }
    table
}

/// All results as JSON.
pub fn json(tuning: &Tuning, command: Option<&str>) -> String {
    let gains = ControlParameters::TABLE[..FOUND].iter().enumerate();
    let gains = gains.map(|(index, p)| (p.name.to_owned(), json!(tuning.control.get(index))));
    let margin = |margin: Option<Margin>| {
        margin.map(|m| json!({ "value": m.value, "frequency_hz": m.frequency_hz }))
    };
    let margins = stable_margins(tuning);
    let warnings: Vec<_> = tuning.warnings.iter().map(|w| w.to_string()).collect();
    let value = json!({
        "gains": serde_json::Map::from_iter(gains),
        "inner_bandwidth_rad_s": tuning.inner_bandwidth_rad_s,
        "bandwidth_hz": tuning.bandwidth_hz,
        "is_stable": margins.stable,
        "gain_margin_db": margin(margins.gain_db),
        "phase_margin_deg": margin(margins.phase_deg),
        "delay_margin_s": margins.delay_s,
        "duty_jump_pct": tuning.duty_jump_pct,
        "warnings": warnings,
        "simulate": command,
    });
    format!("{value:#}\n")
}
