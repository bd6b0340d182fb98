//! The winding of a brushed motor: resistance, inductance and back-EMF, with the bridge at its
//! terminals.
//!
//! ```text
//! L di/dt = v - R i - k w          torque = k i
//! ```
//!
//! With the back-EMF `e = k w` constant over a step, current and charge have closed forms in `E =
//! exp(-dt R/L)`, valid for every step length and for zero inductance.

/// Maximum supply voltage, V.
pub(super) const GREATEST_SUPPLY_V: f64 = 60.0;

crate::parameters! {
    /// The motor and its supply. The estimates are derived in [`crate::plant::drivetrain`].
    pub struct ElectricalParameters {
        /// Supply voltage of the bridge.
        supply_v [""]: 6.0, "V", 0.0, GREATEST_SUPPLY_V, "Futaba S3305: rated 4.8 V to 6 V";
        /// Resistance of winding, brushes and bridge.
        winding_resistance_ohm [""]: 7.7, "ohm", 0.05, 1000.0, "estimate from the catalogue's stall torque";
        /// Inductance of the winding.
        winding_inductance_h [""]: 1e-3, "H", 0.0, 1.0, "estimate: 0.13 ms with the resistance, usual for small cored motors";
        /// Torque per current, equal to the back-EMF per rate of the motor shaft.
        torque_constant_nm_a [""]: 3.62e-3, "Nm/A", 1e-5, 1.0, "estimate: no-load rate of 283.6 deg/s at 6 V";
        /// Forward voltage of each diode that conducts when all switches are open.
        diode_drop_v [""]: 0.7, "V", 0.0, 5.0, "body diode of a small MOSFET";
        /// Bridge state during the off time of a PWM period: 0 brakes, 1 coasts.
        coast_when_off [""]: 0.0, "choice", 0.0, 1.0, "sign-magnitude drive brakes";
    }
}

/// State of the bridge at the terminals of the winding.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Terminal {
    /// Driven with this voltage, V, limited to the supply.
    Driven(f64),
    /// Both terminals shorted.
    Brake,
    /// All switches open: the current decays through the diodes into the supply, then remains 0.
    Coast,
}

/// The winding and its current.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Winding {
    /// 1/R.
    conductance_s: f64,
    time_constant_s: f64,
    /// Forward voltage of the two conducting diodes.
    drop_v: f64,
    /// Voltage of supply and diodes that opposes the current.
    diode_v: f64,
    pub current_a: f64,
}

/// Coefficients of the closed form for one step length.
#[derive(Debug, Clone, Copy)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Step {
    pub step_s: f64,
    /// `E`, the share of the current at the start in that at the end.
    pub left: f64,
    /// `(1 - E)/R`, the current at the end per voltage.
    pub gain_s: f64,
    /// `(1 - E) L/(R dt)`, the share of the current at the start in the mean.
    pub mean_left: f64,
    /// The mean current per voltage. A sum of two products is a shorter path through a step than
    /// the difference from the steady current.
    pub mean_gain_s: f64,
}

impl Winding {
    pub fn new(p: &ElectricalParameters) -> Self {
        Self {
            conductance_s: 1.0 / p.winding_resistance_ohm,
            time_constant_s: p.winding_inductance_h / p.winding_resistance_ohm,
            drop_v: 2.0 * p.diode_drop_v,
            diode_v: p.supply_v + 2.0 * p.diode_drop_v,
            current_a: 0.0,
        }
    }

    /// Sets the resistance, ohm.
    pub fn set_resistance(&mut self, resistance_ohm: f64) {
        let inductance_h = self.time_constant_s / self.conductance_s;
        self.conductance_s = 1.0 / resistance_ohm;
        self.time_constant_s = inductance_h / resistance_ohm;
    }

    /// `L/R`, s.
    pub fn time_constant_s(&self) -> f64 {
        self.time_constant_s
    }

    pub fn set_supply_v(&mut self, supply_v: f64) {
        self.diode_v = supply_v + self.drop_v;
    }

    /// Coefficients for a step of `step_s`, which is above 0.
    pub fn step(&self, step_s: f64) -> Step {
        // Zero inductance: exp(-inf) = 0, the current follows immediately.
        let exponent = -step_s / self.time_constant_s;
        let gone = -libm::expm1(exponent);
        let mean_left = gone * self.time_constant_s / step_s;
        Step {
            step_s,
            left: libm::exp(exponent),
            gain_s: gone * self.conductance_s,
            mean_left,
            mean_gain_s: (1.0 - mean_left) * self.conductance_s,
        }
    }

