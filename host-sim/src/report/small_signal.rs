//! The linear models of the report's models.

use crate::{
    analysis::{
        linear_models::{Loop, Motor, Timing, black_box_1, black_box_2},
        loop_gain::Margins,
        transfer_function::TransferFunction,
    },
    error::Error,
    settings::{ModelKind, PlantKind, Settings},
};
use model_core::{control::parameters::ControlParameters, models::grey_box::GreyBoxParameters};

/// The linear model of a model, without limits.
#[derive(Debug, Clone, PartialEq)]
pub struct SmallSignal {
    /// From command to angle, without the transport delay.
    pub closed: TransferFunction,
    /// Margins of its loop, sampled for the board. A black box has no loop.
    pub margins: Option<Margins>,
}

impl SmallSignal {
    /// The linear model of these parameters. `None` for the bench, whose friction makes it
    /// nonlinear at any amplitude.
    ///
    /// ```
    /// use host_sim::analysis::frequency::bandwidth_hz;
    /// use host_sim::report::small_signal::SmallSignal;
    /// use host_sim::settings::{ModelKind, PlantKind, Settings};
    /// let settings = Settings::new(ModelKind::BlackBox1, PlantKind::FirstOrder);
    /// let linear = SmallSignal::of(&settings).unwrap().unwrap();
    /// assert!((bandwidth_hz(&linear.closed).unwrap() - 4.7746).abs() < 1e-4);
    /// ```
    ///
    /// # Errors
    /// [`Error::Parameter`] for a parameter that has no linear model.
    pub fn of(settings: &Settings) -> Result<Option<Self>, Error> {
        let s = settings;
        Ok(Some(match (s.model, s.plant) {
            (ModelKind::BlackBox1, _) => Self::open(black_box_1(s.black_box_1.pole_rad_s)),
            (ModelKind::BlackBox2, _) => {
                let p = &s.black_box_2;
                Self::open(black_box_2(p.position_gain_per_s2, p.rate_gain_per_s))
            }
            (ModelKind::GreyBox, _) => Self::around(grey_box(&s.grey_box)?),
            (ModelKind::Board, PlantKind::FirstOrder) => {
                Self::around(sampled(s, Timing::default())?)
            }
            (ModelKind::Board, PlantKind::Drivetrain) => return Ok(None),
        }))
    }

    fn open(closed: TransferFunction) -> Self {
        Self {
            closed,
            margins: None,
        }
    }

    fn around(servo: Loop) -> Self {
        let margins = Some(Margins::of(&servo));
        Self {
            closed: servo.closed,
            margins,
        }
    }
}

/// The board's sampled loop around its first-order motor.
///
/// # Errors
/// [`Error::Parameter`] for a parameter that has no linear model.
pub fn sampled(settings: &Settings, timing: Timing) -> Result<Loop, Error> {
    let p = &settings.first_order;
    let motor = motor(p.motor_gain_up, p.motor_gain_down, p.motor_time_constant_s);
    Ok(Loop::sampled(&motor, &settings.control, &timing)?)
}

fn grey_box(p: &GreyBoxParameters) -> Result<Loop, Error> {
    let control = ControlParameters {
        position_gain: p.position_gain,
        proportional_gain: p.proportional_gain,
        integral_gain: p.integral_gain,
        ..ControlParameters::default()
    };
    let motor = motor(p.motor_gain_up, p.motor_gain_down, p.motor_time_constant_s);
    Ok(Loop::continuous(&motor, &control)?)
}

/// The linear approximation of a motor with different gains up and down: for a symmetric sine the
/// duties are in the inverse ratio of the gains, so the inverses are averaged.
fn motor(gain_up: f64, gain_down: f64, motor_time_constant_s: f64) -> Motor {
    let motor_gain = if gain_up == gain_down {
        gain_up
    } else {
        2.0 / (1.0 / gain_up + 1.0 / gain_down)
    };
    Motor {
        motor_gain,
        motor_time_constant_s,
    }
}
