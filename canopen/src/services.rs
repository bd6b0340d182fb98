//! The communication objects held by the server, 1000h to 1FFFh.

use crate::dictionary::{Access, Address, Dictionary, Entry};
use crate::pdo::{PdoObject, PdoParameters, PdoTable, Rpdo, Tpdo, rpdo_of, tpdo_of};
use crate::timer::Timer;
use crate::{Abort, emergency, heartbeat, sync, time};

/// All services except SDO and LSS, with the objects that configure them.
#[derive(Debug)]
pub(crate) struct Services<const R: usize, const T: usize> {
    pub heartbeat: heartbeat::Producer,
    pub sync: sync::SyncService,
    pub time: time::TimeConsumer,
    /// Object 1029h:1.
    pub communication_error: u8,
    /// Object 1F80h.
    pub startup: u32,
    /// Object 1020h: configuration date and time.
    pub configuration_date: [u32; 2],
    pub emergency: emergency::EmergencyProducer,
    pub consumers: heartbeat::Consumers,
    /// The parameters of the PDOs, apart from what changes with each frame.
    pub pdo_table: PdoTable<R, T>,
    pub rpdos: [Rpdo; R],
    pub tpdos: [Tpdo; T],
}

/// Index of the synchronous counter overflow value.
const SYNC_OVERFLOW: u16 = 0x1019;

/// Objects held by the server that are not stored by 1010h.
const fn is_volatile(index: u16) -> bool {
    matches!(index, 0x1001 | 0x1003)
}

impl<const R: usize, const T: usize> Services<R, T> {
    /// Initial state, all zero so that it needs no initialisation data; [`Services::load`] must
    /// follow.
    pub const NEW: Self = Self {
        heartbeat: heartbeat::Producer::NEW,
        consumers: heartbeat::Consumers::NEW,
        emergency: emergency::EmergencyProducer::NEW,
        sync: sync::SyncService::NEW,
        time: time::TimeConsumer::NEW,
        pdo_table: PdoTable::NEW,
        rpdos: [Rpdo::NEW; R],
        tpdos: [Tpdo::NEW; T],
        communication_error: 0,
        startup: 0,
        configuration_date: [0; 2],
    };

    /// Advances all timers.
    pub fn advance(&mut self, elapsed: Timer) {
        self.heartbeat.advance(elapsed);
        self.consumers.advance(elapsed);
        self.emergency.advance(elapsed);
        self.sync.advance(elapsed);
        for rpdo in &mut self.rpdos {
            rpdo.advance(elapsed);
        }
        for tpdo in &mut self.tpdos {
            tpdo.advance(elapsed);
        }
    }

    /// Loads stored values, or defaults where none is stored. Active errors remain active.
    pub fn load(
        &mut self,
        dictionary: &Dictionary,
        node_id: u8,
        mut stored: impl FnMut(Address) -> Option<u32>,
    ) {
        // Assigned one by one: a temporary of the whole struct would be large.
        self.heartbeat = heartbeat::Producer::NEW;
        self.consumers = heartbeat::Consumers::NEW;
        self.emergency.reset_communication();
        self.sync = sync::SyncService::NEW;
        self.time = time::TimeConsumer::NEW;
        self.rpdos = [Rpdo::NEW; R];
        self.tpdos = [Tpdo::NEW; T];
        self.pdo_table.reset();
        self.communication_error = 0;
        // Without 1F80h the node remains in PRE-OPERATIONAL after boot-up.
        self.startup = NO_SELF_START;
        self.configuration_date = [0; 2];
        // 1019h first: it cannot be written while SYNC is produced.
        let communication = dictionary.range(0x1000..0x2000);
        let is_overflow = |entry: &&Entry| entry.address().index == SYNC_OVERFLOW;
        let overflow = dictionary.range(SYNC_OVERFLOW..SYNC_OVERFLOW + 1).iter();
        for entry in overflow.chain(communication.iter().filter(|entry| !is_overflow(entry))) {
            let address = entry.address();
            let stored = entry.is_writable().then(|| stored(address)).flatten();
            let value = stored.unwrap_or_else(|| entry.default_value(node_id));
            self.load_one(address, value);
        }
        for parameters in self.pdo_table.all_mut() {
            parameters.validate(dictionary);
        }
    }

    fn load_one(&mut self, address: Address, value: u32) {
        let Address { index, sub } = address;
        if let Some(parameters) = self.pdo_mut(index, PdoObject::Communication) {
            parameters.load_parameter(sub, value);
        } else if let Some(parameters) = self.pdo_mut(index, PdoObject::Mapping) {
            parameters.map.load(sub, value);
        } else if !(is_volatile(index) || matches!((index, sub), (0x1016, 0))) {
            // An invalid stored value is refused; the service then remains disabled.
            let _ = self.write_service(address, value);
        }
    }

