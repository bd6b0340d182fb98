//! The bench of the study: how the board is tuned, what it moves, and which servo it is.

use model_core::sensors::noise::Noise;
use virtual_board::plant::BoardPlantOptions;

/// How the loops of the board are tuned.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Controller {
    /// As the paper prints it: P = 8, F = 10 (1 + 0.1318 s)/s.
    Printed,
    /// So that the loop is the paper's second black box, A = 900 and B = 54, in small motions.
    Retuned,
}

/// The motor as the paper prints it, in the reading of docs/model.md: gain, (deg/s)/%, and pole,
/// 1/s.
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
    /// The zero of the rate loop cancels the motor's pole, so that the loop is `B/s`; around it the
    /// position gain `A/B` makes `A/(s^2 + B s + A)`.
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

    /// The same by index and sub-index of their objects.
    pub fn objects(self) -> Vec<((u16, u8), f64)> {
        let objects = [(0x60FB, 1), (0x60F9, 1), (0x60F9, 2)];
        let values = self.settings().into_iter().map(|(_, value)| value);
        objects.into_iter().zip(values).collect()
    }
}

/// What hangs on the shaft.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Load {
    /// Nothing, as in the paper.
    Unloaded,
    /// A constant torque against positive angles, as of a dynamometer.
    Loaded,
}

/// The torque of [`Load::Loaded`], Nm: a sixth of the stall torque. The motor's rate falls by
/// 5.67 deg/s for 0.001 Nm: it makes the limits unequal as the paper found them.
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

/// Runs of each input, as in the paper's figures.
pub const RUNS: u64 = 5;

/// Standard deviation of the supply, as a share; never more than two of them.
const SUPPLY_SPREAD: f64 = 0.015;
/// The stream of the supply's draws: those of the rig begin at the other end.
const SUPPLY_STREAM: u64 = 1 << 32;

/// The rig of a run: noise, friction and supply by its seed, the same in every run of this number.
pub fn rig(load: Load, run: u64) -> BoardPlantOptions {
    let mut options = BoardPlantOptions::realistic(run);
    let mut chance = Noise::new(run, SUPPLY_STREAM);
    let limit = 2.0 * SUPPLY_SPREAD;
    let spread = chance.gaussian(SUPPLY_SPREAD).clamp(-limit, limit);
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
    fn the_retuned_loop_is_the_second_black_box() {
        let settings = Controller::Retuned.settings();
        let value = |name| settings.iter().find(|(n, _)| *n == name).unwrap().1;
        let ratio = value("proportional_gain") / value("integral_gain");
        assert!(
            (ratio - 1.0 / MOTOR.1).abs() < 1e-12,
            "the zero is on the pole"
        );
        let rate_loop = value("integral_gain") * MOTOR.0;
        assert!((rate_loop - 54.0).abs() < 1e-12);
        assert!((rate_loop * value("position_gain") - 900.0).abs() < 1e-9);
    }

    #[test]
    fn servos_differ_and_stay_within_what_the_board_accepts() {
        let supply = |run| rig(Load::Unloaded, run).drivetrain.electrical.supply_v;
        for run in 1..=RUNS {
            // Over-voltage is at 6.3 V, and the ripple has 0.02 V.
            assert!((5.8..6.2).contains(&supply(run)), "{}", supply(run));
        }
        assert_ne!(supply(1), supply(2));
    }
}
