//! Everything that the chip's pins see: motor, gear train, supply, encoder, analogue front ends.
//!
//! The plant advances slot by slot through each update period: to the instant at which the current
//! is sampled, to the start of the coast window, to the instant at which the legs are sampled, to
//! the next edge. Within a slot the winding's current is computed in closed form between the edges
//! of the bridge, with the conduction of the diodes while all switches are open. Two callers that
//! pass the same bridge states obtain the same words and codes bit for bit: the emulated board
//! does, and so does a loop that runs the application natively.

mod bridge;
mod control_period;
mod defects;
mod encoder;
mod heat;
mod legs;
mod options;
mod sensed;
mod slot;
mod supply;
#[cfg(test)]
mod tests;

use crate::control::pwm_timer::CurrentInstant;
use crate::parameter::ParameterError;
use crate::plant::drivetrain::{Drivetrain, Reading, electrical::Terminal};
use crate::sensors::dividers::{leg_code, temperature_code};
use crate::sensors::noise::Noise;

pub use bridge::{Bridge, PERIOD_CYCLES};
pub use control_period::{Edge, Sampled, SampledBoardPlant};
pub use defects::Defects;
pub use encoder::{ENCODER_DELAY_S, EncoderWire, SsiWord, Stuck};
pub use heat::HeatParameters;
pub use options::BoardPlantOptions;
pub use sensed::{Legs, Sensed};
pub use slot::Slot;
pub use supply::SupplyParameters;

