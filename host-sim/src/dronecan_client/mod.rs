//! A client of DroneCAN nodes: it finds them, reads and writes their parameters, commands actuators
//! and receives their telemetry.

mod allocator;
mod error;
mod messages;

use std::collections::BTreeSet;
use std::time::{Duration, Instant};

use canopen::CanFrame;
use dronecan::{
    ACTUATOR_STATUS, ALLOCATION, ARRAY_COMMAND, Assembly, CIRCUIT_STATUS, DataType, FrameId,
    GET_NODE_INFO, GET_SET, Kind, NODE_STATUS, Outbox, Outgoing, Payload, TEMPERATURE, Target,
};
use embedded_can::{Frame as _, Id};

use crate::can::link::{self, Link};
use allocator::Allocator;

pub use error::NodeError;
pub use messages::{ActuatorStatus, Content, NodeInfo, Parameter};

/// What the name of a bus begins with.
const PREFIX: &str = "dronecan:";

/// Node-ID of this client: that of a tool.
const OWN_ID: u8 = 127;

/// Priorities of a request, and of a command.
const REQUEST: u8 = 16;
const COMMAND: u8 = 8;

/// Time within which a node answers, and the number of requests.
const ANSWER: Duration = Duration::from_millis(500);
const TRIES: u32 = 3;

/// Time in which each node sends its status once.
const STATUS: Duration = Duration::from_millis(1200);

/// Time after the last sign of a node without a node-ID.
const QUIET: Duration = Duration::from_millis(2500);

/// Most time of a scan.
const SCAN: Duration = Duration::from_secs(60);

/// The messages that are received.
const MESSAGES: [DataType; 5] = [
    ALLOCATION,
    NODE_STATUS,
    ACTUATOR_STATUS,
    CIRCUIT_STATUS,
    TEMPERATURE,
];

/// The services whose responses are received.
const SERVICES: [DataType; 2] = [GET_NODE_INFO, GET_SET];

/// Whether this is the name of a bus with DroneCAN.
///
/// ```
/// use host_sim::dronecan_client::is_dronecan;
/// assert!(is_dronecan("dronecan:can0") && !is_dronecan("can0"));
/// ```
pub fn is_dronecan(bus: &str) -> bool {
    bus.starts_with(PREFIX)
}

/// A transfer of another node.
struct Received {
    kind: Kind,
    source: u8,
    transfer_id: u8,
    payload: Vec<u8>,
}

/// A client.
pub struct Client {
    bus: String,
    link: Box<dyn Link>,
    assembly: Assembly,
    outbox: Outbox,
    transfer_id: u8,
    start: Instant,
}

impl Client {
    /// Opens a bus: `dronecan:` and the name of one as for CANopen.
    ///
    /// # Errors
    /// The error of the operating system.
    pub fn open(bus: &str, kbit_s: u16) -> Result<Self, NodeError> {
        let name = bus.strip_prefix(PREFIX).unwrap_or(bus);
        let link = link::open(name, kbit_s).map_err(|source| NodeError::Bus {
            bus: name.to_owned(),
            source,
        })?;
        Ok(Self {
            bus: name.to_owned(),
            link,
            assembly: Assembly::new(),
            outbox: Outbox::new(),
            transfer_id: 0,
            start: Instant::now(),
        })
    }

    /// Lists the nodes; if it allocates, nodes that ask for a node-ID get one, unless the bus has
    /// an allocator already.
    ///
    /// # Errors
    /// Those of the bus.
    pub fn scan(&mut self, allocates: bool) -> Result<Vec<NodeInfo>, NodeError> {
        let mut known = BTreeSet::new();
        let mut allocator = Allocator::default();
        let begun = Instant::now();
        let mut end = begun + if allocates { QUIET } else { STATUS };
        while let Some(received) = self.next(end.min(begun + SCAN))? {
            match received.kind {
                Kind::Message(id) if id == NODE_STATUS.id => {
                    known.insert(received.source);
                }
                Kind::Message(id) if id == ALLOCATION.id && allocates => {
                    end = Instant::now() + QUIET;
                    // By then each node with an ID has sent its status.
                    if begun.elapsed() > STATUS
                        && let Some(answer) =
                            allocator.answer(&received.payload, received.source, &known)
                    {
                        known.extend(answer.node);
                        self.send(
                            Kind::Message(ALLOCATION.id),
                            ALLOCATION,
                            REQUEST,
                            &answer.payload,
                        )?;
                    }
                }
                _ => {}
            }
        }
        let infos = known.into_iter().map(|node| self.info(node));
        infos.collect()
    }

    /// What a node is.
    ///
    /// # Errors
    /// Without an answer; those of the bus.
    pub fn info(&mut self, node: u8) -> Result<NodeInfo, NodeError> {
        let answer = self.request(node, GET_NODE_INFO, &Payload::new())?;
        Ok(NodeInfo::read(node, &answer))
    }

    /// All parameters of a node.
    ///
    /// # Errors
    /// Without an answer; those of the bus.
    pub fn parameters(&mut self, node: u8) -> Result<Vec<Parameter>, NodeError> {
        let mut all = Vec::new();
        for index in 0..1 << 13 {
            let answer = self.request(node, GET_SET, &messages::get_by_index(index))?;
            let parameter = Parameter::read(&answer);
            if parameter.name.is_empty() {
                break;
            }
            all.push(parameter);
        }
        Ok(all)
    }

