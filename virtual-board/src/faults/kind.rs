//! Kinds of faults.

use model_core::control::encoder_word::Magnet;
use serde::Deserialize;

use crate::can::WireFault;
use crate::plant::{EncoderWire, Stuck};

/// A fault.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Fault {
    /// A wire of the encoder is stuck at one level.
    EncoderWire {
        /// The wire.
        line: EncoderWire,
        /// The level.
        stuck: Stuck,
    },
    /// Bits of the encoder's word are inverted: bit 17 is D11, bit 0 the parity.
    EncoderBits {
        /// The bits.
        mask: u32,
    },
    /// The feedback of the encoder's clock is late: the last bit of each byte keeps that of the
    /// byte before.
    EncoderClockLate,
    /// The magnet of the encoder is displaced.
    Magnet {
        /// State that the encoder reports.
        state: MagnetState,
    },
    /// The encoder repeats its last angle.
    EncoderFrozen,
    /// The magnet slips on the shaft.
    MagnetSlips {
        /// By this angle.
        deg: f64,
    },
    /// The encoder shows less of the shaft's travel, or more: an eccentric or loose magnet.
    EncoderScale {
        /// By this much, %.
        percent: f64,
    },
    /// Play between the shaft and the magnet.
    EncoderPlay {
        /// Of this angle.
        deg: f64,
    },
    /// A resistance across the motor.
    MotorShort {
        /// Ohm.
        ohm: f64,
    },
    /// A wire of the motor is off.
    MotorOpen,
    /// The gear train is jammed.
    Jam,
    /// External torque at the surface.
    Torque {
        /// Positive towards positive angles.
        nm: f64,
    },
    /// The source has another voltage.
    Supply {
        /// V.
        volts: f64,
    },
    /// The source has another resistance, and its voltage drops under load.
    Source {
        /// Ohm.
        ohm: f64,
    },
    /// Temperature of the board.
    Temperature {
        /// deg C.
        deg_c: f64,
    },
    /// The current sense returns one code, 0 to 4095.
    CurrentSense {
        /// The code.
        code: u16,
    },
    /// The divider of leg A returns one code, 0 to 4095: 0 where it is open.
    LegSense {
        /// The code.
        code: u16,
    },
    /// The current sense has another gain.
    CurrentGain {
        /// More by this much, %.
        percent: f64,
    },
    /// The over-current comparator trips, independently of the current.
    BridgeTrip,
    /// The board loses its supply and its RAM contents.
    PowerLoss,
    /// The supply is cut during a flash operation.
    FlashCut {
        /// Number of the operation after the trigger, from 0.
        operation: u64,
        /// Elapsed share of its duration, thousandths.
        permille: u64,
    },
    /// The reset pin is pulled low.
    ResetPin,
    /// A bit of RAM flips, once.
    FlipRam {
        /// Location of the byte.
        #[serde(flatten)]
        place: MemoryLocation,
        /// Bit number, counted from bit 0 of the byte at this location.
        bit: u32,
    },
    /// A bit of the flash flips, and remains so.
    FlipFlash {
        /// Location of the byte.
        #[serde(flatten)]
        place: MemoryLocation,
        /// Bit number, counted from bit 0 of the byte at this location.
        bit: u32,
    },
    /// A bit of the acceptance filter of the CAN controller flips, once.
    AcceptanceFilter(FilterBit),
    /// The core stops executing while the peripherals continue.
    StallCore,
    /// The independent watchdog does not reset the processor.
    WatchdogDead,
    /// Fault of the CAN bus line.
    Can {
        /// The fault.
        wire: WireFault,
    },
    /// Disturbances destroy frames on the bus.
    CanNoise {
        /// Number of frames.
        frames: u32,
    },
    /// The servo input receives no pulses, or pulses of another width.
    ServoPulse {
        /// Pulse width; without it no pulses.
        us: Option<f64>,
    },
}

/// A bit of the acceptance filter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FilterBit {
    /// A bit of the words with the identifiers, counted from bit 0 of the first word: the first 28
    /// filter registers of bxCAN, `CAN_F0R1` to `CAN_F13R2`, or of the filters in the message RAM
    /// of FDCAN.
    Identifiers(u32),
    /// The activation bit of a bank of bxCAN (`CAN_FA1R`), or the lowest bit of the configuration
    /// of an element of the standard filters of FDCAN, which turns it off.
    Activation(u32),
}

/// A location in memory.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MemoryLocation {
    /// An address.
    Address(u64),
    /// A symbol of the ELF file.
    Symbol(String),
}

/// State of the magnet that the encoder reports.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MagnetState {
    /// The distance decreases.
    Approaching,
    /// The distance increases.
    Receding,
    /// Too far or too near; the angle is still usable.
    Marginal,
    /// No magnet: the angle is not usable.
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
    /// Its limited number, with name, minimum and maximum.
    pub(super) fn bounds(&self) -> Option<(&'static str, f64, f64, f64)> {
        match self {
            Self::MagnetSlips { deg } => Some(("deg", *deg, -360.0, 360.0)),
            Self::EncoderScale { percent } | Self::CurrentGain { percent } => {
                Some(("percent", *percent, -100.0, 1000.0))
            }
            Self::EncoderPlay { deg } => Some(("deg", *deg, 0.0, 360.0)),
            Self::MotorShort { ohm } => Some(("ohm", *ohm, 0.0, 1e6)),
            Self::Torque { nm } => Some(("nm", *nm, -100.0, 100.0)),
            Self::Supply { volts } => Some(("volts", *volts, 0.0, 60.0)),
            Self::Source { ohm } => Some(("ohm", *ohm, 0.0, 1000.0)),
            Self::Temperature { deg_c } => Some(("deg_c", *deg_c, -273.0, 1000.0)),
            Self::CurrentSense { code } | Self::LegSense { code } => {
                Some(("code", f64::from(*code), 0.0, 4095.0))
            }
            Self::FlashCut { permille, .. } => Some(("permille", *permille as f64, 0.0, 999.0)),
            Self::FlipRam { bit, .. } | Self::FlipFlash { bit, .. } => {
                Some(("bit", f64::from(*bit), 0.0, 31.0))
            }
            Self::AcceptanceFilter(FilterBit::Identifiers(bit)) => {
                Some(("identifiers", f64::from(*bit), 0.0, 895.0))
            }
            Self::AcceptanceFilter(FilterBit::Activation(number)) => {
                Some(("activation", f64::from(*number), 0.0, 13.0))
            }
            Self::ServoPulse { us: Some(us) } => Some(("us", *us, 1.0, 19_000.0)),
            Self::EncoderBits { mask } => Some(("mask", f64::from(*mask), 1.0, 262_143.0)),
            _ => None,
        }
    }
}
