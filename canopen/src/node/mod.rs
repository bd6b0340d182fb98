//! The CANopen node: receives frames and time, returns frames.

mod identifiers;
mod process_data;
mod receive;
mod state;

pub use identifiers::SERVICE_IDENTIFIERS;

use embedded_can::Frame;

use crate::application::{Application, Event};
use crate::cob_id;
use crate::dictionary::Dictionary;
use crate::emergency::{Emergency, ErrorCode};
use crate::message::Message;
use crate::nmt::{NmtState, NodeId};
use crate::objects::Objects;
use crate::services::Services;
use crate::timer::Timer;
use crate::{lss, sdo};

/// State change reported by the CAN controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BusEvent {
    /// Received frames were lost.
    Overrun,
    /// The controller became error passive.
    ErrorPassive,
    /// The controller is error active again, or its receive queue has room again.
    Recovered,
    /// The controller went bus-off.
    BusOff,
    /// The controller recovered from bus-off.
    BusOffRecovered,
}

/// A CANopen device with `R` RPDOs and `T` TPDOs.
///
/// The node performs no I/O and reads no clock. Call [`Node::receive`] with each received frame,
/// [`Node::tick`] about once a millisecond or once per control period, and [`Node::transmit`] until
/// it returns `None` or the CAN controller accepts no more frames. Times are in microseconds of one
/// monotonic clock with any origin. The work in each call is bounded.
#[derive(Debug)]
pub struct Node<const R: usize, const T: usize> {
    state: NmtState,
    /// Node-ID in use since the last reset communication.
    node_id: Option<NodeId>,
    dictionary: &'static Dictionary,
    now_us: u64,
    lss: lss::LssSlave,
    services: Services<R, T>,
    sdo: sdo::SdoServer,
}

/// RAM of a node; it uses no other.
#[cfg(target_pointer_width = "32")]
const _: () = assert!(size_of::<Node<4, 4>>() <= 1792);

impl<const R: usize, const T: usize> Node<R, T> {
    /// Creates a node in its power-on state. Without a node-ID it waits for LSS to assign one.
    pub fn new(
        dictionary: &'static Dictionary,
        node_id: Option<NodeId>,
        app: &mut impl Application,
        now_us: u64,
    ) -> Self {
        let mut node = Self {
            dictionary,
            node_id,
            state: NmtState::Initialising,
            services: Services::NEW,
            sdo: sdo::SdoServer::NEW,
            lss: lss::LssSlave::new(node_id),
            now_us,
        };
        node.reset(crate::application::Reset::Node, app);
        node
    }

    /// Node-ID in use.
    #[must_use]
    pub const fn node_id(&self) -> Option<NodeId> {
        self.node_id
    }

    /// NMT state.
    #[must_use]
    pub const fn state(&self) -> NmtState {
        self.state
    }

    /// Error register 1001h.
    #[must_use]
    pub fn error_register(&self) -> u8 {
        self.services.emergency.register()
    }

    fn node_id_number(&self) -> u8 {
        self.node_id.map_or(0, NodeId::get)
    }

