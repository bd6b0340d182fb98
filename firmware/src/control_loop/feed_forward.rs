//! Feed-forward: what the motion that the axis demands needs is known before the loops measure an
//! error.
//!
//! The rate of the demand is added to that of the position loop. The motor gets the voltage that it
//! needs for this rate `w` and acceleration `a`; with the torque constant `k`, gears of ratio `N`,
//! the resistance `R` of the cold winding, and inertia `J` and friction `b`, `c` at the output
//!
//! ```text
//! u = N k w + R/(N k) (J a + b w + c sign(w))
//! ```
//!
//! Its shares, object 2013h, are 0 by default: the loop of the paper. While the motor is driven
//! neither they nor the motor of 2011h can be changed. It depends on the demand and the supply
//! alone: at a stiff supply it does not change the stability of the loop.
//!
//! Targets that come every `n` control periods make a demand of straight lines, whose acceleration
//! is 0 but where two of them meet. A filter of the first order with `n` control periods spreads it
//! until the next one.

use crate::{
    application::BoardState, measure::Single, parameters::ObjectValues, timing::CONTROL_PERIOD_MS,
};

/// Radians per thousandth of a degree.
const RAD: f32 = core::f32::consts::PI / 180_000.0;

/// The friction acts in full from this rate on, mdeg/s: the demand of a target that flickers makes
/// no noise.
const FULL_FRICTION: f32 = 5000.0;

/// No motor takes more, mV.
const GREATEST_MV: f32 = 33_000.0;

/// 1 in 2^-10.
const ONE: f32 = 1024.0;

/// What is fed forward; nothing by default, whatever the motor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash)]
pub struct ForwardGains {
    /// Share of the demanded velocity, in 2^-10.
    share: i32,
    /// mV per mdeg/s.
    velocity: Single,
    /// mV per change of the velocity in a control period, mdeg/s.
    acceleration: Single,
    friction_mv: Single,
    /// Share of the acceleration that is new in each control period, for targets of cyclic modes.
    spread: Single,
}

impl ForwardGains {
    /// Those of these values.
    pub(crate) fn of(values: &ObjectValues) -> Self {
        let (model, forward) = (&values.model, &values.tracking);
        if forward.velocity_permille == 0 && forward.model_permille == 0 {
            return Self::default();
        }
        let v_s_rad = model.torque_constant_nm_a * model.gear_ratio;
        let share = forward.model_permille as f32 * 1e-3;
        // mV per N m at the output.
        let mv_nm = share * 1e3 * model.resistance_ohm / v_s_rad;
        let periods_s = 1e3 / CONTROL_PERIOD_MS as f32;
        let interpolation_ms = f32::from(values.profile.interpolation_time);
        let spread = CONTROL_PERIOD_MS as f32 / interpolation_ms;
        Self {
            share: (forward.velocity_permille as f32 * 1e-3 * ONE) as i32,
            velocity: Single::new(
                (share * 1e3 * v_s_rad + mv_nm * model.viscous_friction_nm_s) * RAD,
            ),
            acceleration: Single::new(mv_nm * model.inertia_kg_m2 * periods_s * RAD),
            friction_mv: Single::new(mv_nm * model.coulomb_friction_nm),
            spread: Single::new(if spread < 1.0 { spread } else { 1.0 }),
        }
    }

    /// Whether these may replace others in this state: the duty of a driven motor does not jump.
    pub(crate) fn may_change(&self, state: BoardState, other: &Self) -> bool {
        !state.is_driving() || self == other
    }

    /// Whether the shares are 0.
    pub(super) fn is_off(&self) -> bool {
        self.share == 0 && !self.has_model()
    }

    fn has_model(&self) -> bool {
        self.velocity != Single::default()
    }

    /// The rate that is added to that of the position loop, mdeg/s.
    pub(super) fn velocity(&self, demanded_mdeg_s: i32) -> i32 {
        ((i64::from(demanded_mdeg_s) * i64::from(self.share)) >> 10) as i32
    }
}

/// The demand of the last control period; none by default. The first velocity has no acceleration:
/// the motor may have it already.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Demanded {
    velocity_mdeg_s: Option<i32>,
    /// Mean change of the velocity in a control period, mdeg/s.
    acceleration: Single,
}

