//! The communication objects that the server keeps itself, 1000h to 1FFFh.

use crate::dictionary::{Access, Address, Dictionary, Row};
use crate::pdo::{Channel, Direction, Rpdo, Tpdo};
use crate::timer::Timer;
use crate::{Abort, emergency, heartbeat, sync, time};

/// All services but SDO and LSS, and the objects that configure them.
#[derive(Debug)]
// The small ones first, as in the node.
#[repr(C)]
pub(crate) struct Services<const R: usize, const T: usize> {
    pub heartbeat: heartbeat::Producer,
    pub sync: sync::Service,
    pub time: time::Service,
    /// Object 1029h:1.
    pub communication_error: u8,
    /// Object 1F80h.
    pub startup: u32,
    /// Object 1020h: date and time of the configuration.
    pub verified: [u32; 2],
    pub emergency: emergency::Service,
    pub consumers: heartbeat::Consumers,
    pub rpdos: [Rpdo; R],
    pub tpdos: [Tpdo; T],
}

/// First communication parameters of RPDOs and TPDOs, and the way from them to the mapping.
const RPDO: u16 = 0x1400;
const TPDO: u16 = 0x1800;
const MAPPING: u16 = 0x0200;

/// Objects whose values the server keeps, but which are no parameters to be stored.
const fn transient(index: u16) -> bool {
    matches!(index, 0x1001 | 0x1003)
}

/// How far an index is behind another; very far where it is before it.
fn distance(index: u16, base: u16) -> usize {
    usize::from(index.wrapping_sub(base))
}

impl<const R: usize, const T: usize> Services<R, T> {
    /// Nothing yet: [`Services::load`] has to follow. As everything is zero, no byte of it is kept in the program.
    pub const NEW: Self = Self {
        heartbeat: heartbeat::Producer::NEW,
        consumers: heartbeat::Consumers::NEW,
        emergency: emergency::Service::NEW,
        sync: sync::Service::NEW,
        time: time::Service::NEW,
        rpdos: [Rpdo::NEW; R],
        tpdos: [Tpdo::NEW; T],
        communication_error: 0,
        startup: 0,
        verified: [0; 2],
    };

    /// Time passes.
    pub fn pass(&mut self, elapsed: Timer) {
        self.heartbeat.pass(elapsed);
        self.consumers.pass(elapsed);
        self.emergency.pass(elapsed);
        self.sync.pass(elapsed);
        for rpdo in &mut self.rpdos {
            rpdo.pass(elapsed);
        }
        for tpdo in &mut self.tpdos {
            tpdo.pass(elapsed);
        }
    }

    /// Takes defaults, or what was stored of them; errors that are there stay.
    pub fn load(
        &mut self,
        dictionary: &Dictionary,
        node_id: u8,
        mut stored: impl FnMut(Address) -> Option<u32>,
    ) {
        // One after the other, where they are: all at once they are large.
        self.heartbeat = heartbeat::Producer::NEW;
        self.consumers = heartbeat::Consumers::NEW;
        self.emergency.reset_communication();
        self.sync = sync::Service::NEW;
        self.time = time::Service::NEW;
        self.rpdos = [Rpdo::NEW; R];
        self.tpdos = [Tpdo::NEW; T];
        for (direction, channel) in self.channels() {
            channel.begin(direction);
        }
        self.communication_error = 0;
        // Without 1F80h a node waits in PRE-OPERATIONAL.
        self.startup = SELF_START_OFF;
        self.verified = [0; 2];
        // 1019h first, which is not to be written while SYNC is produced.
        for is_first in [true, false] {
            for row in dictionary.rows() {
                let address = row.address();
                let has_turn = (address.index == 0x1019) == is_first;
                if !has_turn || !(0x1000..0x2000).contains(&address.index) {
                    continue;
                }
                let stored = row.writable().then(|| stored(address)).flatten();
                let value = stored.unwrap_or_else(|| dictionary.value(row, node_id));
                self.load_one(address, value);
            }
        }
        for (_, channel) in self.channels() {
            channel.settle(dictionary);
        }
    }

    /// What all PDOs have in common.
    fn channels(&mut self) -> impl Iterator<Item = (Direction, &mut Channel)> {
        let receive = self
            .rpdos
            .iter_mut()
            .map(|rpdo| (Direction::Receive, &mut rpdo.channel));
        let transmit = self
            .tpdos
            .iter_mut()
            .map(|tpdo| (Direction::Transmit, &mut tpdo.channel));
        receive.chain(transmit)
    }

    fn load_one(&mut self, address: Address, value: u32) {
        let Address { index, sub } = address;
        if let Some(channel) = self.channel_mut(index, 0) {
            channel.load_parameter(sub, value);
        } else if let Some(channel) = self.channel_mut(index, MAPPING) {
            channel.map.load(sub, value);
        } else if !transient(index) && !(index == 0x1016 && sub == 0) {
            // What was stored is refused where it makes no sense; the service stays off then.
            let _ = self.write_service(address, value);
        }
    }

