//! Identification: the predicted standard errors of an excitation, the fit of a recording, and what
//! the board and the tuning take over from it.

use std::collections::BTreeMap;

use host_sim::can::client::{Client, ClientError};
use host_sim::can::{excitation, motor_objects, names};
use host_sim::fit_page::{self, Content, tables};
use host_sim::plot::html;
use host_sim::scenario::Scenario;
use host_sim::settings::{ModelKind, PlantKind, Settings};
use host_sim::table::Table;
use identification::assessment::{Assessment, NonparametricAnalysis};
use identification::design::ExperimentSetup;
use identification::{
    Experiment, Hold, Options, Progress, Recording, models, parameter_file, request::Request,
};
use model_core::actuator::Actuator;
use model_core::time::{CONTROL_PERIOD_TICKS, seconds, ticks};
use serde::Deserialize;
use serde_json::{Value, json};

use super::objects::address;
use super::{Context, ExcitationValues};
use crate::core::Task;
use crate::quantity::place;
use crate::record::Row;

/// The longest excitation for which errors are predicted, s.
const LONGEST_S: f64 = 120.0;

/// What is to be predicted.
#[derive(Debug, Deserialize)]
pub struct Prediction {
    model: String,
    settings: ExcitationValues,
}

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

pub fn predict(context: Context, wanted: Prediction) {
    let reply = context.reply.clone();
    let begun = context
        .core
        .spawn(move |_, _| reply.result(prediction(&wanted)));
    context.reply.busy(begun.map(drop));
}

/// The command of an excitation in each control period, until the shaft is at rest behind it.
fn command(settings: &ExcitationValues) -> Result<Vec<f64>, String> {
    let settings = excitation::settings(&settings.0).map_err(|error| error.to_string())?;
    let run = settings.run().ok_or("these settings exclude each other")?;
    let length = run.ticks.saturating_mul(u64::from(run.more) + 1);
    if length > ticks(LONGEST_S) {
        let length_s = seconds(length);
        return Err(format!(
            "the excitation takes {length_s:.0} s, expected at most {LONGEST_S} s"
        ));
    }
    let periods = (length + ticks(AFTER_S)) / CONTROL_PERIOD_TICKS;
    let command = |period: u64| {
        let tick = period * CONTROL_PERIOD_TICKS;
        match tick < length {
            true => run.sample(tick % run.ticks.max(1)).angle.to_f64(),
            false => 0.0,
        }
    };
    Ok((0..periods).map(command).collect())
}

/// The recording that is expected of the simulated actuator.
fn expected(settings: &Settings, command: &[f64]) -> Result<Recording, String> {
    let mut actuator = Actuator::try_new(settings).map_err(|error| error.to_string())?;
    let mut recording = Recording {
        name: "expected".into(),
        command_deg: command.to_vec(),
        hold: Hold::Zero,
        ..Recording::default()
    };
    let mut duty_pct = Vec::new();
    for (period, command) in (0..).zip(command) {
        recording
            .time_s
            .push(seconds(period * CONTROL_PERIOD_TICKS));
        recording.angle_deg.push(actuator.reading().angle_deg);
        actuator
            .advance(*command, CONTROL_PERIOD_TICKS)
            .map_err(|_| "the command is no angle".to_owned())?;
        duty_pct.push(actuator.reading().duty_pct);
    }
    recording.duty_pct = Some(duty_pct);
    Ok(recording)
}

/// The parameter that is measured and not fitted: without a known load, an angle tells only the
/// ratios of torque constant, inertia and friction.
const TORQUE_CONSTANT: &str = "torque_constant_nm_a";

/// Rate below which the noise of rate and back-EMF matters, deg/s.
const SLOWEST_DEG_S: f64 = 30.0;

