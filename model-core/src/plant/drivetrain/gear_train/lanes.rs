//! Several gear trains at once, bit for bit those of [`GearTrain`].
//!
//! A selection takes the place of each branch, so that a loop over the lanes becomes vectors; the
//! operations and their order are those of a single train. Sums with a zero that a single train
//! computes are left out where they change no bit.

use core::array::from_fn;

use super::super::or_rest;
use super::{GearTrain, Load};
use crate::plant::lanes::{greater, lesser};

/// One element a train.
type Lanes<const N: usize> = [f64; N];

/// Gear trains with friction M1, without a pendulum and not jammed.
#[derive(Debug, Clone)]
pub(in crate::plant::drivetrain) struct TrainLanes<const N: usize> {
    constants: Constants<N>,
    /// Body by body, from the motor on.
    bodies: [Bodies<N>; 3],
}

/// One body of each train.
#[derive(Debug, Clone, Copy)]
struct Bodies<const N: usize> {
    angle_rad: Lanes<N>,
    rate_rad_s: Lanes<N>,
}

#[derive(Debug, Clone)]
struct Constants<const N: usize> {
    step_s: Lanes<N>,
    /// Of each body, with the damping of the load in a step.
    inertia_kg_m2: [Lanes<N>; 3],
    inverse_1_kg_m2: [Lanes<N>; 3],
    /// Of each joint.
    stiffness_nm: [Lanes<N>; 2],
    damping_nm_s: [Lanes<N>; 2],
    /// Of the first joint; the second has none.
    half_gap_rad: Lanes<N>,
    coulomb_nm: Lanes<N>,
    viscous_nm_s: Lanes<N>,
    bearing_nm: Lanes<N>,
    stop_rad: Lanes<N>,
    /// The load's constant torque.
    external_nm: Lanes<N>,
    hinge_nm_rad: Lanes<N>,
    load_damping_nm_s: Lanes<N>,
}

/// How many bodies a train has, and which of them is the output.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(in crate::plant::drivetrain) enum Chain {
    /// Motor, output and load.
    Three,
    /// The motor, and output and load as one.
    RigidShaft,
    /// Motor and output as one, and the load.
    RigidGears,
    /// All as one.
    Rigid,
}

impl GearTrain {
    /// The chain; `None` if the train is not one of [`TrainLanes`].
    pub fn chain(&self, load: &Load) -> Option<Chain> {
        if self.is_jammed || load.weight_nm != 0.0 || self.friction.viscous().is_none() {
            return None;
        }
        match (self.count, self.output) {
            (3, 1) => Some(Chain::Three),
            (2, 1) => Some(Chain::RigidShaft),
            (2, 0) => Some(Chain::RigidGears),
            (1, 0) => Some(Chain::Rigid),
            _ => None,
        }
    }
}

impl<const N: usize> TrainLanes<N> {
    /// These trains, which all have the same chain, with their loads and steps.
    pub fn new(trains: [(&GearTrain, &Load, f64); N]) -> Self {
        let body = |i: usize, lane: usize| &trains[lane].0.bodies[i];
        let joint = |i: usize, lane: usize| &trains[lane].0.joints[i];
        let viscous = |lane: usize| trains[lane].0.friction.viscous().unwrap_or_default();
        let inertia = |i: usize, lane: usize| {
            let (train, load, step_s) = &trains[lane];
            train.bodies[i].damped_inertia_kg_m2(i + 1 == train.count, load, *step_s)
        };
        let constants = Constants {
            step_s: trains.map(|(_, _, step_s)| step_s),
            inertia_kg_m2: from_fn(|i| from_fn(|lane| inertia(i, lane))),
            inverse_1_kg_m2: from_fn(|i| from_fn(|lane| 1.0 / inertia(i, lane))),
            stiffness_nm: from_fn(|i| from_fn(|lane| joint(i, lane).stiffness_nm)),
            damping_nm_s: from_fn(|i| from_fn(|lane| joint(i, lane).damping_nm_s)),
            half_gap_rad: from_fn(|lane| joint(0, lane).half_gap_rad),
            coulomb_nm: from_fn(|lane| viscous(lane).0),
            viscous_nm_s: from_fn(|lane| viscous(lane).1),
            bearing_nm: trains.map(|(train, ..)| train.bearing_nm),
            stop_rad: trains.map(|(train, ..)| train.stop_rad),
            external_nm: trains.map(|(_, load, _)| load.external_nm()),
            hinge_nm_rad: trains.map(|(_, load, _)| load.hinge_nm_rad),
            load_damping_nm_s: trains.map(|(_, load, _)| load.damping_nm_s),
        };
        let bodies = from_fn(|i| Bodies {
            angle_rad: from_fn(|lane| body(i, lane).angle_rad),
            rate_rad_s: from_fn(|lane| body(i, lane).rate_rad_s),
        });
        Self { constants, bodies }
    }

