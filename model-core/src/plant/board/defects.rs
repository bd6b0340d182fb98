//! What can break on the plant.

use crate::control::encoder_word::Magnet;
use crate::sensors::adc::AdcCode;

use super::encoder::{EncoderWire, Stuck};

/// Everything that is broken.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Defects {
    /// A wire of the encoder that lies at one level.
    pub encoder_wire: Option<(EncoderWire, Stuck)>,
    /// Bits of the encoder's word that are inverted on their way.
    pub encoder_flipped: u32,
    /// What the encoder's magnet does; none is its own state.
    pub magnet: Option<Magnet>,
    /// The encoder repeats its last count.
    pub is_encoder_frozen: bool,
    /// The magnet has slipped on the shaft by this angle, deg.
    pub magnet_slip_deg: f64,
    /// The encoder shows this much of the shaft's travel less, %: an eccentric or loose magnet.
    pub encoder_loss_pct: f64,
    /// Play between the shaft and the magnet, deg.
    pub encoder_play_deg: f64,
    /// A resistance across the motor, ohm.
    pub motor_short_ohm: Option<f64>,
    /// A wire of the motor is off.
    pub is_motor_open: bool,
    /// The gear train is stuck.
    pub is_jammed: bool,
    /// Torque from outside, Nm.
    pub torque_nm: f64,
    /// The source's voltage, V.
    pub source_v: Option<f64>,
    /// The source's resistance, ohm.
    pub source_ohm: Option<f64>,
    /// Temperature of the board, deg C.
    pub temperature_deg_c: Option<f64>,
    /// The current sense has this much of its gain less, %.
    pub current_loss_pct: f64,
    /// The current sense gives this code.
    pub stuck_current: Option<AdcCode>,
    /// The divider of leg A gives this code: 0 where its upper resistor is open.
    pub stuck_leg: Option<AdcCode>,
}
