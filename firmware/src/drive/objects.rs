//! The hooks of the object dictionary.

use core::task::Poll;

use canopen::dictionary::Address;
use canopen::{Abort, BitRate, Event, NmtState, NodeId, ParameterGroup, Reset};

use canopen::cia402::Cia402State;

use super::{Drive, numbers, set, set::Asker};

impl canopen::Application for Drive<'_> {
    fn read(&mut self, address: Address) -> Result<u64, Abort> {
        self.value(address)
    }

    fn write(&mut self, address: Address, value: u64) -> Result<(), Abort> {
        self.set_value(address, value)
    }

    /// Protection limits and identity are locked while there is power, or about to be.
    fn guarded(&self) -> bool {
        self.is_driving()
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
            // Who resets the communication of a drive that moves has lost it.
            Reset::Communication => {
                let moves = self.axis.state() == Cia402State::OperationEnabled;
                self.failsafe.network(moves);
            }
        }
    }

    fn domain_cancel(&mut self, _: Address) {
        self.store.abandon();
    }

    fn stored(&mut self, address: Address) -> Option<u32> {
        self.store.communication(address)
    }

    fn store(
        &mut self,
        group: ParameterGroup,
        communication: &mut dyn Iterator<Item = (Address, u32)>,
    ) -> Poll<Result<(), Abort>> {
        let Self {
            application,
            kept,
            store,
            node_id,
            ..
        } = self;
        store.save(Asker::Save(group), |set| {
            let in_force = (application.parameters(), &*kept, *node_id);
            set::keep(set, group, in_force, communication);
        })
    }

    fn restore(&mut self, group: ParameterGroup) -> Poll<Result<(), Abort>> {
        self.store
            .save(Asker::Restore(group), |set| set::forget(set, group))
    }

    fn event(&mut self, event: Event) {
        match event {
            Event::HeartbeatLost(_) | Event::NmtState(NmtState::Stopped) => {
                self.failsafe.network(true);
            }
            Event::HeartbeatStarted(_) | Event::NmtState(NmtState::Operational) => {
                self.failsafe.network(false);
            }
            _ => {}
        }
    }

    fn supports_bit_rate(&self, bit_rate: BitRate) -> bool {
        kbit_s(bit_rate).is_some()
    }

    fn set_bit_rate(&mut self, bit_rate: BitRate) {
        self.bit_rate_kbit_s = kbit_s(bit_rate).map(|rate| rate as u16);
    }

    fn store_lss(
        &mut self,
        node_id: Option<NodeId>,
        bit_rate: Option<BitRate>,
    ) -> Poll<Result<(), Abort>> {
        let mut parameters = *self.application.parameters();
        let bus = &mut parameters.bus;
        bus.node_id = node_id.map_or(bus.node_id, |id| i32::from(id.get()));
        bus.bit_rate_kbit_s = bit_rate.and_then(kbit_s).unwrap_or(bus.bit_rate_kbit_s);
        let bus = *bus;
        // 2102h shows it, and 1010h does not undo it; a drive that is enabled does not change its identity.
        if !self.store.has_asked(Asker::Lss)
            && let Err(refused) = self.application.retune(&parameters)
        {
            return Poll::Ready(Err(numbers::abort(refused)));
        }
        self.store.save(Asker::Lss, |set| set.board.bus = bus)
    }
}

/// The bit rates that the board has.
const fn kbit_s(bit_rate: BitRate) -> Option<i32> {
    match bit_rate {
        BitRate::Kbit1000 => Some(1000),
        BitRate::Kbit500 => Some(500),
        _ => None,
    }
}
