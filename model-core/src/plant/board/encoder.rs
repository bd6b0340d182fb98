//! The encoder with its three wires.

use crate::control::encoder_word::{EncoderCount, EncoderWord, Magnet};
use crate::parameter::ParameterError;
use crate::sensors::encoder::{Encoder, EncoderParameters};
use crate::sensors::noise::Noise;

use super::Defects;

/// A wire of the encoder.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum EncoderWire {
    /// Data out.
    Data,
    /// Clock.
    Clock,
    /// Chip select.
    Select,
}

/// The level of a broken wire.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Stuck {
    /// Ground.
    Low,
    /// The supply, or a pull-up.
    High,
}

/// What a controller that clocks 24 times reads of the encoder's 18 bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct SsiWord(u32);

impl SsiWord {
    /// Clocks of a transfer: three bytes.
    pub const CLOCKS: u32 = 24;

    /// The data line is high from the select on, and stays so at the first falling edge of the
    /// clock; each rising edge after it shifts a bit out, and after the last of 18 the line is low.
    fn of(word: EncoderWord) -> Self {
        Self(1 << 23 | word.bits() << 5)
    }

    /// 24 bits, the first of them the most significant.
    pub fn bits(self) -> u32 {
        self.0
    }

    /// The encoder's word in it.
    pub fn word(self) -> EncoderWord {
        EncoderWord::new(self.0 >> 5)
    }
}

/// Age of the angle that a word has, s: AS5045 data sheet, propagation delay in slow mode.
pub const ENCODER_DELAY_S: f64 = 384e-6;

#[derive(Debug, Clone)]
pub(super) struct EncoderOutput {
    chip: Encoder,
    own_magnet: Magnet,
    last: EncoderCount,
    /// The angle of the magnet, deg, and that from which on the scale is wrong.
    magnet_deg: f64,
    scaled_from_deg: f64,
}

impl EncoderOutput {
    pub fn try_new(parameters: EncoderParameters, noise: Noise) -> Result<Self, ParameterError> {
        parameters.check()?;
        let chip = Encoder::new(parameters, noise);
        Ok(Self {
            own_magnet: chip.magnet,
            chip,
            last: EncoderCount::new(0),
            magnet_deg: 0.0,
            scaled_from_deg: 0.0,
        })
    }

    /// What is read of it at this angle of the shaft.
    pub fn word(&mut self, shaft_deg: f64, defects: &Defects) -> SsiWord {
        // The shaft takes the magnet along at either end of its play.
        let half_deg = defects.encoder_play_deg / 2.0;
        let (least, most) = (shaft_deg - half_deg, shaft_deg + half_deg);
        self.magnet_deg = crate::plant::within(self.magnet_deg, least, most);
        if defects.encoder_loss_pct == 0.0 {
            self.scaled_from_deg = self.magnet_deg;
        }
        let scaled_deg = self.magnet_deg - self.scaled_from_deg;
        let lost_deg = scaled_deg * (defects.encoder_loss_pct / 100.0);
        let count = (self.chip).count(self.magnet_deg - lost_deg + defects.magnet_slip_deg);
        if !defects.is_encoder_frozen {
            self.last = count;
        }
        let magnet = defects.magnet.unwrap_or(self.own_magnet);
        let word = EncoderWord::of(self.last, magnet);
        let flipped = EncoderWord::new(word.bits() ^ defects.encoder_flipped);
        broken(SsiWord::of(flipped), defects)
    }
}

/// What a broken wire leaves of it.
fn broken(whole: SsiWord, defects: &Defects) -> SsiWord {
    const ALL: u32 = (1 << SsiWord::CLOCKS) - 1;
    match defects.encoder_wire {
        None => whole,
        Some((EncoderWire::Data, Stuck::Low)) => SsiWord(0),
        Some((EncoderWire::Data, Stuck::High)) => SsiWord(ALL),
        // Selected or not, without a clock the line keeps its first level.
        Some((EncoderWire::Clock, _)) => SsiWord(ALL),
        // Never selected: the pull-up holds the line, which has no driver.
        Some((EncoderWire::Select, Stuck::High)) => SsiWord(ALL),
        // Always selected: the next transfer goes on behind the 18 bits of the first.
        Some((EncoderWire::Select, Stuck::Low)) => SsiWord(0),
    }
}
