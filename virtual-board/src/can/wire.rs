//! The wire: who gets it, what becomes of the frame, and what hangs on it beside the controllers.

mod contest;
mod port;
#[cfg(test)]
mod tests;

pub use contest::{Outcome, Station, Transfer, contest};
pub use port::Port;

use super::Frame;

/// What is wrong with the wire.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum WireFault {
    /// Nothing.
    #[default]
    None,
    /// The controllers are cut off from all ports and from each other: nobody acknowledges.
    Open,
    /// CANH and CANL touch: no dominant bit comes through, every frame fails at its first bit.
    Short,
}

/// A frame that was on the wire, whatever became of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sent {
    /// End of the frame, or of the error frame that destroyed it, ns.
    pub at_ns: u64,
    /// The station: first the controllers, then the ports.
    pub sender: usize,
    /// The frame.
    pub frame: Frame,
    /// What became of it.
    pub outcome: Outcome,
}

/// A bus with outside ports. Controllers take part as [`Station`]s that they describe at every contest.
#[derive(Debug, Default)]
pub struct Wire {
    /// The stations beside the controllers.
    pub ports: Vec<Port>,
    /// What is wrong with the wire.
    pub fault: WireFault,
    /// So many of the next frames meet a disturbance.
    pub noise: u32,
    running: Option<(u64, Transfer)>,
    free_at_ns: u64,
    log: Vec<Sent>,
}

impl Wire {
    /// A wire with these ports.
    pub fn new(ports: Vec<Port>) -> Self {
        Self {
            ports,
            ..Self::default()
        }
    }

    /// Whether a frame is on its way.
    pub fn is_busy(&self) -> bool {
        self.running.is_some()
    }

    /// When the next frame may start, ns.
    pub fn free_at_ns(&self) -> u64 {
        self.free_at_ns
    }

    /// When the frame on its way ends, or a contest has to be held, not before `now_ns`; `None`
    /// while nobody wants to send.
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

    /// Holds a contest between the controllers and the ports if the wire is free, and starts what
    /// wins it.
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
        let transfer = contest(&stations, self.fault, self.noise > 0)?;
        if transfer.outcome == Outcome::Disturbed(None) {
            self.noise = self.noise.saturating_sub(1);
        }
        let ends_ns = now_ns + transfer.outcome_ns();
        self.free_at_ns = now_ns + transfer.busy_ns();
        self.running = Some((ends_ns, transfer));
        self.running
    }

    /// Ends the frame on its way at its instant, and tells the ports. The controllers are the
    /// caller's, `controllers` of them.
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
                port.hear(ends_ns, station, &transfer);
            }
        }
        Some(transfer)
    }

    /// The part that sent disappeared from the bus: its frame is lost.
    pub fn abandon(&mut self, controller: usize) {
        self.running
            .take_if(|(_, transfer)| transfer.sender == controller);
    }

    /// Every frame since the last call.
    pub fn take_log(&mut self) -> Vec<Sent> {
        std::mem::take(&mut self.log)
    }
}
