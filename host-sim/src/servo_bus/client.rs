//! A client of servos on a serial bus, real or simulated.

mod columns;
mod device;
mod error;
mod line;
mod registers;
#[cfg(test)]
mod tests;

use std::io::{self, ErrorKind};
use std::ops::RangeInclusive;
use std::time::{Duration, Instant};

use servo_bus::tables::{SCS0009, STS3215, STS3250, XL330_M288, XM430_W350, sts, x};
use servo_bus::{BROADCAST, Bytes, Field, Register, Table, dynamixel, feetech};

use super::model::Family;
use line::{Answered, Framed, Line, is_pause, open};

pub use columns::{COLUMNS, Columns};
pub use device::{Device, TORQUE_ON, errors};
pub use error::{ServoError, in_units};
pub use registers::{angle_deg, position, register, value};

/// Bit rate of a bus whose name has none.
const BIT_S: u32 = 1_000_000;

/// Time for an answer: adapters deliver every 16 ms.
const ANSWER: Duration = Duration::from_millis(60);

/// The same where most IDs do not answer: a scan lasts 6 s.
const SCAN_ANSWER: Duration = Duration::from_millis(25);

/// The IDs that servos can have; 253 is one of Feetech's alone.
pub const IDS: RangeInclusive<u8> = 0..=253;

/// Register `end` of the SCS series, whose values have the high byte first.
const HIGH_FIRST: i32 = 1;

/// Prefixes of the names of buses.
const PREFIXES: [(&str, Family); 2] = [("sts:", Family::Sts), ("dxl:", Family::X)];

/// A serial bus with servos.
pub struct Client {
    bus: String,
    line: Box<dyn Line>,
    framed: Framed,
    answer: Duration,
}

/// Whether a bus of this name has servos.
pub fn is_servo_bus(bus: &str) -> bool {
    PREFIXES.iter().any(|(prefix, _)| bus.starts_with(prefix))
}

impl Client {
    /// Opens `sts:PORT` or `dxl:PORT`; the port is a serial device, which may be followed by `@`
    /// and a bit rate, or HOST:PORT of a server.
    ///
    /// # Errors
    /// For a name that is not one; the error of the operating system.
    pub fn open(bus: &str) -> Result<Self, ServoError> {
        let name = || ServoError::Name(bus.to_owned());
        let found = PREFIXES
            .iter()
            .find_map(|(prefix, family)| bus.strip_prefix(prefix).map(|port| (port, *family)));
        let (port, family) = found.ok_or_else(name)?;
        let (port, bit_s) = match port.rsplit_once('@') {
            Some((port, rate)) => (port, rate.parse().map_err(|_| name())?),
            None => (port, BIT_S),
        };
        let framed = match family {
            Family::Sts => Framed::Feetech(Box::default()),
            Family::X => Framed::Dynamixel(Box::default()),
        };
        let line = open(port, bit_s).map_err(|source| ServoError::Bus {
            bus: bus.to_owned(),
            source,
        })?;
        Ok(Self {
            bus: bus.to_owned(),
            line,
            framed,
            answer: ANSWER,
        })
    }

    fn failed(&self, source: io::Error) -> ServoError {
        ServoError::Bus {
            bus: self.bus.clone(),
            source,
        }
    }

    /// The IDs that answer, with their control tables.
    ///
    /// # Errors
    /// Those of the bus.
    pub fn scan(&mut self) -> Result<Vec<(u8, &'static Table)>, ServoError> {
        let mut found = Vec::new();
        for id in IDS {
            found.extend(self.probe(id)?.map(|table| (id, table)));
        }
        Ok(found)
    }

