//! The gear train: up to three inertias in series, all referred to the output shaft.
//!
//! ```text
//! motor ──[ backlash, gear stiffness ]── output gear ──[ shaft stiffness ]── load
//!   friction M1..M6                        bearing friction                    external torque
//!                                          encoder, hard stops
//! ```
//!
//! A joint stiffer than the shortest step resolves is rigid and its two bodies are one inertia. A
//! joint with backlash cannot be rigid; its stiffness is limited to what the shortest step
//! resolves.
//!
//! Each step is semi-implicit: torques from the angles and rates at its start, then the rates, then
//! the angles from the new rates. Friction removes at most its budget of momentum, so a body at
//! rest under a torque below the budget keeps a rate of exactly zero.

pub(super) mod lanes;

use core::{array::from_fn, f64::consts::PI};

use super::friction::Friction;
use super::load::Load;
use crate::limits::{greater, lesser, limited};
use crate::time::TICK_S;

crate::parameters! {
    /// Gears, shafts, inertias and stops. The estimates are derived in
    /// [`crate::plant::drivetrain`].
    pub struct GearTrainParameters {
        /// Motor revolutions per output revolution.
        gear_ratio [""]: 320.0, "1", 1.0, 2000.0, "estimate: 15,100 rpm of the motor at the no-load rate";
        /// Inertia of rotor and pinion.
        motor_inertia_kg_m2 [""]: 2.27e-7, "kg m^2", 1e-10, 1e-2, "estimate from the time constant of the paper's eq. (2)";
        /// Inertia of the output gear with the encoder's magnet.
        output_inertia_kg_m2 [""]: 2e-6, "kg m^2", 1e-8, 1.0, "estimate: 20 g at 1 cm";
        /// Inertia of horn and surface.
        load_inertia_kg_m2 [""]: 2e-6, "kg m^2", 1e-8, 1.0, "estimate: a bare horn";
        /// Free play of the output from flank to flank with the motor blocked.
        backlash_deg [""]: 0.1, "deg", 0.0, 20.0, "estimate: one encoder count; paper, section II.B: negligible";
        /// Stiffness of the gears; infinite if rigid.
        gear_stiffness_nm_deg [""]: 2.0, "Nm/deg", 1e-3, f64::INFINITY, "estimate: 0.4 deg at the stall torque";
        /// Damping of the gears' flexibility.
        gear_damping_nm_s_deg [""]: 5e-5, "Nm s/deg", 0.0, 1.0, "estimate: a tenth of critical";
        /// Stiffness of the shaft to the load; infinite if rigid.
        shaft_stiffness_nm_deg [""]: 4.0, "Nm/deg", 1e-3, f64::INFINITY, "estimate: twice the gears'";
        /// Damping of that shaft.
        shaft_damping_nm_s_deg [""]: 5e-5, "Nm s/deg", 0.0, 1.0, "estimate: as the gears'";
        /// Coulomb friction of the output bearing, which holds the output within the backlash.
        bearing_friction_nm [""]: 0.002, "Nm", 0.0, 10.0, "estimate";
        /// Inelastic stops of the output at plus and minus this angle.
        hard_stop_deg [""]: 180.0, "deg", 0.0, 32000.0, "paper, section III.A: deflection limit of 180 degrees";
    }
}

impl GearTrainParameters {
    /// The inertia of the rotor at the output, kg m^2.
    fn rotor_kg_m2(&self) -> f64 {
        self.motor_inertia_kg_m2 * self.gear_ratio * self.gear_ratio
    }

    /// All inertias at the output, kg m^2: `J_motor N^2 + J_output + J_load`.
    ///
    /// ```
    /// use model_core::plant::drivetrain::DrivetrainParameters;
    ///
    /// let kg_m2 = DrivetrainParameters::default().gear_train.inertia_kg_m2();
    /// assert!((kg_m2 - (2.27e-7 * 320.0 * 320.0 + 4e-6)).abs() < 1e-12);
    /// ```
    pub fn inertia_kg_m2(&self) -> f64 {
        self.rotor_kg_m2() + self.output_inertia_kg_m2 + self.load_inertia_kg_m2
    }
}

