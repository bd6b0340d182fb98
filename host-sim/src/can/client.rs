//! A CANopen client: reads and writes objects, and operates the drive.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use canopen::CanFrame;
use canopen::cia402::{controlword, statusword};
use canopen_generator::Row;
use embedded_can::{Frame, StandardId};

use super::link::Link;
use super::names::{self, Value};
use super::sdo::{Sdo, SdoError};
use super::supervised::{SupervisedLink, TIMEOUT_MS};
use crate::error::Error;

/// Why a request to an actuator failed.
#[derive(Debug, thiserror::Error)]
pub enum ClientError {
    /// The bus cannot be opened.
    #[error("cannot open the bus `{bus}`: {source}")]
    Open {
        /// Its name.
        bus: String,
        /// The error of the operating system.
        source: io::Error,
    },
    /// An object cannot be read or written.
    #[error("{name}: {source}{}", source.expected())]
    Object {
        /// Its name.
        name: String,
        /// The error of the transfer.
        source: SdoError,
    },
    /// The bus failed.
    #[error("the bus: {0}")]
    Link(#[from] io::Error),
    /// The actuator cannot do that in its present state.
    #[error("node {node}: {why}")]
    NotNow {
        /// The node.
        node: u8,
        /// The reason, and the remedy.
        why: &'static str,
    },
    /// The drive is not in the expected state.
    #[error("node {node}: {state}; {expected}")]
    State {
        /// The node.
        node: u8,
        /// Its state, with the fault.
        state: String,
        /// The state that is expected.
        expected: &'static str,
    },
    /// The drive stopped at one of its limits.
    #[error("node {node} is at {angle_deg} deg: {why}")]
    AtLimit {
        /// The node.
        node: u8,
        /// Its angle, deg.
        angle_deg: f64,
        /// The limit.
        why: &'static str,
    },
    /// The object does not hold an integer.
    #[error("{0} is not an integer")]
    NotAnInteger(String),
    /// This program is asked to end.
    #[error("interrupted")]
    Interrupted,
    /// Another program sends heartbeats with the node-ID of this one.
    #[error(
        "another program on the bus uses the node-ID of this one, {0}: its heartbeats hide the end of this program"
    )]
    SharedNode(u8),
    /// No TPDO of the actuator is valid.
    #[error("the actuator has no valid TPDO")]
    NoTpdo,
    /// The name of an object, or a value for it, is refused before it is sent.
    #[error(transparent)]
    Request(#[from] Error),
}

impl ClientError {
    /// Whether the actuator responded with a refusal.
    pub fn is_refusal(&self) -> bool {
        match self {
            Self::Object { source, .. } => matches!(source, SdoError::Abort { .. }),
            Self::State { .. } | Self::NotNow { .. } => true,
            _ => false,
        }
    }

    /// Whether the actuator did what it could, and stopped at a limit.
    pub fn is_at_limit(&self) -> bool {
        matches!(self, Self::AtLimit { .. })
    }

