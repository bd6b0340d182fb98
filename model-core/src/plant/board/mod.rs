//! Everything that the chip's pins see: motor, gear train, supply, encoder, analogue front ends.
//!
//! The plant is driven from boundary to boundary of a fixed grid, twice a PWM period: 900 us, where
//! the window for the back-EMF opens, and 1000 us. Whoever calls it with the same bridge states
//! gets the same words and codes bit for bit: the emulated board does, and so does a loop that runs
//! the application natively.

mod bridge;
mod control_period;
mod defects;
mod encoder;
mod options;
mod sensed;
mod slot;
mod supply;
#[cfg(test)]
mod tests;

use crate::parameter::ParameterError;
use crate::plant::drivetrain::{Drivetrain, Reading, electrical::Terminal};
use crate::sensors::noise::Noise;

pub use bridge::{Bridge, PERIOD_CYCLES};
pub use control_period::{Edge, Sampled, SampledBoardPlant};
pub use defects::Defects;
pub use encoder::{EncoderWire, SsiWord, Stuck};
pub use options::BoardPlantOptions;
pub use sensed::{Legs, Sensed};
pub use slot::{Slot, WINDOW_NS};
pub use supply::SupplyParameters;

use self::encoder::EncoderOutput;
use self::sensed::FrontEnds;
use self::supply::Supply;

/// The plant.
#[derive(Debug, Clone)]
pub struct BoardPlant {
    /// What is broken.
    pub defects: Defects,
    drivetrain: Drivetrain,
    supply: Supply,
    encoder: EncoderOutput,
    front_ends: FrontEnds,
    /// What the bridge did in the last interval.
    bridge: Bridge,
    /// Current through the bridge's shunt at its end, A, with the sign of the motor's.
    bridge_a: f64,
}

impl BoardPlant {
    /// A plant at rest at zero, with a bridge that is off.
    ///
    /// # Errors
    /// That of the first parameter outside its range.
    ///
    /// ```
    /// use model_core::plant::board::{Bridge, BoardPlant, BoardPlantOptions, Slot};
    ///
    /// let mut plant = BoardPlant::try_new(&BoardPlantOptions::default()).unwrap();
    /// for _ in 0..500 {
    ///     plant.advance(Bridge::driven(28_000), Slot::Head);
    ///     plant.advance(Bridge::driven(28_000), Slot::Tail);
    /// }
    /// // Half of 283.6 deg/s, less the share of friction and dead time.
    /// assert!((plant.reading().output.rate_deg_s - 133.6).abs() < 1.0);
    /// ```
    pub fn try_new(options: &BoardPlantOptions) -> Result<Self, ParameterError> {
        let noise = |stream| Noise::new(options.seed, stream);
        Ok(Self {
            defects: Defects::default(),
            drivetrain: Drivetrain::try_new(&options.drivetrain)?,
            supply: Supply::try_new(&options.drivetrain.electrical, &options.supply)?,
            encoder: EncoderOutput::try_new(options.encoder, noise(0))?,
            front_ends: FrontEnds::try_new(options, noise)?,
            bridge: Bridge::Coast,
            bridge_a: 0.0,
        })
    }

    /// Runs a slot of the grid with the bridge in this state.
    pub fn advance(&mut self, bridge: Bridge, slot: Slot) {
        let share = bridge.share(slot.from_ns(), slot.until_ns());
        self.advance_with(bridge, share, slot.length_s());
    }

    /// Runs any time, where the grid is disturbed: the board restarts, or a fault wants it finer.
    pub fn advance_by(&mut self, bridge: Bridge, time_s: f64) {
        let share = bridge.share(0, Slot::Tail.until_ns());
        self.advance_with(bridge, share, time_s);
    }

    fn advance_with(&mut self, bridge: Bridge, share: f64, time_s: f64) {
        self.bridge = bridge;
        self.supply
            .advance(time_s, self.bridge_a * share, &self.defects);
        let supply_v = self.supply.volts();
        self.drivetrain.set_supply_v(supply_v);
        self.drivetrain.set_jammed(self.defects.is_jammed);
        self.drivetrain
            .set_recorded_torque_nm(self.defects.torque_nm);
        let terminal = self.terminal(bridge, share * supply_v);
        self.drivetrain.advance(terminal, time_s);
        self.bridge_a = self.shunt_a(terminal);
    }

