//! The tables of figures of merit.

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
    let caption = "Pulse of 90 deg. Times count from the command, settling is to within 2 %; a \
        negative overshoot falls short.";
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
            number(overshoot_up_pct, 2),
            number(overshoot_down_pct, 2),
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
        ("variable step: overshot", "of 13"),
        ("variable step: unsettled", "of 13"),
        ("ramp: lag", "deg"),
        ("sine: gain", ""),
        ("sine: phase", "deg"),
    ];
    let caption = "The other inputs. The overshoot is seen from where the angle was when the step \
        came. A step counts as overshot beyond 2 % of it, as unsettled if it is not within 2 % \
        when the next comes. The ramp has 60 deg/s, the sine 20 deg and 1 Hz.";
    filled(comparison, caption, &columns, |o| {
        let m = &o.metrics;
        vec![
            Cell::Number(m.variable_step.worst_overshoot_deg, 1),
            Cell::Number(m.variable_step.overshot_steps as f64, 0),
            Cell::Number(m.variable_step.unsettled_steps as f64, 0),
            number(m.ramp_lag_deg, 2),
            number(m.sine_gain, 3),
            number(m.sine_phase_deg, 1),
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
    let caption = "Small signals: bandwidths, computed and measured by sines, and margins of the \
        loop cut at the duty, sampled at 250 Hz for the board.";
    filled(comparison, caption, &columns, |o| {
        let SmallSignalMetrics {
            half_power_hz,
            measured_half_power_hz,
            minus_3_db_hz,
            gain_margin_db,
            phase_margin_deg,
            delay_margin_s,
        } = o.metrics.small_signal;
        vec![
            number(half_power_hz, 3),
            number(measured_half_power_hz, 3),
            number(minus_3_db_hz, 3),
            number(gain_margin_db, 2),
            number(phase_margin_deg, 1),
            ms(delay_margin_s),
        ]
    })
}

fn differences(comparison: &Comparison) -> Table {
    let inputs = INPUTS.map(|input| (input, "deg"));
    let columns: Vec<_> = [("model", "")].into_iter().chain(inputs).collect();
    let caption = "How far the angle is from that of the board, root mean square.";
    filled(comparison, caption, &columns, |o| {
        let of = |input| number(o.rms_difference_deg.get(input).copied(), 2);
        INPUTS.map(of).to_vec()
    })
}

/// Margins of some loops by name.
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
        // The margins of an unstable loop say nothing that could be read off.
        let if_stable = |value: Option<f64>| value.filter(|_| m.stable);
        table.push([
            (*name).into(),
            number(if_stable(m.gain_db.map(|m| m.value)), 2),
            number(if_stable(m.phase_deg.map(|m| m.value)), 1),
            ms(if_stable(m.delay_s)),
            if m.stable { "stable" } else { "unstable" }.into(),
        ]);
    }
    table
}

/// A table with a row a model, which `cells` fills behind its name.
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

fn number(value: Option<f64>, decimals: usize) -> Cell {
    value.map_or(Cell::None, |value| Cell::Number(value, decimals))
}

fn ms(seconds: Option<f64>) -> Cell {
    number(seconds.map(|s| 1e3 * s), 1)
}
