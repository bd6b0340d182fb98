//! Integer trajectory generator.
//!
//! The position has a resolution of one millionth of a unit, the velocity one thousandth of a unit
//! per second: a period of `T` microseconds changes the position by `velocity * T / 1000`, and an
//! acceleration of `a` units per second squared changes the velocity by `a * T / 1000`. There is no
//! floating point and no drift.

/// Position increments per unit.
const UNIT: i64 = 1_000_000;
/// Velocity increments per unit per second.
const UNIT_PER_S: i64 = 1_000;
/// Longest period: |velocity| <= 2^31 * 1000, times this period, is below 2^63.
const PERIOD_MAX_US: u32 = 1_000_000;

/// Limits of a motion profile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Velocity in units per second.
    pub velocity: u32,
    /// Acceleration in units per second squared; 0 means the smallest representable one.
    pub acceleration: u32,
    /// Deceleration in units per second squared; 0 means the smallest representable one.
    pub deceleration: u32,
}

/// Position demand and its velocity.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Ramp {
    position: i64,
    velocity: i64,
}

impl Ramp {
    /// At a position, moving with a velocity.
    #[must_use]
    pub const fn moving(position: i32, velocity: i32) -> Self {
        Self {
            velocity: velocity as i64 * UNIT_PER_S,
            ..Self::at(position)
        }
    }

    /// At rest at a position.
    #[must_use]
    pub const fn at(position: i32) -> Self {
        Self {
            position: position as i64 * UNIT,
            velocity: 0,
        }
    }

    /// Position, rounded to whole units.
    #[must_use]
    pub const fn position(&self) -> i32 {
        let half = if self.position < 0 {
            -UNIT / 2
        } else {
            UNIT / 2
        };
        saturate(divide(self.position + half, UNIT as u32))
    }

    /// Velocity in units per second.
    #[must_use]
    pub const fn velocity(&self) -> i32 {
        saturate(divide(self.velocity, UNIT_PER_S as u32))
    }

    /// Whether the velocity is zero.
    #[must_use]
    pub const fn is_stationary(&self) -> bool {
        self.velocity == 0
    }

    /// Advances one period toward a position at which the motion ends, with a trapezoidal velocity
    /// profile within the limits. Returns whether the position is reached.
    pub fn to_position(&mut self, target: i32, limits: &Limits, period_us: u32) -> bool {
        let target = i64::from(target) * UNIT;
        let distance = target - self.position;
        let deceleration_step = velocity_change(limits.deceleration, period_us);
        if distance.abs() < UNIT / 2 && self.velocity.abs() <= deceleration_step {
            *self = Self {
                position: target,
                velocity: 0,
            };
            return true;
        }
        let forward = if distance < 0 { -1 } else { 1 };
        let toward = self.velocity * forward;
        let allowed = braking_velocity(distance.unsigned_abs(), deceleration_step, period_us)
            .min(max_velocity(limits));
        let rate = if (0..=allowed).contains(&toward) {
            velocity_change(limits.acceleration, period_us)
        } else {
            deceleration_step
        };
        let next = toward + clamp_symmetric(allowed - toward, rate);
        self.move_at(next * forward, period_us);
        false
    }

    /// Advances one period toward a velocity.
    pub fn to_velocity(&mut self, target: i32, limits: &Limits, period_us: u32) {
        let target = clamp_symmetric(i64::from(target) * UNIT_PER_S, max_velocity(limits));
        let difference = target - self.velocity;
        let slows = self.velocity != 0 && (difference < 0) != (self.velocity < 0);
        let rate = if slows {
            limits.deceleration
        } else {
            limits.acceleration
        };
        let step = clamp_symmetric(difference, velocity_change(rate, period_us));
        self.move_at(self.velocity + step, period_us);
    }

    /// Moves to a position within one period; the velocity follows from the difference.
    pub fn follow(&mut self, position: i64, period_us: u32) {
        // |difference| <= 2^32 * 10^6, times 1000 is below 2^63.
        let velocity = divide((position - self.position) * 1000, period_us.max(1));
        self.velocity = clamp_symmetric(velocity, VELOCITY_MAX);
        self.position = position;
    }

    /// Advances one of `steps` equal steps to a position.
    pub fn interpolate(&mut self, target: i32, steps: u32, period_us: u32) {
        let target = i64::from(target) * UNIT;
        let next = self.position + divide(target - self.position, steps.max(1));
        self.follow(next, period_us);
    }