const RAD: f64 = PI / 180.0;

/// The shortest step: 64 per tick limit a simulated second to below two million steps.
pub(super) const SHORTEST_STEP_S: f64 = TICK_S / 64.0;

/// Phase of the fastest oscillation, and fraction of the fastest time constant, per step. The
/// method is stable up to 2; at 0.2 its frequencies are accurate to 0.2^2/24 = 0.2 %.
pub(super) const STEP_SHARE: f64 = 0.2;

#[derive(Debug, Clone, Copy, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Body {
    inertia_kg_m2: f64,
    angle_rad: f64,
    rate_rad_s: f64,
}

impl Body {
    /// The inertia with the load's damping in a step, which acts on the last body and on its new
    /// rate (implicit): that is stable for any value.
    #[inline(always)]
    fn damped_inertia_kg_m2(&self, is_last: bool, load: &Load, step_s: f64) -> f64 {
        let damping_nm_s = if is_last { load.damping_nm_s } else { 0.0 };
        self.inertia_kg_m2 + damping_nm_s * step_s
    }
}

#[derive(Debug, Clone, Copy, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Joint {
    stiffness_nm: f64,
    damping_nm_s: f64,
    half_gap_rad: f64,
}

impl Joint {
    /// The torque from the first body on the second.
    #[inline(always)]
    fn torque_nm(&self, first: &Body, second: &Body) -> f64 {
        let lead_rad = first.angle_rad - second.angle_rad;
        let damping_nm = self.damping_nm_s * (first.rate_rad_s - second.rate_rad_s);
        let gap = self.half_gap_rad;
        let offset_rad = if lead_rad < 0.0 { -gap } else { gap };
        let torque_nm = self.stiffness_nm * (lead_rad - offset_rad) + damping_nm;
        if gap == 0.0 {
            return torque_nm;
        }
        // Flanks with backlash push but do not pull.
        if lead_rad > gap {
            greater(torque_nm, 0.0)
        } else if lead_rad < -gap {
            lesser(torque_nm, 0.0)
        } else {
            0.0
        }
    }
}

/// What equal steps of a train have in common.
#[derive(Debug, Clone, Copy)]
struct Step<const COUNT: usize> {
    step_s: f64,
    /// With the damping of the load.
    inertias_kg_m2: [f64; COUNT],
    inverses_1_kg_m2: [f64; COUNT],
    joints: [Joint; 2],
    bearing_nm: [f64; COUNT],
    output: usize,
    stop_rad: f64,
}

impl<const COUNT: usize> Step<COUNT> {
    /// Advances the bodies by a step; returns the momentum that friction takes from each.
    /// `gearbox_nm` gives the budget of friction for the motor's rate and the torque behind it.
    #[inline(always)]
    fn advance(
        &self,
        bodies: &mut [Body; COUNT],
        motor_nm: f64,
        load: &Load,
        gearbox_nm: impl Fn(f64, f64) -> f64,
    ) -> [f64; COUNT] {
        // behind[i] acts on body i from its load side, and on the next from its motor side.
        let mut behind = [-load_nm(load, &bodies[COUNT - 1]); COUNT];
        for i in 1..COUNT {
            behind[i - 1] = self.joints[i - 1].torque_nm(&bodies[i - 1], &bodies[i]);
        }
        let gearbox_nm = gearbox_nm(bodies[0].rate_rad_s, -behind[0]);
        let mut taken = [0.0; COUNT];
        for i in 0..COUNT {
            let before = if i == 0 { motor_nm } else { behind[i - 1] };
            let gearbox = if i == 0 { gearbox_nm } else { 0.0 };
            let budget = (gearbox + self.bearing_nm[i]) * self.step_s;
            let body = &mut bodies[i];
            let momentum =
                self.inertias_kg_m2[i] * body.rate_rad_s + (before - behind[i]) * self.step_s;
            taken[i] = limited(momentum, budget);
            body.rate_rad_s = (momentum - taken[i]) * self.inverses_1_kg_m2[i];
            body.angle_rad += body.rate_rad_s * self.step_s;
            // An index that varies would keep the bodies out of registers.
            if i == self.output {
                stop(body, self.stop_rad);
            }
        }
        taken
    }
}

