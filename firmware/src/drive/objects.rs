//! The hooks of the CANopen server.

use core::task::Poll;

use bootloader::Bus;
use canopen::dictionary::{Address, Entry};
use canopen::{Abort, BitRate, Event, NmtState, NodeId, ParameterGroup, Reset};

use super::{Drive, commands::is_signal, measured::real, store::StoreClient};
use crate::{
    application::{Refused, may_retune},
    control_loop::{ForwardGains, LoopParameters},
    dictionary::{Location, location},
    parameters::{BoardParameters, ObjectValue, Parameter},
};

/// Index of the program data.
const PROGRAM_DATA: u16 = 0x1f50;

impl Drive<'_> {
    /// Sets a parameter of the board if all parameters are valid with it.
    pub(super) fn set_parameter(&mut self, parameter: Parameter, word: u32) -> Result<(), Abort> {
        self.retune(|parameters| {
            parameters.set_word(parameter, word);
            true
        })
    }

    /// Changes parameters of the board without a step of the duty. `change` returns whether the
    /// value is possible; range and relations are checked here.
    fn retune(&mut self, change: impl FnOnce(&mut BoardParameters) -> bool) -> Result<(), Abort> {
        let mut parameters = *self.parameters();
        if !change(&mut parameters) {
            return Err(Abort::Value);
        }
        self.set_board(parameters)
    }

    /// Posts parameters of the board if the state of the loop permits their changes.
    fn set_board(&mut self, board: BoardParameters) -> Result<(), Abort> {
        may_retune(self.outputs.state, self.parameters(), &board).map_err(abort)?;
        self.post(|parameters| parameters.board = board);
        Ok(())
    }

    /// Changes the message of parameters.
    fn post(&mut self, change: impl FnOnce(&mut LoopParameters)) {
        let mut values = self.values;
        let most = &mut values.limits.max_torque_permille;
        *most = (*most).min(self.servo_torque_permille);
        self.messages.parameters.update(|parameters| {
            parameters.number = parameters.number.wrapping_add(1);
            change(parameters);
            parameters.set_values(&values);
        });
    }

    /// Limits the torque beside object 6072h, thousandths of the rated one.
    pub(super) fn limit_torque(&mut self, permille: u16) {
        if self.servo_torque_permille != permille {
            self.servo_torque_permille = permille;
            self.post(|_| {});
        }
    }

    pub(super) fn set_value(&mut self, value: ObjectValue, word: u32) -> Result<(), Abort> {
        use ObjectValue::{Signal1, Signal2, Signal3, Signal4, Signal5, Signal6, Signal7, Signal8};
        let selects_signal = matches!(
            value,
            Signal1 | Signal2 | Signal3 | Signal4 | Signal5 | Signal6 | Signal7 | Signal8
        );
        if selects_signal && !is_signal(word) {
            return Err(Abort::Value);
        }
        let mut values = self.values;
        values.set_word(value, word);
        // The server has checked ranges and relations of two objects; this, lists of values.
        values.check().map_err(|_| Abort::Value)?;
        let forward = &self.messages.parameters.unverified().forward;
        if !forward.may_change(self.outputs.state, &ForwardGains::of(&values)) {
            return Err(Abort::DeviceState);
        }
        self.values = values;
        if value == ObjectValue::Password {
            self.service.password_set();
        }
        self.post(|_| {});
        Ok(())
    }
}

impl Drive<'_> {
    fn report_network(&mut self, is_lost: bool) {
        (self.messages.commands).update(|commands| commands.report_network(is_lost));
    }
}

impl Drive<'_> {
    /// Stores a group with these values of the communication.
    pub(super) fn save(
        &mut self,
        group: ParameterGroup,
        communication: impl Iterator<Item = (Address, u32)>,
    ) -> Poll<Result<(), Abort>> {
        let Self {
            messages,
            values,
            store,
            node_id,
            ..
        } = self;
        store.save(StoreClient::Save(group), |stored| {
            let board = &messages.parameters.unverified().board;
            let present = (board, &*values, *node_id);
            stored.take(group, present, communication);
        })
    }
}

