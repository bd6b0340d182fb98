//! Frames as LAWICEL lines.

use embedded_can::Frame;

use crate::frame::CanFrame;

/// The frame in a line such as `t6058402F600001000000`; `None` where there is none.
pub fn parse(line: &str) -> Option<CanFrame> {
    let kind = line.chars().next().filter(|_| line.is_ascii())?;
    let extended = matches!(kind, 'T' | 'R');
    let remote = matches!(kind, 'r' | 'R');
    if !extended && !matches!(kind, 't' | 'r') {
        return None;
    }
    let digits = if extended { 8 } else { 3 };
    let id = u32::from_str_radix(line.get(1..1 + digits)?, 16).ok()?;
    let length = line
        .get(1 + digits..2 + digits)?
        .parse()
        .ok()
        .filter(|length| *length <= 8)?;
    let mut data = [0; 8];
    if !remote {
        for (at, byte) in data.iter_mut().take(length).enumerate() {
            let start = 2 + digits + 2 * at;
            *byte = u8::from_str_radix(line.get(start..start + 2)?, 16).ok()?;
        }
    }
    CanFrame::raw(id, extended, remote, length, data)
}

/// The line of a frame, with its carriage return.
pub fn print(frame: &CanFrame) -> String {
    let (id, extended) = frame.raw_id();
    let data: String = frame
        .data()
        .iter()
        .map(|byte| format!("{byte:02X}"))
        .collect();
    match (extended, frame.is_remote_frame()) {
        (false, false) => format!("t{id:03X}{}{data}\r", frame.dlc()),
        (true, false) => format!("T{id:08X}{}{data}\r", frame.dlc()),
        (false, true) => format!("r{id:03X}{}\r", frame.dlc()),
        (true, true) => format!("R{id:08X}{}\r", frame.dlc()),
    }
}