/// The moving parts.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct GearTrain {
    bodies: [Body; 3],
    /// `joints[i]` connects `bodies[i]` and `bodies[i + 1]`.
    joints: [Joint; 2],
    count: usize,
    /// Inertia of the last body without what is added to it.
    last_inertia_kg_m2: f64,
    /// Inertia that is added to the last body.
    added_kg_m2: f64,
    /// Index of the output gear in `bodies`.
    output: usize,
    friction: Friction,
    bearing_nm: f64,
    stop_rad: f64,
    /// Whether the gear train is jammed.
    pub is_jammed: bool,
    /// Total friction torque in the last step.
    pub friction_nm: f64,
}

/// Angle and rate of a body, rad and rad/s, referred to the output.
pub(super) type Motion = (f64, f64);

/// What changes in a [`GearTrain`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct TrainState {
    motions: [Motion; 3],
    pub added_kg_m2: f64,
    friction_nm: f64,
}

impl GearTrain {
    #[inline(always)]
    pub fn state(&self) -> TrainState {
        TrainState {
            motions: from_fn(|i| self.motion(i)),
            added_kg_m2: self.added_kg_m2,
            friction_nm: self.friction_nm,
        }
    }

    /// Continues from a state with the present added inertia.
    #[inline(always)]
    pub fn set_state(&mut self, state: &TrainState) {
        for (body, motion) in self.bodies.iter_mut().zip(state.motions) {
            (body.angle_rad, body.rate_rad_s) = motion;
        }
        self.friction_nm = state.friction_nm;
    }

    pub fn new(p: &GearTrainParameters, friction: Friction, load: &Load) -> Self {
        let inertias = [
            p.rotor_kg_m2(),
            p.output_inertia_kg_m2,
            p.load_inertia_kg_m2 + load.inertia_kg_m2,
        ];
        let least = inertias[0].min(inertias[1]).min(inertias[2]);
        // Limits 2 sum(k)/J and sum(c)/J of a body between two joints to resolvable values.
        let fastest = STEP_SHARE / SHORTEST_STEP_S;
        let stiffest_nm = least / 4.0 * fastest * fastest;
        let joint = |stiffness: f64, damping: f64, backlash: f64| Joint {
            stiffness_nm: (stiffness / RAD).min(stiffest_nm),
            damping_nm_s: (damping / RAD).min(least / 2.0 * fastest),
            half_gap_rad: backlash / 2.0 * RAD,
        };
        let joints = [
            joint(
                p.gear_stiffness_nm_deg,
                p.gear_damping_nm_s_deg,
                p.backlash_deg,
            ),
            joint(p.shaft_stiffness_nm_deg, p.shaft_damping_nm_s_deg, 0.0),
        ];
        let mut train = Self {
            bodies: [Body::default(); 3],
            joints: [Joint::default(); 2],
            count: 1,
            last_inertia_kg_m2: 0.0,
            added_kg_m2: 0.0,
            output: 0,
            friction,
            bearing_nm: p.bearing_friction_nm,
            stop_rad: p.hard_stop_deg * RAD,
            is_jammed: false,
            friction_nm: 0.0,
        };
        train.bodies[0].inertia_kg_m2 = inertias[0];
        for (i, joint) in joints.into_iter().enumerate() {
            if joint.stiffness_nm < stiffest_nm || joint.half_gap_rad > 0.0 {
                train.joints[train.count - 1] = joint;
                train.count += 1;
            }
            train.bodies[train.count - 1].inertia_kg_m2 += inertias[i + 1];
            if i == 0 {
                train.output = train.count - 1;
            }
        }
        train.last_inertia_kg_m2 = train.bodies[train.count - 1].inertia_kg_m2;
        train
    }

