//! Control tables as data.

/// How a value of a register has a sign.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sign {
    /// It has none.
    None,
    /// Two's complement.
    Two,
    /// Magnitude, and this bit for negative values.
    Bit(u8),
}

/// Where a register is, and how its value is encoded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Field {
    /// Address of its first byte.
    pub address: u16,
    /// Bytes: 1, 2 or 4.
    pub size: u8,
    /// Its sign.
    pub sign: Sign,
}

/// Order of the bytes of a value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Order {
    /// The low byte first.
    Little,
    /// The high byte first.
    Big,
}

/// A register.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Register {
    /// Its name.
    #[cfg(feature = "names")]
    pub name: &'static str,
    /// Its place.
    pub field: Field,
    /// Whether the bus may write it.
    pub is_writable: bool,
    /// Whether it lasts without power.
    pub is_eeprom: bool,
    /// Least value.
    pub min: i32,
    /// Greatest value.
    pub max: i32,
    /// Value of a new servo; of a register in RAM, after each start.
    pub default: i32,
    /// Unit of one.
    #[cfg(feature = "names")]
    pub unit: &'static str,
    /// Index and sub-index of the CANopen object with this quantity, on an actuator board that is
    /// this servo. A goal's object has the value of its profile at the time.
    #[cfg(feature = "names")]
    pub object: Option<(u16, u8)>,
    /// Meaning, and that of its values or bits; empty where the name says it.
    #[cfg(feature = "names")]
    pub meaning: &'static str,
}

/// The registers of a model by their address: those of its family, and its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Registers {
    pub(crate) of_family: &'static [Register],
    pub(crate) of_model: &'static [Register],
}

impl Registers {
    /// All of them.
    pub fn iter(&self) -> RegisterIter {
        RegisterIter { rest: *self }
    }
}

impl IntoIterator for Registers {
    type Item = &'static Register;
    type IntoIter = RegisterIter;

    fn into_iter(self) -> RegisterIter {
        self.iter()
    }
}

/// The registers of a model, in turn.
#[derive(Debug, Clone)]
pub struct RegisterIter {
    rest: Registers,
}

impl Iterator for RegisterIter {
    type Item = &'static Register;

    // Not inlined: a memory has many loops.
    #[inline(never)]
    fn next(&mut self) -> Option<&'static Register> {
        let Registers {
            of_family,
            of_model,
        } = &mut self.rest;
        let is_of_model = match (of_family.first(), of_model.first()) {
            (Some(one), Some(other)) => other.field.address < one.field.address,
            (one, _) => one.is_none(),
        };
        let rest = if is_of_model { of_model } else { of_family };
        let (register, others) = rest.split_first()?;
        *rest = others;
        Some(register)
    }
}

/// A control table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Table {
    /// Name of the model.
    #[cfg(feature = "names")]
    pub name: &'static str,
    /// Order of the bytes of a value.
    pub order: Order,
    /// The register that locks the EEPROM.
    pub lock: Option<Field>,
    /// Indirect registers: first address of the addresses, first address of the data, number.
    pub indirect: &'static [(u16, u16, u16)],
    /// The registers.
    pub registers: Registers,
    /// The first address behind all registers, also indirect ones.
    pub end: u16,
    /// Unit of currents, uA; 0 without a register for them.
    pub current_ua: u16,
}

#[cfg(feature = "names")]
impl Table {
    /// The register with this name.
    ///
    /// ```
    /// use servo_bus::tables::STS3215;
    ///
    /// assert_eq!(STS3215.register("goal_position").unwrap().field.address, 42);
    /// assert_eq!(STS3215.register("goal"), None);
    /// ```
    pub fn register(&self, name: &str) -> Option<&'static Register> {
        self.registers.iter().find(|register| register.name == name)
    }
}

impl Field {
    /// The value of these bytes.
    pub fn decode(&self, bytes: &[u8], order: Order) -> i32 {
        let mut raw = 0u32;
        for index in 0..bytes.len() {
            let place = match order {
                Order::Little => bytes.len() - 1 - index,
                Order::Big => index,
            };
            raw = raw << 8 | u32::from(bytes.get(place).copied().unwrap_or(0));
        }
        match self.sign {
            Sign::None => raw as i32,
            Sign::Two if self.size == 1 => i32::from(raw as u8 as i8),
            Sign::Two if self.size == 2 => i32::from(raw as u16 as i16),
            Sign::Two => raw as i32,
            Sign::Bit(bit) => {
                let flag = 1 << bit;
                let magnitude = (raw & (flag - 1)) as i32;
                if raw & flag == 0 {
                    magnitude
                } else {
                    -magnitude
                }
            }
        }
    }

    /// The bytes of a value, of which the first [`Self::size`] count.
    pub fn encode(&self, value: i32, order: Order) -> [u8; 4] {
        let raw = match self.sign {
            Sign::Bit(bit) => {
                let magnitude = value.unsigned_abs() & ((1 << bit) - 1);
                if value < 0 {
                    magnitude | 1 << bit
                } else {
                    magnitude
                }
            }
            Sign::None | Sign::Two => value as u32,
        };
        match (order, self.size) {
            (Order::Big, 2) => [(raw >> 8) as u8, raw as u8, 0, 0],
            (Order::Big, 4) => raw.to_be_bytes(),
            _ => raw.to_le_bytes(),
        }
    }
}
