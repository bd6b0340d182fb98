//! Integer trajectory generator.
//!
//! The position has a resolution of one millionth of a unit, the velocity one thousandth of a unit
//! per second: a period of `T` microseconds changes the position by `velocity * T / 1000`, and an
//! acceleration of `a` units per second squared changes the velocity by `a * T / 1000`. There is no
//! floating point and no drift. The period is a constant of the type: a processor of 32 bits
//! multiplies and divides by it with shifts, if it is a power of two of milliseconds.

/// Position increments per unit.
pub(super) const UNIT: i64 = 1_000_000;
/// Velocity increments per unit per second.
const UNIT_PER_S: i64 = 1_000;
/// Shortest period: a distance, at most 2^32 * 10^6, over it in ms is below 2^61.
const PERIOD_MIN_US: u32 = 2;
/// Longest period: the way in it, |velocity| <= 2^31 * 1000 times the period in ms, is below 2^47,
/// for 16 fractional bits.
const PERIOD_MAX_US: u32 = 65_535;

/// Fails to compile for a period out of range.
const fn assert_range(period_us: u32) {
    assert!(period_us >= PERIOD_MIN_US && period_us <= PERIOD_MAX_US);
}

/// Limits of a motion profile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Velocity in units per second.
    pub velocity: u32,
    /// Acceleration in units per second squared; 0 counts as 1.
    pub acceleration: u32,
    /// Deceleration in units per second squared; 0 counts as 1.
    pub deceleration: u32,
}

/// Position demand and its velocity, advanced in periods of `PERIOD_US` microseconds, 2 to 65,535.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Ramp<const PERIOD_US: u32> {
    position: i64,
    velocity: i64,
}

