//! Gains: predicted from a motor and a target, and applied.

use host_sim::analysis::linear_models::{Motor, Timing};
use host_sim::analysis::loop_gain::Margin;
use host_sim::can::{client::ClientError, names};
use host_sim::plot::html;
use host_sim::settings::{ModelKind, PlantKind, Settings};
use host_sim::tune::{
    Goal, InnerLoop, Language, PositionLoop, TuneRequest, Tuning, bode, code, stable_margins,
    tune as compute,
};
use model_core::actuator::Actuator;
use model_core::control::parameters::ControlParameters;
use model_core::parameter::{Parameter, Parameters};
use model_core::time::{CONTROL_PERIOD_TICKS, seconds};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::Context;
use super::objects::address;

/// Motor and target.
#[derive(Debug, Deserialize)]
pub struct TuneValues {
    motor_gain: f64,
    motor_time_constant_s: f64,
    /// Whether the target is that of the position loop.
    is_position: bool,
    inner_bandwidth_rad_s: f64,
    position_share: f64,
    bandwidth_hz: f64,
    phase_margin_deg: f64,
    /// The step that is predicted.
    step_deg: f64,
    /// Gains to be shown in place of computed ones.
    gains: Option<Gains>,
}

/// The gains that tuning computes.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub struct Gains {
    position_gain: f64,
    proportional_gain: f64,
    integral_gain: f64,
    anti_windup_gain: f64,
}

impl Gains {
    fn of(control: &ControlParameters) -> Self {
        Self {
            position_gain: control.position_gain,
            proportional_gain: control.proportional_gain,
            integral_gain: control.integral_gain,
            anti_windup_gain: control.anti_windup_gain,
        }
    }

    fn values(&self) -> [(&'static str, f64); 4] {
        [
            ("position_gain", self.position_gain),
            ("proportional_gain", self.proportional_gain),
            ("integral_gain", self.integral_gain),
            ("anti_windup_gain", self.anti_windup_gain),
        ]
    }
}

fn describe(parameter: &Parameter) -> Value {
    json!({
        "name": parameter.name, "default": parameter.default, "unit": parameter.unit,
        "min": parameter.min, "max": parameter.max, "help": parameter.meaning,
    })
}

/// The fields of the form, from the tables of the tuning.
pub fn parameters() -> Value {
    let list = |table: &[Parameter]| -> Vec<_> { table.iter().map(describe).collect() };
    let gains = ControlParameters::TABLE.iter();
    let of_gain = |p: &&Parameter| {
        Gains::of(&ControlParameters::default())
            .values()
            .iter()
            .any(|(name, _)| *name == p.name)
    };
    let gains: Vec<_> = gains
        .filter(of_gain)
        .map(|p| {
            let row = names::of_value(&format!("control.{}", p.name)).ok();
            json!({ "name": p.name, "symbol": p.symbol, "unit": p.unit, "object": row.map(address) })
        })
        .collect();
    json!({
        "motor": list(Motor::TABLE), "inner": list(InnerLoop::TABLE),
        "position": list(PositionLoop::TABLE), "gains": gains,
    })
}

pub fn tune(context: Context, values: TuneValues) {
    let reply = context.reply.clone();
    let begun = context
        .core
        .spawn(move |_, _| reply.result(answer(&values)));
    context.reply.busy(begun.map(drop));
}

fn request(values: &TuneValues) -> TuneRequest {
    TuneRequest {
        motor: Motor {
            motor_gain: values.motor_gain,
            motor_time_constant_s: values.motor_time_constant_s,
        },
        goal: if values.is_position {
            Goal::Position(PositionLoop {
                bandwidth_hz: values.bandwidth_hz,
                phase_margin_deg: values.phase_margin_deg,
            })
        } else {
            Goal::Inner(InnerLoop {
                inner_bandwidth_rad_s: values.inner_bandwidth_rad_s,
                position_share: values.position_share,
            })
        },
        timing: Timing::default(),
        ..TuneRequest::default()
    }
}

fn answer(values: &TuneValues) -> Result<Value, String> {
    let request = request(values);
    request.motor.check().map_err(|error| error.to_string())?;
    let tuning = compute(&request).map_err(|error| error.to_string())?;
    let margins = stable_margins(&tuning);
    let margin = |margin: Option<Margin>| {
        margin.map(|m| json!({ "value": m.value, "frequency_hz": m.frequency_hz }))
    };
    let figure = bode(&request, &tuning).map_err(|error| error.to_string())?;
    let figure: Value = serde_json::from_str(&html::json(&figure)).unwrap_or_default();
    let warnings: Vec<_> = tuning.warnings.iter().map(ToString::to_string).collect();
    let step = step(&request.motor, &tuning.control, values.step_deg)?;
    let present = match &values.gains {
        Some(gains) => Some(self::step(
            &request.motor,
            &with(&tuning, gains),
            values.step_deg,
        )?),
        None => None,
    };
    let code = |language| code(&request, &tuning, language).map_err(|error| error.to_string());
    Ok(json!({
        "gains": Gains::of(&tuning.control), "bandwidth_hz": tuning.bandwidth_hz,
        "is_stable": margins.stable, "gain_margin_db": margin(margins.gain_db),
        "phase_margin_deg": margin(margins.phase_deg), "delay_margin_s": margins.delay_s,
        "duty_jump_pct": tuning.duty_jump_pct, "warnings": warnings, "bode": figure,
        "step": step, "present_step": present,
        "code": { "gains.m": code(Language::Matlab)?, "gains.py": code(Language::Python)? },
    }))
}

fn with(tuning: &Tuning, gains: &Gains) -> ControlParameters {
    ControlParameters {
        position_gain: gains.position_gain,
        proportional_gain: gains.proportional_gain,
        integral_gain: gains.integral_gain,
        anti_windup_gain: gains.anti_windup_gain,
        ..tuning.control
    }
}

/// Length of a predicted step, s.
const STEP_S: f64 = 1.5;

/// The step of the board with this motor and these gains, by the simulator.
fn step(motor: &Motor, control: &ControlParameters, step_deg: f64) -> Result<Value, String> {
    let mut settings = Settings::new(ModelKind::Board, PlantKind::FirstOrder);
    settings.control = *control;
    settings.first_order.motor_gain_up = motor.motor_gain;
    settings.first_order.motor_gain_down = motor.motor_gain;
    settings.first_order.motor_time_constant_s = motor.motor_time_constant_s;
    let mut actuator = Actuator::try_new(&settings).map_err(|error| error.to_string())?;
    let periods = (STEP_S / seconds(CONTROL_PERIOD_TICKS)) as u64;
    let (mut time, mut angle) = (Vec::new(), Vec::new());
    for period in 0..periods {
        time.push(seconds(period * CONTROL_PERIOD_TICKS));
        angle.push(actuator.reading().angle_deg);
        actuator
            .advance(step_deg, CONTROL_PERIOD_TICKS)
            .map_err(|_| format!("the step is {step_deg} deg, expected an angle"))?;
    }
    Ok(json!({ "t": time, "deg": angle }))
}

pub fn apply(context: Context, node: u8, gains: Gains) {
    context.at_node(node, move |core, client| {
        for (name, value) in gains.values() {
            let row = names::of_value(&format!("control.{name}")).map_err(ClientError::from)?;
            client.set(row, &(value as f32).to_le_bytes())?;
            core.with_node(node, |node| node.unsaved.insert(address(row)));
        }
        Ok::<_, ClientError>(json!(null))
    });
}
