//! Which pin goes where; each board has its table.
//!
//! By the registers themselves (RM0090, section 8.4): a pin by the types of the crate
//! `stm32f4xx-hal` costs some 40 bytes of program, and a board has up to 16.

use core::ptr;

/// What a pin is.
#[derive(Clone, Copy)]
pub enum Mode {
    #[allow(dead_code, reason = "not every board has one")]
    Output,
    /// The alternate function of this number (data sheet, table 12).
    Alternate(u8),
    /// The same, with edges of less than 100 ns.
    FastAlternate(u8),
    #[allow(dead_code, reason = "not every board measures")]
    Analog,
}

/// What holds a pin that nobody drives.
#[derive(Clone, Copy)]
pub enum Pull {
    None = 0b00,
    Up = 0b01,
    #[allow(dead_code, reason = "not every board has one")]
    Down = 0b10,
}

/// A pin: the letter of its port, its number, what it is, and what holds it.
pub type Pin = (u8, u8, Mode, Pull);

/// The address of a port's registers (section 2.3).
fn address(port: u8) -> u32 {
    0x4002_0000 + 0x400 * u32::from(port.wrapping_sub(b'A'))
}

/// Offsets of their registers: two bits a pin in the first three, four bits in the last, two words.
const MODER: u32 = 0x00;
const OSPEEDR: u32 = 0x08;
const PUPDR: u32 = 0x0c;
const AFR: u32 = 0x20;

const HIGH_SPEED: u32 = 0b10;

/// Gives every pin its function; the ports have their clocks, and outputs the levels that they start
/// with.
pub fn set_up(pins: &[Pin]) {
    for &(port, number, mode, pull) in pins {
        let port = address(port);
        put(port + PUPDR, 2, number, pull as u32);
        let mode = match mode {
            Mode::Output => 0b01,
            Mode::Alternate(function) | Mode::FastAlternate(function) => {
                if matches!(mode, Mode::FastAlternate(_)) {
                    put(port + OSPEEDR, 2, number, HIGH_SPEED);
                }
                let half = u32::from(number / 8);
                put(port + AFR + 4 * half, 4, number % 8, function.into());
                0b10
            }
            Mode::Analog => 0b11,
        };
        put(port + MODER, 2, number, mode);
    }
}

/// Writes field `number` of a register of so wide ones.
fn put(register: u32, width: u8, number: u8, value: u32) {
    let register: *mut u32 = ptr::with_exposed_provenance_mut(register as usize);
    let shift = u32::from(width * number);
    let mask = ((1 << width) - 1) << shift;
    // SAFETY: a register of a port, and nobody else sets pins up.
    unsafe {
        let others = ptr::read_volatile(register) & !mask;
        ptr::write_volatile(register, others | value << shift);
    }
}
