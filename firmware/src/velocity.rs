//! The velocity that is reported: a tracking loop behind the encoder.
//!
//! The rate estimate of the control law is fast and coarse: one count more or less in a period is
//! 22 deg/s, of which its filter leaves 40 %. What is reported, and what the windows of CiA 402
//! compare, comes from a loop of second order that tracks the corrected angle of the encoder:
//!
//! ```text
//! lead    += rate                       the angle tracked minus the last one measured
//! error    = travelled - lead
//! lead     = -(1 - g)^2 error
//! rate    += g^2 error                  both poles at z = 1 - g
//! ```
//!
//! With `g = T * 31.25/s`, an eighth at 250 Hz, both poles lie at `-ln(1 - g)/T`, 33 rad/s:
//!
//! | | |
//! |---|---|
//! | bandwidth (-3 dB) | 33 rad/s * 0.644 = 21 rad/s = 3.4 Hz |
//! | lag behind a velocity that changes steadily | 2/(33 rad/s) = 60 ms |
//! | a step of the velocity is shown to 1 % after | 6.6/(33 rad/s) = 0.2 s |
//! | ripple at a constant velocity | at most 1.1 deg/s |
//!
//! The ripple: the quantisation is within half a count of `q = 360/4096 deg` on either side. A step
//! of one count shows as `g^2/T (k + 1) (1 - g)^k q` after `k` periods, which grows to
//! `12.3/s * q = 1.08 deg/s` and falls to zero. The sum of the magnitudes of the response to a
//! single sample is twice that peak, and half a count times it is 1.08 deg/s: no velocity and no
//! phase of the counts gives more.

use model_core::{
    control::{encoder_word::COUNT_DEG, units::Angle},
    time::CONTROL_RATE_HZ,
};

/// Share `g` of the poles, `T * 31.25/s`: a power of two at 250 Hz and at 1 kHz.
const SHARE: f32 = 31.25 / CONTROL_RATE_HZ as f32;

/// What is left of an error of the angle.
const LEFT: f32 = (1.0 - SHARE) * (1.0 - SHARE);

/// An encoder count in units of the tracked angle, 2^-9 deg.
const COUNT: i32 = (COUNT_DEG * 512.0) as i32;

/// mdeg/s in one unit a control period.
const MDEG_S: f32 = 1000.0 / 512.0 * CONTROL_RATE_HZ as f32;

const _: () = assert!(COUNT == 45, "a count is a whole number of units");

/// The tracking loop. Angles are in 2^-9 deg, the rate in that a control period.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct VelocityTracker {
    /// The last valid angle; `None` before the first and once the position is lost.
    last: Option<i32>,
    lead: f32,
    rate: f32,
}

impl VelocityTracker {
    /// Discards the angle: the next one is a start from rest.
    pub fn reset(&mut self) {
        *self = Self::default();
    }

    /// One control period, behind so many that did not run; without an angle the rate stays.
    pub fn step(&mut self, angle: Option<Angle>, missed_periods: u8) {
        if missed_periods > 0 {
            self.lead += self.rate * f32::from(missed_periods);
        }
        self.lead += self.rate;
        let Some(angle) = angle else {
            return;
        };
        // Angles lie within 2^15 deg, so this within 2^24: differences are exact.
        let angle = (angle.to_bits() >> 23) as i32;
        let Some(last) = self.last.replace(angle) else {
            self.lead = 0.0;
            return;
        };
        let error = (angle - last) as f32 - self.lead;
        self.lead = -LEFT * error;
        self.rate += SHARE * SHARE * error;
    }

    /// The velocity, mdeg/s.
    pub fn mdeg_s(&self) -> i32 {
        (self.rate * MDEG_S) as i32
    }
}

#[cfg(test)]
mod tests {
    extern crate std;

    use proptest::prelude::*;

    use super::*;

