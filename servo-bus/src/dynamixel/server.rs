//! A servo's answers.

use super::packet::begin;
use super::rules::allows;
use super::{Error, Instruction, Item, Packet, encode};
use crate::BROADCAST;
use crate::answer::Answer;
use crate::bytes::Bytes;
use crate::memory::Memory;
use crate::table::{Field, Table};
use crate::tables::x;

/// The instruction of a status packet.
const STATUS: u8 = 0x55;

/// Bytes of an answer's data that always fit with stuffing, header, error and CRC.
const MOST_DATA: usize = 700;

/// Bytes of a status packet before its error.
const BEGINNING: u16 = 8;

/// Set in the error of a status packet while there is a hardware error.
const ALERT: u8 = 0x80;

/// What the backup has beside the EEPROM, by the manual; indirect addresses are not kept.
const BACKED_UP: [Field; 9] = [
    x::VELOCITY_I_GAIN,
    x::VELOCITY_P_GAIN,
    x::POSITION_D_GAIN,
    x::POSITION_I_GAIN,
    x::POSITION_P_GAIN,
    x::FEEDFORWARD_1ST_GAIN,
    x::FEEDFORWARD_2ND_GAIN,
    x::PROFILE_ACCELERATION,
    x::PROFILE_VELOCITY,
];

/// What the servo has to do beside its memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Event {
    /// It starts again: its memory has the values of a start.
    Restart,
    /// Its position is one within a turn from now on.
    ResetTurns,
}

/// The bus side of a servo.
#[derive(Debug)]
pub struct Server {
    /// Its registers.
    pub memory: Memory,
    registered: Option<(u16, Bytes)>,
    event: Option<Event>,
    has_received: bool,
}

/// Contents of an answer, and the level of answers from which it is given.
type Outcome = (Result<Bytes, Error>, i32);

impl Server {
    /// A new servo with this ID.
    pub fn new(table: &'static Table, id: u8) -> Self {
        let mut memory = Memory::new(table);
        memory.store(x::ID, i32::from(id));
        Self::with(memory)
    }

    /// A servo with these registers.
    pub fn with(memory: Memory) -> Self {
        Self {
            memory,
            registered: None,
            event: None,
            has_received: false,
        }
    }

    /// What the servo has to do since the last call.
    pub fn take_event(&mut self) -> Option<Event> {
        self.event.take()
    }

    /// Whether an instruction, of any servo, has been received since the last call: for the
    /// watchdog.
    pub fn take_received(&mut self) -> bool {
        core::mem::take(&mut self.has_received)
    }

    /// Carries out the instruction of a packet, and returns the answer to it. What is not a packet
    /// has no answer.
    pub fn receive(&mut self, packet: &[u8]) -> Option<Answer> {
        let packet = Packet::try_new(packet)?;
        let body = packet.body();
        // Also servos hear the answers of the others.
        if body.first() == Some(&STATUS) {
            return None;
        }
        self.has_received = true;
        let id = self.memory.get(x::ID) as u8;
        let is_broadcast = packet.id() == BROADCAST;
        let is_secondary = i32::from(packet.id()) == self.memory.get(x::SECONDARY_ID);
        if !is_broadcast && packet.id() != id && !is_secondary {
            return None;
        }
        let Some(instruction) = Instruction::parse(&body) else {
            let outcome = (Err(Error::Instruction), 2);
            return (packet.id() == id).then(|| self.answer(id, 0, outcome))?;
        };
        if is_broadcast {
            return self.broadcast(instruction, id);
        }
        let outcome = self.execute(instruction);
        // A servo does not answer to its secondary ID.
        (packet.id() == id).then(|| self.answer(id, 0, outcome))?
    }

    /// An instruction to all.
    fn broadcast(&mut self, instruction: Instruction<'_>, id: u8) -> Option<Answer> {
        match instruction {
            // Each in the place of its ID.
            Instruction::Ping => {
                let outcome = self.execute(instruction);
                self.answer(id, id, outcome)
            }
            Instruction::SyncRead {
                address,
                length,
                ids,
                is_fast,
            } => {
                let turn = ids.iter().position(|other| *other == id)?;
                let lengths = ids.iter().map(|_| length);
                self.several((address, length), turn, lengths, is_fast)
            }
            Instruction::BulkRead { items, is_fast } => {
                let turn = Item::all(items, false).position(|item| item.id == id)?;
                let own = Item::all(items, false).nth(turn)?;
                let lengths = Item::all(items, false).map(|item| item.length);
                self.several((own.address, own.length), turn, lengths, is_fast)
            }
            Instruction::SyncWrite {
                address,
                length,
                items,
            } => {
                let mut items = items.chunks_exact(usize::from(length) + 1);
                let item = items.find(|item| item.first() == Some(&id))?;
                let _ = self.write(address, item.get(1..)?);
                None
            }
            Instruction::BulkWrite { items } => {
                let item = Item::all(items, true).find(|item| item.id == id)?;
                let _ = self.write(item.address, item.data);
                None
            }
            Instruction::Read { .. } => None,
            // From firmware 42 on.
            Instruction::FactoryReset(0xFF) => None,
            other => {
                let _ = self.execute(other);
                None
            }
        }
    }