impl<const PERIOD_US: u32> Ramp<PERIOD_US> {
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
        // A position is within 2^31 units.
        let rounded = self.position.unsigned_abs() + UNIT as u64 / 2;
        with_sign_of(self.position, divide_magnitude(rounded, UNIT as u32)) as i32
    }

    /// Velocity in units per second.
    #[must_use]
    pub const fn velocity(&self) -> i32 {
        // A velocity is within 2^31 units per second.
        divide(self.velocity, UNIT_PER_S as u32) as i32
    }

    /// Position in millionths of a unit.
    pub(super) const fn fine_position(&self) -> i64 {
        self.position
    }

    /// Way of one period at the present velocity, in millionths of a unit.
    pub(super) fn fine_step(&self) -> i64 {
        in_period::<PERIOD_US>(self.velocity)
    }

    /// At this position in millionths of a unit, with the velocity of another one.
    pub(super) fn at_fine(self, position: i64) -> Self {
        let position = clamp_symmetric(position, i32::MAX as i64 * UNIT);
        Self { position, ..self }
    }

    /// Changes the position, with the velocity, by this many units.
    pub(super) fn shift(&mut self, units: i32) {
        let position = self.position + i64::from(units) * UNIT;
        self.position = clamp_symmetric(position, i32::MAX as i64 * UNIT);
    }

    /// Whether the velocity is zero.
    #[must_use]
    pub const fn is_stationary(&self) -> bool {
        self.velocity == 0
    }

    /// Advances one period toward a position at which the motion ends, with a trapezoidal velocity
    /// profile within the limits. Returns whether the position is reached.
    pub fn to_position(&mut self, target: i32, limits: &Limits) -> bool {
        let target = i64::from(target) * UNIT;
        let distance = target - self.position;
        let deceleration_step = velocity_change::<PERIOD_US>(limits.deceleration);
        if distance.abs() < UNIT / 2 && self.velocity.abs() <= deceleration_step {
            *self = Self {
                position: target,
                velocity: 0,
            };
            return true;
        }
        let forward = if distance < 0 { -1 } else { 1 };
        let toward = self.velocity * forward;
        let braking = braking_velocity::<PERIOD_US>(
            distance.unsigned_abs(),
            deceleration_step.unsigned_abs(),
        );
        let allowed = braking.min(max_velocity(limits));
        let rate = if (0..=allowed).contains(&toward) {
            velocity_change::<PERIOD_US>(limits.acceleration)
        } else {
            deceleration_step
        };
        let next = toward + clamp_symmetric(allowed - toward, rate);
        self.move_at(next * forward);
        false
    }

    /// Advances one period toward a velocity.
    pub fn to_velocity(&mut self, target: i32, limits: &Limits) {
        let target = clamp_symmetric(i64::from(target) * UNIT_PER_S, max_velocity(limits));
        let difference = target - self.velocity;
        let slows = self.velocity != 0 && (difference < 0) != (self.velocity < 0);
        let rate = if slows {
            limits.deceleration
        } else {
            limits.acceleration
        };
        let step = clamp_symmetric(difference, velocity_change::<PERIOD_US>(rate));
        self.move_at(self.velocity + step);
    }

    /// Moves to a position within one period; the velocity follows from the difference.
    pub fn follow(&mut self, position: i64) {
        // |difference| <= 2^32 * 10^6.
        let velocity = per_period::<PERIOD_US>(position - self.position);
        self.velocity = clamp_symmetric(velocity, VELOCITY_MAX);
        self.position = position;
    }

    /// Advances one of `steps` equal steps to a position, at most at this velocity; returns whether
    /// that made the step shorter.
    pub fn interpolate(&mut self, target: i32, steps: u32, velocity: u32) -> bool {
        let target = i64::from(target) * UNIT;
        let step = divide(target - self.position, steps.max(1));
        // In units of UNIT: below 2^31 * 10^6.
        let velocity = velocity.min(i32::MAX as u32);
        let longest = i64::from(velocity) * i64::from(PERIOD_US);
        let possible = clamp_symmetric(step, longest);
        self.position += possible;
        self.velocity = per_period::<PERIOD_US>(possible);
        possible != step
    }

    /// Sets the velocity and advances one period.
    pub fn set_velocity(&mut self, velocity: i32) {
        self.move_at(i64::from(velocity.max(-i32::MAX)) * UNIT_PER_S);
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

    /// The highest velocity from which the axis can stop within a distance, if it begins to
    /// decelerate a period later: `v T + v^2/(2 a) = d`. At most 2^-15 of it too low.
    #[must_use]
    pub fn stopping_velocity(distance: u32, deceleration: u32) -> i32 {
        const { assert_range(PERIOD_US) };
        let step = i64::from(deceleration) * i64::from(PERIOD_US);
        // At most 2^32: its square saturates.
        let step = divide(step, 1_000_000).unsigned_abs();
        let product = (u64::from(deceleration) * u64::from(distance)).saturating_mul(2);
        let root = rough_square_root(step.saturating_mul(step).saturating_add(product));
        i32::try_from(u64::from(root).saturating_sub(step)).unwrap_or(i32::MAX)
    }

    /// Continues with this velocity, at most 2^31 units per second, for one period.
    fn move_at(&mut self, velocity: i64) {
        self.velocity = velocity;
        let travel = self.fine_step();
        self.position = clamp_symmetric(self.position + travel, i32::MAX as i64 * UNIT);
    }
}

/// Largest representable velocity.
const VELOCITY_MAX: i64 = i32::MAX as i64 * UNIT_PER_S;

const fn max_velocity(limits: &Limits) -> i64 {
    let top = if limits.velocity < i32::MAX as u32 {
        limits.velocity
    } else {
        i32::MAX as u32
    };
    top as i64 * UNIT_PER_S
}