    /// The control table of a servo that may be missing, which is detected sooner than by other
    /// requests.
    ///
    /// # Errors
    /// Those of the bus.
    pub fn probe(&mut self, id: u8) -> Result<Option<&'static Table>, ServoError> {
        self.answer = SCAN_ANSWER;
        let found = self.table(id);
        self.answer = ANSWER;
        match found {
            Ok(table) => Ok(Some(table)),
            Err(ServoError::NoAnswer(_)) => Ok(None),
            Err(error) => Err(error),
        }
    }

    /// The control table of a servo; of a model that is not known, that of its series.
    ///
    /// # Errors
    /// Without an answer; those of the bus.
    pub fn table(&mut self, id: u8) -> Result<&'static Table, ServoError> {
        let is_feetech = matches!(self.framed, Framed::Feetech(_));
        let has_high_first = is_feetech && self.read(id, &STS3215, sts::END)? == HIGH_FIRST;
        let (tables, number): (&[&Table], Field) = match self.framed {
            Framed::Feetech(_) if has_high_first => (&[&SCS0009], sts::MODEL_NUMBER),
            Framed::Feetech(_) => (&[&STS3215, &STS3250], sts::MODEL_NUMBER),
            Framed::Dynamixel(_) => (&[&XM430_W350, &XL330_M288], x::MODEL_NUMBER),
        };
        let bytes = self.read_bytes(id, number.address, 2)?;
        let is_of = |table: &&&'static Table| {
            let model = table.register("model_number");
            model.is_some_and(|model| number.decode(&bytes, table.order) == model.default)
        };
        Ok(tables.iter().find(is_of).unwrap_or(&tables[0]))
    }

    /// Reads the bytes from an address on.
    ///
    /// # Errors
    /// Without an answer, or for a refusal; those of the bus.
    pub fn read_bytes(&mut self, id: u8, address: u16, length: u8) -> Result<Vec<u8>, ServoError> {
        let [low, high] = address.to_le_bytes();
        let packet = match self.framed {
            Framed::Feetech(_) => feetech::encode(id, 2, &[low, length]),
            Framed::Dynamixel(_) => dynamixel::encode(id, 2, &[&[low, high, length, 0]]),
        };
        let answered = self.exchange(id, &packet, || format!("a read of address {address}"))?;
        // An answer that is too short is no answer.
        let is_whole = answered.data.len() == usize::from(length);
        is_whole
            .then_some(answered.data)
            .ok_or(ServoError::NoAnswer(id))
    }

    /// Reads the same bytes of several servos with one request, which an SCS does not know; `None`
    /// for those without an answer.
    ///
    /// # Errors
    /// Those of the bus.
    pub fn sync_read(
        &mut self,
        ids: &[u8],
        address: u16,
        length: u8,
    ) -> Result<Vec<Option<Vec<u8>>>, ServoError> {
        let [low, high] = address.to_le_bytes();
        let packet = match self.framed {
            Framed::Feetech(_) => feetech::encode(BROADCAST, 0x82, &[&[low, length], ids].concat()),
            Framed::Dynamixel(_) => {
                dynamixel::encode(BROADCAST, 0x82, &[&[low, high, length, 0], ids])
            }
        };
        let mut found = vec![None; ids.len()];
        self.send(&packet)?;
        // Each answer may take the time of one.
        let mut end = Instant::now() + self.answer;
        while found.contains(&None) && Instant::now() < end {
            for Answered { id, error, data } in self.receive(&packet)? {
                let place = ids.iter().position(|known| *known == id);
                let is_whole = error & 0x7F == 0 && data.len() == usize::from(length);
                if let Some(place) = place.filter(|_| is_whole) {
                    found[place] = Some(data);
                    end = Instant::now() + self.answer;
                }
            }
        }
        Ok(found)
    }

    /// Reads a register.
    ///
    /// # Errors
    /// As [`Self::read_bytes`].
    pub fn read(&mut self, id: u8, table: &Table, field: Field) -> Result<i32, ServoError> {
        let bytes = self.read_bytes(id, field.address, field.size)?;
        Ok(field.decode(&bytes, table.order))
    }

    /// Writes a register; one of a Feetech's EEPROM lasts.
    ///
    /// # Errors
    /// Without an answer, or for a refusal; those of the bus.
    pub fn write(
        &mut self,
        id: u8,
        table: &Table,
        register: &Register,
        value: i32,
    ) -> Result<(), ServoError> {
        let lock = table.register("lock").filter(|_| register.is_eeprom);
        if let Some(lock) = lock {
            self.write_field(id, table, lock, 0)?;
        }
        self.write_field(id, table, register, value)?;
        // A servo with a new ID has it from now on.
        let id = if register.name == "id" {
            value as u8
        } else {
            id
        };
        lock.map_or(Ok(()), |lock| self.write_field(id, table, lock, 1))
    }

    fn write_field(
        &mut self,
        id: u8,
        table: &Table,
        register: &Register,
        value: i32,
    ) -> Result<(), ServoError> {
        let field = register.field;
        let encoded = field.encode(value, table.order);
        let data = &encoded[..usize::from(field.size)];
        let [low, high] = field.address.to_le_bytes();
        let packet = match self.framed {
            Framed::Feetech(_) => feetech::encode(id, 3, &[&[low], data].concat()),
            Framed::Dynamixel(_) => dynamixel::encode(id, 3, &[&[low, high], data]),
        };
        // The answer to a new ID may have the new one.
        let answers = if register.name == "id" {
            value as u8
        } else {
            id
        };
        let what = || format!("{} = {value}", register.name);
        match self.exchange(id, &packet, what) {
            Err(ServoError::NoAnswer(_)) if answers != id => Ok(()),
            other => other.map(drop),
        }
    }

    /// Sends a packet, and waits for the answer of a servo.
    fn exchange(
        &mut self,
        id: u8,
        packet: &Bytes,
        what: impl Fn() -> String,
    ) -> Result<Answered, ServoError> {
        self.send(packet)?;
        let end = Instant::now() + self.answer;
        while Instant::now() < end {
            let answers = self.receive(packet)?;
            if let Some(answered) = answers.into_iter().find(|answered| answered.id == id) {
                return match answered.error & 0x7F {
                    0 => Ok(answered),
                    error => Err(ServoError::Refused {
                        id,
                        what: what(),
                        error,
                    }),
                };
            }
        }
        Err(ServoError::NoAnswer(id))
    }

    fn send(&mut self, packet: &Bytes) -> Result<(), ServoError> {
        // An answer that was late is not that to this packet.
        self.framed.discard();
        let sent = self
            .line
            .discard()
            .and_then(|()| self.line.write_all(packet))
            .and_then(|()| self.line.flush());
        sent.map_err(|source| self.failed(source))
    }

    /// The answers that the next bytes complete; none after a short wait without bytes.
    fn receive(&mut self, sent: &Bytes) -> Result<Vec<Answered>, ServoError> {
        let mut bytes = [0; 256];
        match self.line.read(&mut bytes) {
            Ok(0) => Err(self.failed(ErrorKind::UnexpectedEof.into())),
            Ok(length) => {
                let bytes = bytes[..length].iter();
                Ok(bytes
                    .flat_map(|byte| self.framed.push(*byte, sent))
                    .collect())
            }
            Err(error) if is_pause(&error) => Ok(Vec::new()),
            Err(source) => Err(self.failed(source)),
        }
    }
}
