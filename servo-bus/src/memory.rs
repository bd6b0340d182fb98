//! The bytes behind a control table.

use crate::table::{Field, Register, Sign, Table};

/// Addresses of a table: those of the XM430 end at 662.
const SIZE: usize = 662;

/// Bytes that hold the EEPROM of every table, from address 0 on.
pub const EEPROM: usize = 64;

/// Bytes that hold what a backup has, from address 0 on: the EEPROM, and the gains and the profile
/// of a Dynamixel.
const BACKUP: usize = 128;

/// Indirect addresses point to registers in RAM.
const RAM_OF_INDIRECT: i32 = 64;

/// Why a write is refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Refusal {
    /// No register, or one that may not be written now.
    Access,
    /// A part of a register.
    Length,
    /// A value outside the range of its register.
    Range,
    /// A value beyond the limit that another register sets.
    Limit,
}

/// The values of a servo's registers, what is stored of them, and which the bus has written.
#[derive(Debug, Clone)]
pub struct Memory {
    table: &'static Table,
    bytes: [u8; SIZE],
    stored: [u8; EEPROM],
    backup: [u8; BACKUP],
    /// A bit for each address.
    written: [u32; SIZE.div_ceil(32)],
}

impl Memory {
    /// A new servo's.
    pub fn new(table: &'static Table) -> Self {
        let mut memory = Self {
            table,
            bytes: [0; SIZE],
            stored: [0; EEPROM],
            backup: [0; BACKUP],
            written: [0; SIZE.div_ceil(32)],
        };
        for register in table.registers {
            memory.store(register.field, register.default);
        }
        memory.back_up(&[]);
        memory.restart();
        memory
    }

    /// What lasts without power.
    pub fn eeprom(&self) -> &[u8; EEPROM] {
        &self.stored
    }

    /// Starts with what lasted without power. A register whose value is out of its range, or which
    /// the bus may not write, has that of a new servo.
    ///
    /// ```
    /// use servo_bus::{Memory, tables::{STS3215, sts}};
    ///
    /// let mut before = Memory::new(&STS3215);
    /// before.store(sts::ID, 7);
    /// let mut after = Memory::new(&STS3215);
    /// after.load(before.eeprom());
    /// assert_eq!(after.get(sts::ID), 7);
    /// ```
    pub fn load(&mut self, eeprom: &[u8; EEPROM]) {
        let writable = |register: &&Register| register.is_eeprom && register.is_writable;
        for register in self.table.registers.iter().filter(writable) {
            let bytes = eeprom.get(range(register.field)).unwrap_or_default();
            let value = register.field.decode(bytes, self.table.order);
            if (register.min..=register.max).contains(&value) {
                self.store(register.field, value);
            }
        }
        self.back_up(&[]);
        self.restart();
    }

