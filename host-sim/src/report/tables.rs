//! The tables of figures of merit.

use model_core::time::CONTROL_RATE_HZ;

use super::{
    comparison::{Comparison, Outcome},
    metrics::{Pulse, SmallSignalMetrics},
    runs::INPUTS,
};
use crate::{
    analysis::loop_gain::Margins,
    table::{Cell, Table},
};

/// All tables, in the order of the report.
pub fn all(comparison: &Comparison) -> [Table; 4] {
    [
        pulse(comparison),
        other_inputs(comparison),
        small_signals(comparison),
        differences(comparison),
    ]
}

fn pulse(comparison: &Comparison) -> Table {
    let columns = [
        ("model", ""),
        ("rise 10–90 %", "ms"),
        ("t90", "ms"),
        ("overshoot up", "%"),
        ("overshoot down", "%"),
        ("settling up", "ms"),
        ("settling down", "ms"),
        ("fastest up", "deg/s"),
        ("fastest down", "deg/s"),
    ];
    let caption = "Pulse of 90 deg. Times count from the step of the command; settling is to within \
        2 %. A negative overshoot means that the command is not reached.";
    filled(comparison, caption, &columns, |o| {
        let Pulse {
            rise_time_s,
            t90_s,
            overshoot_up_pct,
            overshoot_down_pct,
            settling_up_s,
            settling_down_s,
            max_rate_deg_s,
            min_rate_deg_s,
        } = o.metrics.pulse;
        vec![
            ms(rise_time_s),
            ms(t90_s),
            Cell::optional(overshoot_up_pct, 2),
            Cell::optional(overshoot_down_pct, 2),
            ms(settling_up_s),
            ms(settling_down_s),
            Cell::Number(max_rate_deg_s, 1),
            Cell::Number(min_rate_deg_s, 1),
        ]
    })
}

fn other_inputs(comparison: &Comparison) -> Table {
    let columns = [
        ("model", ""),
        ("variable step: worst overshoot", "deg"),
        ("variable step: overshoots", "of 13"),
        ("variable step: unsettled", "of 13"),
        ("ramp: lag", "deg"),
        ("sine: gain", ""),
        ("sine: phase", "deg"),
    ];
    let caption = "The other inputs. The direction of an overshoot is that from the angle at the \
        step to the command. A step counts as an overshoot if it exceeds 2 % of the step, and as \
        unsettled if the angle is not within 2 % at the next step. The ramp has 60 deg/s, the sine \
        20 deg and 1 Hz.";
    filled(comparison, caption, &columns, |o| {
        let m = &o.metrics;
        vec![
            Cell::Number(m.variable_step.worst_overshoot_deg, 1),
            Cell::Number(m.variable_step.overshot_steps as f64, 0),
            Cell::Number(m.variable_step.unsettled_steps as f64, 0),
            Cell::optional(m.ramp_lag_deg, 2),
            Cell::optional(m.sine_gain, 3),
            Cell::optional(m.sine_phase_deg, 1),
        ]
    })
}

fn small_signals(comparison: &Comparison) -> Table {
    let columns = [
        ("model", ""),
        ("half power", "Hz"),
        ("half power, measured", "Hz"),
        ("−3.000 dB", "Hz"),
        ("gain margin", "dB"),
        ("phase margin", "deg"),
        ("delay margin", "ms"),
    ];
    let caption = format!(
        "Small signals: bandwidths, computed and measured with sines, and margins of the loop opened \
        at the duty, sampled at {CONTROL_RATE_HZ} Hz for the board."
    );
    filled(comparison, &caption, &columns, |o| {
        let SmallSignalMetrics {
            half_power_hz,
            measured_half_power_hz,
            minus_3_db_hz,
            gain_margin_db,
            phase_margin_deg,
            delay_margin_s,
        } = o.metrics.small_signal;
        vec![
            Cell::optional(half_power_hz, 3),
            Cell::optional(measured_half_power_hz, 3),
            Cell::optional(minus_3_db_hz, 3),
            Cell::optional(gain_margin_db, 2),
            Cell::optional(phase_margin_deg, 1),
            ms(delay_margin_s),
        ]
    })
}

fn differences(comparison: &Comparison) -> Table {
    let inputs = INPUTS.map(|input| (input, "deg"));
    let columns: Vec<_> = [("model", "")].into_iter().chain(inputs).collect();
    let caption = "Root mean square of the difference to the angle of the board.";
    filled(comparison, caption, &columns, |o| {
        let of = |input| Cell::optional(o.rms_difference_deg.get(input).copied(), 2);
        INPUTS.map(of).to_vec()
    })
}

/// The margins of named loops.
pub fn margins(caption: &str, loops: &[(&str, Margins)]) -> Table {
    let columns = [
        ("loop", ""),
        ("gain margin", "dB"),
        ("phase margin", "deg"),
        ("delay margin", "ms"),
        ("closed", ""),
    ];
    let mut table = Table::new(caption, &columns);
    for (name, m) in loops {
        // The margins of an unstable loop have no meaning.
        let if_stable = |value: Option<f64>| value.filter(|_| m.stable);
        table.push([
            (*name).into(),
            Cell::optional(if_stable(m.gain_db.map(|m| m.value)), 2),
            Cell::optional(if_stable(m.phase_deg.map(|m| m.value)), 1),
            ms(if_stable(m.delay_s)),
            if m.stable { "stable" } else { "unstable" }.into(),
        ]);
    }
    table
}

/// A table with one row for each model: its name, then the result of `cells`.
fn filled(
    comparison: &Comparison,
    caption: &str,
    columns: &[(&str, &str)],
    cells: impl Fn(&Outcome) -> Vec<Cell>,
) -> Table {
    let mut table = Table::new(caption, columns);
    for outcome in &comparison.outcomes {
        let name = Cell::from(outcome.runs.model.name);
        table.push([name].into_iter().chain(cells(outcome)));
    }
    table
}

fn ms(seconds: Option<f64>) -> Cell {
    Cell::optional(seconds.map(|s| 1e3 * s), 1)
}
