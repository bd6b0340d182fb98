//! Which objects a PDO carries.

use super::Direction;
use crate::Abort;
use crate::dictionary::{Address, DataType, Dictionary, Row};

/// Objects in a PDO at most: eight bytes, and no bit-wise mapping.
const SLOTS: usize = 8;

/// One mapped object.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Slot {
    /// Bytes that it takes; 0 where there is no object any more.
    pub size: u8,
    /// Its entry; `None` for a dummy, which takes room in an RPDO and goes nowhere.
    pub row: Option<&'static Row>,
}

/// Object 16xxh or 1Axxh.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Map {
    words: [u32; SLOTS],
    count: u8,
    slots: [Slot; SLOTS],
    length: u8,
}

impl Slot {
    const EMPTY: Self = Self { size: 0, row: None };
}

impl Map {
    pub const NEW: Self = Self {
        words: [0; SLOTS],
        count: 0,
        slots: [Slot::EMPTY; SLOTS],
        length: 0,
    };

    /// Bytes of the PDO.
    pub const fn length(&self) -> u8 {
        self.length
    }

    /// The mapped objects, in their order; `None` behind the last.
    pub fn slot(&self, at: usize) -> Option<Slot> {
        self.slots.get(at).copied().filter(|slot| slot.size > 0)
    }

    pub fn maps(&self, address: Address) -> bool {
        self.slots
            .iter()
            .flat_map(|slot| slot.row)
            .any(|row| row.address() == address)
    }

    pub fn read(&self, sub: u8) -> Option<u32> {
        match sub.checked_sub(1) {
            None => Some(u32::from(self.count)),
            Some(at) => self.words.get(usize::from(at)).copied(),
        }
    }

    pub fn load(&mut self, sub: u8, value: u32) {
        match sub
            .checked_sub(1)
            .map(|at| self.words.get_mut(usize::from(at)))
        {
            None => self.count = value.min(u32::from(u8::MAX)) as u8,
            Some(Some(word)) => *word = value,
            Some(None) => {}
        }
    }

    /// Carries nothing; what is written in the entries stays.
    pub fn disable(&mut self) {
        self.count = 0;
        self.length = 0;
        self.slots = [Slot::EMPTY; SLOTS];
    }

    /// Writes sub-index 0: 0 takes the mapping out of use, a number puts that many into use.
    pub fn enable(
        &mut self,
        count: u32,
        direction: Direction,
        dictionary: &Dictionary,
    ) -> Result<(), Abort> {
        let before = self.count;
        self.count = u8::try_from(count).map_err(|_| Abort::Value)?;
        let done = self.resolve(direction, dictionary);
        if done.is_err() {
            self.count = before;
        }
        done
    }

    /// Writes one mapping entry; zero leaves it empty.
    pub fn write(
        &mut self,
        sub: u8,
        word: u32,
        direction: Direction,
        dictionary: &Dictionary,
    ) -> Result<(), Abort> {
        if self.count != 0 {
            return Err(Abort::UnsupportedAccess);
        }
        if word != 0 {
            resolve(word, direction, dictionary)?;
        }
        let at = usize::from(sub.wrapping_sub(1));
        *self.words.get_mut(at).ok_or(Abort::NoSubIndex)? = word;
        Ok(())
    }

    /// Finds the objects of all entries in use; where that is not possible, nothing changes.
    pub fn resolve(&mut self, direction: Direction, dictionary: &Dictionary) -> Result<(), Abort> {
        let used = self
            .words
            .get(..usize::from(self.count))
            .ok_or(Abort::PdoLength)?;
        let mut slots = [Slot::EMPTY; SLOTS];
        let mut length = 0;
        for (slot, word) in slots.iter_mut().zip(used) {
            *slot = resolve(*word, direction, dictionary)?;
            length += slot.size;
        }
        if length > 8 {
            return Err(Abort::PdoLength);
        }
        self.slots = slots;
        self.length = length;
        Ok(())
    }
}

fn resolve(word: u32, direction: Direction, dictionary: &Dictionary) -> Result<Slot, Abort> {
    let address = Address::new((word >> 16) as u16, (word >> 8) as u8);
    let dummy = match direction {
        Direction::Receive if address.sub == 0 => DataType::dummy(address.index),
        _ => None,
    };
    let (row, data_type) = match dummy {
        Some(data_type) => (None, data_type),
        None => {
            let row = dictionary.find(address)?;
            if !direction.allows(row.mapping()) {
                return Err(Abort::NotMappable);
            }
            (Some(row), row.data_type())
        }
    };
    match data_type.size() {
        Some(size) if u32::from(size) * 8 == word & 0xFF => Ok(Slot { size, row }),
        _ => Err(Abort::NotMappable),
    }
}