    /// The value of an object that is kept here.
    pub fn read(&self, address: Address, dictionary: &Dictionary) -> Option<Result<u32, Abort>> {
        let Address { index, sub } = address;
        if let Some(channel) = self.channel(index, 0) {
            return channel.read_parameter(sub).map(Ok);
        }
        if let Some(channel) = self.channel(index, MAPPING) {
            return channel.map.read(sub).map(Ok);
        }
        Some(Ok(match (index, sub) {
            (0x1001, _) => u32::from(self.emergency.register()),
            (0x1003, _) => {
                let history = |row: &&Row| row.address().index == 0x1003;
                let shown = dictionary.rows().iter().filter(history).count();
                return Some(self.emergency.history(sub, shown.saturating_sub(1)));
            }
            (0x1005, _) => self.sync.cob_id(),
            (0x1006, _) => self.sync.period_us(),
            (0x1007, _) => self.sync.window_us(),
            (0x1012, _) => self.time.cob_id(),
            (0x1014, _) => self.emergency.cob_id(),
            (0x1015, _) => u32::from(self.emergency.inhibit_100us()),
            (0x1016, _) => self.consumers.word(sub)?,
            (0x1017, _) => u32::from(self.heartbeat.period_ms()),
            (0x1019, _) => u32::from(self.sync.overflow()),
            (0x1020, 1 | 2) => *self.verified.get(usize::from(sub) - 1)?,
            (0x1029, 1) => u32::from(self.communication_error),
            (0x1F80, _) => self.startup,
            _ => return None,
        }))
    }

    /// Writes an object that is kept here; `None` if it is not.
    pub fn write(
        &mut self,
        address: Address,
        value: u32,
        dictionary: &Dictionary,
    ) -> Option<Result<(), Abort>> {
        let Address { index, sub } = address;
        if let Some(channel) = self.channel_mut(index, MAPPING) {
            return Some(channel.write_mapping(sub, value, dictionary));
        }
        if let Some(channel) = self.channel_mut(index, 0) {
            let existed = channel.valid();
            let done = channel.write_parameter(sub, value);
            self.restart_pdo(index, sub, existed);
            return Some(done);
        }
        self.write_service(address, value)
    }

    /// Starts anew what a change of a communication parameter makes another PDO.
    fn restart_pdo(&mut self, index: u16, sub: u8, existed: bool) {
        let is_other = !existed || sub == 2;
        if let Some(rpdo) = self.rpdos.get_mut(distance(index, RPDO))
            && (is_other || sub == 5)
        {
            rpdo.start();
        }
        if let Some(tpdo) = self.tpdos.get_mut(distance(index, TPDO)) {
            if is_other {
                tpdo.start();
            } else if sub == 5 {
                tpdo.restart_timer();
            }
        }
    }

    /// The PDO whose communication parameters (`offset` 0) or mapping stand at `index`.
    fn channel(&self, index: u16, offset: u16) -> Option<&Channel> {
        let rpdo = self.rpdos.get(distance(index, RPDO + offset));
        let tpdo = self.tpdos.get(distance(index, TPDO + offset));
        (rpdo.map(|rpdo| &rpdo.channel)).or(tpdo.map(|tpdo| &tpdo.channel))
    }

    fn channel_mut(&mut self, index: u16, offset: u16) -> Option<&mut Channel> {
        let rpdo = self.rpdos.get_mut(distance(index, RPDO + offset));
        let tpdo = self.tpdos.get_mut(distance(index, TPDO + offset));
        (rpdo.map(|rpdo| &mut rpdo.channel)).or(tpdo.map(|tpdo| &mut tpdo.channel))
    }

    fn write_service(&mut self, address: Address, value: u32) -> Option<Result<(), Abort>> {
        let done = match (address.index, address.sub) {
            (0x1003, 0) => self.emergency.clear_history(value),
            (0x1005, _) => self.sync.set_cob_id(value),
            (0x1006, _) => self.sync.set_period(value),
            (0x1007, _) => {
                self.sync.set_window(value);
                Ok(())
            }
            (0x1012, _) => self.time.set_cob_id(value),
            (0x1014, _) => self.emergency.set_cob_id(value),
            (0x1015, _) => {
                self.emergency.set_inhibit(value as u16);
                Ok(())
            }
            (0x1016, sub) => self.write_consumer(sub, value),
            (0x1017, _) => {
                self.heartbeat.set_period(value as u16);
                Ok(())
            }
            (0x1019, _) => self.sync.set_overflow(value as u8),
            (0x1020, sub @ (1 | 2)) => {
                if let Some(word) = self.verified.get_mut(usize::from(sub) - 1) {
                    *word = value;
                }
                Ok(())
            }
            (0x1029, 1) if value > 2 => Err(Abort::Value),
            (0x1029, 1) => {
                self.communication_error = value as u8;
                Ok(())
            }
            // Of 1F80h a node that is no NMT master has bit 2 alone.
            (0x1F80, _) if value & !SELF_START_OFF != 0 => Err(Abort::Value),
            (0x1F80, _) => {
                self.startup = value;
                Ok(())
            }
            _ => return None,
        };
        Some(done)
    }

    fn write_consumer(&mut self, sub: u8, value: u32) -> Result<(), Abort> {
        let lost = self.consumers.configure(sub, value)?;
        if let Some(node) = lost {
            self.emergency.clear(crate::ErrorCode::HEARTBEAT, node);
        }
        Ok(())
    }

    /// Whether the node goes on to OPERATIONAL by itself.
    pub const fn starts_itself(&self) -> bool {
        self.startup & SELF_START_OFF == 0
    }

    /// The parameters that 1010h stores.
    pub fn parameters<'a>(
        &'a self,
        dictionary: &'a Dictionary,
    ) -> impl Iterator<Item = (Address, u32)> + 'a {
        let kept = dictionary
            .rows()
            .iter()
            .filter(|row| row.access() == Access::ReadWrite)
            .map(Row::address)
            .filter(|address| !transient(address.index));
        kept.filter_map(|address| {
            let value = self.read(address, dictionary)?.ok()?;
            Some((address, value))
        })
    }
}

/// Bit 2 of 1F80h: the node does not enter OPERATIONAL by itself.
const SELF_START_OFF: u32 = 1 << 2;
