//! PDO and SYNC processing of the node.

use super::Node;
use crate::application::{Application, Event};
use crate::dictionary::Address;
use crate::emergency::{Emergency, ErrorCode};
use crate::message::Message;
use crate::nmt::NmtState;
use crate::pdo::Received;
use crate::sync::Sync;

impl<const R: usize, const T: usize> Node<R, T> {
    /// Reports a change of an object. Event-driven TPDOs (types 254 and 255) that map it are
    /// transmitted with the next [`Node::tick`] or after their inhibit time, TPDOs of type 0 with
    /// the next SYNC.
    pub fn object_changed(&mut self, address: Address) {
        for (tpdo, parameters) in self.services.all_tpdos() {
            if parameters.map.maps(address) {
                tpdo.request();
            }
        }
    }

    /// Triggers one TPDO like [`Node::object_changed`]; `number` is from 1.
    pub fn request_tpdo(&mut self, number: u8) {
        let at = usize::from(number).checked_sub(1);
        if let Some(tpdo) = at.and_then(|at| self.services.tpdos.get_mut(at)) {
            tpdo.request();
        }
    }

    /// Transmits the event-driven TPDOs again, with new samples: their frames were discarded.
    pub fn repeat_process_data(&mut self) {
        for (tpdo, parameters) in self.services.all_tpdos() {
            if parameters.event_driven() {
                tpdo.request();
            }
        }
    }

    pub(super) fn start_process_data(&mut self) {
        for rpdo in &mut self.services.rpdos {
            rpdo.start();
        }
        for (tpdo, parameters) in self.services.all_tpdos() {
            tpdo.start(parameters);
        }
    }

    pub(super) fn tick_process_data(&mut self, app: &mut impl Application) {
        for number in 0..T {
            if self.state == NmtState::Operational
                && self
                    .services
                    .tpdo(number)
                    .is_some_and(|(tpdo, parameters)| tpdo.tick(parameters))
            {
                self.sample(number, app);
            }
        }
        for number in 0..R {
            if self.state == NmtState::Operational
                && self
                    .services
                    .rpdos
                    .get_mut(number)
                    .is_some_and(|rpdo| rpdo.timed_out())
            {
                self.raise(
                    Emergency::communication(ErrorCode::RPDO_TIMEOUT, pdo_number(number)),
                    app,
                );
                app.event(Event::RpdoTimeout(pdo_number(number)));
            }
        }
    }

    /// Samples the mapped objects of a TPDO.
    fn sample(&mut self, number: usize, app: &mut impl Application) {
        let objects = &mut self.split(app).0;
        let mut sample = [0; 8];
        let mut rest: &mut [u8] = &mut sample;
        for at in 0.. {
            let tpdo = objects.services.pdo_table.transmit().get(number);
            let Some(mapped) = tpdo.and_then(|tpdo| tpdo.map.object(at)) else {
                break;
            };
            let Some((bytes, after)) = rest.split_at_mut_checked(usize::from(mapped.size)) else {
                break;
            };
            if let Some(entry) = mapped.entry {
                // An object that cannot be read now is transmitted as zero.
                let value = objects.read_number(entry).unwrap_or(0);
                for (byte, value) in bytes.iter_mut().zip(value.to_le_bytes()) {
                    *byte = value;
                }
            }
            rest = after;
        }
        if let Some((tpdo, parameters)) = self.services.tpdo(number) {
            tpdo.set_sample(parameters, sample);
        }
    }

    pub(super) fn transmit_process_data(&mut self) -> Option<Message> {
        if self.state != NmtState::Operational {
            return None;
        }
        let closed = self.services.sync.window_closed();
        self.services
            .all_tpdos()
            .find_map(|(tpdo, parameters)| tpdo.transmit(parameters, closed))
    }

    pub(super) fn receive_process_data(&mut self, message: &Message, app: &mut impl Application) {
        if message.remote {
            return self.remote_request(message.id, app);
        }
        for number in 0..R {
            let Some((rpdo, parameters)) = self.services.rpdo(number) else {
                continue;
            };
            if !parameters.valid() || parameters.id() != message.id {
                continue;
            }
            let instance = pdo_number(number);
            match rpdo.receive(parameters, message) {
                Received::TooShort => {
                    self.raise(
                        Emergency::communication(ErrorCode::PDO_LENGTH, instance),
                        app,
                    );
                    continue;
                }
                Received::Apply(data) => self.apply(number, data, app),
                Received::Buffered => {}
            }
            self.clear(ErrorCode::PDO_LENGTH, instance);
            self.clear(ErrorCode::RPDO_TIMEOUT, instance);
        }
    }

    /// Writes the data of an RPDO to the mapped objects. An object that refuses its value keeps the
    /// previous one; the EMCY has the address of the last one.
    fn apply(&mut self, number: usize, data: [u8; 8], app: &mut impl Application) {
        let mut refused = None;
        let objects = &mut self.split(app).0;
        let mut rest: &[u8] = &data;
        for at in 0.. {
            let rpdo = objects.services.pdo_table.receive().get(number);
            let Some(mapped) = rpdo.and_then(|rpdo| rpdo.map.object(at)) else {
                break;
            };
            let Some((bytes, after)) = rest.split_at_checked(usize::from(mapped.size)) else {
                break;
            };
            if let Some(entry) = mapped.entry {
                let value = entry.data_type().decode(bytes);
                if objects.write_number(entry, value).is_err() {
                    refused = Some(entry.address());
                }
            }
            rest = after;
        }
        match refused {
            Some(Address { index, sub }) => {
                let [low, high] = index.to_le_bytes();
                let error = Emergency {
                    information: [low, high, sub, 0],
                    ..Emergency::communication(ErrorCode::PDO_VALUE, pdo_number(number))
                };
                self.raise(error, app);
            }
            None => self.clear(ErrorCode::PDO_VALUE, pdo_number(number)),
        }
        app.event(Event::Rpdo(pdo_number(number)));
    }

    fn remote_request(&mut self, id: u32, app: &mut impl Application) {
        let at = self
            .services
            .pdo_table
            .transmit()
            .iter()
            .position(|tpdo| tpdo.remote_allowed() && tpdo.id() == id);
        let Some(number) = at else { return };
        if self
            .services
            .tpdo(number)
            .is_some_and(|(tpdo, parameters)| tpdo.remote(parameters))
        {
            self.sample(number, app);
        }
    }

    /// Processes a received SYNC, or one that the node itself produces.
    pub(super) fn sync(&mut self, sync: Sync, app: &mut impl Application) {
        if sync.length_ok {
            self.clear(ErrorCode::SYNC_LENGTH, 0);
        } else {
            self.raise(Emergency::communication(ErrorCode::SYNC_LENGTH, 0), app);
        }
        if self.state == NmtState::Operational {
            for number in 0..R {
                let Some(rpdo) = self.services.rpdos.get_mut(number) else {
                    continue;
                };
                if let Some(data) = rpdo.sync() {
                    self.apply(number, data, app);
                }
            }
            for number in 0..T {
                let tpdo = self.services.tpdo(number);
                if tpdo.is_some_and(|(tpdo, parameters)| tpdo.sync(parameters, sync.counter)) {
                    self.sample(number, app);
                }
            }
        }
        app.event(Event::Sync(sync.counter));
    }
}

/// PDO number, from 1, of an array index.
fn pdo_number(number: usize) -> u8 {
    number.saturating_add(1).min(255) as u8
}