    /// What the winding sees of the bridge, whose mean voltage this is.
    fn terminal(&self, bridge: Bridge, mean_v: f64) -> Terminal {
        let shorted = self.defects.motor_short_ohm.is_some();
        match bridge {
            _ if self.defects.is_motor_open => Terminal::Coast,
            // The short brakes the motor where the bridge does not drive it.
            Bridge::Coast if shorted => Terminal::Brake,
            Bridge::Coast => Terminal::Coast,
            Bridge::Brake => Terminal::Brake,
            Bridge::Driven { .. } => Terminal::Driven(mean_v),
        }
    }

    /// The winding's current, and that of a short across it while the bridge drives.
    fn shunt_a(&self, terminal: Terminal) -> f64 {
        let reading = self.drivetrain.reading();
        let short_a = match (self.defects.motor_short_ohm, terminal) {
            (Some(ohm), Terminal::Driven(v)) => v / ohm.max(1e-3),
            _ => 0.0,
        };
        let open = self.bridge == Bridge::Coast && self.defects.motor_short_ohm.is_some();
        if open {
            0.0
        } else {
            reading.current_a + short_a
        }
    }

    /// The encoder's word and the converter's codes, for what follows.
    pub fn sense(&mut self) -> Sensed {
        let reading = self.drivetrain.reading();
        let quantities = sensed::Quantities {
            current_a: self.bridge_a,
            supply_v: self.supply_on_v(),
            temperature_deg_c: self
                .defects
                .temperature_deg_c
                .unwrap_or(self.front_ends.ambient_deg_c),
        };
        let mut sensed = self.front_ends.sense(&quantities, self.legs(self.bridge));
        sensed.encoder = self.encoder.word(reading.output.angle_deg, &self.defects);
        if let Some(code) = self.defects.stuck_current {
            sensed.current = code;
        }
        sensed
    }

    /// What the supply falls to while the bridge conducts, V: its pin is sampled in the middle of
    /// the on time.
    fn supply_on_v(&self) -> f64 {
        match self.bridge {
            Bridge::Driven { is_positive, .. } => {
                let drawn_a = if is_positive {
                    self.bridge_a
                } else {
                    -self.bridge_a
                };
                self.supply.under(drawn_a)
            }
            Bridge::Brake | Bridge::Coast => self.supply.volts(),
        }
    }

    /// The legs' codes now that the bridge is in this state; nothing moves, and no noise is drawn.
    pub fn sense_legs(&mut self, bridge: Bridge) -> Legs {
        let legs = self.legs(bridge);
        self.front_ends.legs(legs)
    }

    /// Voltages of the legs, V.
    fn legs(&self, bridge: Bridge) -> [f64; 2] {
        let supply_v = self.supply.volts();
        match bridge {
            Bridge::Coast => {
                let back_emf_v =
                    if self.defects.is_motor_open || self.defects.motor_short_ohm.is_some() {
                        0.0
                    } else {
                        self.drivetrain.reading().back_emf_v
                    };
                [(supply_v + back_emf_v) / 2.0, (supply_v - back_emf_v) / 2.0]
            }
            Bridge::Brake => [0.0; 2],
            Bridge::Driven { .. } => {
                let share = bridge.share(0, Slot::Tail.until_ns());
                [share.max(0.0) * supply_v, (-share).max(0.0) * supply_v]
            }
        }
    }

    /// Everything that can be read off the drivetrain.
    pub fn reading(&self) -> Reading {
        self.drivetrain.reading()
    }

    /// Current through the bridge's shunt, A.
    pub fn bridge_current_a(&self) -> f64 {
        self.bridge_a
    }

    /// Voltage of the supply at the board, V.
    pub fn supply_v(&self) -> f64 {
        self.supply.volts()
    }
}