    /// Sets the velocity and advances one period.
    pub fn set_velocity(&mut self, velocity: i32, period_us: u32) {
        self.move_at(i64::from(velocity) * UNIT_PER_S, period_us);
    }

    /// Sets the position; the velocity is unchanged.
    pub fn set_position(&mut self, position: i32) {
        self.position = i64::from(position) * UNIT;
    }

    /// Limits the velocity, which a step of a cyclic target position may exceed.
    pub fn limit_velocity(&mut self, velocity: u32) {
        self.velocity = clamp_symmetric(self.velocity, i64::from(velocity) * UNIT_PER_S);
    }

    /// Sets the velocity to zero.
    pub fn stop(&mut self) {
        self.velocity = 0;
    }

    /// The highest velocity from which the axis can stop within a distance.
    #[must_use]
    pub fn max_velocity_toward(distance: u32, deceleration: u32, period_us: u32) -> i32 {
        let distance = u64::from(distance) * UNIT as u64;
        let deceleration_step = velocity_change(deceleration, period_us);
        saturate(braking_velocity(distance, deceleration_step, period_us) / UNIT_PER_S)
    }

    fn move_at(&mut self, velocity: i64, period_us: u32) {
        self.velocity = clamp_symmetric(velocity, VELOCITY_MAX);
        let travel = divide(
            self.velocity * i64::from(period_us.min(PERIOD_MAX_US)),
            1000,
        );
        self.position = clamp_symmetric(self.position + travel, i32::MAX as i64 * UNIT);
    }
}

/// Largest representable velocity.
const VELOCITY_MAX: i64 = i32::MAX as i64 * UNIT_PER_S;

const fn max_velocity(limits: &Limits) -> i64 {
    let top = limits.velocity as i64 * UNIT_PER_S;
    if top < VELOCITY_MAX {
        top
    } else {
        VELOCITY_MAX
    }
}

/// `numerator / divisor`, rounded toward zero; 0 if the divisor is 0.
///
/// Every control period divides several times. A processor of 32 bits has no division of 64 bits:
/// if the odd part of the divisor is below 2^16, long division with digits of 16 bits takes a third
/// of the instructions of the compiler's routine.
const fn divide(numerator: i64, divisor: u32) -> i64 {
    let shift = divisor.trailing_zeros() % u32::BITS;
    let odd = divisor >> shift;
    if odd == 0 {
        return 0;
    }
    if odd >= 1 << 16 {
        return numerator / divisor as i64;
    }
    // A remainder is below 2^16: with the next digit it is below 2^32.
    let magnitude = numerator.unsigned_abs() >> shift;
    let (high, low) = ((magnitude >> 32) as u32, magnitude as u32);
    let middle = (high % odd) << 16 | low >> 16;
    let last = (middle % odd) << 16 | low & 0xFFFF;
    let quotient =
        ((high / odd) as i64) << 32 | ((middle / odd) as i64) << 16 | (last / odd) as i64;
    if numerator < 0 {
        quotient.wrapping_neg()
    } else {
        quotient
    }
}

fn clamp_symmetric(value: i64, bound: i64) -> i64 {
    value.max(-bound).min(bound)
}

const fn saturate(value: i64) -> i32 {
    if value > i32::MAX as i64 {
        i32::MAX
    } else if value < i32::MIN as i64 {
        i32::MIN
    } else {
        value as i32
    }
}

/// Velocity change of an acceleration in one period: at most 2^32 * 10^6 / 1000.
fn velocity_change(acceleration: u32, period_us: u32) -> i64 {
    (i64::from(acceleration) * i64::from(period_us.min(PERIOD_MAX_US)) / 1000).max(1)
}