    /// Reads an object held by the server; `None` if it is not.
    pub fn read(&self, address: Address, dictionary: &Dictionary) -> Option<Result<u32, Abort>> {
        let Address { index, sub } = address;
        if let Some(parameters) = self.pdo_table.find(index, PdoObject::Communication) {
            return parameters.read_parameter(sub).map(Ok);
        }
        if let Some(parameters) = self.pdo_table.find(index, PdoObject::Mapping) {
            return parameters.map.read(sub).map(Ok);
        }
        Some(Ok(match (index, sub) {
            (0x1001, _) => u32::from(self.emergency.register()),
            (0x1003, _) => {
                let history = |entry: &&Entry| entry.address().index == 0x1003;
                let shown = dictionary.entries().iter().filter(history).count();
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
            (SYNC_OVERFLOW, _) => u32::from(self.sync.overflow()),
            (0x1020, 1 | 2) => *self.configuration_date.get(usize::from(sub) - 1)?,
            (0x1029, 1) => u32::from(self.communication_error),
            (0x1F80, _) => self.startup,
            _ => return None,
        }))
    }

    /// Writes an object held by the server; `None` if it is not.
    pub fn write(
        &mut self,
        address: Address,
        value: u32,
        dictionary: &Dictionary,
    ) -> Option<Result<(), Abort>> {
        let Address { index, sub } = address;
        if let Some(parameters) = self.pdo_mut(index, PdoObject::Mapping) {
            return Some(parameters.write_mapping(sub, value, dictionary));
        }
        if let Some(parameters) = self.pdo_mut(index, PdoObject::Communication) {
            let existed = parameters.valid();
            let done = parameters.write_parameter(sub, value);
            self.restart_pdo(index, sub, existed);
            return Some(done);
        }
        self.write_service(address, value)
    }

    /// Restarts a PDO after a change of its communication parameters.
    fn restart_pdo(&mut self, index: u16, sub: u8, existed: bool) {
        let is_redefined = !existed || sub == 2;
        if let Some((rpdo, _)) = self.rpdo(rpdo_of(index))
            && (is_redefined || sub == 5)
        {
            rpdo.start();
        }
        if let Some((tpdo, parameters)) = self.tpdo(tpdo_of(index)) {
            if is_redefined {
                tpdo.start(parameters);
            } else if sub == 5 {
                tpdo.restart_timer(parameters);
            }
        }
    }

    /// An RPDO and its parameters.
    pub fn rpdo(&mut self, number: usize) -> Option<(&mut Rpdo, &PdoParameters)> {
        let parameters = self.pdo_table.receive().get(number)?;
        Some((self.rpdos.get_mut(number)?, parameters))
    }

    /// A TPDO and its parameters.
    pub fn tpdo(&mut self, number: usize) -> Option<(&mut Tpdo, &PdoParameters)> {
        let parameters = self.pdo_table.transmit().get(number)?;
        Some((self.tpdos.get_mut(number)?, parameters))
    }

    /// All TPDOs and their parameters.
    pub fn all_tpdos(&mut self) -> impl Iterator<Item = (&mut Tpdo, &PdoParameters)> {
        self.tpdos.iter_mut().zip(self.pdo_table.transmit())
    }

    /// The PDO with these parameters at `index`, to be changed.
    fn pdo_mut(&mut self, index: u16, object: PdoObject) -> Option<&mut PdoParameters> {
        // A search without a result is no access to the table.
        self.pdo_table.find(index, object)?;
        self.pdo_table.find_mut(index, object)
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
            (SYNC_OVERFLOW, _) => self.sync.set_overflow(value as u8),
            (0x1020, sub @ (1 | 2)) => {
                if let Some(word) = self.configuration_date.get_mut(usize::from(sub) - 1) {
                    *word = value;
                }
                Ok(())
            }
            (0x1029, 1) if value > 2 => Err(Abort::Value),
            (0x1029, 1) => {
                self.communication_error = value as u8;
                Ok(())
            }
            // A node that is not an NMT master supports bit 2 of 1F80h only.
            (0x1F80, _) if value & !NO_SELF_START != 0 => Err(Abort::Value),
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

    /// Whether the node enters OPERATIONAL autonomously after boot-up.
    pub const fn is_self_starting(&self) -> bool {
        self.startup & NO_SELF_START == 0
    }

    /// The parameters that 1010h stores.
    pub fn storable_parameters<'a>(
        &'a self,
        dictionary: &'a Dictionary,
    ) -> impl Iterator<Item = (Address, u32)> + 'a {
        let addresses = dictionary
            .entries()
            .iter()
            .filter(|entry| entry.access() == Access::ReadWrite)
            .map(Entry::address)
            .filter(|address| !is_volatile(address.index));
        addresses.filter_map(|address| {
            let value = self.read(address, dictionary)?.ok()?;
            Some((address, value))
        })
    }
}

/// Bit 2 of 1F80h: the node does not enter OPERATIONAL autonomously.
const NO_SELF_START: u32 = 1 << 2;
