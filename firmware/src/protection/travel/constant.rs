//! The error of the back-EMF's constant, by which the encoder's travel and the motor's differ.
//!
//! | before it is learned | encoder against motor |
//! |---|---|
//! | constant 30 % too low (`1/0.7 - 1`) | 43 % ahead |
//! | constant 30 % too high (`1 - 1/1.3`) | 23 % behind |
//!
//! The leaky sums of the residual and of the motor's travel have the ratio of the error. This is
//! taken once in either direction, when the sum of the travel passes [`MOTION_MDEG`]: the offset of
//! the back-EMF and a drift, which do not change their signs, cancel in the mean. What remains, in
//! shares of the encoder's travel:
//!
//! | cause | share |
//! |---|---|
//! | ferrite magnets, -0.2 %/K, 60 K from then (`1/0.88 - 1`) | 13.6 % |
//! | play of 1 deg in motions of 12 deg and of 24 deg (`(1/12 + 1/24)/2`) | 6.3 % |
//! | a count of rounding in each, and the rounding to 1 % | 1.5 % |
//!
//! It is learned once after each reset: a scale of the encoder that changes later is a fault, not
//! another constant.

use super::MDEG;

/// Share of the motor's travel by which the encoder may be further than the motor, and less far,
/// before the error is learned, %.
const AHEAD_PCT: i8 = 45;
const BEHIND_PCT: i8 = 25;

/// The same, in shares of the encoder's travel, around the learned error, %.
const LEARNED_PCT: i32 = 22;

/// The error of a constant between 130 and 70 %, %.
const LEAST_PCT: i32 = -23;
const MOST_PCT: i32 = 43;

/// Leaky sum of the motor's travel at which the error is taken, mdeg: half of a motion to and fro.
const MOTION_MDEG: i32 = 12_000;

/// Errors of which the mean is learned: one to and one fro.
const TAKEN: u8 = 2;

/// What is known of the constant.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct ConstantError {
    ahead_pct: i8,
    behind_pct: i8,
    /// Sum of the errors that were taken, %, and their number.
    sum_pct: i16,
    taken: u8,
}

impl Default for ConstantError {
    fn default() -> Self {
        Self {
            ahead_pct: AHEAD_PCT,
            behind_pct: BEHIND_PCT,
            sum_pct: 0,
            taken: 0,
        }
    }
}

impl ConstantError {
    /// What it makes of this travel of the motor: of a positive residual, and of a negative one.
    #[inline(always)]
    pub fn tolerances(&self, travel: i32) -> (i32, i32) {
        // The travel is below 2^30.
        let percent = travel.abs() / 100;
        let ahead = percent * i32::from(self.ahead_pct);
        let behind = percent * i32::from(self.behind_pct);
        if travel > 0 {
            (ahead, behind)
        } else {
            (behind, ahead)
        }
    }

    /// Takes the leaky sums of the residual and of the motor's travel, in [`MDEG`].
    #[inline(always)]
    pub fn learn(&mut self, drift: i32, motion: i32) {
        let way = if self.taken == 0 { motion } else { -motion };
        if self.taken < TAKEN && way >= MOTION_MDEG * MDEG {
            self.take(drift, motion);
        }
    }

    #[inline(never)]
    fn take(&mut self, drift: i32, motion: i32) {
        // Within 150 %, or the drift is a fault: 45 %, and 12.2 deg of limit and offset in 12 deg.
        self.sum_pct += drift.checked_div(motion / 100).unwrap_or(0) as i16;
        self.taken += 1;
        if self.taken == TAKEN {
            let error_pct = i32::from(self.sum_pct) / i32::from(TAKEN);
            let error_pct = error_pct.clamp(LEAST_PCT, MOST_PCT);
            let tolerance_pct = (100 + error_pct) * LEARNED_PCT / 100;
            self.ahead_pct = (tolerance_pct + error_pct) as i8;
            self.behind_pct = (tolerance_pct - error_pct) as i8;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is permitted ahead and behind of 100 deg after motions to and fro with this error, the
    /// residual beginning at an offset, deg.
    fn permitted(error_pct: i32, offset_deg: i32, motions: usize) -> (i32, i32) {
        let mut constant = ConstantError::default();
        for sign in [1, -1].into_iter().cycle().take(motions) {
            for deg in 0..60 {
                let residual = deg * error_pct * 10 * sign + offset_deg * 1_000;
                constant.learn(residual * MDEG, deg * 1_000 * sign * MDEG);
            }
        }
        let (above, below) = constant.tolerances(100_000 * MDEG);
        assert_eq!(constant.tolerances(-100_000 * MDEG), (below, above));
        (above / MDEG / 1_000, below / MDEG / 1_000)
    }

    #[test]
    fn a_learned_error_is_the_middle_of_what_is_permitted_whatever_the_offset() {
        for offset_deg in [-2, 0, 2] {
            for (error_pct, ahead_pct, behind_pct) in [(0, 22, 22), (40, 70, -10), (-20, -3, 37)] {
                let (ahead, behind) = permitted(error_pct, offset_deg, 2);
                // A percent of rounding, twice.
                assert!(ahead.abs_diff(ahead_pct) <= 2, "{error_pct}: {ahead}");
                assert!(behind.abs_diff(behind_pct) <= 2, "{error_pct}: {behind}");
            }
        }
        assert_eq!(permitted(-20, 0, 1), (45, 25), "before the second");
    }

    #[test]
    fn an_error_is_learned_once_and_within_that_of_a_constant() {
        // 43 % and 22 % of 143.
        assert_eq!(permitted(60, 0, 2), (74, -12));
        let mut constant = ConstantError::default();
        for (motions, error_pct) in [(2, 0), (40, -30)] {
            for sign in [1, -1].into_iter().cycle().take(motions) {
                let motion = 40_000 * sign * MDEG;
                constant.learn(motion / 100 * error_pct, motion);
            }
        }
        assert_eq!(constant.tolerances(100), (22, 22));
    }

    #[test]
    fn a_motion_in_one_direction_shows_nothing() {
        assert_eq!(permitted(0, 0, 1), (45, 25));
        let mut constant = ConstantError::default();
        for _ in 0..1_000 {
            constant.learn(0, 100_000 * MDEG);
        }
        assert_eq!(constant.taken, 1);
    }
}
