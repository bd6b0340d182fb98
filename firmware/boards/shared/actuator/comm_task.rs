//! The communication on the board: CANopen node and drive, and their connections to the other
//! tasks.

mod exchange;

use canopen::{CanFrame, NmtState, NodeId};
use drivers::can::AcceptedIds;
use embedded_can::{Frame as _, Id};
use firmware::{
    drive::{Device, Messages, ServoBus, StoredParameters},
    timing::{COMMUNICATION_PERIODS, periods},
};

use super::{
    bus_status,
    mailboxes::{Mailboxes, Poster, Reader, Telemetry},
    queues::CommEnds,
    timing::UPDATE_PERIOD_US,
};
use crate::peripherals::Acceptance;

/// Length of the capture buffer, words: 22 s of eight signals at 250 Hz. An image that is
/// downloaded lies there until it is staged.
pub const CAPTURE_WORDS: usize = 44 * 1024;

/// Communication cycles without outputs of the loop after which what the node knows is old, 20 ms.
const OLD_CYCLES: usize = COMMUNICATION_PERIODS.len() * periods(20) as usize;

/// NMT state and node-ID, with CANopen or with DroneCAN.
type Identity = (NmtState, Option<NodeId>, Option<u8>);

/// Node, drive, and their connections to the other tasks.
pub struct CommTask {
    device: &'static mut Device<'static>,
    poster: Poster,
    reader: Reader,
    queues: CommEnds,
    /// Memory for the set of the next save; none while a save runs.
    set_to_save: Option<&'static mut StoredParameters>,
    /// The filter of the frames that the controller receives.
    acceptance: Acceptance,
    accepted_ids: AcceptedIds,
    /// That with which they were determined.
    identity: Identity,
    /// Cycles since the last valid outputs of the loop.
    cycles_without_outputs: usize,
    /// Number of the update period of the last cycle, and its time, us.
    last_cycle: (u32, u64),
    /// Cycles in which process data has waited without a frame leaving the board, and the number of
    /// frames that had left it before.
    waited: (usize, u32),
    /// Process data has waited since an earlier cycle.
    has_backlog: bool,
    /// Discarded frames that were reported to the device.
    discarded: u32,
}

impl CommTask {
    /// The task of a device, with the filter of its frames.
    pub fn new(
        device: &'static mut Device<'static>,
        (poster, reader): (Poster, Reader),
        queues: CommEnds,
        set_to_save: &'static mut StoredParameters,
        (acceptance, accepted_ids): (Acceptance, AcceptedIds),
    ) -> Self {
        Self {
            device,
            poster,
            reader,
            queues,
            set_to_save: Some(set_to_save),
            acceptance,
            accepted_ids,
            identity: (NmtState::Initialising, None, None),
            cycles_without_outputs: 0,
            last_cycle: (0, 0),
            waited: (0, 0),
            has_backlog: false,
            discarded: 0,
        }
    }

    /// A communication cycle, in the update period of this number. Returns whether there are frames
    /// to transmit.
    pub fn communicate(
        &mut self,
        period: u32,
        (mailboxes, telemetry, servo_bus): (
            &mut impl rtic::Mutex<T = Mailboxes>,
            &mut impl rtic::Mutex<T = Telemetry>,
            &mut impl rtic::Mutex<T = Option<&'static mut ServoBus>>,
        ),
    ) -> bool {
        let outputs = self.reader.take(telemetry);
        let has_outputs = outputs.is_some();
        self.cycles_without_outputs = self.cycles_without_outputs.saturating_add(1);
        if let Some(outputs) = outputs {
            self.cycles_without_outputs = 0;
            self.device.observe(outputs);
            self.update_diagnostics();
        }
        let now_us = self.time_us(period);
        self.discard_stale();
        self.has_backlog = self.queues.process_data.len() > 0;
        let has_service = process_frames(self, now_us);
        servo_bus.lock(|bus| {
            if let Some(bus) = bus {
                bus.exchange(&mut self.device.drive);
            }
        });
        self.exchange_with_store();
        self.exchange_with_updater();
        self.forward_bit_rate();
        // Only a service, or its end, changes the identifiers.
        let identity = self.identity();
        let is_changed = has_service || identity != self.identity;
        if is_changed {
            self.identity = identity;
            self.accepted_ids = AcceptedIds::of(self.device);
        }
        // With the outputs of each control period: it restores a register that has changed.
        if is_changed || has_outputs {
            self.acceptance.set(&self.accepted_ids);
        }
        self.poster.post(&self.device.drive.messages, mailboxes);
        self.queues.to_transmit.len() > 0 || self.queues.process_data.len() > 0
    }

