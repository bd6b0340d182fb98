//! The node: frames and time go in, frames come out.

mod identifiers;
mod process_data;
mod receive;
mod state;

pub use identifiers::SERVICE_IDENTIFIERS;

use embedded_can::Frame;

use crate::application::{Application, Event};
use crate::dictionary::Dictionary;
use crate::emergency::{Emergency, ErrorCode};
use crate::message::Message;
use crate::nmt::{NmtState, NodeId};
use crate::objects::Objects;
use crate::services::Services;
use crate::timer::Timer;
use crate::{lss, sdo};

/// What the CAN controller tells of itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BusEvent {
    /// It lost frames.
    Overrun,
    /// It became error passive.
    ErrorPassive,
    /// It is error active again, or its receive queue is free again.
    Recovered,
    /// It went bus-off.
    BusOff,
    /// It is on the bus again.
    BusOffRecovered,
}

/// A CANopen device with `R` RPDOs and `T` TPDOs.
///
/// It does no I/O and reads no clock: call [`Node::receive`] with each frame from the bus,
/// [`Node::tick`] about once a millisecond or as often as a control loop runs, and [`Node::transmit`]
/// as long as the CAN controller takes frames and there are any. Times are microseconds of one clock that
/// begins anywhere and only grows. The work in each call is bounded.
#[derive(Debug)]
// What is small and often used comes first: short instructions reach it.
#[repr(C)]
pub struct Node<const R: usize, const T: usize> {
    state: NmtState,
    /// In use since the last reset of communication.
    node_id: Option<NodeId>,
    dictionary: &'static Dictionary,
    now_us: u64,
    lss: lss::Server,
    services: Services<R, T>,
    sdo: sdo::Server,
}

impl<const R: usize, const T: usize> Node<R, T> {
    /// Powers a node on. Without a node-ID it waits for one by LSS.
    #[cfg_attr(target_os = "none", inline(never))]
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
            sdo: sdo::Server::NEW,
            lss: lss::Server::new(node_id),
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

    fn number(&self) -> u8 {
        self.node_id.map_or(0, NodeId::get)
    }

    /// The objects, and beside them the SDO server that works on them.
    fn split<'a, A: Application>(
        &'a mut self,
        app: &'a mut A,
    ) -> (Objects<'a, A, R, T>, &'a mut sdo::Server) {
        let node_id = self.number();
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

    /// Raises an error: an EMCY goes out, 1001h and 1003h have it. Once, until it is cleared.
    pub fn raise(&mut self, error: Emergency, app: &mut impl Application) {
        if self.services.emergency.raise(error) {
            app.event(Event::Error(error.code));
        }
    }

    /// An error is gone: an EMCY "error reset" goes out.
    pub fn clear(&mut self, code: ErrorCode, instance: u8) {
        self.services.emergency.clear(code, instance);
    }

    /// Something happened to the CAN controller.
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

    /// Time passes, until `now_us`.
    fn pass(&mut self, now_us: u64) {
        let elapsed_us = now_us.saturating_sub(self.now_us);
        if elapsed_us == 0 {
            return;
        }
        self.now_us = now_us;
        let elapsed = Timer::us(u32::try_from(elapsed_us).unwrap_or(u32::MAX));
        self.services.pass(elapsed);
        self.sdo.pass(elapsed);
        self.lss.pass(elapsed);
    }

    /// Does what has become due. `now_us` is in microseconds.
    #[cfg_attr(target_os = "none", inline(never))]
    pub fn tick(&mut self, now_us: u64, app: &mut impl Application) {
        self.pass(now_us);
        self.lss.tick(app);
        if self.node_id.is_none() || self.state == NmtState::Initialising {
            return;
        }
        self.services.heartbeat.tick();
        while let Some(notice) = self.services.consumers.tick() {
            self.notice(notice, app);
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

    /// The next frame for the bus. Call it until it has none, or the controller takes no more.
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
            self.booted(app);
            return Some(Message::new(0x700 + node_id, &[0]));
        }
        if self.services.heartbeat.take() {
            return Some(Message::new(0x700 + node_id, &[self.state as u8]));
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
        Some(Message::new(0x580 + node_id, &data))
    }
}
