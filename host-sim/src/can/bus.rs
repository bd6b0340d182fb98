//! A bus without errors and without arbitration: every frame reaches every participant but its
//! sender, in order.

use std::collections::VecDeque;
use std::sync::mpsc::Receiver;

use canopen::CanFrame;

use super::native_node::{NativeNode, PERIOD_US};
use super::node_fault::Fault;

/// Late control periods that are run after a pause. More are skipped: a suspended computer must not
/// trigger the command timeout.
const MAX_LATE_PERIODS: u64 = 5;

/// A participant of the bus.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Port {
    /// An actuator, by its index.
    Node(usize),
    /// A client, by its number.
    Client(u64),
}

/// Actuators on a bus.
pub struct Bus<'a> {
    nodes: Vec<NativeNode<'a>>,
    queue: VecDeque<(Port, CanFrame)>,
    faults: Option<Receiver<Fault>>,
}

impl<'a> Bus<'a> {
    /// A bus with these actuators.
    pub fn new(nodes: Vec<NativeNode<'a>>) -> Self {
        let mut bus = Self {
            nodes,
            queue: VecDeque::new(),
            faults: None,
        };
        bus.collect_all();
        bus
    }

    /// Faults at run time; of an actuator that does not exist, nothing.
    pub fn set_faults(&mut self, faults: Receiver<Fault>) {
        self.faults = Some(faults);
    }

    /// Delivers a frame of a client and the responses to it; `monitor` gets each frame with its
    /// sender.
    pub fn send(&mut self, from: u64, frame: CanFrame, mut monitor: impl FnMut(Port, &CanFrame)) {
        self.queue.push_back((Port::Client(from), frame));
        self.deliver(&mut monitor);
    }

    /// The time of the next control period, us.
    pub fn next_us(&self) -> u64 {
        let times = self.nodes.iter().map(NativeNode::next_us);
        times.min().unwrap_or(u64::MAX)
    }

    /// Runs a control period of each actuator for which one is due, and delivers all frames;
    /// `monitor` gets each frame with its sender.
    pub fn step(&mut self, now_us: u64, mut monitor: impl FnMut(Port, &CanFrame)) {
        self.deliver(&mut monitor);
        for fault in self.faults.iter().flat_map(Receiver::try_iter) {
            if let Some(node) = self.nodes.get_mut(fault.node - 1) {
                node.apply(fault.change);
            }
        }
        for node in &mut self.nodes {
            node.step(now_us);
        }
        self.collect_all();
        self.deliver(&mut monitor);
    }

    /// Skips the control periods that are too late to be run; returns their number.
    pub fn skip_late(&mut self, now_us: u64) -> u64 {
        let latest = now_us.saturating_sub(MAX_LATE_PERIODS * PERIOD_US);
        let skipped = latest.saturating_sub(self.next_us()) / PERIOD_US;
        for node in &mut self.nodes {
            node.skip_to(latest);
        }
        skipped
    }

    fn collect_all(&mut self) {
        for index in 0..self.nodes.len() {
            self.collect(index);
        }
    }

    fn collect(&mut self, index: usize) {
        while let Some(frame) = self.nodes[index].transmit() {
            self.queue.push_back((Port::Node(index), frame));
        }
    }

    fn deliver(&mut self, monitor: &mut impl FnMut(Port, &CanFrame)) {
        while let Some((from, frame)) = self.queue.pop_front() {
            monitor(from, &frame);
            for index in 0..self.nodes.len() {
                if from != Port::Node(index) && self.nodes[index].receive(&frame) {
                    self.collect(index);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use model_core::plant::board::BoardPlantOptions;

    use super::super::native_node::CAPTURE_VALUES;
    use super::*;
    use canopen::{NodeId, cob_id};
    use embedded_can::Frame as _;

    /// Emergency messages of node 1 with this error code.
    fn count(frames: &[CanFrame], code: u16) -> usize {
        let is_one = |frame: &&CanFrame| {
            frame.raw_id().0 == 0x81 && frame.bytes().starts_with(&code.to_le_bytes())
        };
        frames.iter().filter(is_one).count()
    }

    #[test]
    fn heartbeats_that_a_node_has_not_received_in_a_pause_of_the_computer_are_not_late() {
        let mut buffer = vec![0; CAPTURE_VALUES];
        let id = NodeId::new(1);
        let plant = BoardPlantOptions::default();
        let node = NativeNode::new(1, id, &plant, &mut buffer).expect("a node");
        let mut bus = Bus::new(vec![node]);
        // 1016h:1 monitors node 126 with 300 ms.
        let monitor = [0x23, 0x16, 0x10, 1, 0x2C, 0x01, 126, 0];
        for (id, data) in [
            (cob_id::of_node(cob_id::SDO_REQUEST, 1), &monitor[..]),
            (cob_id::of_node(cob_id::HEARTBEAT, 126), &[5]),
        ] {
            let frame = CanFrame::new(id, data).expect("a frame");
            bus.send(0, frame, |_, _| {});
        }
        let mut frames = Vec::new();
        let mut run = |bus: &mut Bus<'_>, from_us: u64, periods: u64| {
            for period in 0..periods {
                let now_us = from_us + period * PERIOD_US;
                bus.skip_late(now_us);
                bus.step(now_us, |_, frame| frames.push(*frame));
            }
            count(&frames, 0x8130)
        };
        assert_eq!(run(&mut bus, PERIOD_US, 10), 0);
        // Two seconds later; 70 of the periods remain until the heartbeat is late.
        assert_eq!(run(&mut bus, 2_000_000, 55), 0);
        assert_eq!(run(&mut bus, 2_000_000 + 55 * PERIOD_US, 15), 1);
    }
}
