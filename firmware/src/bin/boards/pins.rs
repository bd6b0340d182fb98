//! Which pin goes where; `docs/hardware.md` has the same table, and a test on the emulated board looks.
//!
//! By the registers themselves (RM0090, section 8.4): a pin by the types of the crate
//! `stm32f4xx-hal` costs some 40 bytes of program, and there are 16.

use core::ptr;

/// What a pin is.
#[derive(Clone, Copy)]
enum Mode {
    Output,
    /// The alternate function of this number (data sheet, table 12).
    Alternate(u8),
    Analog,
}

/// What holds a pin that nobody drives.
#[derive(Clone, Copy)]
enum Pull {
    None = 0b00,
    Up = 0b01,
    Down = 0b10,
}

/// Ports.
const A: u8 = 0;
const B: u8 = 1;
const C: u8 = 2;
const D: u8 = 3;
const E: u8 = 4;

/// The address of a port's registers (section 2.3).
fn address(port: u8) -> u32 {
    0x4002_0000 + 0x400 * u32::from(port)
}

/// Offsets of their registers: two bits a pin in the first three, four bits in the last, two words.
const MODER: u32 = 0x00;
const OSPEEDR: u32 = 0x08;
const PUPDR: u32 = 0x0c;
const AFR: u32 = 0x20;

const PINS: [(u8, u8, Mode, Pull); 16] = [
    // Bridge: leg A high and low, leg B high and low.
    (E, 9, Mode::Alternate(1), Pull::None),
    (E, 8, Mode::Alternate(1), Pull::None),
    (E, 11, Mode::Alternate(1), Pull::None),
    (E, 10, Mode::Alternate(1), Pull::None),
    // Break. Without a comparator it reads low: no drive.
    (E, 15, Mode::Alternate(1), Pull::Down),
    // Encoder: CSn, CLK, DO. A broken wire reads as zeros, which are no valid word.
    (A, 4, Mode::Output, Pull::None),
    (A, 5, Mode::Alternate(5), Pull::None),
    (A, 6, Mode::Alternate(5), Pull::Down),
    // Current, temperature, legs, supply.
    (A, 3, Mode::Analog, Pull::None),
    (B, 1, Mode::Analog, Pull::None),
    (C, 0, Mode::Analog, Pull::None),
    (C, 2, Mode::Analog, Pull::None),
    (C, 3, Mode::Analog, Pull::None),
    // Servo pulse. A broken wire gives none.
    (D, 12, Mode::Alternate(2), Pull::Down),
    // CAN: receive, send.
    (D, 0, Mode::Alternate(9), Pull::Up),
    (D, 1, Mode::Alternate(9), Pull::None),
];

/// What CAN1 drives needs edges of less than 100 ns.
const FAST: (u8, u8) = (D, 1);
const HIGH_SPEED: u32 = 0b10;

/// Gives every pin its function; the ports have their clocks, and outputs the levels that they start
/// with.
pub fn set_up() {
    let (port, number) = FAST;
    put(address(port) + OSPEEDR, 2, number, HIGH_SPEED);
    for &(port, number, mode, pull) in &PINS {
        let port = address(port);
        put(port + PUPDR, 2, number, pull as u32);
        let mode = match mode {
            Mode::Output => 0b01,
            Mode::Alternate(function) => {
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
