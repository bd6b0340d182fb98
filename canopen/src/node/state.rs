//! NMT slave state machine of the node.

use super::Node;
use crate::application::{Application, Event, Reset};
use crate::emergency;
use crate::nmt::{Command, NmtState};

impl<const R: usize, const T: usize> Node<R, T> {
    pub(super) fn apply_nmt_command(&mut self, command: Command, app: &mut impl Application) {
        match command {
            Command::Enter(state) => self.enter(state, app),
            Command::ResetNode => self.reset(Reset::Node, app),
            Command::ResetCommunication => self.reset(Reset::Communication, app),
        }
    }

    /// Enters initialisation, which ends when the boot-up message is transmitted.
    pub(super) fn reset(&mut self, reset: Reset, app: &mut impl Application) {
        let (mut objects, sdo) = self.split(app);
        sdo.cancel(&mut objects);
        if reset == Reset::Node {
            self.services.emergency = emergency::EmergencyProducer::NEW;
        }
        app.reset(reset);
        self.node_id = self.lss.node_id();
        let node_id = self.node_id_number();
        self.services
            .load(self.dictionary, node_id, |address| app.stored(address));
        self.state = NmtState::Initialising;
        app.event(Event::NmtState(self.state));
    }

    /// Leaves initialisation after transmission of the boot-up message.
    pub(super) fn boot_up_sent(&mut self, app: &mut impl Application) {
        self.enter(NmtState::PreOperational, app);
        if self.services.is_self_starting() {
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
        app.event(Event::NmtState(state));
    }

    /// Applies the error behaviour 1029h:1 after a communication error.
    pub(super) fn communication_error(&mut self, app: &mut impl Application) {
        match self.services.communication_error {
            0 if self.state == NmtState::Operational => self.enter(NmtState::PreOperational, app),
            2 if self.state.communicates() => {
                self.services.emergency.mark_before_stop();
                self.enter(NmtState::Stopped, app);
            }
            _ => {}
        }
    }
}
