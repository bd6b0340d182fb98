//! What a person does with an actuator over the bus.

use std::io;
use std::time::{Duration, Instant};

use canopen::CanFrame;
use canopen::cia402::{controlword, statusword};
use canopen_generator::Row;
use embedded_can::{Frame, StandardId};

use super::link::Link;
use super::names::{self, Value};
use super::sdo::{Sdo, SdoError};
use crate::error::Error;

/// Why something could not be done with an actuator.
#[derive(Debug, thiserror::Error)]
pub enum ClientError {
    /// The bus cannot be opened.
    #[error("cannot open the bus `{bus}`: {source}")]
    Open {
        /// Its name.
        bus: String,
        /// What the system said.
        source: io::Error,
    },
    /// An object cannot be read or written.
    #[error("{name}: {source}")]
    Object {
        /// Its name.
        name: String,
        /// Why.
        source: SdoError,
    },
    /// The bus.
    #[error("the bus: {0}")]
    Link(#[from] io::Error),
    /// It cannot do that as it is now.
    #[error("node {node}: {why}")]
    NotNow {
        /// The node.
        node: u8,
        /// What hinders it, and what helps.
        why: &'static str,
    },
    /// The drive is not where it should be.
    #[error("node {node}: {state}; {wanted}")]
    State {
        /// The node.
        node: u8,
        /// Its state, with the fault.
        state: String,
        /// What was wanted.
        wanted: &'static str,
    },
}

impl ClientError {
    /// Whether the actuator was reached and said no.
    pub fn is_refusal(&self) -> bool {
        match self {
            Self::Object { source, .. } => matches!(source, SdoError::Abort { .. }),
            Self::State { .. } | Self::NotNow { .. } => true,
            Self::Open { .. } | Self::Link(_) => false,
        }
    }
}

/// The state of a drive by its statusword (CiA 402, table 30).
///
/// ```
/// assert_eq!(host_sim::can::client::state_name(0x0637), "operation enabled");
/// ```
pub fn state_name(status: u16) -> &'static str {
    match status & 0x6F {
        0x21 => "ready to switch on",
        0x23 => "switched on",
        0x27 => "operation enabled",
        0x07 => "quick stop active",
        _ => match status & 0x4F {
            0x00 => "not ready to switch on",
            0x40 => "switch on disabled",
            0x0F => "fault reaction active",
            0x08 => "fault",
            _ => "unknown",
        },
    }
}

/// One actuator.
pub struct Client {
    link: Box<dyn Link>,
    node: u8,
}

impl Client {
    /// Opens the bus to this node.
    ///
    /// # Errors
    /// [`ClientError::Open`].
    pub fn open(bus: &str, kbit_s: u16, node: u8) -> Result<Self, Error> {
        let link = super::link::open(bus, kbit_s);
        let link = link.map_err(|source| ClientError::Open {
            bus: bus.to_owned(),
            source,
        })?;
        Ok(Self { link, node })
    }

    /// The node.
    pub fn node(&self) -> u8 {
        self.node
    }

    /// Another node of the same bus from now on.
    pub fn turn_to(&mut self, node: u8) {
        self.node = node;
    }

    /// The bus.
    pub fn link(&mut self) -> &mut dyn Link {
        &mut *self.link
    }