    /// Rate of a motor.
    #[inline(always)]
    pub fn motor_rad_s(&self, lane: usize) -> f64 {
        self.bodies[0].rate_rad_s[lane]
    }

    /// Angle and rate of an output.
    #[inline(always)]
    pub fn output<const OUTPUT: usize>(&self, lane: usize) -> super::Motion {
        let body = &self.bodies[OUTPUT];
        (body.angle_rad[lane], body.rate_rad_s[lane])
    }

    /// Takes over the motion of a train.
    pub fn keep(&mut self, other: &Self, lane: usize) {
        for (body, other) in self.bodies.iter_mut().zip(&other.bodies) {
            body.angle_rad[lane] = other.angle_rad[lane];
            body.rate_rad_s[lane] = other.rate_rad_s[lane];
        }
    }

    /// As [`GearTrain::settle`].
    pub fn settle(&mut self) {
        for body in &mut self.bodies {
            for rate_rad_s in &mut body.rate_rad_s {
                *rate_rad_s = or_rest(*rate_rad_s);
            }
        }
    }

    /// One step of a train with this motor torque, if it is taken.
    #[inline(always)]
    pub fn step<const COUNT: usize, const OUTPUT: usize>(
        &mut self,
        lane: usize,
        motor_nm: f64,
        is_taken: bool,
    ) {
        let constants = &self.constants;
        let step_s = constants.step_s[lane];
        let angles: [f64; COUNT] = from_fn(|i| self.bodies[i].angle_rad[lane]);
        let rates: [f64; COUNT] = from_fn(|i| self.bodies[i].rate_rad_s[lane]);
        let mut behind = [-constants.load_nm(lane, angles[COUNT - 1], rates[COUNT - 1]); COUNT];
        for i in 1..COUNT {
            let lead_rad = angles[i - 1] - angles[i];
            let damping_nm = constants.damping_nm_s[i - 1][lane] * (rates[i - 1] - rates[i]);
            behind[i - 1] = if i == 1 {
                constants.first_joint_nm(lane, lead_rad, damping_nm)
            } else {
                constants.stiffness_nm[i - 1][lane] * lead_rad + damping_nm
            };
        }
        for i in 0..COUNT {
            let before = if i == 0 { motor_nm } else { behind[i - 1] };
            let bearing_nm = if i == OUTPUT {
                constants.bearing_nm[lane]
            } else {
                0.0
            };
            let momentum =
                constants.inertia_kg_m2[i][lane] * rates[i] + (before - behind[i]) * step_s;
            let left = if i == 0 {
                let gearbox_nm =
                    constants.coulomb_nm[lane] + constants.viscous_nm_s[lane] * rates[0].abs();
                momentum - limited(momentum, (gearbox_nm + bearing_nm) * step_s)
            } else if i == OUTPUT {
                momentum - limited(momentum, bearing_nm * step_s)
            } else {
                // What remains of a negative zero without friction is a positive one.
                momentum + 0.0
            };
            let mut rate = left * constants.inverse_1_kg_m2[i][lane];
            let mut angle = angles[i] + rate * step_s;
            if i == OUTPUT {
                let stop_rad = constants.stop_rad[lane];
                let stopped = limited(angle, stop_rad);
                let is_held = (angle.abs() > stop_rad) & (stopped * rate > 0.0);
                rate = if is_held { 0.0 } else { rate };
                angle = stopped;
            }
            let body = &mut self.bodies[i];
            body.angle_rad[lane] = if is_taken { angle } else { angles[i] };
            body.rate_rad_s[lane] = if is_taken { rate } else { rates[i] };
        }
    }
}

impl<const N: usize> Constants<N> {
    #[inline(always)]
    fn load_nm(&self, lane: usize, angle_rad: f64, rate_rad_s: f64) -> f64 {
        let torque_nm = self.external_nm[lane] - self.hinge_nm_rad[lane] * angle_rad;
        torque_nm - self.load_damping_nm_s[lane] * rate_rad_s
    }

    /// The torque of the joint that may have backlash.
    #[inline(always)]
    fn first_joint_nm(&self, lane: usize, lead_rad: f64, damping_nm: f64) -> f64 {
        let gap = self.half_gap_rad[lane];
        let offset_rad = if lead_rad < -gap { -gap } else { gap };
        let torque_nm = self.stiffness_nm[0][lane] * (lead_rad - offset_rad) + damping_nm;
        let is_gapless = gap == 0.0;
        let may_push = (lead_rad > gap) | is_gapless;
        let may_pull = (lead_rad < -gap) | is_gapless;
        let torque_nm = if (torque_nm > 0.0) & !may_push {
            0.0
        } else {
            torque_nm
        };
        if (torque_nm < 0.0) & !may_pull {
            0.0
        } else {
            torque_nm
        }
    }
}

/// `value` limited to plus and minus a limit that is not negative.
#[inline(always)]
fn limited(value: f64, limit: f64) -> f64 {
    // The limit first: of equal zeros the value remains.
    lesser(limit, greater(-limit, value))
}