    /// Adds an inertia to the load; whether that is a change.
    pub fn set_added_inertia(&mut self, added_kg_m2: f64) -> bool {
        if added_kg_m2 == self.added_kg_m2 {
            return false;
        }
        self.added_kg_m2 = added_kg_m2;
        self.bodies[self.count - 1].inertia_kg_m2 = self.last_inertia_kg_m2 + added_kg_m2;
        true
    }

    /// Sets the angle of all bodies: the flanks are in the middle of the backlash.
    pub fn place(&mut self, angle_rad: f64) {
        for body in &mut self.bodies {
            body.angle_rad = angle_rad;
        }
    }

    /// Moves the load by an angle and an impulse.
    pub fn push_load(&mut self, angle_rad: f64, impulse_nms: f64) {
        let load = &mut self.bodies[self.count - 1];
        load.angle_rad += angle_rad;
        load.rate_rad_s += impulse_nms / load.inertia_kg_m2;
    }

    /// The longest step that resolves every oscillation and decay, at most a tick.
    pub fn longest_step_s(&self, load: &Load) -> f64 {
        let mut step_s = TICK_S;
        for (i, body) in self.bodies[..self.count].iter().enumerate() {
            let is_last = i + 1 == self.count;
            let own_nm = if is_last {
                load.hinge_nm_rad.abs() + load.weight_nm
            } else {
                0.0
            };
            // The joints before and after the body; zero beyond the ends.
            let before = i
                .checked_sub(1)
                .map_or(Joint::default(), |j| self.joints[j]);
            let behind = self.joints.get(i).copied().unwrap_or_default();
            let stiffness_nm = before.stiffness_nm + behind.stiffness_nm + own_nm;
            let damping_nm_s = before.damping_nm_s + behind.damping_nm_s;
            let inertia = body.inertia_kg_m2;
            // Gershgorin bound: no mode is faster than the stiffest row, 2 sum(k)/J.
            let fastest = libm::sqrt(2.0 * stiffness_nm / inertia).max(damping_nm_s / inertia);
            // A zero gives infinity, which is never the minimum.
            step_s = step_s.min(STEP_SHARE / fastest);
        }
        step_s.max(SHORTEST_STEP_S)
    }

    /// Advances equal steps. `motor_nm` gives the motor torque of a step for the motor's rate at
    /// its start.
    #[inline(always)]
    pub fn advance(
        &mut self,
        steps: u32,
        step_s: f64,
        load: &Load,
        motor_nm: impl FnMut(f64) -> f64,
    ) {
        // A constant number of bodies lets the compiler keep them in registers.
        match self.count {
            3 => self.advance_bodies::<3>(steps, step_s, load, motor_nm),
            2 => self.advance_bodies::<2>(steps, step_s, load, motor_nm),
            _ => self.advance_bodies::<1>(steps, step_s, load, motor_nm),
        }
    }

    #[inline(always)]
    fn advance_bodies<const COUNT: usize>(
        &mut self,
        steps: u32,
        step_s: f64,
        load: &Load,
        mut motor_nm: impl FnMut(f64) -> f64,
    ) {
        let mut bodies: [Body; COUNT] = from_fn(|i| self.bodies[i]);
        let inertias = from_fn(|i| bodies[i].damped_inertia_kg_m2(i + 1 == COUNT, load, step_s));
        // An infinite friction holds a jammed train.
        let held_nm = if self.is_jammed { f64::INFINITY } else { 0.0 };
        let output = self.output.min(COUNT - 1);
        let step = Step {
            step_s,
            inertias_kg_m2: inertias,
            // Not divided by in each step: a division is on the longest path through it.
            inverses_1_kg_m2: inertias.map(|inertia_kg_m2| 1.0 / inertia_kg_m2),
            joints: self.joints,
            bearing_nm: from_fn(|i| held_nm + if i == output { self.bearing_nm } else { 0.0 }),
            output,
            stop_rad: self.stop_rad,
        };
        let friction = &self.friction;
        let mut taken = [0.0; COUNT];
        for _ in 0..steps {
            let motor_nm = motor_nm(bodies[0].rate_rad_s);
            taken = step.advance(&mut bodies, motor_nm, load, |rate_rad_s, external_nm| {
                friction.budget_nm(rate_rad_s, motor_nm, external_nm)
            });
        }
        self.bodies[..COUNT].copy_from_slice(&bodies);
        self.friction_nm = 0.0;
        for taken in taken {
            self.friction_nm += taken / step_s;
        }
    }

