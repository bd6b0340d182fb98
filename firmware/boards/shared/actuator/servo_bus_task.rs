//! The tasks of the servo bus: between the line and the servo's registers.

use firmware::drive::{Elapsed, ServoBus};

use crate::peripherals::servo_line::ServoLine;

/// What has happened on the line.
pub enum LineEvent<'a> {
    /// Nothing.
    None,
    /// These bytes were received, and a pause followed.
    Received(&'a [u8]),
    /// The answer was transmitted.
    Transmitted,
}

/// Time after which a line on which bytes are received is looked at again, us: a byte at 9,600
/// bit/s.
const RECEIVING_US: u32 = 1042;

/// An event of the line: bytes were received up to a pause, or the answer was transmitted.
pub fn on_line(line: &mut ServoLine, bus: &mut ServoBus) {
    match line.take_event() {
        LineEvent::None => {}
        LineEvent::Received(bytes) => {
            let wait_us = bus.receive(bytes);
            line.timer.start(wait_us);
        }
        // What the instruction has written of the bit rate is in effect behind its answer.
        LineEvent::Transmitted => {
            line.set_bit_rate(bus.bit_rate());
            line.receive();
        }
    }
}

/// The time that the servo waits for has elapsed.
pub fn on_timer(line: &mut ServoLine, bus: &mut ServoBus) {
    if !line.timer.take_elapsed() {
        return;
    }
    // Another servo transmits: its pause is the next event.
    if line.is_receiving() {
        return line.timer.start(Some(RECEIVING_US));
    }
    match bus.elapsed() {
        Elapsed::Transmit => line.transmit(|buffer| bus.take_answer(buffer)),
        Elapsed::Wait(us) => line.timer.start(Some(us)),
        Elapsed::Silence => line.set_bit_rate(bus.bit_rate()),
    }
}
