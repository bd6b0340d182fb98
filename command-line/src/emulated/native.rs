//! Native actuators on the bus of the emulated boards.

use std::sync::mpsc::Receiver;

use canopen::{CanFrame, NodeId};
use host_sim::can::native_node::{CAPTURE_VALUES, NativeNode};
use host_sim::can::node_fault::Change;
use model_core::plant::board::BoardPlantOptions;
use virtual_board::can::{Frame, Id, Port};
use virtual_board::run::SharedBus;

/// Frames that wait for the bus, as in the mailboxes of a controller; further ones wait in the
/// actuator, which knows which of them are obsolete.
const MAILBOXES: usize = 3;

/// The actuators, each of which has the port of its place.
pub struct NativeActuators {
    bus: SharedBus,
    /// Each with its faults at run time.
    nodes: Vec<(NativeNode<'static>, Receiver<Change>)>,
}

impl NativeActuators {
    /// Actuators with these numbers and plants, at the first ports of this bus.
    ///
    /// # Errors
    /// For a parameter of a plant that is out of range.
    pub fn new(
        bus: SharedBus,
        plants: Vec<(u8, BoardPlantOptions, Receiver<Change>)>,
        has_dronecan: bool,
    ) -> Result<Self, String> {
        let node = |(number, plant, faults): (u8, BoardPlantOptions, _)| {
            // As long as the program runs, as the boards.
            let capture = vec![0; CAPTURE_VALUES].leak();
            let node = match has_dronecan {
                true => NativeNode::with_dronecan(number, &plant, capture),
                false => NativeNode::new(number.into(), NodeId::new(number), &plant, capture),
            };
            node.map(|node| (node, faults))
        };
        let nodes = plants.into_iter().map(node).collect::<Result<_, _>>();
        let nodes = nodes.map_err(|error| error.to_string())?;
        Ok(Self { bus, nodes })
    }

    /// Receives, runs the control period that is due, and transmits.
    pub fn poll(&mut self, now_ns: u64) {
        for (port, (node, faults)) in self.nodes.iter_mut().enumerate() {
            faults.try_iter().for_each(|change| node.apply(change));
            self.bus.with_port(port, |port| {
                for frame in port.take_received().iter().filter_map(received) {
                    node.receive(&frame);
                }
                node.step(now_ns / 1000);
                transmit(node, port, now_ns);
            });
        }
    }
}

fn transmit(node: &mut NativeNode<'_>, port: &mut Port, now_ns: u64) {
    while port.queued() < MAILBOXES
        && let Some(frame) = node.transmit()
    {
        port.send(now_ns, sent(&frame));
    }
}

fn received((_, frame): &(u64, Frame)) -> Option<CanFrame> {
    let is_extended = matches!(frame.id, Id::Extended(_));
    let length = frame.dlc.min(8);
    CanFrame::raw(
        frame.id.value(),
        is_extended,
        frame.remote,
        length,
        frame.data,
    )
}

fn sent(frame: &CanFrame) -> Frame {
    let id = match frame.raw_id() {
        (id, true) => Id::Extended(id),
        (id, false) => Id::Standard(id as u16),
    };
    Frame::data_frame(id, embedded_can::Frame::data(frame))
}
