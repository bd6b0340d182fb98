//! External load: a sum of terms.

use core::f64::consts::PI;

crate::parameters! {
    /// The external load; a positive torque acts towards positive angles.
    pub struct LoadParameters {
        /// Constant torque.
        load_torque_nm [""]: 0.0, "Nm", -100.0, 100.0, "paper: unloaded throughout";
        /// Spring constant towards zero, for example of an aerodynamic hinge moment; negative if
        /// destabilising.
        hinge_moment_nm_deg [""]: 0.0, "Nm/deg", -1.0, 1.0, "paper: unloaded throughout";
        /// Viscous damping.
        load_damping_nm_s_deg [""]: 0.0, "Nm s/deg", 0.0, 1.0, "paper: unloaded throughout";
        /// Point mass of a pendulum that hangs down at angle zero.
        pendulum_mass_kg [""]: 0.0, "kg", 0.0, 10.0, "paper: unloaded throughout";
        /// Length of the pendulum.
        pendulum_length_m [""]: 0.1, "m", 0.0, 1.0, "as long as a servo horn's rod";
    }
}

/// Standard gravity, m/s^2 (ISO 80000-3).
const GRAVITY_M_S2: f64 = 9.80665;

/// The load in SI units.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Load {
    constant_nm: f64,
    pub hinge_nm_rad: f64,
    pub damping_nm_s: f64,
    pub weight_nm: f64,
    /// Inertia of the pendulum.
    pub inertia_kg_m2: f64,
    /// Torque added by a recording or by the caller.
    pub recorded_nm: f64,
}

impl Load {
    pub fn new(p: &LoadParameters) -> Self {
        let (mass, arm) = (p.pendulum_mass_kg, p.pendulum_length_m);
        Self {
            constant_nm: p.load_torque_nm,
            hinge_nm_rad: p.hinge_moment_nm_deg * (180.0 / PI),
            damping_nm_s: p.load_damping_nm_s_deg * (180.0 / PI),
            weight_nm: mass * GRAVITY_M_S2 * arm,
            inertia_kg_m2: mass * arm * arm,
            recorded_nm: 0.0,
        }
    }

    /// A load without a pendulum, whose constant torque includes what was recorded.
    #[inline(always)]
    pub const fn without_pendulum(constant_nm: f64, hinge_nm_rad: f64, damping_nm_s: f64) -> Self {
        Self {
            constant_nm,
            hinge_nm_rad,
            damping_nm_s,
            weight_nm: 0.0,
            inertia_kg_m2: 0.0,
            recorded_nm: 0.0,
        }
    }

    /// The torque at this angle without damping.
    #[inline(always)]
    pub fn torque_nm(&self, angle_rad: f64) -> f64 {
        let weight_nm = if self.weight_nm == 0.0 {
            0.0
        } else {
            self.weight_nm * libm::sin(angle_rad)
        };
        self.external_nm() - self.hinge_nm_rad * angle_rad - weight_nm
    }

    /// What does not depend on the motion.
    pub fn external_nm(&self) -> f64 {
        self.constant_nm + self.recorded_nm
    }
}

/// A recorded load: torque steps, each constant until the next.
#[derive(Debug, Clone, Copy)]
pub struct Recording<'a> {
    steps: &'a [(u64, f64)],
}

impl<'a> Recording<'a> {
    /// A recording of pairs of tick and torque, Nm; before the first the torque is 0.
    ///
    /// `None` unless the ticks increase and every torque is finite.
    ///
    /// ```
    /// use model_core::plant::drivetrain::load::Recording;
    ///
    /// let gust = Recording::try_new(&[(10, 0.5), (20, 0.0)]).unwrap();
    /// assert_eq!(gust.torque_nm(15), 0.5);
    /// assert!(Recording::try_new(&[(20, 0.5), (10, 0.0)]).is_none());
    /// ```
    pub fn try_new(steps: &'a [(u64, f64)]) -> Option<Self> {
        let is_usable =
            steps.is_sorted_by(|a, b| a.0 < b.0) && steps.iter().all(|(_, nm)| nm.is_finite());
        is_usable.then_some(Self { steps })
    }

    /// The torque in the interval that starts at this tick, Nm.
    pub fn torque_nm(&self, tick: u64) -> f64 {
        let later = self.steps.partition_point(|(start, _)| *start <= tick);
        later
            .checked_sub(1)
            .and_then(|last| self.steps.get(last))
            .map_or(0.0, |(_, torque_nm)| *torque_nm)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_load_terms_are_added() {
        let load = Load::new(&LoadParameters {
            load_torque_nm: 0.5,
            hinge_moment_nm_deg: 0.01,
            load_damping_nm_s_deg: 0.0,
            pendulum_mass_kg: 0.2,
            pendulum_length_m: 0.5,
        });
        // At 30 deg: 0.5 - 0.3 - 0.2 kg g 0.5 m / 2.
        let expected = 0.5 - 0.3 - 0.05 * 9.80665;
        assert!((load.torque_nm(PI / 6.0) - expected).abs() < 1e-15);
        assert_eq!(load.inertia_kg_m2, 0.05);
    }

    #[test]
    fn a_recorded_torque_is_constant_from_its_tick() {
        let steps = [(3, 1.0), (5, -2.0)];
        let recording = Recording::try_new(&steps).unwrap();
        let torques = [2, 3, 4, 5, 1_000_000].map(|tick| recording.torque_nm(tick));
        assert_eq!(torques, [0.0, 1.0, 1.0, -2.0, -2.0]);
        assert_eq!(Recording::try_new(&[]).unwrap().torque_nm(7), 0.0);
        assert!(Recording::try_new(&[(0, f64::NAN)]).is_none());
        assert!(Recording::try_new(&[(1, 0.0), (1, 1.0)]).is_none());
    }
}
