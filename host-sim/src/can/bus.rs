//! A bus without errors and without arbitration: every frame reaches every participant but its
//! sender, in order.

use std::collections::VecDeque;

use canopen::CanFrame;

use super::native_node::{NativeNode, PERIOD_US};

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
}

impl<'a> Bus<'a> {
    /// A bus with these actuators.
    pub fn new(nodes: Vec<NativeNode<'a>>) -> Self {
        let mut bus = Self {
            nodes,
            queue: VecDeque::new(),
        };
        bus.collect();
        bus
    }

    /// Queues a frame of a client.
    pub fn send(&mut self, from: u64, frame: CanFrame) {
        self.queue.push_back((Port::Client(from), frame));
    }

    /// Runs the control periods that are due and delivers all frames; `monitor` gets each frame
    /// with its sender.
    pub fn run(&mut self, now_us: u64, mut monitor: impl FnMut(Port, &CanFrame)) {
        self.deliver(&mut monitor);
        let latest = now_us.saturating_sub(MAX_LATE_PERIODS * PERIOD_US);
        for node in &mut self.nodes {
            node.skip_to(latest);
        }
        while self.step(now_us) {
            self.collect();
            self.deliver(&mut monitor);
        }
    }

    fn step(&mut self, now_us: u64) -> bool {
        let steps = self.nodes.iter_mut().map(|node| node.step(now_us));
        steps.fold(false, |any, stepped| any | stepped)
    }

    fn collect(&mut self) {
        for (index, node) in self.nodes.iter_mut().enumerate() {
            while let Some(frame) = node.transmit() {
                self.queue.push_back((Port::Node(index), frame));
            }
        }
    }

    fn deliver(&mut self, monitor: &mut impl FnMut(Port, &CanFrame)) {
        while let Some((from, frame)) = self.queue.pop_front() {
            monitor(from, &frame);
            for (index, node) in self.nodes.iter_mut().enumerate() {
                if from != Port::Node(index) {
                    node.receive(&frame);
                }
            }
            self.collect();
        }
    }
}