    /// The answer to a read of several servos.
    fn several(
        &mut self,
        (address, length): (u16, u16),
        turn: usize,
        lengths: impl Iterator<Item = u16> + Clone,
        is_fast: bool,
    ) -> Option<Answer> {
        let id = self.memory.get(x::ID) as u8;
        let data = self.read(address, length);
        if !is_fast {
            return self.answer(id, turn as u8, (data, 1));
        }
        if usize::from(length) > MOST_DATA {
            return None;
        }
        // Error, ID, data and CRC of each, behind the instruction.
        let sum = |sum: u16, length: u16| sum.saturating_add(length.saturating_add(4));
        let bytes_before = match turn {
            0 => 0,
            _ => lengths.clone().take(turn).fold(BEGINNING, sum),
        };
        let total = lengths.fold(1, sum);
        let mut bytes = if turn == 0 {
            begin(BROADCAST, STATUS, total)
        } else {
            Bytes::default()
        };
        let error = self.error(data.as_ref().err());
        bytes.extend(&[error, id]);
        let data = data.unwrap_or_default();
        for index in 0..usize::from(length) {
            bytes.push(data.get(index).copied().unwrap_or(0));
        }
        let delay_us = self.delay_us();
        (self.level() >= 1).then_some(Answer {
            turn: turn as u8,
            delay_us,
            bytes,
            is_linked: true,
            bytes_before,
        })
    }

    fn answer(&self, id: u8, turn: u8, (outcome, level): Outcome) -> Option<Answer> {
        let error = self.error(outcome.as_ref().err());
        let data = outcome.unwrap_or_default();
        (self.level() >= level).then(|| Answer {
            turn,
            delay_us: self.delay_us(),
            bytes: encode(id, STATUS, &[&[error], &data]),
            is_linked: false,
            bytes_before: 0,
        })
    }

    fn error(&self, error: Option<&Error>) -> u8 {
        let alert = if self.memory.get(x::HARDWARE_ERROR_STATUS) == 0 {
            0
        } else {
            ALERT
        };
        alert | error.map_or(0, |error| *error as u8)
    }

    fn level(&self) -> i32 {
        self.memory.get(x::STATUS_RETURN_LEVEL)
    }

    fn delay_us(&self) -> u16 {
        2 * self.memory.get(x::RETURN_DELAY_TIME) as u16
    }

    fn execute(&mut self, instruction: Instruction<'_>) -> Outcome {
        match instruction {
            Instruction::Ping => return (self.identity(), 0),
            Instruction::Read { address, length } => return (self.read(address, length), 1),
            _ => {}
        }
        let done = match instruction {
            Instruction::Write { address, data } => self.write(address, data),
            Instruction::RegWrite { address, data } => self.register(address, data),
            Instruction::Action => self.act(),
            Instruction::FactoryReset(option) => {
                let kept: &[Field] = match option {
                    1 => &[x::ID],
                    2 => &[x::ID, x::BAUD_RATE],
                    _ => &[],
                };
                self.restart(|memory| memory.restore(false, kept))
            }
            Instruction::Reboot => self.restart(Memory::restart),
            Instruction::Clear if self.memory.get(x::MOVING) != 0 => Err(Error::Result),
            Instruction::Clear => {
                self.event = Some(Event::ResetTurns);
                Ok(())
            }
            Instruction::BackUp | Instruction::Restore if self.is_driven() => Err(Error::Result),
            Instruction::BackUp => {
                self.memory.back_up(&BACKED_UP);
                self.memory.set(x::BACKUP_READY, 1);
                Ok(())
            }
            Instruction::Restore => self.restart(|memory| memory.restore(true, &[])),
            // Those for several servos are for all.
            _ => Err(Error::Instruction),
        };
        (done.map(|()| Bytes::default()), 2)
    }

    fn identity(&self) -> Result<Bytes, Error> {
        let mut data = Bytes::default();
        data.extend(&(self.memory.get(x::MODEL_NUMBER) as u16).to_le_bytes());
        data.push(self.memory.get(x::FIRMWARE_VERSION) as u8);
        Ok(data)
    }

    fn is_driven(&self) -> bool {
        self.memory.get(x::TORQUE_ENABLE) != 0
    }

    fn restart(&mut self, act: impl FnOnce(&mut Memory)) -> Result<(), Error> {
        act(&mut self.memory);
        self.registered = None;
        self.event = Some(Event::Restart);
        Ok(())
    }

    fn register(&mut self, address: u16, data: &[u8]) -> Result<(), Error> {
        let mut bytes = Bytes::default();
        if !bytes.extend(data) {
            return Err(Error::DataLength);
        }
        self.registered = Some((address, bytes));
        self.memory.set(x::REGISTERED_INSTRUCTION, 1);
        Ok(())
    }

    fn act(&mut self) -> Result<(), Error> {
        let (address, data) = self.registered.take().ok_or(Error::Instruction)?;
        self.memory.set(x::REGISTERED_INSTRUCTION, 0);
        self.write(address, &data)
    }

    fn read(&self, address: u16, length: u16) -> Result<Bytes, Error> {
        let length = usize::from(length);
        let mut bytes = [0; MOST_DATA];
        let part = bytes.get_mut(..length).ok_or(Error::DataLength)?;
        if !self.memory.contains(address, length) {
            return Err(Error::Access);
        }
        self.memory.read(address, part);
        let mut data = Bytes::default();
        data.extend(part);
        Ok(data)
    }

    fn write(&mut self, address: u16, data: &[u8]) -> Result<(), Error> {
        Ok(self.memory.write(address, data, allows)?)
    }
}
