//! The word of the AS5045 magnetic encoder.
//!
//! 18 bits, most significant first: D11..D0, OCF, COF, LIN, MagINC, MagDEC, even parity (AS5045
//! data sheet, section 8.1, tables 3 to 5). The data are valid where OCF is set, COF and LIN are
//! clear, and the parity is even. A line stuck at either level is never valid.

use core::hint::cold_path;

/// Counts in one turn: 12 bits.
pub const COUNTS_PER_TURN: i32 = 4096;

/// Angle of one count, deg. The paper prints 0.0875, the part has 12 bits.
pub const COUNT_DEG: f64 = 360.0 / COUNTS_PER_TURN as f64;

/// Offset compensation finished.
const OCF: u32 = 1 << 5;
/// CORDIC overflow.
const COF: u32 = 1 << 4;
/// Linearity alarm.
const LIN: u32 = 1 << 3;
/// Magnitude of the field rising: the magnet comes nearer.
const MAG_INC: u32 = 1 << 2;
/// Magnitude of the field falling: the magnet moves away.
const MAG_DEC: u32 = 1 << 1;

/// An absolute angle in counts, 0 to 4095.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct EncoderCount(u16);

impl EncoderCount {
    /// The count, less whole turns.
    ///
    /// ```
    /// use model_core::control::encoder_word::EncoderCount;
    /// assert_eq!(EncoderCount::new(4097).get(), 1);
    /// ```
    pub const fn new(count: u16) -> Self {
        Self(count & 0xfff)
    }

    /// 0 to 4095.
    pub const fn get(self) -> u16 {
        self.0
    }
}

/// What the encoder says of its magnet (data sheet, table 4).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Magnet {
    /// The field is strong enough and steady.
    #[default]
    Steady,
    /// The magnet comes nearer.
    Approaching,
    /// The magnet moves away.
    Receding,
    /// The field is out of the recommended range; the angle still serves, with less accuracy.
    Marginal,
    /// The field is far out of range. No valid reading says so.
    Lost,
}

impl Magnet {
    const fn bits(self) -> u32 {
        match self {
            Self::Steady => 0,
            Self::Approaching => MAG_INC,
            Self::Receding => MAG_DEC,
            Self::Marginal => MAG_INC | MAG_DEC,
            Self::Lost => LIN | MAG_INC | MAG_DEC,
        }
    }
}

/// What a valid word says of the magnet, by its bits MagINC and MagDEC.
const VALID: [Magnet; 4] = [
    Magnet::Steady,
    Magnet::Receding,
    Magnet::Approaching,
    Magnet::Marginal,
];

/// Why a word is not an angle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EncoderError {
    /// The parity is odd: a bit was lost on the line.
    Parity,
    /// The offset compensation has not finished: just powered, or a line stuck low.
    NotReady,
    /// The CORDIC overflowed: the magnet is missing or far off, or a line stuck high.
    CordicOverflow,
    /// The linearity alarm: the magnet is out of its place.
    Linearity,
}

/// A valid reading.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct EncoderReading {
    /// The angle.
    pub count: EncoderCount,
    /// The state of the magnet.
    pub magnet: Magnet,
}

/// The 18 bits as they come over the wire, right-aligned.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct EncoderWord(u32);

impl EncoderWord {
    /// The low 18 bits of `bits`.
    ///
    /// ```
    /// use model_core::control::encoder_word::{EncoderCount, EncoderWord};
    /// let reading = EncoderWord::new(0b0000_0000_0001_1000_00).read().unwrap();
    /// assert_eq!(reading.count, EncoderCount::new(1));
    /// ```
    pub const fn new(bits: u32) -> Self {
        Self(bits & 0x3_ffff)
    }

    /// The word of a working encoder at this count.
    ///
    /// ```
    /// use model_core::control::encoder_word::{EncoderCount, EncoderWord, Magnet};
    /// let word = EncoderWord::of(EncoderCount::new(0xfff), Magnet::Steady);
    /// assert_eq!(word.bits(), 0b1111_1111_1111_10_000_1);
    /// ```
    pub const fn of(count: EncoderCount, magnet: Magnet) -> Self {
        let bits = (count.get() as u32) << 6 | OCF | magnet.bits();
        Self(bits | bits.count_ones() & 1)
    }

    /// The 18 bits.
    pub const fn bits(self) -> u32 {
        self.0
    }

    /// The angle, if the word is valid.
    ///
    /// # Errors
    /// The first of [`EncoderError`]'s reasons that applies.
    #[inline(always)]
    pub const fn read(self) -> Result<EncoderReading, EncoderError> {
        let bits = self.0;
        if bits.count_ones() & 1 != 0 {
            return Err(EncoderError::Parity);
        }
        if bits & (OCF | COF | LIN) != OCF {
            cold_path();
            return Err(if bits & OCF == 0 {
                EncoderError::NotReady
            } else if bits & COF != 0 {
                EncoderError::CordicOverflow
            } else {
                EncoderError::Linearity
            });
        }
        Ok(EncoderReading {
            count: EncoderCount::new((bits >> 6) as u16),
            magnet: VALID[(bits >> 1 & 3) as usize],
        })
    }
}
