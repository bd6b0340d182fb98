//! Several gear trains at once, in the steps of [`GearTrain`].
//!
//! The numbers of a train are taken from arrays with one element a train and its motion is stored
//! there again, so that a loop over the lanes becomes vectors.

use core::array::from_fn;

use super::super::{friction::viscous_nm, or_rest};
use super::{Body, GearTrain, Joint, Load, Motion, Step};

/// Numbers of a train that no step changes.
const CONSTANTS: usize = 19;

/// Gear trains with friction M1, without a pendulum and not jammed.
#[derive(Debug, Clone)]
pub(in crate::plant::drivetrain) struct TrainLanes<const N: usize> {
    /// In the order of [`constants`].
    constants: [[f64; N]; CONSTANTS],
    /// Body by body, from the motor on.
    angle_rad: [[f64; N]; 3],
    rate_rad_s: [[f64; N]; 3],
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

fn constants((train, load, step_s): (&GearTrain, &Load, f64)) -> [f64; CONSTANTS] {
    let inertia =
        |i: usize| train.bodies[i].damped_inertia_kg_m2(i + 1 == train.count, load, step_s);
    let [first, second] = train.joints;
    let (coulomb_nm, viscous_nm_s) = train.friction.viscous().unwrap_or_default();
    [
        step_s,
        inertia(0),
        inertia(1),
        inertia(2),
        1.0 / inertia(0),
        1.0 / inertia(1),
        1.0 / inertia(2),
        first.stiffness_nm,
        first.damping_nm_s,
        first.half_gap_rad,
        second.stiffness_nm,
        second.damping_nm_s,
        coulomb_nm,
        viscous_nm_s,
        train.bearing_nm,
        train.stop_rad,
        load.external_nm(),
        load.hinge_nm_rad,
        load.damping_nm_s,
    ]
}

impl<const N: usize> TrainLanes<N> {
    /// These trains, which all have the same chain, with their loads and steps.
    pub fn new(trains: [(&GearTrain, &Load, f64); N]) -> Self {
        let all = trains.map(constants);
        let body = |i: usize, lane: usize| &trains[lane].0.bodies[i];
        Self {
            constants: from_fn(|i| all.map(|constants| constants[i])),
            angle_rad: from_fn(|i| from_fn(|lane| body(i, lane).angle_rad)),
            rate_rad_s: from_fn(|i| from_fn(|lane| body(i, lane).rate_rad_s)),
        }
    }

    /// Rate of a motor.
    #[inline(always)]
    pub fn motor_rad_s(&self, lane: usize) -> f64 {
        self.rate_rad_s[0][lane]
    }

    /// Angle and rate of an output.
    #[inline(always)]
    pub fn output<const OUTPUT: usize>(&self, lane: usize) -> Motion {
        (self.angle_rad[OUTPUT][lane], self.rate_rad_s[OUTPUT][lane])
    }

    /// Takes over the motion of a train.
    pub fn keep(&mut self, other: &Self, lane: usize) {
        for i in 0..3 {
            self.angle_rad[i][lane] = other.angle_rad[i][lane];
            self.rate_rad_s[i][lane] = other.rate_rad_s[i][lane];
        }
    }

    /// As [`GearTrain::settle`].
    pub fn settle(&mut self) {
        for rate_rad_s in self.rate_rad_s.as_flattened_mut() {
            *rate_rad_s = or_rest(*rate_rad_s);
        }
    }

    /// One step of a train with this motor torque, if it is taken.
    #[inline(always)]
    pub fn advance<const COUNT: usize, const OUTPUT: usize>(
        &mut self,
        lane: usize,
        motor_nm: f64,
        is_taken: bool,
    ) {
        let constants = &self.constants;
        let of = |i: usize| constants[i][lane];
        let joint = |first: usize, half_gap_rad: f64| Joint {
            stiffness_nm: of(first),
            damping_nm_s: of(first + 1),
            half_gap_rad,
        };
        let step = Step {
            step_s: of(0),
            inertias_kg_m2: from_fn(|i| of(1 + i)),
            inverses_1_kg_m2: from_fn(|i| of(4 + i)),
            // The second joint has no backlash.
            joints: [joint(7, of(9)), joint(10, 0.0)],
            bearing_nm: from_fn(|i| if i == OUTPUT { of(14) } else { 0.0 }),
            output: OUTPUT,
            stop_rad: of(15),
        };
        let load = Load::without_pendulum(of(16), of(17), of(18));
        let old: [Body; COUNT] = from_fn(|i| Body {
            angle_rad: self.angle_rad[i][lane],
            rate_rad_s: self.rate_rad_s[i][lane],
            ..Body::default()
        });
        let mut bodies = old;
        step.advance(&mut bodies, motor_nm, &load, |rate_rad_s, _| {
            viscous_nm(of(12), of(13), rate_rad_s)
        });
        let bodies = if is_taken { bodies } else { old };
        for (i, body) in bodies.iter().enumerate() {
            self.angle_rad[i][lane] = body.angle_rad;
            self.rate_rad_s[i][lane] = body.rate_rad_s;
        }
    }
}