    /// The control table.
    pub fn table(&self) -> &'static Table {
        self.table
    }

    /// The value of a register.
    // Not inlined, as the next one: a servo has many calls.
    #[inline(never)]
    pub fn get(&self, field: Field) -> i32 {
        let bytes = self.bytes.get(range(field)).unwrap_or_default();
        field.decode(bytes, self.table.order)
    }

    /// Sets the value of a register, which the servo itself may always do.
    #[inline(never)]
    pub fn set(&mut self, field: Field, value: i32) {
        put(
            &mut self.bytes,
            field,
            field.encode(value, self.table.order),
        );
    }

    /// As [`Self::set`], and lasting without power.
    pub fn store(&mut self, field: Field, value: i32) {
        self.set(field, value);
        put(
            &mut self.stored,
            field,
            field.encode(value, self.table.order),
        );
    }

    /// Whether the bus has written a register since the last call.
    pub fn take_written(&mut self, field: Field) -> bool {
        let (word, bit) = bit_of(field);
        let Some(word) = self.written.get_mut(word) else {
            return false;
        };
        let is_written = *word & bit != 0;
        *word &= !bit;
        is_written
    }

    /// Keeps what is stored, and the present values of these registers, as a backup.
    pub fn back_up(&mut self, also: &[Field]) {
        self.backup = [0; BACKUP];
        for register in self.table.registers {
            let default = register.field.encode(register.default, self.table.order);
            put(&mut self.backup, register.field, default);
        }
        for (place, stored) in self.backup.iter_mut().zip(self.stored) {
            *place = stored;
        }
        for field in also {
            let value = field.encode(self.get(*field), self.table.order);
            put(&mut self.backup, *field, value);
        }
    }

    /// Stores the values of the backup, or of a new servo, but for these registers, and restarts.
    pub fn restore(&mut self, from_backup: bool, but: &[Field]) {
        for register in self
            .table
            .registers
            .iter()
            .filter(|r| !but.contains(&r.field))
        {
            let field = register.field;
            let kept = self.backed_up(field).filter(|_| from_backup);
            self.store(field, kept.unwrap_or(register.default));
        }
        self.restart();
        for register in self.table.registers {
            let kept = self.backed_up(register.field).filter(|_| from_backup);
            if let Some(kept) = kept.filter(|_| !register.is_eeprom) {
                self.set(register.field, kept);
            }
        }
    }

    /// The value of a register in the backup, if it has one.
    fn backed_up(&self, field: Field) -> Option<i32> {
        let bytes = self.backup.get(range(field))?;
        Some(field.decode(bytes, self.table.order))
    }

    /// The values after a start.
    pub fn restart(&mut self) {
        for register in self.table.registers {
            let field = register.field;
            let bytes = self.stored.get(range(field)).unwrap_or_default();
            let stored = field.decode(bytes, self.table.order);
            self.set(
                field,
                if register.is_eeprom {
                    stored
                } else {
                    register.default
                },
            );
        }
        for &(pointers, data, number) in self.table.indirect {
            for index in 0..number {
                self.set(pointer(pointers, index), i32::from(data + index));
            }
        }
        self.written = [0; SIZE.div_ceil(32)];
    }

    /// Whether all these addresses are within the table.
    pub fn contains(&self, address: u16, length: usize) -> bool {
        usize::from(address) + length <= usize::from(self.table.end)
    }

    /// Reads bytes; addresses without a register are 0.
    pub fn read(&self, address: u16, out: &mut [u8]) {
        for (place, address) in out.iter_mut().zip(address..=u16::MAX) {
            let target = usize::from(self.resolve(address));
            *place = self.bytes.get(target).copied().unwrap_or(0);
        }
    }

    /// Writes whole registers: all of them or, after a refusal, none. `check` decides on each, with
    /// the values before the write, and its new value.
    ///
    /// # Errors
    /// The first refusal.
    pub fn write(
        &mut self,
        address: u16,
        data: &[u8],
        check: impl Fn(&Self, &Register, i32) -> Result<(), Refusal>,
    ) -> Result<(), Refusal> {
        let before = self.clone();
        let written = self.write_whole(address, data, |register, value| {
            check(&before, register, value)
        });
        if written.is_err() {
            *self = before;
        }
        written
    }

    /// As [`Self::write`], but up to the first refusal.
    fn write_whole(
        &mut self,
        mut address: u16,
        mut data: &[u8],
        check: impl Fn(&Register, i32) -> Result<(), Refusal>,
    ) -> Result<(), Refusal> {
        while !data.is_empty() {
            let register = self.whole(address, data.len())?;
            let (bytes, rest) = data.split_at(usize::from(register.field.size));
            check(&register, self.checked(&register, bytes)?)?;
            self.commit(&register, bytes, true);
            address = address.saturating_add(u16::from(register.field.size));
            data = rest;
        }
        Ok(())
    }

    /// Writes bytes, also parts of registers. A register that may not be written, or whose value
    /// would be out of its range, keeps its value. `stores`: whether those of the EEPROM are kept.
    pub fn write_each(&mut self, address: u16, data: &[u8], stores: bool) {
        let (mut address, mut rest) = (address, data);
        while !rest.is_empty() {
            let count = match self.register_at(address) {
                Some(register) => self.write_part(&register, address, rest, stores),
                None => 1,
            };
            address = address.saturating_add(count as u16);
            rest = rest.get(count..).unwrap_or_default();
        }
    }

    /// Writes to a register from this of its addresses on; returns the number of bytes for it.
    fn write_part(
        &mut self,
        register: &Register,
        address: u16,
        data: &[u8],
        stores: bool,
    ) -> usize {
        let size = usize::from(register.field.size);
        let first = usize::from(address - register.field.address);
        let count = size.saturating_sub(first).min(data.len()).max(1);
        let mut bytes = [0; 4];
        self.read(register.field.address, &mut bytes);
        for (place, byte) in bytes.iter_mut().skip(first).zip(data.iter().take(count)) {
            *place = *byte;
        }
        let bytes = bytes.get(..size).unwrap_or_default();
        if self.checked(register, bytes).is_ok() {
            self.commit(register, bytes, stores);
        }
        count
    }

    /// The register that begins at this address, directly or by pointers to each of its bytes.
    fn whole(&self, address: u16, available: usize) -> Result<Register, Refusal> {
        let target = self.resolve(address);
        let register = self.register_at(target).ok_or(Refusal::Access)?;
        let size = u16::from(register.field.size);
        let follows =
            |index| self.resolve(address.saturating_add(index)) == target.saturating_add(index);
        let is_whole = target == register.field.address
            && usize::from(size) <= available
            && (1..size).all(follows);
        if is_whole {
            Ok(register)
        } else {
            Err(Refusal::Length)
        }
    }

    fn checked(&self, register: &Register, bytes: &[u8]) -> Result<i32, Refusal> {
        let value = register.field.decode(bytes, self.table.order);
        if !register.is_writable {
            return Err(Refusal::Access);
        }
        let is_within = (register.min..=register.max).contains(&value);
        is_within.then_some(value).ok_or(Refusal::Range)
    }

    fn commit(&mut self, register: &Register, bytes: &[u8], stores: bool) {
        let value = register.field.decode(bytes, self.table.order);
        if stores && register.is_eeprom {
            self.store(register.field, value);
        } else {
            self.set(register.field, value);
        }
        let (word, bit) = bit_of(register.field);
        if let Some(word) = self.written.get_mut(word) {
            *word |= bit;
        }
    }

    /// The register that contains this address; a pointer of indirect data too.
    fn register_at(&self, address: u16) -> Option<Register> {
        let is_of = |field: Field| range(field).contains(&usize::from(address));
        if let Some(register) = self
            .table
            .registers
            .iter()
            .find(|register| is_of(register.field))
        {
            return Some(*register);
        }
        let &(pointers, data, number) =
            self.table.indirect.iter().find(|(pointers, _, number)| {
                (*pointers..pointers + 2 * number).contains(&address)
            })?;
        let field = pointer(pointers, (address - pointers) / 2);
        Some(Register {
            #[cfg(feature = "names")]
            name: "indirect_address",
            #[cfg(feature = "names")]
            unit: "",
            #[cfg(feature = "names")]
            object: None,
            #[cfg(feature = "names")]
            meaning: "",
            field,
            is_writable: true,
            is_eeprom: false,
            min: RAM_OF_INDIRECT,
            max: i32::from(data + number - 1),
            default: 0,
        })
    }

    /// The address behind that of indirect data. A pointer to indirect data is not followed:
    /// without a register there, it reads as 0 and refuses writes.
    fn resolve(&self, address: u16) -> u16 {
        for &(pointers, data, number) in self.table.indirect {
            if (data..data + number).contains(&address) {
                return self.get(pointer(pointers, address - data)) as u16;
            }
        }
        address
    }
}

fn pointer(pointers: u16, index: u16) -> Field {
    Field {
        address: pointers + 2 * index,
        size: 2,
        sign: Sign::None,
    }
}

fn range(field: Field) -> core::ops::Range<usize> {
    let start = usize::from(field.address);
    start..start + usize::from(field.size)
}

/// Word and bit of a register among those that the bus has written.
fn bit_of(field: Field) -> (usize, u32) {
    (usize::from(field.address) / 32, 1 << (field.address % 32))
}

fn put(bytes: &mut [u8], field: Field, value: [u8; 4]) {
    for (place, byte) in bytes
        .iter_mut()
        .skip(usize::from(field.address))
        .take(usize::from(field.size))
        .zip(value)
    {
        *place = byte;
    }
}