    /// One count a control period, mdeg/s.
    const COUNT_MDEG_S: f64 = COUNT_DEG * 1000.0 * CONTROL_RATE_HZ as f64;

    /// The greatest ripple of the table above, mdeg/s, and its rounding.
    const RIPPLE_MDEG_S: f64 = 1080.0;

    /// The angle of the count at so many counts.
    fn angle(counts: f64) -> Option<Angle> {
        let units = (counts.floor() as i64) * i64::from(COUNT);
        Some(Angle::from_bits(units << 23))
    }

    fn settled(counts_a_period: f64, phase: f64) -> (VelocityTracker, f64) {
        let mut tracker = VelocityTracker::default();
        let mut counts = phase;
        for _ in 0..CONTROL_RATE_HZ {
            counts += counts_a_period;
            tracker.step(angle(counts), 0);
        }
        (tracker, counts)
    }

    proptest! {
        #[test]
        fn at_a_constant_velocity_the_ripple_is_within_that_of_the_table(
            velocity_mdeg_s in -400_000..400_000_i32, phase in 0.0..1.0_f64,
        ) {
            let counts_a_period = f64::from(velocity_mdeg_s) / COUNT_MDEG_S;
            let (mut tracker, mut counts) = settled(counts_a_period, phase);
            for _ in 0..2 * CONTROL_RATE_HZ {
                counts += counts_a_period;
                tracker.step(angle(counts), 0);
                let error = tracker.mdeg_s() - velocity_mdeg_s;
                prop_assert!(f64::from(error.abs()) <= RIPPLE_MDEG_S + 1.0, "{error}");
            }
        }

        #[test]
        fn missed_periods_and_lost_samples_change_no_constant_velocity(
            velocity_mdeg_s in -400_000..400_000_i32, missed in 0..9_u8, lost in 0..9,
        ) {
            let counts_a_period = f64::from(velocity_mdeg_s) / COUNT_MDEG_S;
            let (mut tracker, mut counts) = settled(counts_a_period, 0.5);
            for _ in 0..lost {
                counts += counts_a_period;
                tracker.step(None, 0);
            }
            counts += counts_a_period * f64::from(missed + 1);
            tracker.step(angle(counts), missed);
            let error = tracker.mdeg_s() - velocity_mdeg_s;
            // The error of the angle that was predicted with the ripple enters with its share.
            let periods = f64::from(lost + i32::from(missed) + 1);
            let share = f64::from(SHARE * SHARE);
            let bound = RIPPLE_MDEG_S * (1.0 + share * periods) + share * COUNT_MDEG_S + 1.0;
            prop_assert!(f64::from(error.abs()) <= bound, "{error}");
        }
    }

    #[test]
    fn a_steady_acceleration_is_shown_with_the_lag_of_the_table() {
        // Fine enough that the counts hardly matter: 2000 deg/s^2 for a quarter of a second.
        let acceleration = 2e6 / COUNT_MDEG_S / f64::from(CONTROL_RATE_HZ);
        let mut tracker = VelocityTracker::default();
        let (mut counts, mut rate) = (0.5, 0.0);
        for _ in 0..CONTROL_RATE_HZ / 4 {
            rate += acceleration;
            counts += rate;
            tracker.step(angle(counts), 0);
        }
        let behind_mdeg_s = rate * COUNT_MDEG_S - f64::from(tracker.mdeg_s());
        let lag_s = behind_mdeg_s / 2e6;
        // Two poles, 2 (1 - g)/g periods exactly: 56 ms at 250 Hz, 60 ms in continuous time.
        assert!((0.054..0.062).contains(&lag_s), "{lag_s}");
    }

    #[test]
    fn a_lost_position_starts_from_rest() {
        let (mut tracker, counts) = settled(10.0, 0.0);
        tracker.reset();
        for _ in 0..CONTROL_RATE_HZ {
            tracker.step(angle(counts - 4096.0), 0);
            assert_eq!(tracker.mdeg_s(), 0);
        }
    }
}
