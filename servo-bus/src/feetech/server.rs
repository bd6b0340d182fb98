//! A servo's answers.

use super::{Instruction, Packet, encode};
use crate::BROADCAST;
use crate::answer::Answer;
use crate::bytes::Bytes;
use crate::memory::Memory;
use crate::table::Table;
use crate::tables::sts;

/// What the servo has to do beside its memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Event {
    /// It starts again: its memory has the values of a start.
    Restart,
    /// Its position is one within a turn from now on.
    ResetTurns,
    /// Its present position is this one from now on.
    Calibrate(i32),
}

/// The bus side of a servo.
#[derive(Debug)]
pub struct Server {
    /// Its registers.
    pub memory: Memory,
    registered: Option<(u8, Bytes)>,
    event: Option<Event>,
}

impl Server {
    /// A new servo with this ID.
    pub fn new(table: &'static Table, id: u8) -> Self {
        let mut memory = Memory::new(table);
        memory.store(sts::ID, i32::from(id));
        Self::with(memory)
    }

    /// A servo with these registers.
    pub fn with(memory: Memory) -> Self {
        Self {
            memory,
            registered: None,
            event: None,
        }
    }

    /// What the servo has to do since the last call.
    pub fn take_event(&mut self) -> Option<Event> {
        self.event.take()
    }

    /// Carries out the instruction of a packet, and returns the answer to it. What is not a packet
    /// or not an instruction has no effect and no answer: whether the originals answer is not
    /// published.
    pub fn receive(&mut self, packet: &[u8]) -> Option<Answer> {
        let packet = Packet::try_new(packet)?;
        let instruction = Instruction::parse(packet)?;
        let id = self.memory.get(sts::ID) as u8;
        let is_broadcast = packet.id() == BROADCAST;
        if !is_broadcast && packet.id() != id {
            return None;
        }
        let (turn, data) = self.execute(instruction, id, is_broadcast)?;
        Some(self.answer(id, turn, &data))
    }

    fn answer(&self, id: u8, turn: u8, data: &[u8]) -> Answer {
        Answer {
            turn,
            delay_us: 2 * self.memory.get(sts::RETURN_DELAY_TIME) as u16,
            bytes: encode(id, self.memory.get(sts::STATUS) as u8, data),
            is_linked: false,
            bytes_before: 0,
        }
    }

    /// Place and contents of the answer.
    fn execute(
        &mut self,
        instruction: Instruction<'_>,
        id: u8,
        is_broadcast: bool,
    ) -> Option<(u8, Bytes)> {
        let answers_all = self.memory.get(sts::RESPONSE_LEVEL) == 1;
        match instruction {
            // Of all servos: each in the place of its ID, as LeRobot expects.
            Instruction::Ping => {
                return Some((if is_broadcast { id } else { 0 }, Bytes::default()));
            }
            Instruction::Read { address, length } => {
                return (!is_broadcast).then(|| (0, self.read(address, length)));
            }
            Instruction::SyncRead {
                address,
                length,
                ids,
            } => {
                let place = ids.iter().position(|other| *other == id)?;
                return is_broadcast.then(|| (place as u8, self.read(address, length)));
            }
            Instruction::SyncWrite {
                address,
                length,
                items,
            } => {
                let mut items = items.chunks_exact(usize::from(length) + 1);
                if let Some([_, data @ ..]) = items.find(|item| item.first() == Some(&id)) {
                    self.write(address, data);
                }
                return None;
            }
            Instruction::Write { address, data } => self.write(address, data),
            Instruction::RegWrite { address, data } => {
                let mut bytes = Bytes::default();
                bytes.extend(data);
                self.registered = Some((address, bytes));
                self.memory.set(sts::REGISTERED, 1);
            }
            Instruction::Action => {
                if let Some((address, data)) = self.registered.take() {
                    self.write(address, &data);
                }
                self.memory.set(sts::REGISTERED, 0);
            }
            Instruction::Recover => self.restart(|memory| memory.restore(true, &[sts::ID])),
            Instruction::Restart => self.restart(Memory::restart),
            Instruction::BackUp => self.memory.back_up(&[]),
            Instruction::ResetTurns => self.event = Some(Event::ResetTurns),
            Instruction::Calibrate(position) => {
                let order = self.memory.table().order;
                let position =
                    position.map_or(2048, |bytes| sts::PRESENT_POSITION.decode(&bytes, order));
                self.event = Some(Event::Calibrate(position));
            }
        }
        (answers_all && !is_broadcast).then(|| (0, Bytes::default()))
    }

    fn restart(&mut self, act: impl FnOnce(&mut Memory)) {
        act(&mut self.memory);
        self.registered = None;
        self.event = Some(Event::Restart);
    }

    fn read(&self, address: u8, length: u8) -> Bytes {
        let mut bytes = [0; u8::MAX as usize];
        let part = bytes.get_mut(..usize::from(length)).unwrap_or_default();
        self.memory.read(u16::from(address), part);
        let mut data = Bytes::default();
        data.extend(part);
        data
    }

    fn write(&mut self, address: u8, data: &[u8]) {
        let lock = self.memory.table().lock;
        let stores = lock.is_some_and(|lock| self.memory.get(lock) == 0);
        self.memory.write_each(u16::from(address), data, stores);
    }
}
