//! Dispatch of received frames to the services.

use embedded_can::Frame;

use super::Node;
use crate::application::{Application, Event, Reset};
use crate::cob_id;
use crate::dictionary::Address;
use crate::emergency::{Emergency, ErrorCode};
use crate::heartbeat::HeartbeatEvent;
use crate::message::Message;
use crate::nmt::{NmtState, NodeId};
use crate::{lss, nmt};

impl<const R: usize, const T: usize> Node<R, T> {
    /// Processes a received frame; `now_us` is the time of the call in microseconds.
    pub fn receive(&mut self, frame: &impl Frame, now_us: u64, app: &mut impl Application) {
        self.advance(now_us);
        if let Some(message) = Message::from_frame(frame) {
            self.dispatch(&message, app);
        }
    }

    fn dispatch(&mut self, message: &Message, app: &mut impl Application) {
        if message.id == lss::REQUEST && !message.remote {
            if message.length == 8 {
                self.layer_setting(message.data, app);
            }
            return;
        }
        let Some(node_id) = self.node_id else { return };
        if message.id == 0 {
            if !message.remote
                && let Some(command) = nmt::command(message.payload(), node_id)
                && (self.state != NmtState::Initialising
                    || !matches!(command, nmt::Command::Enter(_)))
            {
                self.apply_nmt_command(command, app);
            }
            return;
        }
        if self.state == NmtState::Initialising {
            return;
        }
        if let 0x701..=0x77F = message.id {
            return self.heartbeat(message, app);
        }
        if self.state.communicates() {
            self.communicate(message, node_id, app);
        }
    }

    fn communicate(&mut self, message: &Message, node_id: NodeId, app: &mut impl Application) {
        if message.id == cob_id::SDO_REQUEST + u32::from(node_id.get()) {
            if message.length == 8 && !message.remote {
                let (mut objects, sdo) = self.split(app);
                sdo.receive(&message.data, &mut objects);
            }
            return;
        }
        if self.services.sync.is_for(message) {
            let sync = self.services.sync.receive(message.payload());
            self.sync(sync, app);
        } else if let Some(time) = self.services.time.receive(message) {
            app.event(Event::Time(time));
        } else if self.state == NmtState::Operational {
            self.receive_process_data(message, app);
        }
    }

    /// Node guarding (remote frames) is not supported, as CiA 301 permits.
    fn heartbeat(&mut self, message: &Message, app: &mut impl Application) {
        let [state] = message.payload() else { return };
        if message.remote {
            return;
        }
        let node = (message.id & 0x7F) as u8;
        if let Some(event) = self.services.consumers.receive(node, *state) {
            self.heartbeat_event(event, app);
        }
    }

    pub(super) fn heartbeat_event(&mut self, event: HeartbeatEvent, app: &mut impl Application) {
        match event {
            HeartbeatEvent::Started { node, recovered } => {
                if recovered {
                    self.clear(ErrorCode::HEARTBEAT, node);
                }
                app.event(Event::HeartbeatStarted(node));
            }
            HeartbeatEvent::Lost { node } => {
                self.raise(Emergency::communication(ErrorCode::HEARTBEAT, node), app);
                app.event(Event::HeartbeatLost(node));
                self.communication_error(app);
            }
        }
    }

    fn layer_setting(&mut self, request: [u8; 8], app: &mut impl Application) {
        let identity = self.identity(app);
        let outcome = self.lss.receive(request, identity, self.node_id, app);
        match outcome {
            lss::Outcome::Nothing => {}
            lss::Outcome::NodeIdChanged => app.event(Event::NodeId(self.lss.node_id())),
            lss::Outcome::BootUp => self.reset(Reset::Communication, app),
        }
    }

    /// The identity object 1018h.
    fn identity(&mut self, app: &mut impl Application) -> lss::Identity {
        let dictionary = self.dictionary;
        let (mut objects, _) = self.split(app);
        [1, 2, 3, 4].map(|sub| {
            let entry = dictionary.find(Address::new(0x1018, sub));
            entry
                .and_then(|entry| objects.read_number(entry))
                .unwrap_or(0) as u32
        })
    }
}
