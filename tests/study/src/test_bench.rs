//! The simulated test bench of the study: gains of the board, load, and parameters of the
//! individual servo.

use model_core::sensors::noise::Noise;
use virtual_board::plant::BoardPlantOptions;

/// Gains of the board's loops.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Controller {
    /// As printed in the paper: P = 8, F = 10 (1 + 0.1318 s)/s.
    Printed,
    /// Such that the loop equals the paper's black box 2, A = 900 and B = 54, for small signals.
    Retuned,
}

/// The motor of the paper, in the interpretation of docs/model.md: gain, (deg/s)/%, and pole, 1/s.
const MOTOR: (f64, f64) = (2.836, 7.586);
/// Black box 2 of the paper: A, 1/s^2, and B, 1/s.
pub const BLACK_BOX_2: (f64, f64) = (900.0, 54.0);

impl Controller {
    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Printed => "printed",
            Self::Retuned => "retuned",
        }
    }

    /// The parameters that are not at their defaults, by name.
    ///
    /// The zero of the rate controller cancels the motor's pole, so that the open rate loop is
    /// `B/s`; with the position gain `A/B` the closed loop is `A/(s^2 + B s + A)`.
    pub fn settings(self) -> Vec<(&'static str, f64)> {
        let ((gain, pole), (a, b)) = (MOTOR, BLACK_BOX_2);
        match self {
            Self::Printed => Vec::new(),
            Self::Retuned => vec![
                ("position_gain", a / b),
                ("proportional_gain", b / (gain * pole)),
                ("integral_gain", b / gain),
            ],
        }
    }

    /// The same parameters by index and sub-index of their objects.
    pub fn objects(self) -> Vec<((u16, u8), f64)> {
        let objects = [(0x60FB, 1), (0x60F9, 1), (0x60F9, 2)];
        let values = self.settings().into_iter().map(|(_, value)| value);
        objects.into_iter().zip(values).collect()
    }
}

/// Load on the shaft.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Load {
    /// Nothing, as in the paper.
    Unloaded,
    /// A constant torque in the negative direction, as from a dynamometer.
    Loaded,
}

/// The torque of [`Load::Loaded`], Nm: a sixth of the stall torque. The motor's rate falls by
/// 5.67 deg/s per 0.001 Nm, which makes the rate limits differ as in the paper.
pub const LOAD_NM: f64 = 0.14;

impl Load {
    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Unloaded => "unloaded",
            Self::Loaded => "loaded",
        }
    }
}

/// Number of runs of each input, as in the paper's figures.
pub const RUNS: u64 = 5;

/// Relative standard deviation of the supply voltage; deviations are limited to twice this value.
const SUPPLY_SPREAD: f64 = 0.015;
/// Random stream of the supply voltage; the streams of the plant count from 0.
const SUPPLY_STREAM: u64 = 1 << 32;

/// Plant options of a run: noise, friction and supply are drawn with the run number as seed.
pub fn plant_options(load: Load, run: u64) -> BoardPlantOptions {
    let mut options = BoardPlantOptions::realistic(run);
    let mut random = Noise::new(run, SUPPLY_STREAM);
    let limit = 2.0 * SUPPLY_SPREAD;
    let spread = random.gaussian(SUPPLY_SPREAD).clamp(-limit, limit);
    options.drivetrain.electrical.supply_v *= 1.0 + spread;
    if load == Load::Loaded {
        options.drivetrain.load.load_torque_nm = -LOAD_NM;
    }
    options
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_retuned_loop_equals_black_box_2() {
        let settings = Controller::Retuned.settings();
        let value = |name| settings.iter().find(|(n, _)| *n == name).unwrap().1;
        let ratio = value("proportional_gain") / value("integral_gain");
        assert!(
            (ratio - 1.0 / MOTOR.1).abs() < 1e-12,
            "the zero cancels the pole"
        );
        let rate_loop = value("integral_gain") * MOTOR.0;
        assert!((rate_loop - 54.0).abs() < 1e-12);
        assert!((rate_loop * value("position_gain") - 900.0).abs() < 1e-9);
    }

    #[test]
    fn supplies_differ_and_stay_below_the_over_voltage_limit() {
        let supply = |run| {
            plant_options(Load::Unloaded, run)
                .drivetrain
                .electrical
                .supply_v
        };
        for run in 1..=RUNS {
            // Over-voltage is at 6.3 V, and the ripple has 0.02 V.
            assert!((5.8..6.2).contains(&supply(run)), "{}", supply(run));
        }
        assert_ne!(supply(1), supply(2));
    }
}
