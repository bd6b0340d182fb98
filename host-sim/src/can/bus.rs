//! A bus without errors and without arbitration: every frame reaches everybody but its sender, in order.

use std::collections::VecDeque;

use canopen::CanFrame;

use super::native_node::{NativeNode, PERIOD_US};

/// Control periods that are made up for after a pause, far fewer than a command lasts; more are skipped, as a computer that
/// slept is no fault of a master.
const MOST_BEHIND: u64 = 5;

/// Who is on the bus.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Port {
    /// An actuator, by its place.
    Node(usize),
    /// A client, by its number.
    Client(u64),
}

/// Actuators on a bus.
pub struct Bus<'a> {
    nodes: Vec<NativeNode<'a>>,
    waiting: VecDeque<(Port, CanFrame)>,
}

impl<'a> Bus<'a> {
    /// With these actuators.
    pub fn new(nodes: Vec<NativeNode<'a>>) -> Self {
        let mut bus = Self {
            nodes,
            waiting: VecDeque::new(),
        };
        bus.collect();
        bus
    }

    /// A client sends.
    pub fn send(&mut self, from: u64, frame: CanFrame) {
        self.waiting.push_back((Port::Client(from), frame));
    }

    /// Runs the control periods that are due, and delivers all frames; `hear` hears each, with its sender.
    pub fn run(&mut self, now_us: u64, mut hear: impl FnMut(Port, &CanFrame)) {
        self.deliver(&mut hear);
        let latest = now_us.saturating_sub(MOST_BEHIND * PERIOD_US);
        for node in &mut self.nodes {
            node.skip_to(latest);
        }
        while self.step(now_us) {
            self.collect();
            self.deliver(&mut hear);
        }
    }

    fn step(&mut self, now_us: u64) -> bool {
        let steps = self.nodes.iter_mut().map(|node| node.step(now_us));
        steps.fold(false, |any, stepped| any | stepped)
    }

    fn collect(&mut self) {
        for (place, node) in self.nodes.iter_mut().enumerate() {
            while let Some(frame) = node.transmit() {
                self.waiting.push_back((Port::Node(place), frame));
            }
        }
    }

    fn deliver(&mut self, hear: &mut impl FnMut(Port, &CanFrame)) {
        while let Some((from, frame)) = self.waiting.pop_front() {
            hear(from, &frame);
            for (place, node) in self.nodes.iter_mut().enumerate() {
                if from != Port::Node(place) {
                    node.receive(&frame);
                }
            }
            self.collect();
        }
    }

    /// The angles of the shafts, deg.
    pub fn angles_deg(&self) -> Vec<f64> {
        self.nodes.iter().map(NativeNode::angle_deg).collect()
    }
}
