//! A pseudo-random binary sequence: a maximal-length shift register over GF(2).
//!
//! The register after `c` chips holds the polynomial `x^c` modulo a primitive polynomial, and the
//! output is its constant term. The power is calculated by squaring and multiplying, so that any
//! chip is available without the preceding ones, in some hundred instructions. The sequence of
//! order `n` repeats after `2^n - 1` chips; its spectrum is 3 dB down at 0.44 of the chip rate.

use super::at_least_one;
use crate::control::units::{Angle, angle};
use crate::parameter::{ParameterError, Parameters};
use crate::time::ticks;
use core::num::NonZeroU64;

crate::parameters! {
    /// A pseudo-random binary sequence.
    pub struct PrbsParameters {
        /// Magnitude of both levels.
        amplitude_deg [""]: 5.0, "deg", -32768.0, 32767.0, "as the chirp";
        /// Order of the shift register, a whole number: a period has 2^order - 1 chips.
        order ["n"]: 7.0, "choice", 3.0, 16.0, "a period of 10 s";
        /// Duration of a chip.
        chip_s [""]: 0.08, "s", 50e-6, 1e6, "0.44/chip = 5.5 Hz is above the bandwidth of 4.775 Hz";
        /// Index of the first chip in the sequence.
        seed [""]: 0.0, "1", 0.0, 65535.0, "the start";
    }
}

/// The smallest primitive polynomial of each order from 3, bit `k` for `x^k`; verified by the
/// tests.
const POLYNOMIALS: [u32; 14] = [
    0xB, 0x13, 0x25, 0x43, 0x83, 0x11D, 0x211, 0x409, 0x805, 0x1053, 0x201B, 0x402B, 0x8003,
    0x1_002D,
];

/// Two levels in pseudo-random order from tick 0 without end.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Prbs {
    amplitude: Angle,
    chip_ticks: NonZeroU64,
    seed: u32,
    polynomial: u32,
    order: u32,
}

impl Prbs {
    /// A sequence of an order from 3 to 16 that starts at chip `seed`; `None` for another order.
    ///
    /// ```
    /// use core::num::NonZeroU64;
    /// use model_core::{control::units::Angle, excitation::prbs::Prbs};
    /// const PRBS: Prbs = Prbs::new(Angle::ONE, 3, NonZeroU64::MIN, 0).unwrap();
    /// let chips: [i32; 8] = core::array::from_fn(|i| PRBS.command(i as u64).to_int());
    /// assert_eq!(chips, [1, -1, -1, 1, -1, 1, 1, 1]);
    /// ```
    pub const fn new(
        amplitude: Angle,
        order: u32,
        chip_ticks: NonZeroU64,
        seed: u32,
    ) -> Option<Self> {
        if order < 3 || order > 16 {
            return None;
        }
        Some(Self {
            amplitude,
            chip_ticks,
            seed,
            polynomial: POLYNOMIALS[order as usize - 3],
            order,
        })
    }

    /// A sequence with these parameters; whole numbers are rounded.
    ///
    /// ```
    /// use model_core::excitation::prbs::{Prbs, PrbsParameters};
    /// let prbs = Prbs::try_new(&PrbsParameters::default()).unwrap();
    /// assert_eq!(prbs.duration_ticks(), 127 * 1_600);
    /// assert_eq!([0, 1_600].map(|i| prbs.command(i).to_int()), [5, -5]);
    /// ```
    ///
    /// # Errors
    /// [`ParameterError::OutOfRange`] of the first parameter that is NaN or outside its range.
    pub fn try_new(parameters: &PrbsParameters) -> Result<Self, ParameterError> {
        parameters.check()?;
        let amplitude = angle(parameters.amplitude_deg);
        let order = libm::round(parameters.order) as u32;
        let chip_ticks = at_least_one(ticks(parameters.chip_s));
        let seed = libm::round(parameters.seed) as u32;
        Self::new(amplitude, order, chip_ticks, seed).ok_or(ParameterError::OutOfRange {
            parameter: PrbsParameters::TABLE[1],
            value: parameters.order,
        })
    }

