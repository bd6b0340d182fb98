//! A joint with a position loop, as simulators of robots step it: semi-implicit Euler.
//!
//! ```text
//! drive = kp (u - q) - kd w, limited to +-limit - k w          u = slew(command)
//! (M + h c) (w1 - w) = h (drive - d w + friction)              q1 = q + h w1
//! ```
//!
//! `c` is what the integrator takes implicitly: `d` and the slope of `drive`, or nothing.

use crate::scalar::Scalar;

use super::law::Step;

/// The limits and laws that a target does not have are neutral.
pub(super) struct Joint<S> {
    pub step_s: f64,
    pub inertia: f64,
    pub stiffness: S,
    pub rate_feedback: S,
    pub damping: S,
    pub torque_limit: S,
    pub back_emf: S,
    pub friction: Option<S>,
    pub slew: Option<S>,
    pub rate_limit: Option<S>,
    /// Whether the integrator is implicit in the damping of the joint, and in the drive.
    pub implicit: (bool, bool),
    /// Whether the limit is one of the joint, of which the integrator knows nothing.
    pub is_limit_of_joint: bool,
    pub setpoint: S,
    pub angle: S,
    pub rate: S,
}

/// MuJoCo's constraint of dry friction with its default `solreffriction` and `solimpfriction`: the
/// impedance, the greatest one, and the time constant, s.
const IMPEDANCE: f64 = 0.9;
const GREATEST_IMPEDANCE: f64 = 0.95;
const FRICTION_TIME_S: f64 = 0.02;

const DEGREE: f64 = std::f64::consts::PI / 180.0;

impl<S: Scalar> Joint<S> {
    /// A joint at rest at zero, with neutral limits.
    pub fn new(step_s: f64, inertia: f64, stiffness: S, torque_limit: S) -> Self {
        let zero = S::constant(0.0);
        Self {
            step_s,
            inertia,
            stiffness,
            rate_feedback: zero,
            damping: zero,
            torque_limit,
            back_emf: zero,
            friction: None,
            slew: None,
            rate_limit: None,
            implicit: (true, true),
            is_limit_of_joint: false,
            setpoint: zero,
            angle: zero,
            rate: zero,
        }
    }

    /// The torque of the motor, and how it falls with the rate.
    fn drive(&self) -> (S, S) {
        let wanted = self.stiffness * (self.setpoint - self.angle) - self.rate_feedback * self.rate;
        let lost = self.back_emf * self.rate;
        let drive = wanted.within(-self.torque_limit - lost, self.torque_limit - lost);
        match self.is_limit_of_joint || drive.value() == wanted.value() {
            true => (drive, self.rate_feedback),
            false => (drive, self.back_emf),
        }
    }

    /// Dry friction against a smooth torque, as MuJoCo's soft constraint.
    fn friction(&self, smooth: S) -> S {
        let Some(greatest) = self.friction else {
            return S::constant(0.0);
        };
        let time_s = FRICTION_TIME_S.max(2.0 * self.step_s);
        let stiffness = 2.0 / (GREATEST_IMPEDANCE * time_s);
        let stopping = -(self.rate * (self.inertia * stiffness) + smooth) * IMPEDANCE;
        stopping.within(-greatest, greatest)
    }
}

impl<S: Scalar> Step<S> for Joint<S> {
    fn step(&mut self, command_deg: S) -> S {
        let before = self.angle;
        let command = command_deg * DEGREE;
        self.setpoint = match self.slew {
            Some(slew) => {
                let most = slew * self.step_s;
                self.setpoint + (command - self.setpoint).within(-most, most)
            }
            None => command,
        };
        let (drive, slope) = self.drive();
        let smooth = drive - self.damping * self.rate;
        let torque = smooth + self.friction(smooth);
        let mut inertia = S::constant(self.inertia);
        if self.implicit.0 {
            inertia = inertia + self.damping * self.step_s;
        }
        if self.implicit.1 {
            inertia = inertia + slope * self.step_s;
        }
        let rate = self.rate + torque * self.step_s / inertia;
        self.rate = match self.rate_limit {
            Some(limit) => rate.within(-limit, limit),
            None => rate,
        };
        self.angle = self.angle + self.rate * self.step_s;
        before * (1.0 / DEGREE)
    }
}
