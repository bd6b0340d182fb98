//! The peripherals of the STM32H743 on the actuator board.

pub mod analog;
pub mod backup;
pub mod can_port;
pub mod crc_unit;
pub mod encoder;
pub mod flash;
mod message_ram;
pub mod servo_line;
pub mod timing;
pub mod updater;
pub mod wiring;

use drivers::{bridge::HBridge, encoder::As5045};

pub use self::can_port::Acceptance;
use self::encoder::SpiTransfer;
use crate::actuator::{encoder_select::SelectPin, pwm_timer::BridgeTimer};

/// The bridge of the actuator board.
pub type ActuatorBridge = HBridge<BridgeTimer>;

/// The encoder of the actuator board.
pub type Encoder = As5045<SpiTransfer, SelectPin>;

/// The CAN controller of the actuator board.
pub type Can = can_port::Can1;
