//! Bit timing: the length of a bit, and the tolerated difference between two stations.

/// The bit timing of a station.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BitTiming {
    /// Length of a bit, ps.
    pub bit_ps: u64,
    /// Maximum relative error of the length that resynchronisation compensates, 1e-6.
    pub tolerance_ppm: u64,
}

/// Picoseconds in a second.
const PS_PER_S: u64 = 1_000_000_000_000;

impl BitTiming {
    /// Bit timing of a value of `CAN_BTR` at a peripheral clock, Hz (RM0090, section 32.7.7);
    /// `None` while the clock is stopped.
    ///
    /// The tolerance is the smaller of ISO 11898-1's two limits, with a bit of `n` quanta:
    /// `SJW/(20 n)` and `min(TS1, TS2)/(2 (13 n - TS2))`.
    ///
    /// ```
    /// use virtual_board::can::BitTiming;
    ///
    /// // 42 MHz / 3, 1 + 11 + 2 quanta, jump width 1.
    /// let timing = BitTiming::from_btr(0x001a_0002, 42_000_000).unwrap();
    /// assert_eq!(timing.bit_ps, 1_000_000);
    /// assert_eq!(timing.tolerance_ppm, 3571); // 1/(20 14) < 2/(2 (13 14 - 2))
    /// ```
    pub fn from_btr(btr: u32, clock_hz: u64) -> Option<Self> {
        let field = |shift: u32, mask: u32| u64::from((btr >> shift) & mask) + 1;
        let (prescaler, ts1, ts2, jump) = (
            field(0, 0x3ff),
            field(16, 0xf),
            field(20, 0x7),
            field(24, 0x3),
        );
        Self::of_quanta(prescaler, (ts1, ts2), jump, clock_hz)
    }

    /// Bit timing of this prescaler, these segments before and after the sample point, and this
    /// jump width, at a clock, Hz; `None` while the clock is stopped.
    pub fn of_quanta(
        prescaler: u64,
        (ts1, ts2): (u64, u64),
        jump: u64,
        clock_hz: u64,
    ) -> Option<Self> {
        let quanta = 1 + ts1 + ts2;
        if clock_hz == 0 {
            return None;
        }
        let by_jump = 1_000_000 * jump / (20 * quanta);
        let by_segment = 1_000_000 * ts1.min(ts2) / (2 * (13 * quanta - ts2));
        Some(Self {
            bit_ps: PS_PER_S * prescaler * quanta / clock_hz,
            tolerance_ppm: by_jump.min(by_segment),
        })
    }

    /// An exact station at this rate, bit/s, which is above 0.
    pub fn at_rate(bit_s: u32) -> Self {
        Self {
            bit_ps: PS_PER_S / u64::from(bit_s.max(1)),
            tolerance_ppm: 2_000,
        }
    }

    /// Duration of this number of bits, ns.
    pub fn bits_ns(&self, bits: u32) -> u64 {
        u64::from(bits) * self.bit_ps / 1000
    }

    /// Whether two stations can receive each other's frames.
    pub fn is_compatible(&self, other: &Self) -> bool {
        let difference = self.bit_ps.abs_diff(other.bit_ps);
        let tolerance = self.tolerance_ppm + other.tolerance_ppm;
        difference * 1_000_000 <= self.bit_ps.min(other.bit_ps) * tolerance
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_two_rates_of_the_board_are_not_compatible() {
        let fast = BitTiming::from_btr(0x001a_0002, 42_000_000).unwrap();
        let slow = BitTiming::from_btr(0x001a_0005, 42_000_000).unwrap();
        assert_eq!(slow.bit_ps, 2_000_000);
        assert!(fast.is_compatible(&BitTiming::at_rate(1_000_000)));
        assert!(slow.is_compatible(&BitTiming::at_rate(500_000)));
        assert!(!fast.is_compatible(&slow));
    }

    #[test]
    fn an_oscillator_a_fifth_of_a_percent_off_still_agrees_and_one_percent_does_not() {
        let exact = BitTiming::from_btr(0x001a_0002, 42_000_000).unwrap();
        let off = |ppm: u64| BitTiming {
            bit_ps: 1_000_000 + ppm,
            ..exact
        };
        assert!(exact.is_compatible(&off(2_000)));
        assert!(!exact.is_compatible(&off(10_000)));
    }

    #[test]
    fn without_a_clock_there_is_no_bit() {
        assert_eq!(BitTiming::from_btr(0, 0), None);
    }
}
