//! A motor with its gears, bridge, encoder and heat.

use model_core::parameter::ParameterError;
use model_core::plant::drivetrain::{Drivetrain, electrical::Terminal, load::LoadParameters};
use servo_bus::{MIDDLE, TURN};

use super::Model;

/// Time of a period, s.
pub const PERIOD_S: f64 = super::PERIOD_US as f64 / 1e6;

/// Temperature of the room, degC.
const ROOM_C: f64 = 25.0;

/// Heating by the losses of the winding, and its time constant: assumptions for a servo of 20 g to
/// 90 g, with which half the stall current heats it to its limit in minutes.
const HEATING_K_W: f64 = 8.0;
const HEAT_S: f64 = 300.0;

/// Turns of the drivetrain after which its angle begins again, below its stops.
const WRAPPED_TURNS: f64 = 40.0;

/// What the bridge does in a period.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Drive {
    /// All switches open.
    Free,
    /// Both terminals at one level.
    Brake,
    /// A share of the supply.
    Duty(f64),
    /// A current, A, as far as the supply and this duty reach.
    Current(f64, f64),
}

/// What the servo measures.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Sensed {
    /// Position of the shaft in steps, over all turns.
    pub position: i32,
    /// Rate of the shaft, steps/s.
    pub rate: f64,
    /// Current of the winding, A.
    pub current_a: f64,
    /// Supply, V.
    pub supply_v: f64,
    /// Of the winding, degC.
    pub temperature_c: f64,
    /// Duty of the bridge, from -1 to 1.
    pub duty: f64,
}

/// The physical part of a servo.
#[derive(Debug)]
pub struct Motor {
    drivetrain: Drivetrain,
    resistance_ohm: f64,
    /// Turns that the drivetrain's angle lacks.
    turns: f64,
    temperature_c: f64,
    sensed: Sensed,
}

impl Motor {
    /// At rest in the middle of a turn, which is angle zero of the load.
    ///
    /// # Errors
    /// For parameters of the model or the load out of range.
    pub fn new(model: &Model, load: LoadParameters) -> Result<Self, ParameterError> {
        let drivetrain = Drivetrain::try_new(&model.drivetrain(load))?;
        let mut motor = Self {
            drivetrain,
            resistance_ohm: model.resistance_ohm,
            turns: 0.0,
            temperature_c: ROOM_C,
            sensed: Sensed::default(),
        };
        motor.sense(model.supply_v, 0.0);
        Ok(motor)
    }

    /// What was measured at the end of the last period.
    pub fn sensed(&self) -> &Sensed {
        &self.sensed
    }

    /// The supply, 0.1 V, and the temperature, degC.
    pub fn supply_and_temperature(&self) -> (i32, i32) {
        let Sensed {
            supply_v,
            temperature_c,
            ..
        } = self.sensed;
        (
            (supply_v * 10.0).round() as i32,
            temperature_c.round() as i32,
        )
    }

    /// A torque on the output shaft until the next call, Nm.
    pub fn set_load_nm(&mut self, torque_nm: f64) {
        self.drivetrain.set_recorded_torque_nm(torque_nm);
    }

    /// Jams or frees the gears.
    pub fn set_jammed(&mut self, is_jammed: bool) {
        self.drivetrain.set_jammed(is_jammed);
    }

    /// A period with this supply.
    pub fn advance(&mut self, drive: Drive, supply_v: f64) {
        self.drivetrain.set_supply_v(supply_v);
        let back_emf_v = self.drivetrain.reading().back_emf_v;
        let duty = match drive {
            Drive::Free | Drive::Brake => 0.0,
            Drive::Duty(duty) => duty.clamp(-1.0, 1.0),
            Drive::Current(..) if supply_v <= 0.0 => 0.0,
            Drive::Current(current_a, most) => {
                let wanted_v = current_a * self.resistance_ohm + back_emf_v;
                (wanted_v / supply_v).clamp(-most, most)
            }
        };
        let terminal = match drive {
            Drive::Free => Terminal::Coast,
            Drive::Brake => Terminal::Brake,
            Drive::Duty(_) | Drive::Current(..) => Terminal::Driven(duty * supply_v),
        };
        let mean_a = self.drivetrain.advance(terminal, PERIOD_S);
        let heat_k = mean_a * mean_a * self.resistance_ohm * HEATING_K_W;
        self.temperature_c += (ROOM_C + heat_k - self.temperature_c) * (PERIOD_S / HEAT_S);
        self.sense(supply_v, duty);
    }

    fn sense(&mut self, supply_v: f64, duty: f64) {
        let reading = self.drivetrain.reading();
        let steps = |deg: f64| deg * (f64::from(TURN) / 360.0);
        let position = self.turns * f64::from(TURN) + steps(reading.output.angle_deg);
        self.sensed = Sensed {
            // 2^31 steps are days at the greatest rate.
            position: (position.floor() as i32).wrapping_add(MIDDLE),
            rate: steps(reading.output.rate_deg_s),
            current_a: reading.current_a,
            supply_v,
            temperature_c: self.temperature_c,
            duty,
        };
        if reading.output.angle_deg.abs() > WRAPPED_TURNS * 360.0 {
            self.turns += (reading.output.angle_deg / 360.0).trunc();
            // The flanks of the gears meet again within their backlash.
            self.drivetrain.place(reading.output.angle_deg % 360.0);
        }
    }
}