    /// Borrows the objects and, separately, the SDO server.
    fn split<'a, A: Application>(
        &'a mut self,
        app: &'a mut A,
    ) -> (Objects<'a, A, R, T>, &'a mut sdo::SdoServer) {
        let node_id = self.node_id_number();
        let Self {
            dictionary,
            services,
            sdo,
            ..
        } = self;
        (
            Objects {
                dictionary,
                services,
                app,
                node_id,
            },
            sdo,
        )
    }

    /// Raises an error: transmits an EMCY and updates 1001h and 1003h. An error that is already
    /// active is not raised again.
    pub fn raise(&mut self, error: Emergency, app: &mut impl Application) {
        if self.services.emergency.raise(error) {
            app.event(Event::Error(error.code));
        }
    }

    /// Clears an error: transmits an EMCY "error reset".
    pub fn clear(&mut self, code: ErrorCode, instance: u8) {
        self.services.emergency.clear(code, instance);
    }

    /// Reports a state change of the CAN controller.
    pub fn bus_event(&mut self, event: BusEvent, app: &mut impl Application) {
        match event {
            BusEvent::Overrun => {
                self.raise(Emergency::communication(ErrorCode::CAN_OVERRUN, 0), app);
            }
            BusEvent::ErrorPassive => {
                self.raise(Emergency::communication(ErrorCode::CAN_PASSIVE, 0), app);
            }
            BusEvent::Recovered => {
                self.clear(ErrorCode::CAN_OVERRUN, 0);
                self.clear(ErrorCode::CAN_PASSIVE, 0);
                self.clear(ErrorCode::BUS_OFF_RECOVERED, 0);
            }
            BusEvent::BusOff => self.communication_error(app),
            BusEvent::BusOffRecovered => {
                self.raise(
                    Emergency::communication(ErrorCode::BUS_OFF_RECOVERED, 0),
                    app,
                );
            }
        }
    }

    /// Advances all timers to `now_us`.
    fn advance(&mut self, now_us: u64) {
        let elapsed_us = now_us.saturating_sub(self.now_us);
        if elapsed_us == 0 {
            return;
        }
        self.now_us = now_us;
        let elapsed = Timer::from_us(u32::try_from(elapsed_us).unwrap_or(u32::MAX));
        self.services.advance(elapsed);
        self.sdo.advance(elapsed);
        self.lss.advance(elapsed);
    }

    /// Performs all time-driven work up to `now_us`, in microseconds.
    pub fn tick(&mut self, now_us: u64, app: &mut impl Application) {
        self.advance(now_us);
        self.lss.tick(app);
        if self.node_id.is_none() || self.state == NmtState::Initialising {
            return;
        }
        self.services.heartbeat.tick();
        while let Some(event) = self.services.consumers.tick() {
            self.heartbeat_event(event, app);
        }
        if self.state.communicates() {
            let (mut objects, sdo) = self.split(app);
            sdo.tick(&mut objects);
            if let Some(sync) = self.services.sync.tick() {
                self.sync(sync, app);
            }
        }
        self.tick_process_data(app);
    }

    /// The next frame to transmit. Call it until it returns `None` or the controller accepts no
    /// more frames.
    pub fn transmit<F: Frame>(&mut self, app: &mut impl Application) -> Option<F> {
        self.next_message(app)?.to_frame()
    }

    fn next_message(&mut self, app: &mut impl Application) -> Option<Message> {
        if self.lss.silent() {
            return None;
        }
        if let Some(data) = self.lss.transmit() {
            return Some(Message::new(lss::RESPONSE, &data));
        }
        let node_id = u32::from(self.node_id?.get());
        if self.state == NmtState::Initialising {
            self.boot_up_sent(app);
            return Some(Message::new(cob_id::HEARTBEAT + node_id, &[0]));
        }
        // No EMCY in STOPPED: that of the error which stops the node is sent before the state
        // shows.
        if self.state == NmtState::Stopped
            && let Some(message) = self.services.emergency.transmit_before_stop()
        {
            return Some(message);
        }
        if self.services.heartbeat.take() {
            return Some(Message::new(
                cob_id::HEARTBEAT + node_id,
                &[self.state as u8],
            ));
        }
        if !self.state.communicates() {
            return None;
        }
        let services = &mut self.services;
        let first = services
            .sync
            .transmit()
            .or_else(|| services.emergency.transmit());
        if first.is_some() {
            return first;
        }
        if let Some(message) = self.transmit_process_data() {
            return Some(message);
        }
        let (mut objects, sdo) = self.split(app);
        let data = sdo.transmit(&mut objects)?;
        Some(Message::new(cob_id::SDO_RESPONSE + node_id, &data))
    }
}
