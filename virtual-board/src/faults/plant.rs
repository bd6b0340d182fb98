//! Applies faults to the plant.

use model_core::sensors::adc::AdcCode;

use super::Fault;
use crate::plant::Defects;

impl Fault {
    /// Begins or ends the fault if it is one of the plant; returns whether it is one.
    pub fn apply_to(&self, defects: &mut Defects, begins: bool) -> bool {
        let number = |value: f64| if begins { value } else { 0.0 };
        match *self {
            Fault::EncoderWire { line, stuck } => {
                defects.encoder_wire = begins.then_some((line, stuck));
            }
            Fault::EncoderBits { mask } => defects.encoder_flipped = if begins { mask } else { 0 },
            Fault::Magnet { state } => defects.magnet = begins.then_some(state.into()),
            Fault::EncoderFrozen => defects.is_encoder_frozen = begins,
            Fault::MagnetSlips { deg } => defects.magnet_slip_deg = number(deg),
            Fault::EncoderScale { percent } => defects.encoder_loss_pct = number(-percent),
            Fault::EncoderPlay { deg } => defects.encoder_play_deg = number(deg),
            Fault::CurrentGain { percent } => defects.current_loss_pct = number(-percent),
            Fault::MotorShort { ohm } => defects.motor_short_ohm = begins.then_some(ohm),
            Fault::MotorOpen => defects.is_motor_open = begins,
            Fault::Jam => defects.is_jammed = begins,
            Fault::Torque { nm } => defects.torque_nm = number(nm),
            Fault::Supply { volts } => defects.source_v = begins.then_some(volts),
            Fault::Source { ohm } => defects.source_ohm = begins.then_some(ohm),
            Fault::Temperature { deg_c } => defects.temperature_deg_c = begins.then_some(deg_c),
            Fault::CurrentSense { code } => {
                defects.stuck_current = begins.then_some(AdcCode::new(code));
            }
            Fault::LegSense { code } => defects.stuck_leg = begins.then_some(AdcCode::new(code)),
            _ => return false,
        }
        true
    }
}