/// `numerator / divisor` by divisions of 32 bits; 0 if the divisor is 0. Digits of 32 bits, of
/// which the last is found in two halves: D. Knuth, "The Art of Computer Programming", volume 2,
/// 4.3.1, algorithm D.
#[inline(never)]
const fn divide_long(numerator: u64, divisor: u32) -> u64 {
    if divisor == 0 {
        return 0;
    }
    let high = (numerator >> 32) as u32;
    let rest = ((high % divisor) as u64) << 32 | numerator & 0xFFFF_FFFF;
    // The divisor has its highest bit set: a half of the quotient is estimated too high by 2 at
    // most.
    let shift = divisor.leading_zeros();
    let (normal, rest) = (divisor << shift, rest << shift);
    let (first, left) = half_digit((rest >> 32) as u32, (rest >> 16) as u32 & 0xFFFF, normal);
    let (second, _) = half_digit(left, rest as u32 & 0xFFFF, normal);
    let low = first << 16 | second;
    ((high / divisor) as u64) << 32 | low as u64
}

/// Quotient, of 16 bits, and remainder of `rest 2^16 + next` by a divisor whose highest bit is set;
/// `rest` is below the divisor.
#[inline(always)]
const fn half_digit(rest: u32, next: u32, divisor: u32) -> (u32, u32) {
    let (upper, lower) = (divisor >> 16, divisor & 0xFFFF);
    // It is not zero, which the compiler does not know.
    let upper = upper | 0x8000;
    let mut digit = rest / upper;
    let mut left = rest - digit * upper;
    // Twice: the estimate is too high by 2 at most.
    if digit > 0xFFFF || digit * lower > left << 16 | next {
        digit -= 1;
        left += upper;
        if left <= 0xFFFF && (digit > 0xFFFF || digit * lower > left << 16 | next) {
            digit -= 1;
        }
    }
    let product = digit.wrapping_mul(divisor);
    (digit, (rest << 16 | next).wrapping_sub(product))
}

/// `numerator / divisor`, rounded toward zero; 0 if the divisor is 0.
#[inline(always)]
pub(super) const fn divide(numerator: i64, divisor: u32) -> i64 {
    with_sign_of(
        numerator,
        divide_magnitude(numerator.unsigned_abs(), divisor),
    )
}

/// A magnitude below 2^63 with the sign of a number.
const fn with_sign_of(number: i64, magnitude: u64) -> i64 {
    if number < 0 {
        (magnitude as i64).wrapping_neg()
    } else {
        magnitude as i64
    }
}

/// `magnitude / divisor`; 0 if the divisor is 0.
///
/// Every control period divides several times. A processor of 32 bits has no division of 64 bits:
/// if the odd part of the divisor is below 2^16, long division with digits of 16 bits takes a third
/// of the instructions of the compiler's routine, and the magnitude over the even part is mostly
/// below 2^32. Inlined, since most divisors are constants.
#[inline(always)]
const fn divide_magnitude(magnitude: u64, divisor: u32) -> u64 {
    let shift = divisor.trailing_zeros() % u32::BITS;
    let odd = divisor >> shift;
    let shifted = magnitude >> shift;
    if odd <= 1 {
        return if odd == 0 { 0 } else { shifted };
    }
    if odd >= 1 << 16 {
        return divide_long(magnitude, divisor);
    }
    // A remainder is below 2^16: with the next digit it is below 2^32.
    let (high, low) = ((shifted >> 32) as u32, shifted as u32);
    if high == 0 {
        return (low / odd) as u64;
    }
    let middle = (high % odd) << 16 | low >> 16;
    let last = (middle % odd) << 16 | low & 0xFFFF;
    ((high / odd) as u64) << 32 | ((middle / odd) as u64) << 16 | (last / odd) as u64
}

fn clamp_symmetric(value: i64, bound: i64) -> i64 {
    value.max(-bound).min(bound)
}

/// Velocity change of an acceleration in one period: at least 1, at most 2^32 * 65.
fn velocity_change<const PERIOD_US: u32>(acceleration: u32) -> i64 {
    // Bounded twice: from 1 ms on the second bound has no effect and takes no instruction.
    in_period::<PERIOD_US>(i64::from(acceleration.max(1))).max(1)
}