    /// Whether the request is invalid independently of the actuator.
    pub fn is_invalid_request(&self) -> bool {
        matches!(
            self,
            Self::Request(_) | Self::NotAnInteger(_) | Self::NoTpdo
        )
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

/// The entry of the consumer heartbeat time for this client; Studio uses the first one.
pub const MONITORED: &str = "1016:2";

/// Longest time of a stop.
const STOPPED: Duration = Duration::from_secs(10);

/// Controlword of operation enabled.
const ENABLED: u16 = controlword::SWITCH_ON
    | controlword::ENABLE_VOLTAGE
    | controlword::QUICK_STOP
    | controlword::ENABLE_OPERATION;

/// One actuator.
pub struct Client {
    link: SupervisedLink,
    node: u8,
    /// Set when this program is asked to end.
    interrupt: Option<Arc<AtomicBool>>,
}

impl Client {
    /// Opens the bus to this node.
    ///
    /// # Errors
    /// [`ClientError::Open`].
    pub fn open(bus: &str, kbit_s: u16, node: u8) -> Result<Self, ClientError> {
        let link = super::link::open(bus, kbit_s);
        let link = link.map_err(|source| ClientError::Open {
            bus: bus.to_owned(),
            source,
        })?;
        Ok(Self::new(link, node))
    }

    /// A client of this node.
    pub fn new(link: Box<dyn Link>, node: u8) -> Self {
        Self {
            link: SupervisedLink::new(link),
            node,
            interrupt: None,
        }
    }

    /// The node.
    pub fn node(&self) -> u8 {
        self.node
    }

    /// Selects another node of the same bus.
    pub fn select_node(&mut self, node: u8) {
        self.node = node;
    }

    /// The bus.
    pub fn link(&mut self) -> &mut dyn Link {
        &mut self.link
    }

    /// The SDO client of the node.
    pub fn sdo(&mut self) -> Sdo<'_> {
        Sdo::new(&mut self.link, self.node)
    }

    /// The value of an object.
    ///
    /// # Errors
    /// [`ClientError::Object`].
    pub fn get(&mut self, row: &Row) -> Result<Value, ClientError> {
        let (index, sub) = (row.index, row.sub_index());
        let long = row.kind == canopen_generator::DataType::Domain;
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
    pub fn integer(&mut self, object: &str) -> Result<i64, ClientError> {
        match self.get(names::find(object)?)? {
            Value::Integer(value) => Ok(value),
            _ => Err(ClientError::NotAnInteger(object.to_owned())),
        }
    }

    /// Writes a value, given as text, to an object.
    ///
    /// # Errors
    /// [`ClientError::Object`], and [`ClientError::Request`] for an invalid value.
    pub fn write(&mut self, object: &str, value: &str) -> Result<(), ClientError> {
        let row = names::find(object)?;
        self.set(row, &names::encode(row, value)?)
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
    pub fn status(&mut self) -> Result<u16, ClientError> {
        Ok(self.integer("6041")? as u16)
    }

    /// Controlword.
    ///
    /// # Errors
    /// [`ClientError::Object`].
    pub fn control(&mut self, word: u16) -> Result<(), ClientError> {
        self.write("6040", &word.to_string())
    }

    /// Fails with the state and the fault of the drive, and with what is expected.
    ///
    /// # Errors
    /// Always: [`ClientError::State`], or the error of reading the state.
    pub fn fail_in_state<T>(&mut self, expected: &'static str) -> Result<T, ClientError> {
        let mut state = state_name(self.status()?).to_owned();
        let code = self.integer("603F")?;
        if code != 0 {
            state += &format!(" with error code {code:04X}h");
        }
        Err(ClientError::State {
            node: self.node,
            state,
            expected,
        })
    }

    /// Waits until the statusword meets a condition.
    ///
    /// # Errors
    /// [`ClientError::State`] after `time`, or on a fault.
    pub fn wait(
        &mut self,
        time: Duration,
        expected: &'static str,
        is_met: impl Fn(u16) -> bool,
    ) -> Result<u16, ClientError> {
        let end = Instant::now() + time;
        loop {
            let status = self.status()?;
            if is_met(status) {
                return Ok(status);
            }
            if status & statusword::FAULT != 0 || Instant::now() > end {
                return self.fail_in_state(expected);
            }
            self.pause(Duration::from_millis(4))?;
        }
    }

    /// Enables operation in a mode, from any state but a fault.
    ///
    /// # Errors
    /// [`ClientError::State`] if the drive does not reach the state.
    pub fn enable(&mut self, mode: i8) -> Result<(), ClientError> {
        self.manage(1)?;
        if self.status()? & statusword::FAULT != 0 {
            return self.fail_in_state("reset it by `actuator faults --reset`");
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

    /// A rising edge of the fault reset, and the time that the drive needs for it.
    ///
    /// # Errors
    /// [`ClientError::Object`].
    pub fn reset_fault(&mut self) -> Result<(), ClientError> {
        for word in [0, controlword::FAULT_RESET] {
            self.control(word)?;
            self.pause(Duration::from_millis(20))?;
        }
        Ok(())
    }

    /// Waits for this time.
    ///
    /// # Errors
    /// [`ClientError::Link`]; while the actuator is supervised also [`ClientError::Interrupted`]
    /// and [`ClientError::SharedNode`].
    pub fn pause(&mut self, time: Duration) -> Result<(), ClientError> {
        self.link.pause(time)?;
        let Some(interrupt) = &self.interrupt else {
            return Ok(());
        };
        if interrupt.load(Ordering::Relaxed) {
            return Err(ClientError::Interrupted);
        }
        let shared = self.link.shared_node().map(ClientError::SharedNode);
        shared.map_or(Ok(()), Err)
    }

    /// Does what moves the actuator. It monitors the heartbeat of this program meanwhile, and stops
    /// if that ceases. On an error, and when `interrupt` is set, `stop` stops what was started.
    ///
    /// # Errors
    /// Those of `motion`; [`ClientError::Interrupted`], [`ClientError::SharedNode`].
    pub fn supervised<T, E: From<ClientError>>(
        &mut self,
        interrupt: Arc<AtomicBool>,
        motion: impl FnOnce(&mut Self) -> Result<T, E>,
        stop: impl FnOnce(&mut Self) -> Result<(), ClientError>,
    ) -> Result<T, E> {
        let own_node = self.link.begin().map_err(ClientError::from)?;
        let monitored = u32::from(own_node) << 16 | TIMEOUT_MS;
        let begun = (self.write(MONITORED, "0"))
            .and_then(|()| self.write(MONITORED, &monitored.to_string()));
        if let Err(error) = begun {
            self.link.end();
            return Err(error.into());
        }
        self.interrupt = Some(interrupt);
        let mut result = motion(self);
        if let (Ok(_), Some(shared)) = (&result, self.link.shared_node()) {
            result = Err(ClientError::SharedNode(shared).into());
        }
        self.interrupt = None;
        let stopped = match &result {
            Ok(_) => Ok(()),
            Err(_) => stop(self),
        };
        let ended = self.write(MONITORED, "0");
        self.link.end();
        // The error of the motion is more informative than those behind it.
        let result = result?;
        stopped.and(ended)?;
        Ok(result)
    }

    /// Halts the drive, which then holds the shaft, if it is enabled.
    ///
    /// # Errors
    /// [`ClientError::State`] if the shaft is not at rest after ten seconds.
    pub fn halt(&mut self) -> Result<(), ClientError> {
        if self.status()? & 0x6F != 0x27 {
            return Ok(());
        }
        self.control(ENABLED | controlword::HALT)?;
        let threshold = self.integer("606F")?;
        let end = Instant::now() + STOPPED;
        while self.integer("606C")?.abs() > threshold {
            if Instant::now() > end {
                return self.fail_in_state("expected the shaft to be at rest");
            }
            self.pause(Duration::from_millis(4))?;
        }
        Ok(())
    }

    /// Stops the shaft by a quick stop, after which the drive is off.
    ///
    /// # Errors
    /// [`ClientError::State`] if it is not off after ten seconds.
    pub fn quick_stop(&mut self) -> Result<(), ClientError> {
        self.switch_off(controlword::ENABLE_VOLTAGE)
    }

    /// Disables the power stage, after the stop of 605Ch.
    ///
    /// # Errors
    /// As [`Client::quick_stop`].
    pub fn disable(&mut self) -> Result<(), ClientError> {
        self.switch_off(0)
    }

    fn switch_off(&mut self, controlword: u16) -> Result<(), ClientError> {
        self.control(controlword)?;
        let expected = "expected the drive to be off";
        let off = |status: u16| !matches!(status & 0x6F, 0x27 | 0x07);
        self.wait(STOPPED, expected, off)?;
        Ok(())
    }

    /// Starts the homing 6098h of a drive that is enabled in this mode.
    ///
    /// # Errors
    /// [`ClientError::Object`].
    pub fn start_homing(&mut self) -> Result<(), ClientError> {
        self.control(ENABLED | controlword::START_HOMING)
    }

    /// Commands a new set-point of profile position, which replaces the present one at once.
    ///
    /// # Errors
    /// [`ClientError::State`] if the drive does not acknowledge it.
    pub fn move_to(&mut self, position_mdeg: i32) -> Result<(), ClientError> {
        self.control(ENABLED)?;
        self.wait(
            Duration::from_secs(1),
            "expected the last set-point to be acknowledged",
            |status| status & statusword::MODE_12 == 0,
        )?;
        self.write("607A", &position_mdeg.to_string())?;
        self.control(ENABLED | controlword::NEW_SET_POINT | controlword::CHANGE_SET_IMMEDIATELY)?;
        self.wait(
            Duration::from_secs(1),
            "expected the set-point to be acknowledged",
            |status| status & statusword::MODE_12 != 0,
        )?;
        self.control(ENABLED)
    }
}
