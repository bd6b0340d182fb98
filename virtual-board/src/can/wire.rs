//! The CAN bus: arbitration, outcome of frames, and external ports.

mod arbitration;
mod port;
#[cfg(test)]
mod tests;

pub use arbitration::{Outcome, Station, Transfer, arbitrate};
pub use port::Port;

use super::Frame;

/// Fault of the bus line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum WireFault {
    /// No fault.
    #[default]
    None,
    /// The controllers are disconnected from all ports and from each other: no acknowledgement.
    Open,
    /// CANH and CANL are shorted: no dominant bit is possible, every frame fails at its first bit.
    Short,
}

/// A frame that was on the bus, with its outcome.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sent {
    /// End of the frame, or of the error frame that destroyed it, ns.
    pub at_ns: u64,
    /// Index of the transmitter: controllers first, then ports.
    pub sender: usize,
    /// The frame.
    pub frame: Frame,
    /// Its outcome.
    pub outcome: Outcome,
}

/// A bus with external ports. Controllers describe themselves as [`Station`]s for each arbitration.
#[derive(Debug, Default)]
pub struct Wire {
    /// External stations.
    pub ports: Vec<Port>,
    /// Fault of the bus line.
    pub fault: WireFault,
    /// Number of next frames that a disturbance destroys.
    pub noise: u32,
    running: Option<(u64, Transfer)>,
    free_at_ns: u64,
    log: Vec<Sent>,
}

impl Wire {
    /// A bus with these ports.
    pub fn new(ports: Vec<Port>) -> Self {
        Self {
            ports,
            ..Self::default()
        }
    }

    /// Whether a frame is in transmission.
    pub fn is_busy(&self) -> bool {
        self.running.is_some()
    }

    /// Earliest start of the next frame, ns.
    pub fn free_at_ns(&self) -> u64 {
        self.free_at_ns
    }

    /// End of the frame in transmission, or time of the next arbitration, not before `now_ns`;
    /// `None` while no station has a frame to transmit.
    pub fn next_ns(&self, now_ns: u64, a_controller_offers: bool) -> Option<u64> {
        if let Some((ends_ns, _)) = &self.running {
            return Some(*ends_ns);
        }
        let due_ns = if a_controller_offers {
            Some(now_ns)
        } else if self.fault == WireFault::Open {
            None
        } else {
            self.ports.iter().filter_map(Port::due_ns).min()
        };
        due_ns.map(|due_ns| due_ns.max(self.free_at_ns).max(now_ns))
    }

    /// Arbitrates between controllers and ports if the bus is idle, and starts the frame that wins.
    pub fn start(
        &mut self,
        now_ns: u64,
        controllers: &[Option<Station>],
    ) -> Option<(u64, Transfer)> {
        if self.is_busy() || now_ns < self.free_at_ns {
            return None;
        }
        let is_open = self.fault == WireFault::Open;
        let ports = self.ports.iter().map(|port| port.station(now_ns));
        let stations: Vec<_> = (controllers.iter().copied())
            .chain(ports.map(|station| station.filter(|_| !is_open)))
            .collect();
        let transfer = arbitrate(&stations, self.fault, self.noise > 0)?;
        if transfer.outcome == Outcome::Disturbed(None) {
            self.noise = self.noise.saturating_sub(1);
        }
        let ends_ns = now_ns + transfer.outcome_ns();
        self.free_at_ns = now_ns + transfer.busy_ns();
        self.running = Some((ends_ns, transfer));
        self.running
    }

    /// Ends the frame in transmission when its time has elapsed, and delivers it to the ports. The
    /// caller delivers it to its controllers; `controllers` is their number.
    pub fn finish(&mut self, now_ns: u64, controllers: usize) -> Option<Transfer> {
        let (ends_ns, transfer) = self.running.take_if(|(ends_ns, _)| *ends_ns <= now_ns)?;
        self.log.push(Sent {
            at_ns: ends_ns,
            sender: transfer.sender,
            frame: transfer.frame,
            outcome: transfer.outcome,
        });
        if self.fault != WireFault::Open {
            for (port, station) in self.ports.iter_mut().zip(controllers..) {
                port.receive(ends_ns, station, &transfer);
            }
        }
        Some(transfer)
    }

    /// Discards the frame of a controller that left the bus.
    pub fn abandon(&mut self, controller: usize) {
        self.running
            .take_if(|(_, transfer)| transfer.sender == controller);
    }

    /// Frames since the last call.
    pub fn take_log(&mut self) -> Vec<Sent> {
        std::mem::take(&mut self.log)
    }
}
