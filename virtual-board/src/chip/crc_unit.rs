//! The CRC calculation unit (RM0090, chapter 4).
//!
//! It divides by 0x04C11DB7, most significant bit first, from an initial value of 0xFFFFFFFF. Not
//! modelled: that a write while a word is processed waits for its four cycles.

use rigless::device::{Device, DeviceContext, RegisterFile};
use rigless::soc::stm32f427::generated::crc::Register as R;

/// The polynomial without its highest term (section 4.2).
const POLYNOMIAL: u32 = 0x04c1_1db7;
const INITIAL: u32 = 0xffff_ffff;
/// Bit of CR (section 4.4.3).
const RESET: u64 = 1;

/// Remainders of all bytes at the most significant place.
static REMAINDERS: [u32; 256] = {
    let mut remainders = [0; 256];
    let mut byte = 0;
    while byte < 256 {
        remainders[byte] = shifted((byte as u32) << 24, 8);
        byte += 1;
    }
    remainders
};

const fn shifted(mut remainder: u32, bits: u32) -> u32 {
    let mut bit = 0;
    while bit < bits {
        let is_set = remainder >> 31 == 1;
        remainder = (remainder << 1) ^ if is_set { POLYNOMIAL } else { 0 };
        bit += 1;
    }
    remainder
}

/// The unit.
#[derive(Debug)]
pub struct CrcUnit(u32);

impl Default for CrcUnit {
    fn default() -> Self {
        Self(INITIAL)
    }
}

impl CrcUnit {
    fn update(&mut self, word: u32) {
        self.0 = word.to_be_bytes().iter().fold(self.0, |crc, byte| {
            (crc << 8) ^ REMAINDERS[usize::from((crc >> 24) as u8 ^ byte)]
        });
    }
}

impl Device for CrcUnit {
    type Register = R;

    fn write(
        &mut self,
        register: R,
        value: u64,
        registers: &mut RegisterFile,
        _: &mut DeviceContext<'_>,
    ) {
        match register {
            R::Dr => self.update(value as u32),
            R::Cr if value & RESET != 0 => self.0 = INITIAL,
            R::Cr | R::Idr => {}
        }
        registers.set(R::Dr, u64::from(self.0));
    }

    fn reset(&mut self) {
        *self = Self::default();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    // CRC-32/MPEG-2 has the parameters of the unit. Its published check value is that of the nine
    // bytes "123456789"; the unit takes words, so the last byte continues the division here.
    #[test]
    fn the_unit_computes_crc_32_mpeg_2() {
        let mut unit = CrcUnit::default();
        for word in b"12345678".as_chunks::<4>().0 {
            unit.update(u32::from_be_bytes(*word));
        }
        let with_nine = (unit.0 << 8) ^ REMAINDERS[usize::from((unit.0 >> 24) as u8 ^ b'9')];
        assert_eq!(with_nine, 0x0376_e6e7);
    }
}