    /// The terminal voltage, V.
    #[inline(always)]
    pub fn terminal_v(&self, terminal: Terminal, back_emf_v: f64) -> f64 {
        match terminal {
            Terminal::Driven(v) => v,
            Terminal::Brake => 0.0,
            Terminal::Coast if self.current_a > 0.0 => -self.diode_v,
            Terminal::Coast if self.current_a < 0.0 => self.diode_v,
            // The diodes conduct again if the back-EMF exceeds the supply.
            Terminal::Coast => crate::plant::within(back_emf_v, -self.diode_v, self.diode_v),
        }
    }

    /// Advances the current by a step; returns its mean, A.
    pub fn advance(&mut self, terminal: Terminal, back_emf_v: f64, step: &Step) -> f64 {
        let start_a = self.current_a;
        let voltage_v = self.terminal_v(terminal, back_emf_v);
        let mean_a = self.advance_driven(voltage_v, back_emf_v, step);
        if terminal == Terminal::Coast && self.current_a * start_a < 0.0 {
            // The diodes block at the zero crossing: E(t0) = -steady/(start - steady).
            let steady_a = (voltage_v - back_emf_v) * self.conductance_s;
            let tau_s = self.time_constant_s;
            let zero_s = tau_s * libm::log((steady_a - start_a) / steady_a);
            self.current_a = 0.0;
            return (steady_a * zero_s + tau_s * start_a) / step.step_s;
        }
        mean_a
    }

    /// The same with this voltage at the terminals during the whole step.
    #[inline(always)]
    pub fn advance_driven(&mut self, voltage_v: f64, back_emf_v: f64, step: &Step) -> f64 {
        step.advance(&mut self.current_a, voltage_v - back_emf_v)
    }
}

impl Step {
    /// Advances a current with this voltage at resistance and inductance; returns its mean, A.
    #[inline(always)]
    pub fn advance(&self, current_a: &mut f64, drop_v: f64) -> f64 {
        let start_a = *current_a;
        *current_a = start_a * self.left + drop_v * self.gain_s;
        start_a * self.mean_left + drop_v * self.mean_gain_s
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn winding(inductance: f64) -> Winding {
        Winding::new(&ElectricalParameters {
            winding_resistance_ohm: 2.0,
            winding_inductance_h: inductance,
            ..Default::default()
        })
    }

    #[test]
    fn the_current_rises_by_the_closed_form_in_one_step_or_many() {
        let (mut one, mut many) = (winding(4e-3), winding(4e-3));
        let mean = one.advance(Terminal::Driven(5.0), 1.0, &one.step(2e-3));
        let small = many.step(2e-5);
        let mut charge = 0.0;
        for _ in 0..100 {
            charge += many.advance(Terminal::Driven(5.0), 1.0, &small) * 2e-5;
        }
        // 4 V over 2 ohm, one time constant of 2 ms.
        let expected = 2.0 * (1.0 - libm::exp(-1.0));
        assert!((one.current_a - expected).abs() < 1e-14);
        assert!((many.current_a - expected).abs() < 1e-13);
        // The mean of 2 (1 - exp(-t/2 ms)) over 2 ms is 2/e.
        assert!((mean - 2.0 * libm::exp(-1.0)).abs() < 1e-14);
        assert!((charge / 2e-3 - mean).abs() < 1e-13);
    }

    #[test]
    fn without_inductance_the_current_follows_immediately() {
        let mut w = winding(0.0);
        assert_eq!(w.advance(Terminal::Driven(5.0), 1.0, &w.step(1e-6)), 2.0);
        assert_eq!(w.current_a, 2.0);
        assert_eq!(w.advance(Terminal::Coast, 1.0, &w.step(1e-6)), 0.0);
        assert_eq!(w.current_a, 0.0);
    }

    #[test]
    fn a_coasting_current_decays_through_the_diodes_to_zero() {
        let mut w = winding(4e-3);
        w.current_a = 1.0;
        // 7.4 V and 1 V of back-EMF oppose 1 A: steady -4.2 A, zero after 2 ms ln(5.2/4.2).
        let zero_s = 2e-3 * libm::log(5.2 / 4.2);
        let mean = w.advance(Terminal::Coast, 1.0, &w.step(1e-3));
        assert_eq!(w.current_a, 0.0);
        assert!((mean * 1e-3 - (-4.2 * zero_s + 2e-3)).abs() < 1e-15);
        assert_eq!(w.advance(Terminal::Coast, 1.0, &w.step(1e-3)), 0.0);
    }

    #[test]
    fn a_back_emf_above_the_supply_feeds_it_through_the_diodes() {
        let mut w = winding(0.0);
        w.advance(Terminal::Coast, 9.4, &w.step(1e-3));
        assert!((w.current_a + 1.0).abs() < 1e-14);
    }
}
