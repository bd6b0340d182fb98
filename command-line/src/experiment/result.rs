//! Designed inputs as tables and as JSON.

use model_core::parameter::Parameter;
use serde_json::{Value, json};

use host_sim::table::{Cell, Table};
use identification::design::{Designed, ExperimentSetup, Predicted, inputs::Limits};

/// One row per input and one column per parameter.
pub fn table(designs: &[Designed], best: Option<usize>) -> Table {
    let names = designs
        .first()
        .map_or(&[][..], |d| &d.prediction.parameters);
    let columns = [("input", ""), ("amplitude", "deg"), ("rate limited", "%")];
    let names = names.iter().map(|p: &Predicted| (p.name, "%"));
    let columns: Vec<(&str, &str)> = columns.into_iter().chain(names).chain([("", "")]).collect();
    let caption = "Predicted standard errors, as shares of the expected values. A dash: the input does \
        not determine it, or the value is usually zero and within its error.";
    let mut table = Table::new(caption, &columns);
    for (index, design) in designs.iter().enumerate() {
        let prediction = &design.prediction;
        let limited = &prediction.limited;
        let share = 100.0 * limited.rate_limited_s() / limited.duration_s;
        let percent = |p: &Predicted| Cell::Number(p.percent().unwrap_or(f64::NAN), 3);
        let mark = if best == Some(index) { "best" } else { "" };
        let first = [
            design.input.name().into(),
            Cell::Number(design.amplitude_deg, 2),
            Cell::Number(share, 1),
        ];
        let errors = prediction.parameters.iter().map(percent);
        table.push(first.into_iter().chain(errors).chain([mark.into()]));
    }
    table
}

/// The best input as text.
pub fn verdict(design: &Designed) -> String {
    let prediction = &design.prediction;
    let (identified, all) = (prediction.identified(), prediction.parameters.len());
    let others = prediction
        .parameters
        .iter()
        .filter(|p| p.standard_error.is_none());
    let others: Vec<&str> = others.map(|p| p.name).collect();
    let more = match others.is_empty() {
        true => String::new(),
        false => format!(" It does not determine {}.", others.join(", ")),
    };
    format!(
        "{} of {:.2} deg determines {identified} of {all} parameters, the worst to {:.3} %; the angle reaches \
         {:.1} deg.{more}\n{}",
        design.input.name(),
        design.amplitude_deg,
        prediction.worst_percent(),
        prediction.largest_angle_deg,
        simulate(design),
    )
}

/// The options with which `actuator simulate` runs it.
fn simulate(design: &Designed) -> String {
    let set = settings(design).map(|(p, value)| format!(" --set input.{}={value}", p.name));
    format!(
        "simulate --input {}{}",
        design.input.name(),
        set.collect::<String>()
    )
}

/// The parameters of the input that differ from their defaults.
fn settings(design: &Designed) -> impl Iterator<Item = (&'static Parameter, f64)> {
    let input = design.input;
    let values = input.table().iter().enumerate();
    let values = values.filter_map(move |(index, p)| Some((p, input.get(index)?)));
    values.filter(|(p, value)| *value != p.default)
}

/// The command of an input, for `simulate --input-file`.
pub fn csv(design: &Designed, step_s: f64) -> String {
    let mut text = String::from("time_s,command_deg\n");
    for (index, command) in design.command_deg.iter().enumerate() {
        // The command is held between rows: equal values need no row.
        let before = index.checked_sub(1).map(|i| design.command_deg[i]);
        if before != Some(*command) || index + 1 == design.command_deg.len() {
            text += &format!("{},{command}\n", index as f64 * step_s);
        }
    }
    text
}

/// All results as JSON.
pub fn json(
    bench: &ExperimentSetup,
    limits: &Limits,
    designs: &[Designed],
    best: Option<usize>,
) -> String {
    let designed: Vec<Value> = designs.iter().map(design).collect();
    let value = json!({
        "model": bench.model.name(),
        "noise_deg": bench.noise_deg,
        "resolution_deg": bench.resolution_deg,
        "sample_rate_hz": 1.0 / bench.step_s,
        "duration_s": bench.duration_s,
        "bandwidth_hz": limits.bandwidth_hz,
        "inputs": designed,
        "best": best,
    });
    format!("{value:#}\n")
}

fn design(design: &Designed) -> Value {
    let parameter = |p: &Predicted| {
        json!({
            "name": p.name,
            "unit": p.unit,
            "value": p.value,
            "standard_error": p.standard_error,
            "identifiable": p.standard_error.is_some(),
        })
    };
    let prediction = &design.prediction;
    let settings = settings(design).map(|(p, value)| (p.name.to_owned(), json!(value)));
    json!({
        "name": design.input.name(),
        "beyond_rate_limit": design.is_beyond,
        "amplitude_deg": design.amplitude_deg,
        "settings": serde_json::Map::from_iter(settings),
        "rate_limited_s": prediction.limited.rate_limited_s(),
        "largest_angle_deg": prediction.largest_angle_deg,
        "parameters": prediction.parameters.iter().map(parameter).collect::<Vec<_>>(),
        "simulate": simulate(design),
    })
}
