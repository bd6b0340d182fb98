//! Figures of the circuit for program and model: gains, dividers, thresholds.

use crate::design::{Design, LOGIC_V};

/// A voltage divider: resistors from a source to the middle, and from there to ground.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Divider {
    /// From the source to the middle, ohm.
    pub upper_ohm: f64,
    /// From the middle to ground, ohm.
    pub lower_ohm: f64,
    /// Tolerance of each resistor, relative.
    pub tolerance: f64,
}

impl Divider {
    /// The middle's share of the source.
    ///
    /// ```
    /// let divider = board_design::Divider { upper_ohm: 20e3, lower_ohm: 10e3, tolerance: 0.01 };
    /// assert_eq!(divider.ratio(), 1.0 / 3.0);
    /// ```
    #[must_use]
    pub fn ratio(self) -> f64 {
        self.lower_ohm / (self.upper_ohm + self.lower_ohm)
    }

    /// Relative error of the ratio, with one resistor at each end of its tolerance.
    #[must_use]
    pub fn error(self) -> f64 {
        2.0 * self.tolerance * (1.0 - self.ratio())
    }
}

impl Design {
    fn divider(&self, upper: &[&str], lower: &str) -> Divider {
        let tolerance = self.part(lower).and_then(|part| part.tolerance_pct);
        Divider {
            upper_ohm: upper.iter().map(|designator| self.value(designator)).sum(),
            lower_ohm: self.value(lower),
            tolerance: tolerance.map_or(f64::NAN, |percent| percent / 100.0),
        }
    }

    /// The divider of the supply.
    #[must_use]
    pub fn supply_divider(&self) -> Divider {
        self.divider(&["R22", "R26"], "R23")
    }

    /// The divider of leg A.
    #[must_use]
    pub fn leg_a_divider(&self) -> Divider {
        self.divider(&["R15"], "R16")
    }

    /// The divider of leg B.
    #[must_use]
    pub fn leg_b_divider(&self) -> Divider {
        self.divider(&["R17"], "R18")
    }

    /// The divider of the comparator's threshold.
    #[must_use]
    pub fn threshold_divider(&self) -> Divider {
        self.divider(&["R11"], "R12")
    }

    /// Relative error of the measured supply: of the divider and of the reference.
    #[must_use]
    pub fn supply_error(&self) -> f64 {
        self.supply_divider().error() + self.reference_tolerance()
    }

    /// Relative tolerance of the reference of the ADC.
    #[must_use]
    pub fn reference_tolerance(&self) -> f64 {
        self.figure("NUCLEO-F429ZI", "reference_tolerance")
    }

    /// A figure of the current amplifier.
    pub(crate) fn amplifier(&self, figure: &str) -> f64 {
        let kind = self.part("U3").map_or("", |part| part.kind.as_str());
        self.figure(kind, figure)
    }

    /// Volts at the ADC per ampere of motor current.
    #[must_use]
    pub fn current_gain_v_a(&self) -> f64 {
        self.amplifier("gain") * self.value("R10")
    }

    /// The greatest current that the program can read, A, as it computes it from the code. The
    /// reference of the ADC is the supply of the amplifier, so that the middle stays the middle.
    #[must_use]
    pub fn greatest_current_a(&self) -> f64 {
        let supply_v = LOGIC_V * (1.0 - self.reference_tolerance());
        let offset_v = self.amplifier("offset") * self.amplifier("gain")
            + self.amplifier("reference_error") * supply_v;
        let swing_v = supply_v / 2.0 - self.amplifier("below_supply") - offset_v;
        swing_v / supply_v * LOGIC_V / self.current_gain_v_a()
    }

    /// Nominal current at which the comparator trips, A.
    #[must_use]
    pub fn trip_a(&self) -> f64 {
        LOGIC_V * self.threshold_divider().ratio() / self.value("R1")
    }

    /// Lowest and highest voltage at R1 at which the comparator trips, V.
    #[must_use]
    pub fn threshold_range_v(&self) -> (f64, f64) {
        let kind = self.part("U4").map_or("", |part| part.kind.as_str());
        let (divider, offset_v) = (self.threshold_divider(), self.figure(kind, "offset"));
        let error = divider.error() + self.reference_tolerance();
        let reference_v = LOGIC_V * divider.ratio();
        let at = |sign: f64| reference_v * (1.0 + sign * error) + sign * offset_v;
        (at(-1.0), at(1.0))
    }

    /// Lowest and highest current at which the comparator trips, A.
    #[must_use]
    pub fn trip_range_a(&self) -> (f64, f64) {
        let tolerance = self.part("R1").and_then(|part| part.tolerance_pct);
        let error = tolerance.map_or(f64::NAN, |percent| percent / 100.0);
        let (low_v, high_v) = self.threshold_range_v();
        let shunt_ohm = self.value("R1");
        (
            low_v / (shunt_ohm * (1.0 + error)),
            high_v / (shunt_ohm * (1.0 - error)),
        )
    }
}
