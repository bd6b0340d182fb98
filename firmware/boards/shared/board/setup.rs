//! Pin functions.
//!
//! Pins are configured by their registers (RM0090, section 8.4; RM0433, section 11.4), from one
//! table for each board, which is the table of `docs/hardware.md`.

use core::ptr;

use crate::chip::{HIGH_SPEED, PORTS};

/// Function of a pin.
#[derive(Clone, Copy)]
pub enum Mode {
    #[allow(dead_code, reason = "the communication board has no output pin")]
    Output,
    /// Alternate function of this number (data sheet, table of alternate functions).
    Alternate(u8),
    /// Alternate function with edges below 100 ns.
    FastAlternate(u8),
    /// Alternate function with the fastest edges: the clock of an SPI master whose bus runs at 84
    /// MHz, which may otherwise read the last bit of a frame wrongly (ES0206, corrupted last bit of
    /// data in master mode with delayed SCK feedback).
    #[allow(dead_code, reason = "the communication board has no SPI")]
    FastestAlternate(u8),
    /// Alternate function with open drain, and edges below 100 ns.
    #[allow(dead_code, reason = "the communication board has no bus on one wire")]
    OpenDrain(u8),
    #[allow(dead_code, reason = "the communication board has no analog pin")]
    Analog,
}

/// Internal pull resistor.
#[derive(Clone, Copy)]
pub enum Pull {
    None = 0b00,
    Up = 0b01,
    #[allow(dead_code, reason = "the communication board has no pull-down")]
    Down = 0b10,
}

/// Letter of the port, number of the pin, its function and its pull resistor.
pub type Pin = (u8, u8, Mode, Pull);

/// Address of a port's registers.
fn port_address(port: u8) -> u32 {
    PORTS + 0x400 * u32::from(port.wrapping_sub(b'A'))
}

/// Register offsets: one bit for each pin in OTYPER and LCKR, four bits in AFR, which is two words,
/// and two bits in the others.
const MODER: u32 = 0x00;
const OTYPER: u32 = 0x04;
const OSPEEDR: u32 = 0x08;
const PUPDR: u32 = 0x0c;
const LCKR: u32 = 0x1c;
const AFR: u32 = 0x20;

/// Very high speed in OSPEEDR, of both chips.
const VERY_HIGH: u32 = 0b11;

/// LCKK of LCKR.
const LOCK_KEY: u32 = 1 << 16;

/// Sets the function of every pin. The clocks of the ports are enabled, and outputs have their
/// initial levels.
pub fn set_up_pins(pins: &[Pin]) {
    for &(port, number, mode, pull) in pins {
        let port = port_address(port);
        write_field(port + PUPDR, 2, number, pull as u32);
        let mode = match mode {
            Mode::Output => 0b01,
            Mode::Alternate(function)
            | Mode::FastAlternate(function)
            | Mode::FastestAlternate(function)
            | Mode::OpenDrain(function) => {
                match mode {
                    Mode::FastAlternate(_) => write_field(port + OSPEEDR, 2, number, HIGH_SPEED),
                    Mode::OpenDrain(_) => {
                        write_field(port + OTYPER, 1, number, 1);
                        write_field(port + OSPEEDR, 2, number, HIGH_SPEED);
                    }
                    Mode::FastestAlternate(_) => write_field(port + OSPEEDR, 2, number, VERY_HIGH),
                    _ => {}
                }
                let word = u32::from(number / 8);
                write_field(port + AFR + 4 * word, 4, number % 8, function.into());
                0b10
            }
            Mode::Analog => 0b11,
        };
        write_field(port + MODER, 2, number, mode);
    }
}

/// Locks the functions of these pins until the next reset (RM0090, section 8.3.6; RM0433, section
/// 11.3.6).
pub fn lock_pins(pins: &[Pin]) {
    for port in b'A'..=b'I' {
        let locked =
            (pins.iter().filter(|pin| pin.0 == port)).fold(0, |mask, pin| mask | 1 << pin.1);
        if locked == 0 {
            continue;
        }
        let register: *mut u32 =
            ptr::with_exposed_provenance_mut((port_address(port) + LCKR) as usize);
        // The key: LCKK set, clear, set with the same pins, then a read.
        for value in [LOCK_KEY | locked, locked, LOCK_KEY | locked] {
            // SAFETY: the address is that of a port register, and only `init` configures pins.
            unsafe { ptr::write_volatile(register, value) };
        }
        // SAFETY: as above.
        let _ = unsafe { ptr::read_volatile(register) };
    }
}

/// Writes the field of pin `number` in a register with fields of `width` bits.
fn write_field(register: u32, width: u8, number: u8, value: u32) {
    let register: *mut u32 = ptr::with_exposed_provenance_mut(register as usize);
    let shift = u32::from(width * number);
    let mask = ((1 << width) - 1) << shift;
    // SAFETY: the address is that of a port register, and only `init` configures pins.
    unsafe {
        let others = ptr::read_volatile(register) & !mask;
        ptr::write_volatile(register, others | value << shift);
    }
}