/// `value` times the period in ms, rounded toward zero.
const fn in_period<const PERIOD_US: u32>(value: i64) -> i64 {
    const { assert_range(PERIOD_US) };
    if PERIOD_US.is_multiple_of(1000) {
        value * (PERIOD_US / 1000) as i64
    } else {
        divide(value * PERIOD_US as i64, 1000)
    }
}

/// `value`, below 2^63/1000, over the period in ms, rounded toward zero.
const fn per_period<const PERIOD_US: u32>(value: i64) -> i64 {
    with_sign_of(
        value,
        magnitude_per_period::<PERIOD_US>(value.unsigned_abs()),
    )
}

/// The same of a magnitude.
const fn magnitude_per_period<const PERIOD_US: u32>(magnitude: u64) -> u64 {
    const { assert_range(PERIOD_US) };
    if PERIOD_US.is_multiple_of(1000) {
        divide_magnitude(magnitude, PERIOD_US / 1000)
    } else {
        divide_magnitude(magnitude * 1000, PERIOD_US)
    }
}

/// The highest velocity from which a stop within `distance` is possible if each period reduces it
/// by `deceleration_step`.
///
/// With `d` the deceleration step, a stop from `k * d + r` travels `(k + 1)` periods at this
/// velocity less `d * k * (k + 1) / 2`; `k` is the largest for which `d * k * (k + 1) / 2` fits.
/// All distances are in velocity increments times one period.
fn braking_velocity<const PERIOD_US: u32>(distance: u64, deceleration_step: u64) -> i64 {
    // Below 2^61.
    let travel = magnitude_per_period::<PERIOD_US>(distance);
    // deceleration_step * k * (k + 1) / 2 <= travel.
    let saved = |k: u32| deceleration_step * (u64::from(k) * u64::from(k + 1) / 2);
    // The compiler's division of 64 bits by 64 takes three times as long as that by 32.
    let ratio = match u32::try_from(deceleration_step) {
        Ok(step) => divide_long(travel * 8, step),
        Err(_) => (travel * 8).checked_div(deceleration_step).unwrap_or(0),
    };
    let mut k = (rough_square_root(ratio + 1) - 1) / 2;
    // The root is low by its 2^-15 at most: by n <= (k + 1)/2^15 here, by none for a smaller k.
    if k >= 1 << 14 {
        let left = travel.saturating_sub(saved(k));
        let step = deceleration_step * u64::from(k + 1);
        k += left.checked_div(step).unwrap_or(0) as u32;
        // What n further periods save, n (k + 1) + n (n - 1)/2 steps, is taken for its first term.
        // The second, divided by k^2, bounds the velocity error: below
        // deceleration_step/2^31, and with n >= 2, k + 1 >= 2^16 below half an increment.
    }
    // Both terms are below 2^61.
    divide_magnitude(travel + saved(k), k + 1) as i64
}

/// The square root of a value, at most 2^-15 of it too low: that of its upper 31 or 32 bits.
fn rough_square_root(value: u64) -> u32 {
    let excess = (u64::BITS - value.leading_zeros()).saturating_sub(u32::BITS);
    let shift = excess.next_multiple_of(2);
    square_root((value >> shift) as u32) << (shift / 2)
}

/// The square root, rounded down, by Newton's method: a division of 32 bits is one instruction.
fn square_root(value: u32) -> u32 {
    // A power of two, from the root to twice the root: relative errors below 1, 1/4, 1/40, 1/3200
    // and 5e-8, of a root below 2^16. Integer steps never fall below the root rounded down.
    let mut root = 1 << (u32::BITS - value.leading_zeros()).div_ceil(2);
    for _ in 0..4 {
        root = (root + value.checked_div(root).unwrap_or(0)) / 2;
    }
    if u64::from(root) * u64::from(root) > u64::from(value) {
        root -= 1;
    }
    root
}

#[cfg(test)]
mod tests;