    /// Stops each body that is at rest.
    pub fn settle(&mut self) {
        for body in &mut self.bodies {
            body.rate_rad_s = super::or_rest(body.rate_rad_s);
        }
    }

    pub fn motor(&self) -> Motion {
        self.motion(0)
    }

    /// Sets the rate of all bodies.
    #[cfg(test)]
    pub fn spin(&mut self, rate_rad_s: f64) {
        self.bodies
            .iter_mut()
            .for_each(|body| body.rate_rad_s = rate_rad_s);
    }

    pub fn output(&self) -> Motion {
        self.motion(self.output)
    }

    pub fn load(&self) -> Motion {
        self.motion(self.count - 1)
    }

    /// Torque of the last flexible joint on the bodies behind it; 0 if all are one.
    pub fn shaft_nm(&self) -> f64 {
        match self.bodies[..self.count] {
            [.., first, second] => self.joints[self.count - 2].torque_nm(&first, &second),
            _ => 0.0,
        }
    }

    /// External torque at the load.
    pub fn load_nm(&self, load: &Load) -> f64 {
        load_nm(load, &self.bodies[self.count - 1])
    }

    fn motion(&self, index: usize) -> Motion {
        let body = &self.bodies[index];
        (body.angle_rad, body.rate_rad_s)
    }

    /// Kinetic and elastic energy, J.
    #[cfg(test)]
    pub fn energy_j(&self) -> f64 {
        let bodies = &self.bodies[..self.count];
        let kinetic = bodies
            .iter()
            .map(|b| b.inertia_kg_m2 * b.rate_rad_s * b.rate_rad_s / 2.0);
        let elastic = bodies.windows(2).zip(&self.joints).map(|(pair, joint)| {
            let lead = pair[0].angle_rad - pair[1].angle_rad;
            let twist = lead - limited(lead, joint.half_gap_rad);
            joint.stiffness_nm * twist * twist / 2.0
        });
        kinetic.chain(elastic).sum()
    }
}

/// Applies the inelastic stops to the output.
#[inline(always)]
fn stop(body: &mut Body, stop_rad: f64) {
    if body.angle_rad.abs() > stop_rad {
        body.angle_rad = limited(body.angle_rad, stop_rad);
        if body.angle_rad * body.rate_rad_s > 0.0 {
            body.rate_rad_s = 0.0;
        }
    }
}

#[inline(always)]
fn load_nm(load: &Load, body: &Body) -> f64 {
    load.torque_nm(body.angle_rad) - load.damping_nm_s * body.rate_rad_s
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flanks_with_backlash_push_but_do_not_pull() {
        let joint = |half_gap_rad| Joint {
            stiffness_nm: 10.0,
            damping_nm_s: 1.0,
            half_gap_rad,
        };
        let body = |angle_rad, rate_rad_s| Body {
            angle_rad,
            rate_rad_s,
            ..Default::default()
        };
        // 0.125 rad beyond the gap, closing and separating.
        let rest = body(0.0, 0.0);
        assert_eq!(joint(0.25).torque_nm(&body(0.375, 0.5), &rest), 1.75);
        assert_eq!(joint(0.25).torque_nm(&body(0.375, -2.0), &rest), 0.0);
        assert_eq!(joint(0.25).torque_nm(&body(0.125, 0.5), &rest), 0.0);
        // Without backlash the same shaft pulls.
        assert_eq!(joint(0.0).torque_nm(&body(0.125, -2.0), &rest), -0.75);
    }
}
