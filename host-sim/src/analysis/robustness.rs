//! Stability of the sampled loop for every motor of a box, without limits and quantisation.
//!
//! Necessary for the certificates of `docs/proofs.md`, which also cover the duty limit, over the
//! same box.

use super::linear_models::{Loop, Motor, Timing};
use model_core::control::parameters::ControlParameters;
use model_core::parameter::ParameterError;

/// Share by which each of the motor's gain, pole and inertia and the supply may differ.
pub const SPREAD: f64 = 0.3;

/// Motors along each side of the box.
const POINTS: usize = 9;

/// Greatest factor on gains that is tried.
const MOST: f64 = 1e3;

/// A motor of the box, relative to the nominal one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ratios {
    /// Of the steady-state rate.
    pub gain: f64,
    /// Of the pole.
    pub pole: f64,
}

impl Ratios {
    /// The nominal motor.
    pub const ONE: Self = Self {
        gain: 1.0,
        pole: 1.0,
    };

    fn of(self, motor: &Motor) -> Motor {
        Motor {
            motor_gain: motor.motor_gain * self.gain,
            motor_time_constant_s: motor.motor_time_constant_s / self.pole,
        }
    }

    /// Distance from the nominal motor, by factors.
    fn distance(self) -> f64 {
        self.gain.ln().abs() + self.pole.ln().abs()
    }
}

/// The box, nearest motor first. Gain and supply multiply the steady-state rate; the inertia
/// divides the pole.
fn spread_motors() -> Vec<Ratios> {
    let (low, high) = (1.0 - SPREAD, 1.0 + SPREAD);
    let gains = points(low * low, high * high);
    let poles = points(low / high, high / low);
    let all = gains.flat_map(|gain| poles.clone().map(move |pole| Ratios { gain, pole }));
    let mut all: Vec<_> = all.collect();
    all.sort_by(|a, b| a.distance().total_cmp(&b.distance()));
    all
}

/// Points between two ends, in equal factors.
fn points(low: f64, high: f64) -> impl Iterator<Item = f64> + Clone {
    (0..POINTS).map(move |k| low * (high / low).powf(k as f64 / (POINTS - 1) as f64))
}

/// The motor of the box nearest to the nominal one for which the loop is unstable, if there is one.
///
/// # Errors
/// A parameter that is NaN or out of range.
pub fn unstable_motor(
    motor: &Motor,
    control: &ControlParameters,
    timing: &Timing,
) -> Result<Option<Ratios>, ParameterError> {
    Loop::sampled(motor, control, timing)?;
    let is_unstable = |ratios: &Ratios| !is_stable(&ratios.of(motor), control, timing);
    Ok(spread_motors().into_iter().find(is_unstable))
}

/// The least factor above one by which `scale` may multiply gains until the loop is unstable, for
/// the motor itself and for a motor of the box. `None` if the loop is stable up to the end of a
/// gain's range; one if it is unstable as it is.
pub fn stability_limits(
    motor: &Motor,
    control: &ControlParameters,
    timing: &Timing,
    scale: impl Fn(&mut ControlParameters, f64),
) -> [Option<f64>; 2] {
    let of_box = spread_motors();
    [&[Ratios::ONE][..], &of_box].map(|motors| {
        let holds = |factor: f64| {
            let mut control = *control;
            scale(&mut control, factor);
            control.check().ok()?;
            let motors = &mut motors.iter().map(|ratios| ratios.of(motor));
            Some(motors.all(|motor| is_stable(&motor, &control, timing)))
        };
        limit(holds)
    })
}

/// The factor above which a condition does not hold, by steps of 1 % and then by bisection; `None`
/// if it holds up to a factor for which it cannot be evaluated.
fn limit(holds: impl Fn(f64) -> Option<bool>) -> Option<f64> {
    let mut below = 1.0;
    if !holds(below)? {
        return Some(below);
    }
    let mut above = below * 1.01;
    while holds(above)? {
        if above > MOST {
            return None;
        }
        (below, above) = (above, above * 1.01);
    }
    for _ in 0..30 {
        let middle = (below * above).sqrt();
        if holds(middle)? {
            below = middle;
        } else {
            above = middle;
        }
    }
    Some(above)
}

/// Whether the loop is stable; one whose motor or gains are out of range is not.
fn is_stable(motor: &Motor, control: &ControlParameters, timing: &Timing) -> bool {
    Loop::sampled(motor, control, timing).is_ok_and(|servo| servo.closed.is_stable())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::loop_gain::Margins;

    /// Multiplies the gain of the loop that is opened at the duty.
    fn duty_gain(control: &mut ControlParameters, factor: f64) {
        control.proportional_gain *= factor;
        control.integral_gain *= factor;
    }

    #[test]
    fn the_limit_of_the_nominal_motor_is_its_gain_margin() {
        let (motor, control, timing) = Default::default();
        let margins = Margins::of(&Loop::sampled(&motor, &control, &timing).unwrap());
        let margin = 10.0_f64.powf(margins.gain_db.unwrap().value / 20.0);
        let [nominal, of_box] = stability_limits(&motor, &control, &timing, duty_gain);
        assert!((nominal.unwrap() / margin - 1.0).abs() < 1e-6);
        // The greatest gain of the box is 1.69 times the nominal one.
        assert!(of_box.unwrap() <= nominal.unwrap() / 1.69 * (1.0 + 1e-6));
    }

    #[test]
    fn the_box_is_that_of_the_certificates() {
        let motors = spread_motors();
        let most = |f: fn(&Ratios) -> f64| motors.iter().map(f).fold(0.0, f64::max);
        assert!((most(|ratios| ratios.gain) - 1.69).abs() < 1e-12);
        assert!((most(|ratios| ratios.pole) - 1.857).abs() < 1e-3);
        assert!((most(|ratios| 1.0 / ratios.gain) - 1.0 / 0.49).abs() < 1e-12);
        assert!(motors[0].distance() < 0.1);
    }

    #[test]
    fn a_loop_near_its_gain_margin_is_unstable_for_a_motor_of_the_box_only() {
        let (motor, mut control, timing) = Default::default();
        assert_eq!(unstable_motor(&motor, &control, &timing), Ok(None));
        let [nominal, of_box] = stability_limits(&motor, &control, &timing, duty_gain);
        let between = (nominal.unwrap() * of_box.unwrap()).sqrt();
        duty_gain(&mut control, between);
        let found = unstable_motor(&motor, &control, &timing).unwrap().unwrap();
        assert!(found.gain > 1.0, "{found:?}");
        assert!(is_stable(&motor, &control, &timing));
        assert!(!is_stable(&found.of(&motor), &control, &timing));
    }

    #[test]
    fn a_gain_out_of_its_range_is_refused() {
        let control = ControlParameters {
            position_gain: f64::NAN,
            ..Default::default()
        };
        let refused = unstable_motor(&Default::default(), &control, &Default::default());
        assert!(refused.is_err());
    }
}