/// The torque constant at the output: back-EMF per rate, by least squares over the samples in
/// motion; `None` if there are too few.
fn torque_constant(rows: &[Row]) -> Option<f64> {
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

/// Sets the expected values of a motor to those of the actuator's data sheet: at the output, since
/// only the product of torque constant and gear ratio shows.
fn expect_motor(setup: &mut ExperimentSetup, settings: &Settings) -> Result<(), String> {
    let objects = motor_objects::of(settings).map_err(|error| error.to_string())?;
    let [ohm, nm_a, ratio, inertia, viscous, coulomb] = objects.map(|(_, value)| value);
    let mut values = settings.values();
    let supply = values.find(|value| value.parameter.name == "supply_v");
    for (name, value) in [
        ("winding_resistance_ohm", ohm),
        (TORQUE_CONSTANT, nm_a * ratio),
        ("motor_inertia_kg_m2", inertia),
        ("viscous_friction_nm_s_deg", viscous.to_radians()),
        ("coulomb_friction_nm", coulomb),
        ("supply_v", supply.map_or(f64::NAN, |value| value.value)),
    ] {
        if let Some(index) = setup.model.parameter_index(name) {
            setup.values[index] = value;
            // The back-EMF tells it.
            setup.free[index] &= name != TORQUE_CONSTANT;
        }
    }
    Ok(())
}

fn prediction(wanted: &Prediction) -> Result<Value, String> {
    let model = models::named(&wanted.model).ok_or("there is no such model")?;
    let command = command(&wanted.settings)?;
    let settings = Settings::new(ModelKind::Board, PlantKind::Drivetrain);
    let mut setup = ExperimentSetup::new(model);
    expect_motor(&mut setup, &settings)?;
    let takes_command = setup.model.accepts(&Recording::default()).is_ok();
    let prediction = match takes_command {
        true => setup.predict(&command),
        false => setup.predict_recording(expected(&settings, &command)?),
    };
    let prediction = prediction.map_err(|error| error.to_string())?;
    let parameters: Vec<_> = prediction
        .parameters
        .iter()
        .map(|p| {
            json!({
                "name": p.name, "unit": p.unit, "value": p.value,
                "standard_error": p.standard_error, "percent": p.percent().filter(|p| p.is_finite()),
            })
        })
        .collect();
    Ok(json!({
        "parameters": parameters, "largest_angle_deg": prediction.largest_angle_deg,
        "limited_s": prediction.limited.rate_limited_s(), "noise_deg": setup.noise_deg,
    }))
}

/// Time behind an excitation that is recorded, s.
const AFTER_S: f64 = 0.5;

pub fn identify(context: Context, wanted: Identification) {
    let rows: Option<Vec<Row>> = context.core.with_node(wanted.node, |node| {
        let rows = node.record.rows(wanted.from_s, wanted.to_s);
        rows.copied().collect()
    });
    let reply = context.reply.clone();
    let requested = context.core.at_node(wanted.node, {
        let core = context.core.clone();
        move |client| {
            let known = match known(client) {
                Ok(known) => known,
                Err(error) => return reply.result(Err(error.to_string())),
            };
            let answer = reply.clone();
            let begun = core.spawn(move |_, task| {
                let rows = rows.unwrap_or_default();
                answer.result(fit(&wanted, known, &rows, &task));
            });
            reply.busy(begun.map(drop));
        }
    });
    context.reply.busy(requested);
}

/// What the actuator itself knows of its motor, and an experiment cannot tell: only the ratio of the
/// torque constant to the resistance shows, and only its product with the gear ratio.
#[derive(Debug, Clone, Copy)]
struct Known {
    resistance_ohm: f64,
    gear_ratio: f64,
}

fn known(client: &mut Client) -> Result<Known, ClientError> {
    let mut real = |path| match client.get(names::of_value(path)?)? {
        names::Value::Real(value) => Ok(f64::from(value)),
        other => Err(ClientError::NotAnInteger(other.to_string())),
    };
    Ok(Known {
        resistance_ohm: real("values.model.resistance_ohm")?,
        gear_ratio: real("values.model.gear_ratio")?,
    })
}

/// A recording as the identification takes it.
fn recording(wanted: &Identification, known: Known, rows: &[Row]) -> Recording {
    let constants = [("winding_resistance_ohm", known.resistance_ohm)];
    let column = |place: usize| {
        rows.iter()
            .map(|row| f64::from(row.values[place]))
            .collect()
    };
    Recording {
        name: format!("node {}", wanted.node),
        time_s: rows.iter().map(|row| row.time_s - wanted.from_s).collect(),
        command_deg: column(place::DEMAND),
        angle_deg: column(place::ANGLE),
        rate_deg_s: Some(column(place::RATE)),
        duty_pct: Some(column(place::DUTY)),
        current_ma: Some(column(place::CURRENT)),
        supply_v: Some(column(place::SUPPLY)),
        hold: Hold::Zero,
        constants: constants
            .map(|(name, value)| (name.to_owned(), value))
            .into(),
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

fn fit(wanted: &Identification, known: Known, rows: &[Row], task: &Task) -> Result<Value, String> {
    let model = models::named(&wanted.model).ok_or("there is no such model")?;
    task.progress("starts of the search", 0, Options::default().starts);
    let experiment =
        Experiment::try_new(recording(wanted, known, rows)).map_err(|error| error.to_string())?;
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
    });
    let figures: Vec<Value> = page
        .figures()
        .map(|figure| {
            let data: Value = serde_json::from_str(&html::json(figure)).unwrap_or_default();
            json!({ "title": figure.title, "caption": figure.caption, "data": data })
        })
        .collect();
    let [assessment] = &assessments;
    let warnings: Vec<_> = assessment
        .warnings
        .iter()
        .map(ToString::to_string)
        .collect();
    Ok(json!({
        "model": assessment.name, "fit_percent": assessment.fit.fit_percent,
        "noise_deg": assessment.fit.noise_deg, "samples": rows.len(),
        "is_stopped": task.is_stopped(),
        "parameters": table(&tables::parameters(assessment)),
        "warnings": warnings, "figures": figures, "motor": motor(assessment, known, rows).ok(),
    }))
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

/// The fitted motor as objects of the board's model, and as the motor of the tuning.
fn motor(assessment: &Assessment, known: Known, rows: &[Row]) -> Result<Value, String> {
    let text = parameter_file::text(&assessment.fit).map_err(|error| error.to_string())?;
    let scenario: Scenario = toml::from_str(&text).map_err(|error| error.to_string())?;
    let settings = scenario.settings().map_err(|error| error.to_string())?;
    let mut objects = motor_objects::of(&settings).map_err(|error| error.to_string())?;
    let [ohm, nm_a, ratio, inertia, viscous, _] = objects.map(|(_, value)| value);
    // The motor of the fit is at the output.
    let k = nm_a * ratio;
    objects[1].1 = k / known.gear_ratio;
    objects[2].1 = known.gear_ratio;
    let supplies = rows.iter().map(|row| f64::from(row.values[place::SUPPLY]));
    let supply_v = supplies.sum::<f64>() / rows.len().max(1) as f64;
    // Without Coulomb friction and inductance: J w' = k (u - k w)/R - b w, of which the duty gives u
    // as a share of the supply voltage.
    let damping = viscous + k * k / ohm;
    let gain_rad_s_v = k / ohm / damping;
    let values = objects.iter().map(|(row, value)| {
        json!({ "object": address(row), "name": names::name(row), "unit": row.unit, "value": value })
    });
    Ok(json!({
        "objects": values.collect::<Vec<_>>(),
        "remark": motor_objects::omitted_friction(&settings),
        "motor_gain": (gain_rad_s_v * supply_v / 100.0).to_degrees(),
        "motor_time_constant_s": inertia / damping,
    }))
}

pub fn take_over(context: Context, node: u8, values: BTreeMap<String, f64>) {
    context.at_node(node, move |core, client| {
        for (object, value) in &values {
            client.write(object, &value.to_string())?;
            core.with_node(node, |node| node.unsaved.insert(object.clone()));
        }
        // The model starts, or starts anew.
        client.write("2010:2", "0")?;
        client.write("2010:2", "1")?;
        Ok::<_, ClientError>(json!(null))
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A chirp from 0.1 to 6 Hz of 15 deg in 5 s.
    fn chirp() -> ExcitationValues {
        ExcitationValues(vec![(3, 5), (4, 15_000), (5, 100), (6, 6_000), (7, 5_000)])
    }

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

    #[test]
    fn the_errors_of_motors_and_of_models_of_the_command_are_predicted() {
        for (model, parameter) in [
            ("motor-m1", "motor_inertia_kg_m2"),
            ("black-box-2", "delay_s"),
        ] {
            let wanted = Prediction {
                model: model.into(),
                settings: chirp(),
            };
            let answer = prediction(&wanted).expect("it is predicted");
            let parameters = answer["parameters"].as_array().expect("a list");
            let found = parameters.iter().find(|p| p["name"] == parameter);
            let percent = found.expect(parameter)["percent"]
                .as_f64()
                .expect("it is told");
            assert!((0.001..50.0).contains(&percent), "{model}: {answer}");
        }
    }
}
