//! Process data objects (CiA 301, 7.2.2): communication and mapping parameters common to RPDO and
//! TPDO.

mod map;
mod receive;
mod table;
mod transmit;

use map::PdoMapping;
pub(crate) use receive::{Received, Rpdo};
pub use table::PdoTable;
pub(crate) use table::{PdoObject, rpdo_of, tpdo_of};
pub(crate) use transmit::Tpdo;

use crate::Abort;
use crate::dictionary::{Dictionary, Mapping};
use crate::message::{EXTENDED, IDENTIFIER, assignable, cob_id_change_allowed};

/// Bit 31 of a COB-ID: the PDO is not valid.
const INVALID: u32 = 1 << 31;
/// Bit 30 of a TPDO's COB-ID: RTR not allowed.
const NO_REMOTE: u32 = 1 << 30;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Direction {
    Receive,
    Transmit,
}

impl Direction {
    /// Whether an object may be mapped in a PDO of this direction.
    const fn allows(self, mapping: Mapping) -> bool {
        match self {
            Self::Receive => matches!(mapping, Mapping::Receive | Mapping::Both),
            Self::Transmit => matches!(mapping, Mapping::Transmit | Mapping::Both),
        }
    }
}

/// Communication and mapping parameters of a PDO: objects 14xxh and 16xxh, or 18xxh and 1Axxh.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PdoParameters {
    direction: Direction,
    cob_id: u32,
    pub transmission: u8,
    pub inhibit_100us: u16,
    pub event_ms: u16,
    pub sync_start: u8,
    pub map: PdoMapping,
}

impl PdoParameters {
    /// Initial state; [`PdoParameters::reset`] must follow.
    const NEW: Self = Self {
        direction: Direction::Receive,
        cob_id: 0,
        transmission: 0,
        inhibit_100us: 0,
        event_ms: 0,
        sync_start: 0,
        map: PdoMapping::NEW,
    };

    /// Sets the defaults for a PDO without dictionary entries: not valid.
    pub const fn reset(&mut self, direction: Direction) {
        *self = Self {
            direction,
            cob_id: INVALID,
            transmission: 255,
            ..Self::NEW
        };
    }

    pub const fn valid(&self) -> bool {
        self.cob_id & INVALID == 0
    }

    pub const fn id(&self) -> u32 {
        self.cob_id & IDENTIFIER
    }

    /// Whether a remote frame may request the PDO.
    pub const fn remote_allowed(&self) -> bool {
        self.valid() && self.cob_id & NO_REMOTE == 0
    }

    /// Whether the PDO is applied or sampled with SYNC.
    pub const fn synchronous(&self) -> bool {
        matches!(self.transmission, 0..=240 | 252)
    }

    pub const fn event_driven(&self) -> bool {
        matches!(self.transmission, 254 | 255)
    }

    pub fn read_parameter(&self, sub: u8) -> Option<u32> {
        Some(match sub {
            1 => self.cob_id,
            2 => u32::from(self.transmission),
            3 => u32::from(self.inhibit_100us),
            5 => u32::from(self.event_ms),
            6 => u32::from(self.sync_start),
            _ => return None,
        })
    }

    /// Loads a default or stored value; [`PdoParameters::validate`] must follow.
    pub fn load_parameter(&mut self, sub: u8, value: u32) {
        match sub {
            1 => self.cob_id = value,
            2 => self.transmission = value as u8,
            3 => self.inhibit_100us = value as u16,
            5 => self.event_ms = value as u16,
            6 => self.sync_start = value as u8,
            _ => {}
        }
    }

    /// Resolves the mapping of loaded parameters, or disables the PDO if they are inconsistent.
    pub fn validate(&mut self, dictionary: &Dictionary) {
        let is_consistent = self.map.resolve(self.direction, dictionary).is_ok()
            && assignable(self.cob_id)
            && self.accepts(self.transmission)
            && self.sync_start <= 240;
        if !is_consistent {
            self.cob_id |= INVALID;
            self.map.disable();
        }
    }

    fn accepts(&self, transmission: u8) -> bool {
        match self.direction {
            Direction::Receive => matches!(transmission, 0..=240 | 254 | 255),
            Direction::Transmit => matches!(transmission, 0..=240 | 252..=255),
        }
    }

    /// Writes a communication parameter.
    pub fn write_parameter(&mut self, sub: u8, value: u32) -> Result<(), Abort> {
        match sub {
            1 => return self.write_cob_id(value),
            2 if !self.accepts(value as u8) => return Err(Abort::Value),
            3 | 6 if self.valid() => return Err(Abort::DeviceState),
            6 if value > 240 => return Err(Abort::Value),
            _ => {}
        }
        self.load_parameter(sub, value);
        Ok(())
    }

    fn write_cob_id(&mut self, value: u32) -> Result<(), Abort> {
        if value & INVALID == 0 {
            // Bits 0 to 29 must not change while the PDO is valid (CiA 301, 7.5.2.35).
            if !cob_id_change_allowed(value, self.cob_id, self.valid()) {
                return Err(Abort::Value);
            }
        } else if value & EXTENDED == 0 && value & IDENTIFIER > 0x7FF {
            return Err(Abort::Value);
        }
        self.cob_id = value;
        Ok(())
    }

    /// Writes a mapping parameter, which is allowed only while the PDO is not valid.
    pub fn write_mapping(
        &mut self,
        sub: u8,
        value: u32,
        dictionary: &Dictionary,
    ) -> Result<(), Abort> {
        if self.valid() {
            return Err(Abort::UnsupportedAccess);
        }
        match sub {
            0 => self.map.enable(value, self.direction, dictionary),
            _ => self.map.write(sub, value, self.direction, dictionary),
        }
    }
}
