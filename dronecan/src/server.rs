//! What the node answers, and what it sends by itself.

use core::task::Poll;

use crate::allocation::{Allocation, MOST};
use crate::application::{Application, Opcode, Telemetry};
use crate::assembly::Transfer;
use crate::data_types::{
    ACTUATOR_STATUS, ALLOCATION, BEGIN_FIRMWARE_UPDATE, CIRCUIT_STATUS, DataType, EXECUTE_OPCODE,
    FILE_READ, GET_NODE_INFO, GET_SET, LOG_MESSAGE, NODE_STATUS, RESTART_NODE, TEMPERATURE,
};
use crate::download::{Download, Progress};
use crate::node::Settings;
use crate::outbox::{Outbox, Outgoing, TransferIds, priority};
use crate::services::{self, put_status};
use crate::{FrameId, Kind, Payload};

/// Period of the node's status, us.
const STATUS_US: u64 = 1_000_000;

/// Statuses of the actuator until the next one of its circuit.
const CIRCUIT_DIVISOR: u8 = 5;

/// A request whose response takes time.
#[derive(Debug, Clone, Copy)]
struct Pending {
    opcode: Opcode,
    request: Request,
}

/// A request that is to be answered.
#[derive(Debug, Clone, Copy)]
struct Request {
    id: FrameId,
    transfer_id: u8,
}

/// The node without the reception of frames.
#[derive(Debug)]
pub(crate) struct Server {
    settings: Settings,
    /// 0 while it has none.
    pub node_id: u8,
    allocation: Allocation,
    pub outbox: Outbox,
    transfer_ids: TransferIds,
    started_us: u64,
    status_due_us: u64,
    telemetry_due_us: u64,
    until_circuit: u8,
    pending: Option<Pending>,
    download: Option<Download>,
    is_restarting: bool,
}

impl Server {
    pub fn new(settings: Settings, app: &impl Application, now_us: u64) -> Self {
        let is_fixed = (1..=MOST).contains(&settings.node_id);
        Self {
            settings,
            node_id: if is_fixed { settings.node_id } else { 0 },
            allocation: Allocation::new(&app.unique_id(), now_us),
            outbox: Outbox::new(),
            transfer_ids: TransferIds::default(),
            started_us: now_us,
            status_due_us: now_us,
            telemetry_due_us: now_us,
            until_circuit: 0,
            pending: None,
            download: None,
            is_restarting: false,
        }
    }

    /// Takes a transfer.
    pub fn receive(&mut self, transfer: &Transfer<'_>, now_us: u64, app: &mut impl Application) {
        let Transfer { id, payload, .. } = *transfer;
        match id.kind {
            Kind::Message(data_type) if data_type == ALLOCATION.id => {
                self.allocate(id.source, payload, now_us, app);
            }
            Kind::Message(_) if id.source != 0 => {
                services::commands(payload, |actuator_id, target| {
                    app.command(actuator_id, target);
                });
            }
            Kind::Message(_) => {}
            Kind::Request { service, .. } => {
                let request = Request {
                    id,
                    transfer_id: transfer.transfer_id,
                };
                self.serve(service.into(), request, payload, now_us, app);
            }
            Kind::Response { .. } => {
                if let Some(download) = &mut self.download
                    && download.server() == id.source
                    && download.receive(transfer.transfer_id, payload, now_us, app)
                        == Progress::Ended
                {
                    self.download = None;
                }
            }
        }
    }

    fn allocate(&mut self, from: u8, payload: &[u8], now_us: u64, app: &impl Application) {
        if self.node_id != 0 {
            return;
        }
        let allocated = (self.allocation).receive(&app.unique_id(), payload, from != 0, now_us);
        if let Some(node_id) = allocated {
            self.node_id = node_id;
            (self.status_due_us, self.telemetry_due_us) = (now_us, now_us);
        }
    }

    fn serve(
        &mut self,
        service: u16,
        request: Request,
        payload: &[u8],
        now_us: u64,
        app: &mut impl Application,
    ) {
        let (data_type, response) = match service {
            _ if service == GET_NODE_INFO.id => {
                let uptime_s = self.uptime_s(now_us);
                (GET_NODE_INFO, services::node_info(app, uptime_s))
            }
            _ if service == GET_SET.id => match services::get_set(app, payload) {
                Some(response) => (GET_SET, response),
                None => return,
            },
            _ if service == EXECUTE_OPCODE.id => {
                match services::opcode(payload).filter(|_| self.pending.is_none()) {
                    // Answered when it is done; one that comes meanwhile is refused.
                    Some(opcode) => return self.pending = Some(Pending { opcode, request }),
                    None => (EXECUTE_OPCODE, services::executed(false)),
                }
            }
            _ if service == RESTART_NODE.id => {
                self.is_restarting |= services::is_restart(payload);
                (RESTART_NODE, services::restarted(self.is_restarting))
            }
            _ => {
                let refused = self.begin_update(payload, request.id.source, now_us, app);
                (BEGIN_FIRMWARE_UPDATE, services::update_begun(refused))
            }
        };
        self.respond(data_type, request, &response);
    }