use self::bridge::{Connection, Switched};
use self::encoder::EncoderOutput;
use self::heat::Heat;
use self::legs::LegVoltages;
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
    legs: LegVoltages,
    heat: Heat,
    sensed: Sensed,
    /// The connection of the winding at the end of the last slot.
    connection: Connection,
    /// Mean current drawn from the supply in the last slot, A.
    drawn_a: f64,
    /// Largest current through the bridge's return in the last slot, A.
    return_peak_a: f64,
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
    /// let bridge = Bridge::driven(28_000);
    /// for _ in 0..500 {
    ///     for slot in Slot::ALL {
    ///         plant.advance(bridge, slot, bridge.current_instant());
    ///     }
    /// }
    /// // Half of 283.6 deg/s, less the share of friction and dead time.
    /// assert!((plant.reading().output.rate_deg_s - 133.6).abs() < 1.0);
    /// ```
    pub fn try_new(options: &BoardPlantOptions) -> Result<Self, ParameterError> {
        let noise = |stream| Noise::new(options.seed, stream);
        let mut plant = Self {
            defects: Defects::default(),
            drivetrain: Drivetrain::try_new(&options.drivetrain)?,
            supply: Supply::try_new(&options.drivetrain.electrical, &options.supply)?,
            encoder: EncoderOutput::try_new(options.encoder, noise(0))?,
            front_ends: FrontEnds::try_new(options, noise)?,
            legs: LegVoltages::new(&options.drivetrain.electrical),
            heat: Heat::try_new(options)?,
            sensed: Sensed::default(),
            connection: Connection::Open,
            drawn_a: 0.0,
            return_peak_a: 0.0,
        };
        plant.sample_current();
        plant.sample_legs();
        plant.sample_encoder();
        Ok(plant)
    }

    /// Runs a slot of a PWM period with the bridge in this state, and samples at its end what the
    /// slot is named for. `current` is the instant at which this period samples the current.
    /// Returns the mean current of the winding in the slot, A.
    pub fn advance(&mut self, bridge: Bridge, slot: Slot, current: CurrentInstant) -> f64 {
        let (from, until) = slot.cycles(current);
        let length_s = slot::seconds(until - from);
        self.start_slot(length_s);
        let mut charge = 0.0;
        for (switched, cycles) in bridge.between(from, until) {
            if cycles > 0 {
                let time_s = slot::seconds(cycles);
                charge += self.run(switched, time_s) * time_s;
            }
        }
        self.drawn_a /= length_s;
        match slot {
            Slot::Current => self.sample_current(),
            Slot::Window => self.legs.open(self.current_a(), self.back_emf_v()),
            Slot::Legs => self.sample_legs(),
            Slot::Edge => self.sample_encoder(),
        }
        charge / length_s
    }

    /// Runs any time, where the periods are disturbed: the board restarts, or a fault requires a
    /// finer step. The bridge's mean voltage acts, and everything is sampled at the end.
    pub fn advance_by(&mut self, bridge: Bridge, time_s: f64) {
        if time_s <= 0.0 {
            return;
        }
        self.start_slot(time_s);
        for (switched, cycles) in bridge.between(0, PERIOD_CYCLES) {
            if cycles > 0 {
                let share = f64::from(cycles) / f64::from(PERIOD_CYCLES);
                self.run(switched, time_s * share);
            }
        }
        self.drawn_a /= time_s;
        self.legs.open(0.0, self.back_emf_v());
        self.sample_current();
        self.sample_legs();
        self.sample_encoder();
    }

    fn start_slot(&mut self, time_s: f64) {
        self.supply.advance(time_s, self.drawn_a, &self.defects);
        if let Some(resistance_ohm) = self.heat.advance(self.air_deg_c(), time_s) {
            (self.drivetrain).set_winding_resistance_ohm(resistance_ohm);
        }
        self.drivetrain.settle();
        self.drivetrain.set_supply_v(self.supply.volts());
        self.drivetrain.set_jammed(self.defects.is_jammed);
        self.drivetrain
            .set_recorded_torque_nm(self.defects.torque_nm);
        (self.drawn_a, self.return_peak_a) = (0.0, 0.0);
    }

    /// Runs with the switches in this state; `drawn_a` accumulates charge meanwhile. Returns the
    /// mean current of the winding, A.
    fn run(&mut self, switched: Switched, time_s: f64) -> f64 {
        let connection = switched.connection(self.drivetrain.reading().current_a);
        self.connection = connection;
        let peak_a = self.return_a(connection);
        let start_a = self.drivetrain.reading().current_a;
        let mean_a = self.drivetrain.advance(self.terminal(connection), time_s);
        let currents = (start_a, self.drivetrain.reading().current_a, mean_a);
        let constant_s = self.drivetrain.winding_time_constant_s();
        self.heat.take(currents, constant_s, time_s);
        let drawn_a = match connection {
            Connection::Supply(sign) => sign * mean_a + self.short_a(),
            // The diodes return the winding's energy.
            Connection::Open => -mean_a.abs(),
            Connection::Shorted => 0.0,
        };
        self.drawn_a += drawn_a * time_s;
        let end_a = self.return_a(connection);
        self.return_peak_a = self.return_peak_a.max(peak_a).max(end_a);
        mean_a
    }

    /// The terminal voltage of the winding.
    fn terminal(&self, connection: Connection) -> Terminal {
        let is_shorted = self.defects.motor_short_ohm.is_some();
        match connection {
            _ if self.defects.is_motor_open => Terminal::Coast,
            // The short brakes the motor where the bridge does not drive it.
            Connection::Open if is_shorted => Terminal::Brake,
            Connection::Open => Terminal::Coast,
            Connection::Shorted => Terminal::Brake,
            Connection::Supply(sign) => Terminal::Driven(sign * self.supply.volts()),
        }
    }

    /// Current of a short across the motor while the supply is at it, A.
    fn short_a(&self) -> f64 {
        self.defects
            .motor_short_ohm
            .map_or(0.0, |ohm| self.supply.volts() / ohm.max(1e-3))
    }

    /// Current through the return of the bridge, A; none circulates there in the off time.
    fn return_a(&self, connection: Connection) -> f64 {
        match connection {
            Connection::Supply(sign) => {
                (sign * self.drivetrain.reading().current_a + self.short_a()).abs()
            }
            Connection::Open | Connection::Shorted => 0.0,
        }
    }

    /// Current through the shunt in the motor's line, A.
    fn current_a(&self) -> f64 {
        let winding_a = self.drivetrain.reading().current_a;
        match self.connection {
            // It circulates behind the shunt.
            Connection::Open if self.defects.motor_short_ohm.is_some() => 0.0,
            Connection::Supply(sign) => winding_a + sign * self.short_a(),
            Connection::Open | Connection::Shorted => winding_a,
        }
    }

    /// Back-EMF at the motor's terminals, V.
    fn back_emf_v(&self) -> f64 {
        if self.defects.is_motor_open || self.defects.motor_short_ohm.is_some() {
            return 0.0;
        }
        self.drivetrain.reading().back_emf_v
    }

    fn sample_current(&mut self) {
        let (current_a, supply_v) = (self.current_a(), self.supply.after(self.drawn_a));
        let shown_a = current_a * (1.0 - self.defects.current_loss_pct / 100.0);
        self.sensed.current = self.front_ends.current(shown_a);
        self.sensed.supply = self.front_ends.supply(supply_v);
        if let Some(code) = self.defects.stuck_current {
            self.sensed.current = code;
        }
        self.show_driven_legs(supply_v);
    }

    /// While the motor is driven one leg is at the supply and the other at ground: what a scan of
    /// the legs in the on time reads, without errors. The control step does not take one; what
    /// [`Slot::Legs`] samples is what it scans.
    fn show_driven_legs(&mut self, supply_v: f64) {
        let (high, low) = (leg_code(supply_v), leg_code(0.0));
        self.sensed.legs = match self.connection {
            Connection::Supply(sign) if sign > 0.0 => Legs { a: high, b: low },
            Connection::Supply(_) => Legs { a: low, b: high },
            Connection::Open | Connection::Shorted => return,
        };
    }

    fn sample_legs(&mut self) {
        let temperature_deg_c = self.air_deg_c();
        let legs_v = self
            .legs
            .at_sample(self.connection, self.supply.volts(), self.back_emf_v());
        self.sensed.legs = self.front_ends.legs(legs_v);
        if let Some(code) = self.defects.stuck_leg {
            self.sensed.legs.a = code;
        }
        self.sensed.temperature = temperature_code(temperature_deg_c);
    }

    fn sample_encoder(&mut self) {
        let shaft = self.drivetrain.reading().output;
        let seen_deg = shaft.angle_deg - shaft.rate_deg_s * ENCODER_DELAY_S;
        self.sensed.encoder = self.encoder.word(seen_deg, &self.defects);
    }

    /// The last samples: what a transfer from the encoder and the conversions read until the next.
    pub fn sensed(&self) -> Sensed {
        self.sensed
    }

    /// Everything that can be read off the drivetrain.
    pub fn reading(&self) -> Reading {
        self.drivetrain.reading()
    }

    /// Current through the shunt in the motor's line, A.
    pub fn motor_current_a(&self) -> f64 {
        self.current_a()
    }

    /// Largest current through the bridge's return in the last slot, A: what the comparator of the
    /// over-current trip sees.
    pub fn return_peak_a(&self) -> f64 {
        self.return_peak_a
    }

    /// Temperature of the winding, deg C.
    pub fn winding_deg_c(&self) -> f64 {
        self.heat.winding_deg_c()
    }

    /// Copper loss since the start, J, but for that of the last slot.
    pub fn copper_loss_j(&self) -> f64 {
        self.heat.copper_j()
    }

    /// Temperature of the board and of the air around the motor, deg C.
    fn air_deg_c(&self) -> f64 {
        let ambient_deg_c = self.front_ends.ambient_deg_c;
        self.defects.temperature_deg_c.unwrap_or(ambient_deg_c)
    }

    /// Voltage of the supply at the board, V.
    pub fn supply_v(&self) -> f64 {
        self.supply.volts()
    }
}
