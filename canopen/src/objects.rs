//! Object access: the checks of the server, and dispatch to the owner of each value.

use core::task::Poll;

use crate::application::{Application, ParameterGroup};
use crate::dictionary::{Access, Address, DataType, Dictionary, Entry, Mapping};
use crate::message::copy;
use crate::services::Services;
use crate::{Abort, sdo};

/// The signatures of 1010h and 1011h.
const SAVE: u32 = u32::from_le_bytes(*b"save");
const LOAD: u32 = u32::from_le_bytes(*b"load");

/// The first index behind the communication area.
const APPLICATION_AREA: u16 = 0x2000;

/// The object dictionary together with the owners of its values.
pub(crate) struct Objects<'a, A, const R: usize, const T: usize> {
    pub dictionary: &'static Dictionary,
    pub services: &'a mut Services<R, T>,
    pub app: &'a mut A,
    pub node_id: u8,
}

impl<A: Application, const R: usize, const T: usize> Objects<'_, A, R, T> {
    /// Reads a numeric object.
    pub fn read_number(&mut self, entry: &Entry) -> Result<u64, Abort> {
        let address = entry.address();
        // The services have objects of the communication area only (CiA 301, 7.4.1).
        if address.index < APPLICATION_AREA
            && let Some(value) = self.services.read(address, self.dictionary)
        {
            return value.map(u64::from);
        }
        // SDO parameters have constant values that contain the node-ID.
        let from_table = matches!(address.index, 0x1010 | 0x1011 | 0x1200..=0x127F);
        if entry.access() == Access::Const || from_table {
            let value = entry.default_value(self.node_id);
            return Ok(entry.data_type().decode(&value.to_le_bytes()));
        }
        self.app.read(entry)
    }

    /// Writes a numeric object after all checks, for an RPDO or a completed SDO download.
    pub fn write_number(&mut self, entry: &Entry, value: u64) -> Result<(), Abort> {
        if entry.is_guarded() && self.app.guarded() {
            return Err(Abort::DeviceState);
        }
        self.check_limits(entry, value)?;
        self.check_relations(entry, value)?;
        let address = entry.address();
        match self.services.write(address, value as u32, self.dictionary) {
            Some(done) => done?,
            None => self.app.write(entry, value)?,
        }
        // A change of the configuration invalidates 1020h "verify configuration".
        let configures = entry.mapping() == Mapping::None && entry.access() == Access::ReadWrite;
        if configures && !matches!(address.index, 0x1003 | 0x1020) {
            self.services.configuration_date = [0; 2];
        }
        Ok(())
    }

    fn check_limits(&self, entry: &Entry, value: u64) -> Result<(), Abort> {
        let Some((low, high)) = entry.ordered_limits() else {
            return Ok(());
        };
        let value = entry.data_type().ordered(value as u32);
        if value > high {
            return Err(Abort::TooHigh);
        }
        if value < low {
            Err(Abort::TooLow)
        } else {
            Ok(())
        }
    }

    fn check_relations(&mut self, entry: &Entry, value: u64) -> Result<(), Abort> {
        let address = entry.address();
        for relation in self.dictionary.relations() {
            if relation.lower != address && relation.upper != address {
                continue;
            }
            let mut number = |of: Address| {
                let number = if of == address {
                    value
                } else {
                    self.read_number(self.dictionary.find(of)?)?
                };
                Ok(entry.data_type().ordered(number as u32))
            };
            if number(relation.lower)? > number(relation.upper)? {
                return Err(Abort::MaximumBelowMinimum);
            }
        }
        Ok(())
    }

    fn store(&mut self, sub: u8, value: u32) -> Poll<Result<(), Abort>> {
        if value != SAVE {
            return Poll::Ready(Err(Abort::Store));
        }
        let Self {
            dictionary,
            services,
            app,
            ..
        } = self;
        app.store(
            ParameterGroup::from_sub(sub),
            &mut services.storable_parameters(dictionary),
        )
    }

    fn restore(&mut self, sub: u8, value: u32) -> Poll<Result<(), Abort>> {
        if value != LOAD {
            return Poll::Ready(Err(Abort::Store));
        }
        self.app.restore(ParameterGroup::from_sub(sub))
    }
}

impl<A: Application, const R: usize, const T: usize> sdo::ObjectAccess for Objects<'_, A, R, T> {
    fn entry(&self, address: Address) -> Result<&'static Entry, Abort> {
        self.dictionary.find(address)
    }

    fn check_write(&self, entry: &Entry, length: Option<u32>) -> Result<(), Abort> {
        if !entry.is_writable() {
            return Err(Abort::ReadOnly);
        }
        // One that waits is checked when it is written.
        if entry.is_guarded() && self.app.guarded() && !self.app.defers(entry) {
            return Err(Abort::DeviceState);
        }
        let Some(length) = length else { return Ok(()) };
        let (least, most) = match (entry.data_type(), entry.data_type().size()) {
            (_, Some(size)) => (u32::from(size), u32::from(size)),
            (DataType::Domain, _) => (0, u32::MAX),
            _ => (0, entry.default_value(0)),
        };
        if length > most {
            return Err(Abort::TooLong);
        }
        if length < least {
            Err(Abort::TooShort)
        } else {
            Ok(())
        }
    }

    fn constant_text(&self, entry: &Entry) -> Option<&'static [u8]> {
        (entry.data_type() == DataType::VisibleString && entry.access() == Access::Const)
            .then(|| self.dictionary.text(entry.address()))
    }

    fn read(&mut self, entry: &Entry, buffer: &mut [u8]) -> Result<usize, Abort> {
        match entry.data_type().size() {
            Some(size) => {
                let bytes = self.read_number(entry)?.to_le_bytes();
                Ok(copy(
                    buffer,
                    bytes.get(..usize::from(size)).unwrap_or(&bytes),
                ))
            }
            None => self.app.read_bytes(entry.address(), buffer),
        }
    }

    fn write(&mut self, entry: &Entry, data: &[u8]) -> Poll<Result<(), Abort>> {
        if self.app.defers(entry) {
            return Poll::Pending;
        }
        let address = entry.address();
        if entry.data_type().size().is_none() {
            return Poll::Ready(self.app.write_bytes(address, data));
        }
        let value = entry.data_type().decode(data);
        match (address.index, address.sub) {
            (0x1010, 1..) => self.store(address.sub, value as u32),
            (0x1011, 1..) => self.restore(address.sub, value as u32),
            _ => match self.write_number(entry, value) {
                Err(Abort::NoResource) => Poll::Pending,
                done => Poll::Ready(done),
            },
        }
    }

    fn domain_size(&mut self, address: Address) -> Result<u32, Abort> {
        self.app.domain_size(address)
    }

    fn domain_read(&mut self, address: Address, offset: u32, to: &mut [u8]) -> Result<(), Abort> {
        self.app.domain_read(address, offset, to)
    }

    fn domain_begin(&mut self, address: Address, size: Option<u32>) -> Result<(), Abort> {
        self.app.domain_begin(address, size)
    }

    fn domain_write(&mut self, address: Address, offset: u32, data: &[u8]) -> Result<(), Abort> {
        self.app.domain_write(address, offset, data)
    }

    fn domain_end(&mut self, address: Address, size: u32) -> Poll<Result<(), Abort>> {
        self.app.domain_end(address, size)
    }

    fn domain_cancel(&mut self, address: Address) {
        self.app.domain_cancel(address);
    }
}