    /// A parameter of a node.
    ///
    /// # Errors
    /// For a name that the node does not have; without an answer; those of the bus.
    pub fn parameter(&mut self, node: u8, name: &str) -> Result<Parameter, NodeError> {
        self.get_set(node, name, Content::Empty)
    }

    /// Writes a parameter of a node; the text is that of a value of the parameter's type.
    ///
    /// # Errors
    /// For another text, and a value that the node does not take; as [`Client::parameter`].
    pub fn set(&mut self, node: u8, name: &str, text: &str) -> Result<(), NodeError> {
        let before = self.parameter(node, name)?;
        let wanted = before.value.parse(text).ok_or_else(|| NodeError::Value {
            name: name.to_owned(),
            value: text.to_owned(),
            expected: before.expected(),
        })?;
        let after = self.get_set(node, name, wanted.clone())?;
        if after.value == wanted {
            return Ok(());
        }
        Err(NodeError::Kept {
            node,
            name: name.to_owned(),
            value: after.value.to_string(),
            expected: after.expected(),
        })
    }

    fn get_set(&mut self, node: u8, name: &str, value: Content) -> Result<Parameter, NodeError> {
        let request = messages::get_set(name, &value);
        let request = request.ok_or_else(|| NodeError::NoParameter(node, name.to_owned()))?;
        let parameter = Parameter::read(&self.request(node, GET_SET, &request)?);
        if parameter.name != name {
            return Err(NodeError::NoParameter(node, name.to_owned()));
        }
        Ok(parameter)
    }

    /// The next status of the actuator of a node.
    ///
    /// # Errors
    /// If none comes; those of the bus.
    pub fn status(&mut self, node: u8) -> Result<ActuatorStatus, NodeError> {
        let end = Instant::now() + STATUS;
        while let Some(received) = self.next(end)? {
            if received.source == node && received.kind == Kind::Message(ACTUATOR_STATUS.id) {
                return Ok(ActuatorStatus::read(&received.payload));
            }
        }
        Err(NodeError::NoStatus(node))
    }

    /// Commands an actuator by its actuator-ID. It has to be repeated within the time-out of the
    /// actuator.
    ///
    /// # Errors
    /// Those of the bus.
    pub fn command(&mut self, actuator: u8, target: Target) -> Result<(), NodeError> {
        let payload = messages::command(actuator, target);
        self.send(
            Kind::Message(ARRAY_COMMAND.id),
            ARRAY_COMMAND,
            COMMAND,
            &payload,
        )
    }

    fn request(
        &mut self,
        node: u8,
        data_type: DataType,
        payload: &Payload,
    ) -> Result<Vec<u8>, NodeError> {
        let service = data_type.id as u8;
        for _ in 0..TRIES {
            self.send(
                Kind::Request { service, to: node },
                data_type,
                REQUEST,
                payload,
            )?;
            let (sent, end) = (self.transfer_id, Instant::now() + ANSWER);
            while let Some(received) = self.next(end)? {
                let is_answer = received.kind
                    == Kind::Response {
                        service,
                        to: OWN_ID,
                    };
                if is_answer && received.source == node && received.transfer_id == sent {
                    return Ok(received.payload);
                }
            }
        }
        Err(NodeError::NoAnswer(node))
    }

    fn send(
        &mut self,
        kind: Kind,
        data_type: DataType,
        priority: u8,
        payload: &Payload,
    ) -> Result<(), NodeError> {
        self.transfer_id = (self.transfer_id + 1) & 0x1F;
        self.outbox.push(&Outgoing {
            id: FrameId {
                priority,
                kind,
                source: OWN_ID,
            },
            transfer_id: self.transfer_id,
            data_type,
            payload: payload.bytes(),
        });
        while let Some(frame) = self.outbox.pop::<CanFrame>() {
            let sent = self.link.send(&frame);
            sent.map_err(|source| self.failed(source))?;
        }
        Ok(())
    }

    /// The next transfer, if one is complete in time.
    fn next(&mut self, end: Instant) -> Result<Option<Received>, NodeError> {
        loop {
            let left = end.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return Ok(None);
            }
            let frame = self.link.receive(left);
            let frame = frame.map_err(|source| self.failed(source))?;
            if let Some(received) = frame.and_then(|frame| self.take(&frame)) {
                return Ok(Some(received));
            }
        }
    }

    fn take(&mut self, frame: &CanFrame) -> Option<Received> {
        let Id::Extended(id) = frame.id() else {
            return None;
        };
        let id = FrameId::parse(id).filter(|_| frame.is_data_frame())?;
        let now_us = self.start.elapsed().as_micros() as u64;
        let transfer = self
            .assembly
            .receive(id, data_type(id.kind)?, frame.data(), now_us)?;
        Some(Received {
            kind: id.kind,
            source: id.source,
            transfer_id: transfer.transfer_id,
            payload: transfer.payload.to_vec(),
        })
    }

    fn failed(&self, source: std::io::Error) -> NodeError {
        NodeError::Bus {
            bus: self.bus.clone(),
            source,
        }
    }
}

/// The data type of a transfer that is received.
fn data_type(kind: Kind) -> Option<DataType> {
    let (types, id): (&[DataType], u16) = match kind {
        Kind::Message(id) => (&MESSAGES, id),
        Kind::Response {
            service,
            to: OWN_ID,
        } => (&SERVICES, service.into()),
        _ => return None,
    };
    types.iter().copied().find(|data_type| data_type.id == id)
}
