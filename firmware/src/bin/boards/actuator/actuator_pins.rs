//! Which pin of the actuator board goes where; `docs/hardware.md` has the same table, and a test on the
//! emulated board looks.

use crate::board::pins::{Mode, Pin, Pull};

/// All that are wired.
pub const PINS: [Pin; 16] = [
    // Bridge: leg A high and low, leg B high and low.
    (b'E', 9, Mode::Alternate(1), Pull::None),
    (b'E', 8, Mode::Alternate(1), Pull::None),
    (b'E', 11, Mode::Alternate(1), Pull::None),
    (b'E', 10, Mode::Alternate(1), Pull::None),
    // Break. Without a comparator it reads low: no drive.
    (b'E', 15, Mode::Alternate(1), Pull::Down),
    // Encoder: CSn, CLK, DO. A broken wire reads as zeros, which are no valid word.
    (b'A', 4, Mode::Output, Pull::None),
    (b'A', 5, Mode::Alternate(5), Pull::None),
    (b'A', 6, Mode::Alternate(5), Pull::Down),
    // Current, temperature, legs, supply.
    (b'A', 3, Mode::Analog, Pull::None),
    (b'B', 1, Mode::Analog, Pull::None),
    (b'C', 0, Mode::Analog, Pull::None),
    (b'C', 2, Mode::Analog, Pull::None),
    (b'C', 3, Mode::Analog, Pull::None),
    // Servo pulse. A broken wire gives none.
    (b'D', 12, Mode::Alternate(2), Pull::Down),
    // CAN: receive, send.
    (b'D', 0, Mode::Alternate(9), Pull::Up),
    (b'D', 1, Mode::FastAlternate(9), Pull::None),
];
