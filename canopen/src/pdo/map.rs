//! PDO mapping.

use super::Direction;
use crate::Abort;
use crate::dictionary::{Address, DataType, Dictionary, Entry};

/// Maximum number of mapped objects: eight bytes, granularity of one byte.
const MAX_OBJECTS: usize = 8;

/// One mapped object.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MappedObject {
    /// Size in bytes; 0 for an unused element.
    pub size: u8,
    /// Its dictionary entry; `None` for a dummy entry, whose bytes in an RPDO are ignored.
    pub entry: Option<&'static Entry>,
}

/// PDO mapping parameter 16xxh or 1Axxh.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PdoMapping {
    entries: [u32; MAX_OBJECTS],
    count: u8,
    objects: [MappedObject; MAX_OBJECTS],
    length: u8,
}

impl MappedObject {
    const EMPTY: Self = Self {
        size: 0,
        entry: None,
    };
}

impl PdoMapping {
    pub const NEW: Self = Self {
        entries: [0; MAX_OBJECTS],
        count: 0,
        objects: [MappedObject::EMPTY; MAX_OBJECTS],
        length: 0,
    };

    /// Length of the PDO in bytes.
    pub const fn length(&self) -> u8 {
        self.length
    }

    /// The mapped object at a position; `None` beyond the last.
    pub fn object(&self, at: usize) -> Option<MappedObject> {
        self.objects
            .get(at)
            .copied()
            .filter(|object| object.size > 0)
    }

    pub fn maps(&self, address: Address) -> bool {
        self.objects
            .iter()
            .flat_map(|object| object.entry)
            .any(|entry| entry.address() == address)
    }

    pub fn read(&self, sub: u8) -> Option<u32> {
        match sub.checked_sub(1) {
            None => Some(u32::from(self.count)),
            Some(at) => self.entries.get(usize::from(at)).copied(),
        }
    }

    pub fn load(&mut self, sub: u8, value: u32) {
        match sub
            .checked_sub(1)
            .map(|at| self.entries.get_mut(usize::from(at)))
        {
            None => self.count = value.min(u32::from(u8::MAX)) as u8,
            Some(Some(word)) => *word = value,
            Some(None) => {}
        }
    }

    /// Disables the mapping; the mapping entries remain.
    pub fn disable(&mut self) {
        self.count = 0;
        self.length = 0;
        self.objects = [MappedObject::EMPTY; MAX_OBJECTS];
    }

    /// Writes sub-index 0, the number of mapped objects: 0 disables the mapping.
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

    /// Writes one mapping entry; zero clears it.
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
        *self.entries.get_mut(at).ok_or(Abort::NoSubIndex)? = word;
        Ok(())
    }

    /// Resolves all enabled mapping entries to objects; on an error nothing changes.
    pub fn resolve(&mut self, direction: Direction, dictionary: &Dictionary) -> Result<(), Abort> {
        let used = self
            .entries
            .get(..usize::from(self.count))
            .ok_or(Abort::PdoLength)?;
        let mut objects = [MappedObject::EMPTY; MAX_OBJECTS];
        let mut length = 0;
        for (object, word) in objects.iter_mut().zip(used) {
            *object = resolve(*word, direction, dictionary)?;
            length += object.size;
        }
        if length > 8 {
            return Err(Abort::PdoLength);
        }
        self.objects = objects;
        self.length = length;
        Ok(())
    }
}

fn resolve(
    word: u32,
    direction: Direction,
    dictionary: &Dictionary,
) -> Result<MappedObject, Abort> {
    let address = Address::new((word >> 16) as u16, (word >> 8) as u8);
    let dummy = match direction {
        Direction::Receive if address.sub == 0 => DataType::dummy(address.index),
        _ => None,
    };
    let (entry, data_type) = match dummy {
        Some(data_type) => (None, data_type),
        None => {
            let entry = dictionary.find(address)?;
            if !direction.allows(entry.mapping()) {
                return Err(Abort::NotMappable);
            }
            (Some(entry), entry.data_type())
        }
    };
    match data_type.size() {
        Some(size) if u32::from(size) * 8 == word & 0xFF => Ok(MappedObject { size, entry }),
        _ => Err(Abort::NotMappable),
    }
}