    /// The SDO client of the node.
    pub fn sdo(&mut self) -> Sdo<'_> {
        Sdo::new(&mut *self.link, self.node)
    }

    /// The value of an object.
    ///
    /// # Errors
    /// [`ClientError::Object`].
    pub fn get(&mut self, row: &Row) -> Result<Value, ClientError> {
        let (index, sub) = (row.index, row.sub_index());
        let long = row.kind == canopen_generator::Kind::Domain;
        let bytes = if long {
            self.sdo().upload_block(index, sub)
        } else {
            self.sdo().upload(index, sub)
        };
        let value = bytes.and_then(|bytes| {
            let value = names::decode(row.kind, &bytes);
            value.ok_or(SdoError::Protocol(self.node))
        });
        value.map_err(|source| ClientError::Object {
            name: names::name(row),
            source,
        })
    }

    /// Writes bytes to an object.
    ///
    /// # Errors
    /// [`ClientError::Object`].
    pub fn set(&mut self, row: &Row, bytes: &[u8]) -> Result<(), ClientError> {
        let done = self.sdo().download(row.index, row.sub_index(), bytes);
        done.map_err(|source| ClientError::Object {
            name: names::name(row),
            source,
        })
    }

    /// The integer in an object of the actuator's dictionary.
    ///
    /// # Errors
    /// [`ClientError::Object`].
    pub fn integer(&mut self, object: &str) -> Result<i64, Error> {
        match self.get(names::find(object)?)? {
            Value::Integer(value) => Ok(value),
            _ => Err(Error::Conflict(format!("{object} is no integer"))),
        }
    }

    /// Writes a value in words to an object.
    ///
    /// # Errors
    /// [`ClientError::Object`], or that the value is none of the object.
    pub fn write(&mut self, object: &str, value: &str) -> Result<(), Error> {
        let row = names::find(object)?;
        Ok(self.set(row, &names::encode(row, value)?)?)
    }

    /// An NMT command to the node.
    ///
    /// # Errors
    /// [`ClientError::Link`].
    pub fn manage(&mut self, command: u8) -> Result<(), ClientError> {
        let frame = CanFrame::new(StandardId::ZERO, &[command, self.node]);
        Ok(frame.map_or(Ok(()), |frame| self.link.send(&frame))?)
    }

    /// Statusword.
    ///
    /// # Errors
    /// [`ClientError::Object`].
    pub fn status(&mut self) -> Result<u16, Error> {
        Ok(self.integer("6041")? as u16)
    }

    /// Controlword.
    ///
    /// # Errors
    /// [`ClientError::Object`].
    pub fn control(&mut self, word: u16) -> Result<(), Error> {
        self.write("6040", &word.to_string())
    }

    /// That the drive is not as wanted, with its state and fault.
    ///
    /// # Errors
    /// What it says, or why it could not be asked.
    pub fn complain<T>(&mut self, wanted: &'static str) -> Result<T, Error> {
        let mut state = state_name(self.status()?).to_owned();
        let code = self.integer("603F")?;
        if code != 0 {
            state += &format!(" with error code {code:04X}h");
        }
        Err(ClientError::State {
            node: self.node,
            state,
            wanted,
        }
        .into())
    }

    /// Waits until the statusword is so.
    ///
    /// # Errors
    /// What was wanted, in its time.
    pub fn wait(
        &mut self,
        time: Duration,
        wanted: &'static str,
        is_so: impl Fn(u16) -> bool,
    ) -> Result<u16, Error> {
        let end = Instant::now() + time;
        loop {
            let status = self.status()?;
            if is_so(status) {
                return Ok(status);
            }
            if status & statusword::FAULT != 0 || Instant::now() > end {
                return self.complain(wanted);
            }
            std::thread::sleep(Duration::from_millis(4));
        }
    }

    /// Enables operation in a mode, from any state but a fault.
    ///
    /// # Errors
    /// That it does not get there.
    pub fn enable(&mut self, mode: i8) -> Result<(), Error> {
        self.manage(1)?;
        if self.status()? & statusword::FAULT != 0 {
            return self.complain("reset it by `actuator faults --reset`");
        }
        self.write("6060", &mode.to_string())?;
        let second = Duration::from_secs(1);
        if self.status()? & 0x6F == 0x27 {
            return Ok(());
        }
        for (word, mask, state) in [(6, 0x6F, 0x21), (7, 0x6F, 0x23), (15, 0x6F, 0x27)] {
            self.control(word)?;
            self.wait(second, "expected it to be enabled", |status| {
                status & mask == state
            })?;
        }
        Ok(())
    }

    /// Takes the power off.
    ///
    /// # Errors
    /// [`ClientError::Object`].
    pub fn disable(&mut self) -> Result<(), Error> {
        self.control(0)
    }

    /// A new set-point of profile position, which replaces the one under way.
    ///
    /// # Errors
    /// That it is not acknowledged.
    pub fn move_to(&mut self, position_mdeg: i32) -> Result<(), Error> {
        let enabled = controlword::SWITCH_ON
            | controlword::ENABLE_VOLTAGE
            | controlword::QUICK_STOP
            | controlword::ENABLE_OPERATION;
        self.control(enabled)?;
        self.wait(
            Duration::from_secs(1),
            "expected the last set-point to be over",
            |status| status & statusword::MODE_12 == 0,
        )?;
        self.write("607A", &position_mdeg.to_string())?;
        self.control(enabled | controlword::NEW_SET_POINT | controlword::CHANGE_SET_IMMEDIATELY)?;
        self.wait(
            Duration::from_secs(1),
            "expected the set-point to be taken",
            |status| status & statusword::MODE_12 != 0,
        )?;
        self.control(enabled)
    }
}