impl canopen::Application for Drive<'_> {
    fn read(&mut self, entry: &Entry) -> Result<u64, Abort> {
        let parameters = self.parameters();
        Ok(match location(entry) {
            Location::Control(row) => real(parameters.control.get(row).ok_or(Abort::NoObject)?),
            // Signed integers are extended to 64 bits; the server cuts off what is beyond the type.
            Location::Parameter(parameter) => parameters.word(parameter) as i32 as u64,
            Location::Value(value) => self.values.word(value) as i32 as u64,
            Location::Command(command) => self.command_value(command),
            Location::Measured(value) => self.measured(value),
            Location::Server | Location::Communication(_) => return Err(Abort::NoObject),
        })
    }

    /// The server has checked access, length, range and relations of the dictionary.
    fn write(&mut self, entry: &Entry, value: u64) -> Result<(), Abort> {
        let word = value as u32;
        match location(entry) {
            Location::Control(row) => {
                self.retune(|parameters| parameters.control.set(row, f32::from_bits(word)))
            }
            Location::Parameter(parameter) => self.set_parameter(parameter, word),
            Location::Value(value) => self.set_value(value, word),
            Location::Command(command) => self.execute(command, value),
            Location::Measured(_) | Location::Server | Location::Communication(_) => {
                Err(Abort::NoObject)
            }
        }
    }

    /// Protection limits, identity and update are locked while the drive has power or is about to
    /// have it, and by the service password.
    fn guarded(&self) -> bool {
        self.is_driving() || self.is_locked()
    }

    /// A parameter acts behind the commands that were written before it.
    fn defers(&self, entry: &Entry) -> bool {
        let is_parameter = matches!(
            location(entry),
            Location::Control(_) | Location::Parameter(_) | Location::Value(_)
        );
        is_parameter && self.has_waiting_command()
    }

    fn domain_size(&mut self, _: Address) -> Result<u32, Abort> {
        let values = self.capture.count().saturating_mul(self.capture.width());
        match u32::try_from(values) {
            Ok(0) | Err(_) => Err(Abort::NoData),
            Ok(values) => Ok(values.saturating_mul(4)),
        }
    }

    fn domain_read(&mut self, _: Address, offset: u32, buffer: &mut [u8]) -> Result<(), Abort> {
        for (at, byte) in (offset..).zip(buffer) {
            let mut value = [0];
            if self.capture.read((at / 4) as usize, &mut value) == 0 {
                return Err(Abort::NoData);
            }
            let [value] = value.map(i32::to_le_bytes);
            *byte = value.get((at % 4) as usize).copied().unwrap_or(0);
        }
        Ok(())
    }

    fn reset(&mut self, reset: Reset) {
        match reset {
            Reset::Node => self.power_on(),
            // A master that resets the communication of an enabled drive has lost it.
            Reset::Communication => {
                self.report_network(self.is_enabled());
            }
        }
    }

    /// Object 1F50h, the only DOMAIN that is written.
    fn domain_begin(&mut self, _: Address, size: Option<u32>) -> Result<(), Abort> {
        if self.is_locked() {
            return Err(Abort::DeviceState);
        }
        self.update.begin(&mut self.capture, size)
    }

    fn domain_write(&mut self, _: Address, offset: u32, data: &[u8]) -> Result<(), Abort> {
        self.update.write(offset, data)
    }

    fn domain_end(&mut self, _: Address, size: u32) -> Poll<Result<(), Abort>> {
        self.end_download(size)
    }

    fn domain_cancel(&mut self, address: Address) {
        if address.index == PROGRAM_DATA {
            self.update.cancel(&mut self.capture);
        } else {
            self.store.abandon();
        }
    }

    fn stored(&mut self, address: Address) -> Option<u32> {
        self.store.stored().communication(address)
    }

    fn store(
        &mut self,
        group: ParameterGroup,
        communication: &mut dyn Iterator<Item = (Address, u32)>,
    ) -> Poll<Result<(), Abort>> {
        self.save(group, communication)
    }

    fn restore(&mut self, group: ParameterGroup) -> Poll<Result<(), Abort>> {
        let client = StoreClient::Restore(group);
        let is_begun = self.store.has_request_of(client);
        if self.is_locked() && group != ParameterGroup::Communication && !is_begun {
            return Poll::Ready(Err(Abort::DeviceState));
        }
        self.store.save(client, |stored| stored.restore(group))
    }

    fn event(&mut self, event: Event) {
        match event {
            Event::HeartbeatLost(_) | Event::NmtState(NmtState::Stopped) => {
                self.report_network(true);
            }
            Event::HeartbeatStarted(_) | Event::NmtState(NmtState::Operational) => {
                self.report_network(false);
            }
            _ => {}
        }
    }

    fn supports_bit_rate(&self, bit_rate: BitRate) -> bool {
        Bus::kbit_s_of(bit_rate).is_some()
    }

    fn set_bit_rate(&mut self, bit_rate: BitRate) {
        self.bit_rate_kbit_s = Bus::kbit_s_of(bit_rate);
    }

    fn store_lss(
        &mut self,
        node_id: Option<NodeId>,
        bit_rate: Option<BitRate>,
    ) -> Poll<Result<(), Abort>> {
        let is_begun = self.store.has_request_of(StoreClient::Lss);
        if self.is_locked() && !is_begun {
            return Poll::Ready(Err(Abort::DeviceState));
        }
        let mut parameters = *self.parameters();
        let bus = &mut parameters.bus;
        bus.node_id = node_id.map_or(bus.node_id, |id| i32::from(id.get()));
        let kbit_s = bit_rate.and_then(Bus::kbit_s_of).map(i32::from);
        bus.bit_rate_kbit_s = kbit_s.unwrap_or(bus.bit_rate_kbit_s);
        let bus = *bus;
        // The node-ID is shown in 2102h and kept by 1010h; an enabled drive keeps its identity.
        if !is_begun && let Err(refused) = self.set_board(parameters) {
            return Poll::Ready(Err(refused));
        }
        self.store
            .save(StoreClient::Lss, |stored| stored.board.bus = bus)
    }
}

/// Why a request was refused, as an SDO abort code.
pub(super) fn abort(refused: Refused) -> Abort {
    match refused {
        // The range is already checked: another parameter conflicts.
        Refused::Parameter(_) => Abort::Incompatible,
        _ => Abort::DeviceState,
    }
}
