//! Identification: an excitation's predicted errors, the fit of a recording, and what the board and
//! the tuning take over from it.

mod motor;
mod prediction;

use std::collections::BTreeMap;

use host_sim::can::client::ClientError;
use host_sim::fit_page::{self, Content, tables};
use host_sim::plot::html;
use host_sim::table::Table;
use identification::assessment::NonparametricAnalysis;
use identification::{Experiment, Hold, Options, Progress, Recording, models, request::Request};
use serde::Deserialize;
use serde_json::{Value, json};

use super::Context;
use crate::core::Task;
use crate::quantity::place;
use crate::record::Row;
use motor::{Known, TORQUE_CONSTANT, known, torque_constant};

pub use prediction::{Prediction, predict};

/// What is to be fitted.
#[derive(Debug, Deserialize)]
pub struct Identification {
    node: u8,
    model: String,
    from_s: f64,
    to_s: f64,
}

/// The models, for the choice of one.
pub fn models() -> Vec<Value> {
    let all = models::all();
    let all = all.iter();
    all.map(|model| json!({ "name": model.name(), "summary": model.summary() }))
        .collect()
}
pub fn identify(context: Context, order: Identification) {
    let rows: Option<Vec<Row>> = context.core.with_node(order.node, |node| {
        let rows = node.record.rows(order.from_s, order.to_s);
        rows.copied().collect()
    });
    let reply = context.reply.clone();
    let requested = context.core.at_node(order.node, {
        let core = context.core.clone();
        move |client| {
            let known = match known(client) {
                Ok(known) => known,
                Err(error) => return reply.result(Err(error.to_string())),
            };
            let answer = reply.clone();
            let begun = core.spawn(move |_, task| {
                let rows = rows.unwrap_or_default();
                answer.result(fit(&order, known, &rows, &task));
            });
            reply.busy(begun.map(drop));
        }
    });
    context.reply.busy(requested);
}
/// A recording as the identification takes it.
fn recording(order: &Identification, known: Known, rows: &[Row]) -> Recording {
    let column = |place: usize| -> Vec<f64> {
        let values = rows.iter().map(|row| f64::from(row.values[place]));
        values.collect()
    };
    let supply = column(place::SUPPLY);
    let mean_v = supply.iter().sum::<f64>() / supply.len().max(1) as f64;
    let constants = [
        ("winding_resistance_ohm", known.resistance_ohm),
        ("supply_v", mean_v),
    ];
    Recording {
        name: format!("node {}", order.node),
        time_s: rows.iter().map(|row| row.time_s - order.from_s).collect(),
        command_deg: column(place::DEMAND),
        angle_deg: column(place::ANGLE),
        rate_deg_s: Some(column(place::RATE)),
        duty_pct: Some(column(place::DUTY)),
        current_ma: Some(column(place::CURRENT)),
        supply_v: Some(supply),
        hold: Hold::Zero,
        constants: constants
            .map(|(name, value)| (name.to_owned(), value))
            .into_iter()
            .filter(|(_, value)| value.is_finite())
            .collect(),
        ..Recording::default()
    }
}

/// The progress of a search as that of a task.
struct Search<'t>(&'t Task);

impl Progress for Search<'_> {
    fn done(&self, done: usize, of: usize, _: f64) {
        self.0.progress("starts of the search", done, of);
    }

    fn is_stopped(&self) -> bool {
        self.0.is_stopped()
    }
}

fn fit(order: &Identification, known: Known, rows: &[Row], task: &Task) -> Result<Value, String> {
    let model = models::named(&order.model).ok_or("there is no such model")?;
    task.progress("starts of the search", 0, Options::default().starts);
    let experiment =
        Experiment::try_new(recording(order, known, rows)).map_err(|error| error.to_string())?;
    let experiments = [experiment];
    let measured = torque_constant(rows).map(|k| (TORQUE_CONSTANT.to_owned(), k));
    let request = Request {
        fix: measured.into_iter().collect(),
        ..Request::default()
    };
    let assessment = request
        .assess(model, (&experiments, &[]), &[], &Search(task))
        .map_err(|error| error.to_string())?;
    let nonparametric = NonparametricAnalysis::of(&experiments);
    let assessments = [assessment];
    let page = fit_page::page(&Content {
        assessments: &assessments,
        ranking: None,
        nonparametric: &nonparametric,
        notes: &[],
        origin: "",
    });
    let figures: Vec<Value> = page
        .figures()
        .map(|figure| {
            let data: Value = serde_json::from_str(&html::json(figure)).unwrap_or_default();
            json!({ "title": figure.title, "caption": figure.caption, "data": data })
        })
        .collect();
    let [assessment] = &assessments;
    let statements =
        |texts: &[String]| texts.iter().map(|text| statement(text)).collect::<Vec<_>>();
    Ok(json!({
        "model": assessment.name, "fit_percent": assessment.fit.fit_percent,
        "noise_deg": assessment.fit.noise_deg, "samples": rows.len(),
        "is_stopped": task.is_stopped(),
        "parameters": table(&tables::parameters(assessment)),
        "warnings": statements(&assessment.warnings), "doubts": statements(&assessment.doubts), "figures": figures, "motor": motor::motor(assessment, known, rows).ok(),
    }))
}

/// A doubt or warning without advice on options of the command line, which Studio lacks.
fn statement(text: &str) -> String {
    let clauses = text
        .split("; ")
        .filter(|clause| !clause.contains("option `"));
    clauses.collect::<Vec<_>>().join("; ")
}

fn table(table: &Table) -> Value {
    let columns: Vec<_> = table
        .columns
        .iter()
        .map(|c| json!({ "name": c.name, "unit": c.unit }))
        .collect();
    let rows: Vec<Vec<_>> = table
        .rows
        .iter()
        .map(|row| row.iter().map(ToString::to_string).collect())
        .collect();
    json!({ "caption": table.caption, "columns": columns, "rows": rows })
}
pub fn take_over(context: Context, node: u8, values: BTreeMap<String, f64>) {
    context.at_node(node, move |core, client| {
        for (object, value) in &values {
            client.write(object, &value.to_string())?;
            core.with_node(node, |node| node.unsaved.insert(object.clone()));
        }
        // The model starts, or restarts.
        client.write("2010:2", "0")?;
        client.write("2010:2", "1")?;
        Ok::<_, ClientError>(json!(null))
    });
}