    fn identity(&self) -> Identity {
        let node = self.device.node();
        let dronecan = self.device.dronecan().and_then(|node| node.node_id());
        (node.state(), node.node_id(), dronecan)
    }

    /// Time of an update period from its number, which has 31 bits and wraps.
    fn time_us(&mut self, period: u32) -> u64 {
        let (last_period, last_us) = self.last_cycle;
        let elapsed = period.wrapping_sub(last_period) & (u32::MAX >> 1);
        let now_us = last_us.wrapping_add(u64::from(elapsed) * u64::from(UPDATE_PERIOD_US));
        self.last_cycle = (period, now_us);
        now_us
    }

    /// Processes the next received frame. Process data, which commands the drive at once, is
    /// applied twice from the same commands, each time read from the queue: if the results differ,
    /// a frame would act that no master has sent. A frame of DroneCAN, which may be a part of a
    /// transfer, is processed once. Returns whether the frame is process data.
    fn receive(&mut self, now_us: u64) -> bool {
        let is_canopen = self.device.dronecan().is_none();
        let process_data = self.queues.received.peek().filter(|f| is_process_data(f));
        let is_process_data = process_data.is_some();
        let repeated = process_data
            .filter(|_| is_canopen)
            .filter(|frame| !self.device.node().is_sync(frame.id()));
        let requests = self.device.drive.messages.excitation.changes();
        let once = repeated.map(|frame| {
            let drive = &self.device.drive;
            let (commands, points) = (drive.messages.commands, drive.points.waiting());
            self.device.receive(frame, now_us);
            let drive = &mut self.device.drive;
            let once = effect(&drive.messages, requests);
            drive.messages.commands = commands;
            drive.points.truncate(points);
            once
        });
        let requests = self.device.drive.messages.excitation.changes();
        if let Some(frame) = self.queues.received.dequeue() {
            self.device.receive(&frame, now_us);
        }
        let messages = &mut self.device.drive.messages;
        if once.is_some_and(|once| once != effect(messages, requests)) {
            messages.commands.invalidate();
        }
        is_process_data
    }

    /// Queues as many frames as there is room for; the others remain in the node. An EMCY goes
    /// before all process data: if some waits since an earlier cycle it is discarded, also from the
    /// mailboxes, and sampled again. Process data of this cycle is not: a reply to SYNC would be
    /// lost. Process data that would report an old state, and frames of DroneCAN, are discarded:
    /// their master detects that they stay away.
    fn queue_frames(&mut self) {
        let is_old = self.cycles_without_outputs > OLD_CYCLES;
        while self.queues.to_transmit.ready()
            && self.queues.process_data.ready()
            && let Some(frame) = self.device.transmit::<CanFrame>()
        {
            let node = self.device.node();
            let is_process_data = node.is_process_data(frame.id());
            if is_old && (is_process_data || self.device.dronecan().is_some()) {
                continue;
            }
            // There is room.
            let _ = if is_process_data {
                self.queues.process_data.enqueue(frame)
            } else {
                if node.is_emergency(frame.id()) && self.has_backlog {
                    bus_status::request_discard();
                }
                self.queues.to_transmit.enqueue(frame)
            };
        }
    }
}

/// What a frame has changed: the check value of the commands, one of those of their queue, and the
/// number of requests of an excitation since there were so many.
fn effect(messages: &Messages, requests: u32) -> (u32, u32, u32) {
    let (commands, excitation) = (&messages.commands, &messages.excitation);
    (
        commands.check(),
        commands.unverified().check_of_queue(),
        excitation.changes().wrapping_sub(requests),
    )
}

/// Whether a frame is no service: not NMT, SDO, the heartbeat of another node or LSS, whose
/// identifiers no PDO may have (CiA 301, 7.3.5, restricted CAN-IDs).
fn is_process_data(frame: &CanFrame) -> bool {
    match frame.id() {
        Id::Standard(id) => !matches!(id.as_raw(), 0 | 0x600..=0x67F | 0x700..),
        Id::Extended(_) => true,
    }
}

/// Processes the received frames and due events, and queues the frames to be transmitted; returns
/// whether there was a service among the received frames. Not inlined and with a fixed symbol, so
/// that the emulator counts its instructions.
#[unsafe(no_mangle)]
#[inline(never)]
fn process_frames(task: &mut CommTask, now_us: u64) -> bool {
    // Frames that arrive meanwhile wait for the next cycle, so that this one ends.
    let received = task.queues.received.len();
    let mut has_service = false;
    for _ in 0..received {
        has_service |= !task.receive(now_us);
        task.queue_frames();
    }
    task.device.communicate(now_us);
    task.queue_frames();
    has_service
}