    /// Begins a download; returns the number of the error and its reason if that is refused.
    fn begin_update(
        &mut self,
        payload: &[u8],
        from: u8,
        now_us: u64,
        app: &mut impl Application,
    ) -> Option<(u8, &'static str)> {
        if self.download.is_some() {
            return Some((2, "a download is in progress"));
        }
        let Some(download) = Download::new(payload, from, now_us) else {
            return Some((255, "the path is too long"));
        };
        if let Err(reason) = app.begin_update() {
            return Some((1, reason));
        }
        self.download = Some(download);
        None
    }

    /// Does what is due; returns whether the node shall restart.
    pub fn tick(&mut self, now_us: u64, app: &mut impl Application) -> bool {
        if self.node_id == 0 {
            self.request_node_id(now_us, app);
            return false;
        }
        self.finish_opcode(app);
        self.read_file(now_us, app);
        if now_us >= self.status_due_us {
            self.status_due_us = now_us.saturating_add(STATUS_US);
            let mut payload = Payload::new();
            put_status(&mut payload, app.status(), self.uptime_s(now_us));
            self.publish(NODE_STATUS, priority::SLOW, &payload);
            self.publish(
                TEMPERATURE,
                priority::SLOW,
                &services::temperature(&app.telemetry()),
            );
        }
        let period_us = u64::from(self.settings.status_period_us);
        if period_us > 0 && now_us >= self.telemetry_due_us {
            // Without drift, and without a burst after a gap.
            let next_us = self.telemetry_due_us.saturating_add(period_us);
            self.telemetry_due_us = next_us.max(now_us.saturating_sub(period_us));
            self.report(&app.telemetry());
        }
        self.log(app);
        self.is_restarting && self.outbox.is_empty()
    }

    /// Publishes the status of the actuator, and sometimes that of its circuit.
    fn report(&mut self, telemetry: &Telemetry) {
        // What could not leave the board would be old when it does.
        if !self.outbox.is_empty() {
            return;
        }
        let status = services::actuator_status(telemetry);
        self.publish(ACTUATOR_STATUS, priority::STATUS, &status);
        self.until_circuit = match self.until_circuit.checked_sub(1) {
            Some(left) => left,
            None => {
                let circuit = services::circuit_status(telemetry);
                self.publish(CIRCUIT_STATUS, priority::SLOW, &circuit);
                CIRCUIT_DIVISOR - 1
            }
        };
    }

    fn request_node_id(&mut self, now_us: u64, app: &impl Application) {
        if let Some(payload) = self.allocation.poll(&app.unique_id(), now_us) {
            self.publish(ALLOCATION, priority::LOWEST, &payload);
        }
    }

    fn finish_opcode(&mut self, app: &mut impl Application) {
        if let Some(Pending { opcode, request }) = self.pending
            && let Poll::Ready(is_done) = app.perform(opcode)
        {
            self.pending = None;
            self.respond(EXECUTE_OPCODE, request, &services::executed(is_done));
        }
    }

    fn read_file(&mut self, now_us: u64, app: &mut impl Application) {
        let Some(download) = &mut self.download else {
            return;
        };
        if download.is_abandoned(now_us) {
            self.download = None;
            return app.cancel_update();
        }
        let number = { self.transfer_ids }.next(FILE_READ);
        let Some(payload) = download.poll(number, now_us) else {
            return;
        };
        let kind = Kind::Request {
            service: FILE_READ.id as u8,
            to: download.server(),
        };
        self.send(FILE_READ, priority::SLOW, kind, &payload);
    }

    fn log(&mut self, app: &mut impl Application) {
        let mut text = [0; 32];
        if let Some((level, length)) = app.take_log(&mut text) {
            let text = text.get(..length).unwrap_or(&[]);
            self.publish(LOG_MESSAGE, priority::LOWEST, &services::log(level, text));
        }
    }

    fn uptime_s(&self, now_us: u64) -> u32 {
        (now_us.saturating_sub(self.started_us) / 1_000_000) as u32
    }

    fn publish(&mut self, data_type: DataType, priority: u8, payload: &Payload) {
        self.send(data_type, priority, Kind::Message(data_type.id), payload);
    }

    /// Begins a transfer, unless there is no room for it.
    fn send(&mut self, data_type: DataType, priority: u8, kind: Kind, payload: &Payload) {
        let id = FrameId {
            priority,
            kind,
            source: self.node_id,
        };
        let transfer_id = self.transfer_ids.next(data_type);
        self.outbox.push(&Outgoing {
            id,
            transfer_id,
            data_type,
            payload: payload.bytes(),
        });
    }

    fn respond(&mut self, data_type: DataType, request: Request, payload: &Payload) {
        let id = FrameId {
            priority: request.id.priority,
            kind: Kind::Response {
                service: data_type.id as u8,
                to: request.id.source,
            },
            source: self.node_id,
        };
        self.outbox.push(&Outgoing {
            id,
            transfer_id: request.transfer_id,
            data_type,
            payload: payload.bytes(),
        });
    }
}
