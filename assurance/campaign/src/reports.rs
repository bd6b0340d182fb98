//! What the board reports to the network.

use virtual_board::can::Frame;

/// A node whose process data stay away for longer than this is lost to its master, ms.
const SILENCE_MS: u32 = 50;

/// What the board has reported on the network.
#[derive(Debug, Clone, Copy, Default)]
pub struct Reports {
    /// The last angle that the board reported, deg.
    pub angle_deg: Option<f64>,
    /// Time since it, ms.
    silent_ms: u32,
    /// Error code of the last EMCY.
    pub error_code: u16,
    /// The board has reported a fault, restarted, or is lost to its master.
    pub is_detected: bool,
}

impl Reports {
    /// Takes the frames of this time.
    pub fn update(&mut self, elapsed_ms: u32, frames: impl Iterator<Item = Frame>) {
        self.silent_ms += elapsed_ms;
        for frame in frames {
            let bytes = frame.payload();
            match (frame.id.value(), bytes) {
                // EMCY with an error code, boot-up.
                (0x081, [low, high, ..]) => {
                    self.error_code = u16::from_le_bytes([*low, *high]);
                    self.is_detected |= self.error_code != 0;
                }
                (0x701, [0]) => self.is_detected = true,
                // Angle, 0.01 deg.
                (0x181, [low, high, ..]) => {
                    self.silent_ms = 0;
                    let cdeg = i16::from_le_bytes([*low, *high]);
                    self.angle_deg = Some(f64::from(cdeg) / 100.0);
                }
                // Statusword, bit 3.
                (0x281, [.., low, _]) => self.is_detected |= low & 8 != 0,
                _ => {}
            }
        }
        self.is_detected |= self.silent_ms > SILENCE_MS;
    }

    /// Discards what was detected before the injection: the boot-up message, and the silence before
    /// the start of the node.
    pub fn forget(&mut self) {
        self.is_detected = false;
        self.silent_ms = 0;
    }
}
