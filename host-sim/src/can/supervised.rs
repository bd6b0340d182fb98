//! A bus on which a client shows that it is alive, for the actuator that moves on its request.
//!
//! While the client is supervised, it sends heartbeats of a node-ID of its own, which the actuator
//! monitors (1016h). If they cease, the actuator reacts according to 2040h:2: the shaft stops, even
//! if the client was killed.

use std::io;
use std::time::{Duration, Instant};

use canopen::{CanFrame, cob_id};
use embedded_can::{Frame, Id};

use super::link::Link;

/// Period of the heartbeats.
const PERIOD: Duration = Duration::from_millis(50);

/// Time without a heartbeat after which the actuator reacts, ms.
pub const TIMEOUT_MS: u32 = 300;

/// Node-IDs for clients, the highest first; Studio has 127.
const OWN_NODES: std::ops::RangeInclusive<u8> = 112..=126;

/// A bus, with the heartbeat of this program while it has a node-ID.
pub struct SupervisedLink {
    link: Box<dyn Link>,
    own_node: Option<u8>,
    next: Instant,
    /// A heartbeat with the node-ID of this program was received.
    is_shared: bool,
}

impl SupervisedLink {
    /// A bus without heartbeats.
    pub fn new(link: Box<dyn Link>) -> Self {
        Self {
            link,
            own_node: None,
            next: Instant::now(),
            is_shared: false,
        }
    }

    /// Selects a node-ID whose heartbeats are not on the bus, and starts those of this program;
    /// returns the node-ID. Programs that select the same one at the same time select others, by
    /// their process numbers.
    ///
    /// # Errors
    /// The error of the operating system, and [`io::ErrorKind::AddrInUse`] if none is free.
    pub fn begin(&mut self) -> io::Result<u8> {
        let mut free: Vec<u8> = OWN_NODES.rev().collect();
        let end = Instant::now() + 3 * PERIOD;
        while let Some(left) = end.checked_duration_since(Instant::now()) {
            let frame = self.link.receive(left)?;
            if let Some(node) = frame.and_then(|frame| heartbeat_of(&frame)) {
                free.retain(|own| *own != node);
            }
        }
        let mut place = 0;
        while !free.is_empty() {
            let own_node = free.remove(place);
            if self.claim(own_node)? {
                return Ok(own_node);
            }
            place = std::process::id() as usize % free.len().max(1);
        }
        self.own_node = None;
        Err(io::ErrorKind::AddrInUse.into())
    }

    /// Starts the heartbeats of a node-ID; returns whether no other program does so too.
    fn claim(&mut self, own_node: u8) -> io::Result<bool> {
        (self.own_node, self.next, self.is_shared) = (Some(own_node), Instant::now(), false);
        let end = Instant::now() + 2 * PERIOD;
        while let Some(left) = end.checked_duration_since(Instant::now()) {
            self.receive(left)?;
        }
        Ok(!self.is_shared)
    }

    /// Ends the heartbeats.
    pub fn end(&mut self) {
        self.own_node = None;
    }

    /// The node-ID of this program, if another program uses it too: its heartbeats would go on if
    /// this program ended.
    pub fn shared_node(&self) -> Option<u8> {
        self.own_node.filter(|_| self.is_shared)
    }

    fn beat(&mut self) -> io::Result<()> {
        let now = Instant::now();
        let Some(own_node) = self.own_node.filter(|_| now >= self.next) else {
            return Ok(());
        };
        self.next = now + PERIOD;
        let id = cob_id::of_node(cob_id::HEARTBEAT, own_node);
        // Operational.
        match CanFrame::new(id, &[5]) {
            Some(frame) => self.link.send(&frame),
            None => Ok(()),
        }
    }
}

/// The node of a heartbeat.
fn heartbeat_of(frame: &CanFrame) -> Option<u8> {
    let Id::Standard(id) = frame.id() else {
        return None;
    };
    let node = u32::from(id.as_raw()).checked_sub(cob_id::HEARTBEAT)?;
    u8::try_from(node)
        .ok()
        .filter(|node| (1..=127).contains(node))
}