/// The highest velocity from which a stop within `distance` is possible if each period reduces it
/// by `deceleration_step`.
///
/// With `d` the deceleration step, a stop from `k * d + r` travels `(k + 1)` periods at this
/// velocity less `d * k * (k + 1) / 2`; `k` is the largest for which `d * k * (k + 1) / 2` fits.
/// All distances are in velocity increments times one period.
fn braking_velocity(distance: u64, deceleration_step: i64, period_us: u32) -> i64 {
    // distance <= 2^32 * 10^6, times 1000 is below 2^63. Saturated at an eighth of the range for
    // the factor 8 below.
    let travel = (distance * 1000 / u64::from(period_us.max(1))).min(u64::MAX / 8);
    let deceleration_step = deceleration_step.unsigned_abs().max(1);
    let root = (travel * 8 / deceleration_step).saturating_add(1).isqrt();
    let k = (root - 1) / 2;
    // deceleration_step * k * (k + 1) / 2 <= travel < 2^61.
    let saved = deceleration_step * k * (k + 1) / 2;
    let velocity = (travel + saved) / (k + 1);
    velocity.min(VELOCITY_MAX as u64) as i64
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const PERIOD_US: u32 = 4000;

    proptest! {
        #[test]
        fn a_division_by_digits_is_the_division_of_64_bits(
            numerator in -i64::MAX..i64::MAX, drop in 0..63u32, divisor in 1..=u32::MAX, short in 1..1u32 << 17
        ) {
            let numerator = numerator >> drop;
            for divisor in [divisor, short, 1_000, 4_000, 1_000_000] {
                prop_assert_eq!(divide(numerator, divisor), numerator / i64::from(divisor));
            }
        }
    }

    #[test]
    fn a_trapezoidal_profile_takes_the_time_of_the_closed_form() {
        // 60 deg at 300 deg/s and 3000 deg/s^2: v/a + s/v = 0.1 s + 0.2 s.
        let limits = Limits {
            velocity: 300_000,
            acceleration: 3_000_000,
            deceleration: 3_000_000,
        };
        let mut ramp = Ramp::at(0);
        let mut periods = 0;
        while !ramp.to_position(60_000, &limits, PERIOD_US) {
            periods += 1;
        }
        assert_eq!(ramp, Ramp::at(60_000));
        // The velocity changes at the start of a period, which saves half a period at each end.
        assert_eq!(periods, 75 - 1, "0.3 s in periods of 4 ms");
    }

    #[test]
    fn velocity_ramps_use_acceleration_to_speed_up_and_deceleration_to_slow_down() {
        let limits = Limits {
            velocity: 1000,
            acceleration: 1000,
            deceleration: 2000,
        };
        let mut ramp = Ramp::at(0);
        let mut until = |target: i32| {
            (1..).find(|_| {
                ramp.to_velocity(target, &limits, 1000);
                ramp.velocity() == target
            })
        };
        assert_eq!(until(500), Some(500));
        assert_eq!(until(0), Some(250));
        assert_eq!(until(-100), Some(100));
        assert_eq!(until(100), Some(50 + 100), "down to zero, then up");
    }

    #[test]
    fn nothing_overflows_at_the_ends_of_the_range() {
        let limits = Limits {
            velocity: u32::MAX,
            acceleration: u32::MAX,
            deceleration: u32::MAX,
        };
        for period_us in [0, 1, 4000, u32::MAX] {
            let mut ramp = Ramp::at(i32::MIN);
            for _ in 0..100 {
                ramp.to_position(i32::MAX, &limits, period_us);
                ramp.to_velocity(i32::MIN, &limits, period_us);
                ramp.interpolate(i32::MAX, 0, period_us);
                ramp.set_velocity(i32::MIN, period_us);
                assert!(Ramp::max_velocity_toward(u32::MAX, 0, period_us) >= 0);
            }
        }
    }

    proptest! {
        #[test]
        fn a_move_ends_at_its_target_within_its_limits(
            start in -100_000..100_000_i32,
            target in -100_000..100_000_i32,
            velocity in 1_000..2_000_000_u32,
            acceleration in 10_000..10_000_000_u32,
            deceleration in 10_000..10_000_000_u32,
            period_us in 100..20_000_u32,
        ) {
            let limits = Limits { velocity, acceleration, deceleration };
            let mut ramp = Ramp::at(start);
            let (low, high) = (start.min(target), start.max(target));
            for period in 0.. {
                let before = ramp.velocity;
                if ramp.to_position(target, &limits, period_us) {
                    break;
                }
                prop_assert!(period < 30_000_000 / period_us * 10);
                let faster = ramp.velocity.abs() > before.abs();
                let rate = if faster { acceleration } else { deceleration };
                prop_assert!((ramp.velocity - before).abs() <= velocity_change(rate, period_us));
                prop_assert!(ramp.velocity.unsigned_abs() <= u64::from(velocity) * 1000);
                prop_assert!((low..=high).contains(&ramp.position()), "no overshoot");
            }
            prop_assert_eq!(ramp, Ramp::at(target));
        }
    }
}
