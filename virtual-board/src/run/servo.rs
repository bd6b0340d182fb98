//! A radio receiver: a servo pulse every 20 ms.

use rigless::device::Level;

/// Period of the pulses, ns.
const FRAME_NS: u64 = 20_000_000;

/// Start of the pulses within the period: half a microsecond off the counts of a timer that starts
/// at a whole one, ns.
const OFFSET_NS: u64 = 5_000_500;

#[derive(Debug, Clone)]
pub(super) struct Servo {
    /// Width of the pulses, us; `None` for no pulses.
    pub pulse_us: Option<f64>,
    next_ns: u64,
    level: Level,
}

impl Servo {
    pub fn new(pulse_us: Option<f64>) -> Self {
        Self {
            pulse_us,
            next_ns: OFFSET_NS,
            level: Level::Low,
        }
    }

    /// Instant of the next edge, ns.
    pub fn next_ns(&self) -> Option<u64> {
        (self.pulse_us.is_some() || self.level == Level::High).then_some(self.next_ns)
    }

    /// The new level, if an edge is due.
    pub fn edge(&mut self, now_ns: u64) -> Option<Level> {
        if self.next_ns().is_none_or(|next_ns| next_ns > now_ns) {
            return None;
        }
        self.level = !self.level;
        if self.level == Level::High {
            let pulse_ns = (self.pulse_us.unwrap_or(0.0) * 1e3) as u64;
            self.next_ns = now_ns + pulse_ns.max(1_000);
        } else {
            let frames = now_ns / FRAME_NS + 1;
            self.next_ns = frames * FRAME_NS + OFFSET_NS;
        }
        Some(self.level)
    }

    /// Starts, ends or changes the pulses; the next pulse has the new width.
    pub fn set(&mut self, now_ns: u64, pulse_us: Option<f64>) {
        if self.next_ns().is_none() && pulse_us.is_some() {
            self.next_ns = (now_ns / FRAME_NS + 1) * FRAME_NS + OFFSET_NS;
        }
        self.pulse_us = pulse_us;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pulses_have_their_length_and_come_every_20_ms() {
        let mut servo = Servo::new(Some(1500.0));
        let mut edges = Vec::new();
        for _ in 0..4 {
            let at_ns = servo.next_ns().unwrap();
            assert!(servo.edge(at_ns - 1).is_none());
            edges.push((at_ns, servo.edge(at_ns).unwrap()));
        }
        assert_eq!(edges[1].0 - edges[0].0, 1_500_000);
        assert_eq!(edges[2].0 - edges[0].0, 20_000_000);
        assert_eq!(edges[1].1, Level::Low);
    }

    #[test]
    fn a_receiver_that_falls_silent_ends_its_pulse_first() {
        let mut servo = Servo::new(Some(1500.0));
        servo.edge(OFFSET_NS);
        servo.set(OFFSET_NS, None);
        assert_eq!(servo.edge(servo.next_ns().unwrap()), Some(Level::Low));
        assert_eq!(servo.next_ns(), None);
        servo.set(50_000_000, Some(1000.0));
        assert_eq!(servo.next_ns(), Some(60_000_000 + OFFSET_NS));
    }
}
