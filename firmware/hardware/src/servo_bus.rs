//! Figures of the servo bus: a wire that a pin with open drain pulls low, and R34 high.
//!
//! R34 is at the pin, R33 between it and the bus. The drop at R33 then adds to the low level of a
//! servo, which the pin reads with a known threshold, and not to that of the board, which servos
//! read with thresholds that their makers do not state.

use crate::design::{Design, LOGIC_V};

/// Net of the bus outside R33.
const BUS: &str = "BUS_DATA";

/// The servo bus, with all tolerances.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ServoBus {
    /// Half a bit at the greatest bit rate, s.
    pub half_bit_s: f64,
    /// Longest rise from ground to the level that reads high, s.
    pub rise_s: f64,
    /// Greatest level at the pin while a servo drives low, V.
    pub low_v: f64,
    /// Greatest level that the pin reads as low, V.
    pub reads_low_v: f64,
    /// Greatest current from R34 into the pin that drives low, A.
    pub sunk_a: f64,
    /// Greatest voltage of the bus, V.
    pub highest_v: f64,
    /// Greatest current through R34 into the supply while servos hold the bus at this voltage, A.
    pub returned_a: f64,
    /// Bound of the current into the pin that drives low against this voltage: R33 is the only
    /// resistance, A.
    pub opposed_a: f64,
}

impl Design {
    /// The servo bus.
    #[must_use]
    pub fn servo_bus(&self) -> ServoBus {
        let bus = |figure| self.figure("servo bus", figure);
        let pin = |figure| self.figure("STM32F429ZI", figure);
        let (series, pull_up) = (self.resistance("R33"), self.resistance("R34"));
        let tolerance = self.reference_tolerance();
        let (least_v, most_v) = (LOGIC_V * (1.0 - tolerance), LOGIC_V * (1.0 + tolerance));
        let capacitance = bus("servos") * bus("servo_capacitance")
            + bus("cable_length") * bus("cable_capacitance")
            + pin("pin_capacitance");
        // The threshold is a share of the supply that R34 charges to, which cancels.
        let low_share = 1.0 - pin("input_high_share");
        // The pin reads it the closer to its threshold, the lower the supply is.
        let dropped = series.1 / (series.1 + pull_up.0);
        let servo_v = bus("servo_low");
        let highest_v = self
            .range("actuator", BUS)
            .map_or(f64::NAN, |range| range.surge_v);
        let sunk_a = most_v / pull_up.0;
        ServoBus {
            half_bit_s: 0.5 / bus("baud"),
            rise_s: (series.1 + pull_up.1) * capacitance * (1.0 / low_share).ln(),
            low_v: servo_v + (least_v - servo_v) * dropped,
            reads_low_v: least_v * low_share,
            sunk_a,
            highest_v,
            returned_a: (highest_v - least_v) / (series.0 + pull_up.0),
            opposed_a: highest_v / series.0 + sunk_a,
        }
    }

    /// Least and greatest resistance of a part, ohm.
    fn resistance(&self, designator: &str) -> (f64, f64) {
        let tolerance = self.part(designator).and_then(|part| part.tolerance_pct);
        let error = tolerance.map_or(f64::NAN, |percent| percent / 100.0);
        let nominal = self.value(designator);
        (nominal * (1.0 - error), nominal * (1.0 + error))
    }
}