impl Demanded {
    /// The mean voltage of the motor that a demanded velocity needs, mV.
    pub fn next(&mut self, gains: &ForwardGains, velocity_mdeg_s: i32, is_cyclic: bool) -> i32 {
        if !gains.has_model() {
            return 0;
        }
        let velocity = velocity_mdeg_s as f32;
        let change = velocity - self.velocity_mdeg_s.unwrap_or(velocity_mdeg_s) as f32;
        let before = self.acceleration.get();
        let acceleration = match is_cyclic {
            true => before + (change - before) * gains.spread.get(),
            false => change,
        };
        *self = Self {
            velocity_mdeg_s: Some(velocity_mdeg_s),
            acceleration: Single::new(acceleration),
        };
        let direction = (velocity / FULL_FRICTION).clamp(-1.0, 1.0);
        let voltage_mv = gains.velocity.get() * velocity
            + gains.acceleration.get() * acceleration
            + gains.friction_mv.get() * direction;
        voltage_mv.clamp(-GREATEST_MV, GREATEST_MV) as i32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Those of the default motor with these shares.
    fn gains(velocity_permille: u16, model_permille: u16) -> ForwardGains {
        let mut values = ObjectValues::DEFAULT;
        values.tracking.velocity_permille = velocity_permille;
        values.tracking.model_permille = model_permille;
        ForwardGains::of(&values)
    }

    /// The voltages of these velocities, mdeg/s, with the whole model.
    fn voltages<const N: usize>(velocities: [i32; N], is_cyclic: bool) -> [i32; N] {
        let (gains, mut demanded) = (gains(0, 1000), Demanded::default());
        demanded.next(&gains, 0, is_cyclic);
        velocities.map(|velocity| demanded.next(&gains, velocity, is_cyclic))
    }

    #[test]
    fn the_share_of_the_velocity_is_added() {
        let rates = |permille| [90_000, -90_000].map(|rate| gains(permille, 0).velocity(rate));
        assert_eq!(rates(0), [0, 0]);
        assert_eq!(rates(500), [45_000, -45_000]);
        assert_eq!(rates(1000), [90_000, -90_000]);
        assert_eq!(gains(1000, 0).velocity(i32::MIN), i32::MIN);
    }

    #[test]
    fn without_a_share_of_the_model_there_is_no_voltage() {
        assert_eq!(Demanded::default().next(&gains(1000, 0), 90_000, false), 0);
    }

    #[test]
    fn the_voltage_is_that_of_the_motor_equation() {
        // N k = 320 x 0.00362 = 1.1584 V s; R/(N k) = 6.647 V/(N m); 90 deg/s are 1.5708 rad/s:
        // 1.8196 V, of friction 6.647 x (0.03 + 0.002 x 1.5708) = 0.2203 V. The change within 4 ms
        // is 392.7 rad/s^2: 6.647 x 0.0232 x 392.7 = 60.6 V, more than any motor takes.
        assert_eq!(voltages([90_000, 90_000], false), [33_000, 2039]);
        assert_eq!(voltages([-90_000, -90_000], false), [-33_000, -2039]);
        // 1 deg/s more: 4.363 rad/s^2 are 0.6729 V, and the rate makes 0.0205 V.
        assert_eq!(voltages([90_000, 91_000], false)[1], 2733);
        // A fifth of the friction.
        assert_eq!(voltages([1_000, 1_000], false)[1], 60);
        assert_eq!(voltages([0, 0, i32::MAX], false), [0, 0, 33_000]);
    }

    #[test]
    fn the_first_velocity_has_no_acceleration() {
        let voltage_mv = Demanded::default().next(&gains(0, 1000), 90_000, false);
        assert_eq!(voltage_mv, 2039);
    }

    #[test]
    fn the_acceleration_of_cyclic_targets_is_spread_over_their_interval() {
        // A fifth of 0.6729 V for targets every 20 ms, then less by a fifth each.
        let [_, first, second] = voltages([0, 1_000, 1_000], true);
        assert_eq!([first, second], [60 + 134, 60 + 107]);
    }
}
