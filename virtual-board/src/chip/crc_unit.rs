//! The CRC calculation unit (RM0090, chapter 4).
//!
//! It divides by 0x04C11DB7, most significant bit first, from an initial value of 0xFFFFFFFF. Not
//! modelled: that a write while a word is processed waits for its four cycles.

use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

use rigless::device::{Device, DeviceContext, RegisterFile};
use rigless::soc::stm32f427::generated::crc::Register as R;
use rigless::time::VirtualNanos;

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

/// The remainder in the unit, which the bus of the core updates too
/// (`virtual-board/src/board/crc_bus.rs`).
#[derive(Debug, Clone)]
pub struct Remainder(Arc<AtomicU32>);

impl Default for Remainder {
    fn default() -> Self {
        Self(Arc::new(AtomicU32::new(INITIAL)))
    }
}

impl Remainder {
    fn get(&self) -> u32 {
        self.0.load(Relaxed)
    }

    fn restart(&self) {
        self.0.store(INITIAL, Relaxed);
    }

    /// Divides a word more.
    pub(crate) fn update(&self, word: u32) {
        let update =
            |crc: u32, byte: &u8| (crc << 8) ^ REMAINDERS[usize::from((crc >> 24) as u8 ^ byte)];
        let updated = word.to_be_bytes().iter().fold(self.get(), update);
        self.0.store(updated, Relaxed);
    }
}

/// The unit.
#[derive(Debug, Default)]
pub struct CrcUnit {
    /// What it holds.
    pub remainder: Remainder,
}

impl Device for CrcUnit {
    type Register = R;

    fn read(
        &mut self,
        register: R,
        registers: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) -> Option<u64> {
        self.peek(register, registers, context.now())
    }

    fn peek(&self, register: R, _: &RegisterFile, _: VirtualNanos) -> Option<u64> {
        (register == R::Dr).then(|| self.remainder.get().into())
    }

    fn write(&mut self, register: R, value: u64, _: &mut RegisterFile, _: &mut DeviceContext<'_>) {
        match register {
            R::Dr => self.remainder.update(value as u32),
            R::Cr if value & RESET != 0 => self.remainder.restart(),
            R::Cr | R::Idr => {}
        }
    }

    fn reset(&mut self) {
        self.remainder.restart();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    // CRC-32/MPEG-2 has the parameters of the unit. Its published check value is that of the nine
    // bytes "123456789"; the unit takes words, so the last byte continues the division here.
    #[test]
    fn the_unit_computes_crc_32_mpeg_2() {
        let remainder = Remainder::default();
        for word in b"12345678".as_chunks::<4>().0 {
            remainder.update(u32::from_be_bytes(*word));
        }
        let eight = remainder.get();
        let with_nine = (eight << 8) ^ REMAINDERS[usize::from((eight >> 24) as u8 ^ b'9')];
        assert_eq!(with_nine, 0x0376_e6e7);
    }
}
