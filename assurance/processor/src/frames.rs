//! Exceptions: what the processor stores when it takes one, and restores when it returns
//! (DDI 0403E, B1.5.6 to B1.5.8).

use crate::registers::{Registers, SINGLE, it_of, with_it};
use crate::unicorn::{Host, Register, Unicorn};

/// Words of a frame without and with floating-point registers, and where these begin, bytes.
const BASIC_BYTES: u32 = 0x20;
const EXTENDED_BYTES: u32 = 0x68;

/// The bit of the stacked status that marks a stack that was not aligned to eight bytes.
const REALIGNED: u32 = 1 << 9;

/// The bit of EXC_RETURN that marks a frame without floating-point registers.
const BASIC: u32 = 1 << 4;

/// EXC_RETURN of a return to Thread mode, without the bit [`BASIC`].
const TO_THREAD: u32 = 0xffff_ffe9;
/// EXC_RETURN of a return to Handler mode, without the bit [`BASIC`].
const TO_HANDLER: u32 = 0xffff_ffe1;

/// S0 to S15 and FPSCR, which the processor stores only when the handler uses such a register.
#[derive(Debug, Clone, Copy)]
struct Lazy {
    /// Where they are stored.
    address: u32,
    words: [u32; 17],
    is_stored: bool,
}

impl Lazy {
    fn bytes(&self) -> [u8; 68] {
        let mut bytes = [0; 68];
        for (four, word) in bytes.as_chunks_mut::<4>().0.iter_mut().zip(self.words) {
            *four = word.to_le_bytes();
        }
        bytes
    }
}

/// The exceptions that are active on the second emulator.
#[derive(Debug, Default)]
pub struct Frames {
    lazy: Vec<Lazy>,
}

impl Frames {
    /// Discards all frames.
    pub fn clear(&mut self) {
        self.lazy.clear();
    }

    /// Takes an exception: stores the frame and starts the handler. The board's EXC_RETURN says
    /// whether the frame has room for floating-point registers.
    ///
    /// # Errors
    /// The stack is not memory.
    pub fn enter<H: Host>(
        &mut self,
        second: &mut Unicorn<H>,
        (number, handler): (u32, u32),
        it: u8,
        board_link: u32,
    ) -> Result<(), String> {
        let before = Registers::of_second(second);
        let is_extended = board_link & BASIC == 0;
        let r = before.core;
        let bytes = if is_extended {
            EXTENDED_BYTES
        } else {
            BASIC_BYTES
        };
        let at = r[13].wrapping_sub(bytes) & !7;
        let realigned = if r[13] & 4 != 0 { REALIGNED } else { 0 };
        let status = with_it(before.xpsr, it) | realigned;
        let frame = [r[0], r[1], r[2], r[3], r[12], r[14], r[15], status];
        for (word, address) in frame.into_iter().zip((at..).step_by(4)) {
            if !second.memory().write(address, &word.to_le_bytes()) {
                return Err(format!("the frame at {address:08x} is not in memory"));
            }
        }
        if is_extended {
            let mut words = [0; 17];
            words[..16].copy_from_slice(&before.single[..16]);
            words[16] = before.fpscr;
            self.lazy.push(Lazy {
                address: at + BASIC_BYTES,
                words,
                is_stored: false,
            });
        }
        let target = if before.exception() == 0 {
            TO_THREAD
        } else {
            TO_HANDLER
        };
        let link = if is_extended { target } else { target | BASIC };
        let status = Registers::with_exception(with_it(before.xpsr, 0), number);
        second.write([
            (Register::XPSR, status),
            (Register::core(13), at),
            (Register::core(14), link),
            (Register::core(15), handler | 1),
        ]);
        Ok(())
    }

    /// Starts another handler without restoring and storing the frame.
    pub fn chain<H: Host>(second: &mut Unicorn<H>, link: u32, (number, handler): (u32, u32)) {
        let [status] = second.read([Register::XPSR]);
        second.write([
            (
                Register::XPSR,
                Registers::with_exception(with_it(status, 0), number),
            ),
            (Register::core(14), link),
            (Register::core(15), handler | 1),
        ]);
    }

    /// Returns from an exception: restores the frame. Returns the ITSTATE of the code that
    /// continues.
    ///
    /// # Errors
    /// The stack is not memory.
    pub fn leave<H: Host>(&mut self, second: &mut Unicorn<H>, link: u32) -> Result<u8, String> {
        let [at] = second.read([Register::core(13)]);
        let memory = second.memory().clone();
        let word = |number: u32| {
            let address = at + 4 * number;
            let word = memory.word(address);
            word.ok_or_else(|| format!("the frame at {address:08x} is not in memory"))
        };
        let is_extended = link & BASIC == 0;
        let status = word(7)?;
        let bytes = if is_extended {
            EXTENDED_BYTES
        } else {
            BASIC_BYTES
        };
        let realigned = if status & REALIGNED != 0 { 4 } else { 0 };
        if is_extended && let Some(lazy) = self.lazy.pop().filter(|lazy| lazy.is_stored) {
            second.write(std::array::from_fn::<_, 16, _>(|n| {
                (SINGLE[n], lazy.words[n])
            }));
            second.write([(Register::FPSCR, lazy.words[16])]);
        }
        second.write([
            (Register::XPSR, with_it(status & !REALIGNED, 0)),
            (Register::core(0), word(0)?),
            (Register::core(1), word(1)?),
            (Register::core(2), word(2)?),
            (Register::core(3), word(3)?),
            (Register::core(12), word(4)?),
            (Register::core(14), word(5)?),
            (Register::core(13), (at + bytes) | realigned),
            (Register::core(15), word(6)? | 1),
        ]);
        Ok(it_of(status))
    }

    /// Stores the floating-point registers of frames where the board has stored them.
    pub fn store_lazy<H: Host>(
        &mut self,
        second: &Unicorn<H>,
        board_differs: impl Fn(u32, &[u8]) -> bool,
    ) {
        for lazy in self.lazy.iter_mut().filter(|lazy| !lazy.is_stored) {
            let bytes = lazy.bytes();
            if !board_differs(lazy.address, &bytes) {
                second.memory().write(lazy.address, &bytes);
                lazy.is_stored = true;
            }
        }
    }
}
