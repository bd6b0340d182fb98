//! What can break.

use model_core::control::encoder_word::Magnet;
use serde::Deserialize;

use crate::can::WireFault;
use crate::plant::{EncoderWire, Stuck};

/// A fault.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Fault {
    /// A wire of the encoder lies at one level.
    EncoderWire {
        /// Which.
        line: EncoderWire,
        /// At which.
        stuck: Stuck,
    },
    /// Bits of the encoder's word are inverted: bit 17 is D11, bit 0 the parity.
    EncoderBits {
        /// The bits.
        mask: u32,
    },
    /// The encoder's magnet leaves its place.
    Magnet {
        /// What the encoder says of it.
        state: MagnetState,
    },
    /// The encoder repeats its last angle.
    EncoderFrozen,
    /// The magnet slips on the shaft.
    MagnetSlips {
        /// By this angle.
        deg: f64,
    },
    /// A resistance across the motor.
    MotorShort {
        /// Ohm.
        ohm: f64,
    },
    /// A wire of the motor is off.
    MotorOpen,
    /// The gear train is stuck.
    Jam,
    /// Somebody pulls at the surface.
    Torque {
        /// Positive towards positive angles.
        nm: f64,
    },
    /// The source has another voltage.
    Supply {
        /// V.
        volts: f64,
    },
    /// The source has another resistance: it sags under the current.
    Source {
        /// Ohm.
        ohm: f64,
    },
    /// The board is as hot as this.
    Temperature {
        /// deg C.
        deg_c: f64,
    },
    /// The current sense gives one code, 0 to 4095.
    CurrentSense {
        /// The code.
        code: u16,
    },
    /// The hardware over-current comparator trips, whatever the current.
    BridgeTrip,
    /// The supply of the board is gone, RAM with it.
    PowerLoss,
    /// The supply is cut within an operation of the flash.
    FlashCut {
        /// Which, from 0 and counted from the trigger on.
        operation: u64,
        /// How much of its time is over, thousandths.
        permille: u64,
    },
    /// The reset pin is pulled.
    ResetPin,
    /// A bit of RAM flips, once.
    FlipRam {
        /// Where.
        #[serde(flatten)]
        place: Place,
        /// Bit of the byte there and those after it.
        bit: u32,
    },
    /// The core executes nothing, while all around it goes on.
    StallCore,
    /// The wire of the CAN bus.
    Can {
        /// What is wrong with it.
        wire: WireFault,
    },
    /// Frames on the bus meet disturbances.
    CanNoise {
        /// How many.
        frames: u32,
    },
    /// The servo input sees no pulses, or others than it was given.
    ServoPulse {
        /// Their length; none where it is left out.
        us: Option<f64>,
    },
}

/// A place in memory.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Place {
    /// An address.
    Address(u64),
    /// A symbol of the ELF file.
    Symbol(String),
}

/// What the encoder says of its magnet.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MagnetState {
    /// It comes nearer.
    Approaching,
    /// It moves away.
    Receding,
    /// It is too far or too near, the angle still serves.
    Marginal,
    /// It is gone.
    Lost,
}

impl From<MagnetState> for Magnet {
    fn from(state: MagnetState) -> Self {
        match state {
            MagnetState::Approaching => Self::Approaching,
            MagnetState::Receding => Self::Receding,
            MagnetState::Marginal => Self::Marginal,
            MagnetState::Lost => Self::Lost,
        }
    }
}

impl Fault {
    /// The number in it that has to be within a range, with its name and ends.
    pub(super) fn bounds(&self) -> Option<(&'static str, f64, f64, f64)> {
        match self {
            Self::MagnetSlips { deg } => Some(("deg", *deg, -360.0, 360.0)),
            Self::MotorShort { ohm } => Some(("ohm", *ohm, 0.0, 1e6)),
            Self::Torque { nm } => Some(("nm", *nm, -100.0, 100.0)),
            Self::Supply { volts } => Some(("volts", *volts, 0.0, 60.0)),
            Self::Source { ohm } => Some(("ohm", *ohm, 0.0, 1000.0)),
            Self::Temperature { deg_c } => Some(("deg_c", *deg_c, -273.0, 1000.0)),
            Self::CurrentSense { code } => Some(("code", f64::from(*code), 0.0, 4095.0)),
            Self::FlashCut { permille, .. } => Some(("permille", *permille as f64, 0.0, 999.0)),
            Self::FlipRam { bit, .. } => Some(("bit", f64::from(*bit), 0.0, 31.0)),
            Self::ServoPulse { us: Some(us) } => Some(("us", *us, 1.0, 19_000.0)),
            Self::EncoderBits { mask } => Some(("mask", f64::from(*mask), 1.0, 262_143.0)),
            _ => None,
        }
    }
}