    /// The command at a tick.
    pub fn command(&self, tick: u64) -> Angle {
        let period = self.period();
        // Both are below 2^32: the sum does not overflow.
        let chip = tick / self.chip_ticks % period + u64::from(self.seed);
        if self.power((chip % period) as u32) & 1 == 1 {
            self.amplitude
        } else {
            self.amplitude.saturating_neg()
        }
    }

    /// Ticks of one period.
    pub fn duration_ticks(&self) -> u64 {
        self.period().get().saturating_mul(self.chip_ticks.get())
    }

    /// Chips in a period.
    fn period(&self) -> NonZeroU64 {
        // 2^n - 1 is odd: the lowest bit is already set.
        NonZeroU64::MIN | ((1 << self.order) - 1)
    }

    const fn power(&self, exponent: u32) -> u32 {
        let mut power = 1;
        let mut bit = self.order;
        while bit > 0 {
            bit -= 1;
            power = self.product(power, power);
            if exponent >> bit & 1 == 1 {
                power = self.times_x(power);
            }
        }
        power
    }

    const fn product(&self, a: u32, b: u32) -> u32 {
        let mut product = 0;
        let mut bit = self.order;
        while bit > 0 {
            bit -= 1;
            product = self.times_x(product);
            if b >> bit & 1 == 1 {
                product ^= a;
            }
        }
        product
    }

    const fn times_x(&self, a: u32) -> u32 {
        let shifted = a << 1;
        if shifted >> self.order & 1 == 1 {
            shifted ^ self.polynomial
        } else {
            shifted
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    fn prbs(order: u32, seed: u32) -> Prbs {
        Prbs::new(Angle::ONE, order, NonZeroU64::MIN, seed).unwrap()
    }

    fn chips(prbs: &Prbs) -> Vec<i32> {
        (0..prbs.duration_ticks())
            .map(|tick| prbs.command(tick).to_int())
            .collect()
    }

    #[test]
    fn every_order_visits_every_state_but_zero_once_in_a_period() {
        for order in 3..=16 {
            let prbs = prbs(order, 0);
            let mut state = 1;
            for chip in 0..prbs.period().get() {
                assert_eq!(prbs.power(chip as u32), state, "order {order}, chip {chip}");
                state = prbs.times_x(state);
                assert_eq!(
                    state == 1,
                    chip + 1 == prbs.period().get(),
                    "order {order}, chip {chip}"
                );
            }
        }
    }

    #[test]
    fn the_autocorrelation_has_two_values() {
        for order in 3..=8 {
            let chips = chips(&prbs(order, 0));
            for shift in 0..chips.len() {
                let shifted = chips.iter().cycle().skip(shift);
                let sum: i32 = chips.iter().zip(shifted).map(|(a, b)| a * b).sum();
                assert_eq!(sum, if shift == 0 { chips.len() as i32 } else { -1 });
            }
        }
    }

    #[test]
    fn a_period_has_one_more_positive_than_negative_chip() {
        for order in 3..=16 {
            assert_eq!(chips(&prbs(order, 0)).iter().sum::<i32>(), 1);
        }
    }

    #[test]
    fn a_seed_selects_the_first_chip_of_the_sequence() {
        for seed in [1, 126, 127, u32::MAX] {
            for tick in 0..300 {
                let there = prbs(7, 0).command(tick + u64::from(seed));
                assert_eq!(prbs(7, seed).command(tick), there);
            }
        }
    }

    #[test]
    fn there_is_no_order_below_3_or_above_16() {
        for order in [0, 2, 17, u32::MAX] {
            assert_eq!(Prbs::new(Angle::ONE, order, NonZeroU64::MIN, 0), None);
        }
    }
}
