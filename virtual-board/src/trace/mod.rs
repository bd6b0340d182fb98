//! Record of a run in each PWM period, and its hash.

use sha2::{Digest, Sha256};

use crate::can::{Frame, Sent};
use crate::plant::{Bridge, Sensed};

/// The board at the start of a PWM period.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row {
    /// Nominal start of the period, ns.
    pub at_ns: u64,
    /// Number of executed instructions.
    pub instructions: u64,
    /// State of the bridge before it.
    pub bridge: Bridge,
    /// Sensor values from it on.
    pub sensed: Sensed,
    /// Angle of the output shaft, deg.
    pub angle_deg: f64,
    /// Rate of the output shaft, deg/s.
    pub rate_deg_s: f64,
    /// Current through the bridge, A.
    pub current_a: f64,
    /// Supply at the board, V.
    pub supply_v: f64,
}

/// The trace of a run.
#[derive(Debug, Clone, Default)]
pub struct Trace {
    /// A row for each PWM period; empty if only the hash is computed.
    pub rows: Vec<Row>,
    /// Frames on the CAN bus.
    pub frames: Vec<Sent>,
    /// Whether rows and frames are stored, in addition to the hash.
    pub is_kept: bool,
    hash: Sha256,
}

impl Trace {
    /// An empty trace.
    pub fn new(is_kept: bool) -> Self {
        Self {
            is_kept,
            ..Self::default()
        }
    }

    pub(crate) fn row(&mut self, row: Row) {
        self.number(row.at_ns);
        self.number(row.instructions);
        self.bridge(row.bridge);
        self.sensed(&row.sensed);
        for value in [row.angle_deg, row.rate_deg_s, row.current_a, row.supply_v] {
            self.number(value.to_bits());
        }
        if self.is_kept {
            self.rows.push(row);
        }
    }

    pub(crate) fn frame(&mut self, sent: Sent) {
        self.number(sent.at_ns);
        self.number(sent.sender as u64);
        let Frame { id, dlc, data, .. } = sent.frame;
        self.number(u64::from(id.value()) << 8 | u64::from(dlc));
        self.number(u64::from_le_bytes(data));
        if self.is_kept {
            self.frames.push(sent);
        }
    }

    fn number(&mut self, value: u64) {
        self.hash.update(value.to_le_bytes());
    }

    fn bridge(&mut self, bridge: Bridge) {
        self.number(match bridge {
            Bridge::Coast => u64::MAX,
            Bridge::Brake => 0,
            Bridge::Driven {
                is_positive,
                on_cycles,
            } => u64::from(is_positive) << 32 | u64::from(on_cycles),
        });
    }

    fn sensed(&mut self, sensed: &Sensed) {
        self.number(sensed.encoder.bits().into());
        let codes = [
            sensed.current,
            sensed.legs.a,
            sensed.legs.b,
            sensed.supply,
            sensed.temperature,
        ];
        for code in codes {
            self.number(code.bits().into());
        }
    }

    /// SHA-256 of all rows and frames, in hexadecimal.
    pub fn hash(&self) -> String {
        let digest = self.hash.clone().finalize();
        digest.iter().map(|byte| format!("{byte:02x}")).collect()
    }
}