impl Link for SupervisedLink {
    fn send(&mut self, frame: &CanFrame) -> io::Result<()> {
        self.beat()?;
        self.link.send(frame)
    }

    fn receive(&mut self, timeout: Duration) -> io::Result<Option<CanFrame>> {
        let end = Instant::now() + timeout;
        loop {
            self.beat()?;
            let left = end.saturating_duration_since(Instant::now());
            let frame = self.link.receive(left.min(PERIOD))?;
            let node = frame.as_ref().and_then(heartbeat_of);
            self.is_shared |= node.is_some() && node == self.own_node;
            if frame.is_some() || left <= PERIOD {
                return Ok(frame);
            }
        }
    }

    fn pause(&mut self, mut time: Duration) -> io::Result<()> {
        loop {
            self.beat()?;
            let slice = time.min(PERIOD);
            self.link.pause(slice)?;
            time -= slice;
            if time.is_zero() {
                return Ok(());
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::{Arc, Mutex};

    use super::*;

    /// A bus that has these frames, and keeps what is sent.
    struct Bus {
        received: Vec<CanFrame>,
        sent: Arc<Mutex<Vec<CanFrame>>>,
        /// The node-ID that another program selects at the same time.
        claimed: Option<u8>,
    }

    impl Bus {
        fn with(received: Vec<CanFrame>) -> Self {
            Self {
                received,
                sent: Arc::default(),
                claimed: None,
            }
        }
    }

    impl Link for Bus {
        fn send(&mut self, frame: &CanFrame) -> io::Result<()> {
            self.sent.lock().unwrap().push(*frame);
            if self.claimed.is_some() && heartbeat_of(frame) == self.claimed {
                self.received.push(*frame);
            }
            Ok(())
        }

        fn receive(&mut self, timeout: Duration) -> io::Result<Option<CanFrame>> {
            if self.received.is_empty() {
                std::thread::sleep(timeout);
            }
            Ok(self.received.pop())
        }
    }

    fn heartbeat(node: u8) -> CanFrame {
        CanFrame::new(cob_id::of_node(cob_id::HEARTBEAT, node), &[5]).unwrap()
    }

    #[test]
    fn the_highest_node_id_that_no_other_client_uses_is_that_of_the_heartbeats() {
        let bus = Bus::with(vec![heartbeat(1), heartbeat(126), heartbeat(127)]);
        let sent = Arc::clone(&bus.sent);
        let mut link = SupervisedLink::new(Box::new(bus));
        assert_eq!(link.begin().unwrap(), 125);
        // Two or three to claim it, and one behind each period of a wait; fewer on a busy computer.
        link.receive(3 * PERIOD).unwrap();
        link.pause(3 * PERIOD).unwrap();
        link.end();
        link.pause(PERIOD).unwrap();
        let sent = sent.lock().unwrap();
        assert!((5..=9).contains(&sent.len()), "{}", sent.len());
        assert!(sent.iter().all(|frame| *frame == heartbeat(125)));
    }

    #[test]
    fn a_node_id_that_another_program_selects_at_the_same_time_is_left_to_it() {
        let mut bus = Bus::with(Vec::new());
        bus.claimed = Some(126);
        let own_node = SupervisedLink::new(Box::new(bus)).begin().unwrap();
        assert!((112..126).contains(&own_node), "{own_node}");
    }

    #[test]
    fn a_foreign_heartbeat_with_the_own_node_id_is_noticed() {
        let mut link = SupervisedLink::new(Box::new(Bus::with(Vec::new())));
        let own_node = link.begin().unwrap();
        for (node, shared) in [(own_node - 1, None), (own_node, Some(own_node))] {
            link.link = Box::new(Bus::with(vec![heartbeat(node)]));
            link.receive(Duration::ZERO).unwrap();
            assert_eq!(link.shared_node(), shared);
        }
    }
}
