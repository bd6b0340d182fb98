//! NMT state of the node.

use super::Node;
use crate::application::{Application, Event, Reset};
use crate::emergency;
use crate::nmt::{Command, NmtState};

impl<const R: usize, const T: usize> Node<R, T> {
    pub(super) fn obey(&mut self, command: Command, app: &mut impl Application) {
        match command {
            Command::Enter(state) => self.enter(state, app),
            Command::ResetNode => self.reset(Reset::Node, app),
            Command::ResetCommunication => self.reset(Reset::Communication, app),
        }
    }

    /// Initialises; the boot-up frame ends it.
    pub(super) fn reset(&mut self, reset: Reset, app: &mut impl Application) {
        let (mut objects, sdo) = self.split(app);
        sdo.cancel(&mut objects);
        if reset == Reset::Node {
            self.services.emergency = emergency::Service::NEW;
        }
        app.reset(reset);
        self.node_id = self.lss.node_id();
        let node_id = self.number();
        self.services
            .load(self.dictionary, node_id, |address| app.stored(address));
        self.state = NmtState::Initialising;
        app.event(Event::State(self.state));
    }

    /// The boot-up frame goes out.
    pub(super) fn booted(&mut self, app: &mut impl Application) {
        self.enter(NmtState::PreOperational, app);
        if self.services.starts_itself() {
            self.enter(NmtState::Operational, app);
        }
        self.services.heartbeat.restart();
    }

    fn enter(&mut self, state: NmtState, app: &mut impl Application) {
        if state == self.state {
            return;
        }
        if self.state == NmtState::Stopped {
            self.services.sync.restart_counter();
        }
        self.state = state;
        match state {
            NmtState::Operational => self.start_process_data(),
            NmtState::Stopped => {
                let (mut objects, sdo) = self.split(app);
                sdo.cancel(&mut objects);
            }
            _ => {}
        }
        self.services.heartbeat.announce();
        app.event(Event::State(state));
    }

    /// Object 1029h:1 says what a communication error does.
    pub(super) fn communication_error(&mut self, app: &mut impl Application) {
        match self.services.communication_error {
            0 if self.state == NmtState::Operational => self.enter(NmtState::PreOperational, app),
            2 if self.state != NmtState::Initialising => self.enter(NmtState::Stopped, app),
            _ => {}
        }
    }
}
