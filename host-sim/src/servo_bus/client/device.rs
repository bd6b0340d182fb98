//! A servo by the names of its registers, and the end of its motion.

use servo_bus::{Register, Table};

use super::{Client, ServoError};

/// The most bytes of a read of several registers: as many as a sample of an STS, about.
const MOST_BYTES: u16 = 32;

/// `torque_enable` of a servo whose motor is driven; a Feetech with 2 is braked.
pub const TORQUE_ON: i32 = 1;

/// A servo and its control table.
#[derive(Debug, Clone, Copy)]
pub struct Device {
    /// Its ID.
    pub id: u8,
    /// Its control table.
    pub table: &'static Table,
}

impl Device {
    /// The register with this name.
    ///
    /// # Errors
    /// If the model has none.
    pub fn register(&self, name: &'static str) -> Result<&'static Register, ServoError> {
        let model = self.table.name;
        let register = self.table.register(name);
        register.ok_or(ServoError::Lacks { model, name })
    }

    /// Reads a register.
    ///
    /// # Errors
    /// If the model has none, without an answer, or for a refusal; those of the bus.
    pub fn read(&self, client: &mut Client, name: &'static str) -> Result<i32, ServoError> {
        let register = self.register(name)?;
        client.read(self.id, self.table, register.field)
    }

    /// Writes a register.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn write(
        &self,
        client: &mut Client,
        name: &'static str,
        value: i32,
    ) -> Result<(), ServoError> {
        client.write(self.id, self.table, self.register(name)?, value)
    }

    /// All registers and their values.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn read_all(
        &self,
        client: &mut Client,
    ) -> Result<Vec<(&'static Register, i32)>, ServoError> {
        let mut values = Vec::new();
        let registers: Vec<_> = self.table.registers.iter().collect();
        let mut rest = &*registers;
        while let Some(first) = rest.first() {
            let first = first.field.address;
            let end = |register: &&Register| {
                register.field.address + u16::from(register.field.size) - first
            };
            let count = rest
                .partition_point(|register| end(register) <= MOST_BYTES)
                .max(1);
            let (together, others) = rest.split_at(count);
            let length = together.iter().map(end).max().unwrap_or(0);
            let bytes = client.read_bytes(self.id, first, length as u8)?;
            for register in together.iter().copied() {
                let field = register.field;
                let start = usize::from(field.address - first);
                let bytes = bytes.get(start..start + usize::from(field.size));
                values.push((
                    register,
                    field.decode(bytes.unwrap_or_default(), self.table.order),
                ));
            }
            rest = others;
        }
        Ok(values)
    }

    /// Whether it is a Dynamixel.
    pub fn is_dynamixel(&self) -> bool {
        self.table.register("goal_pwm").is_some()
    }

    /// The register whose bits are its errors.
    pub fn error_register(&self) -> Result<&'static Register, ServoError> {
        self.register(match self.is_dynamixel() {
            true => "hardware_error_status",
            false => "status",
        })
    }

    /// Whether its motor is driven.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn is_driven(&self, client: &mut Client) -> Result<bool, ServoError> {
        Ok(self.read(client, "torque_enable")? == TORQUE_ON)
    }

    /// Checks that it answers writes.
    ///
    /// # Errors
    /// For a level of answers at which it does not; as [`Self::read`].
    pub fn require_answers(&self, client: &mut Client) -> Result<(), ServoError> {
        let (name, expected) = match self.is_dynamixel() {
            true => ("status_return_level", 2),
            false => ("response_level", 1),
        };
        let (id, level) = (self.id, self.read(client, name)?);
        if level == expected {
            return Ok(());
        }
        Err(ServoError::Silent {
            id,
            name,
            level,
            expected,
        })
    }

    /// The operating mode; an SCS0009 only has that of the position.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn mode(&self, client: &mut Client) -> Result<i32, ServoError> {
        match self.table.register("operating_mode") {
            Some(_) => self.read(client, "operating_mode"),
            None => Ok(0),
        }
    }

    /// Checks that the goals of its operating mode are angles.
    ///
    /// # Errors
    /// For another mode; as [`Self::read`].
    pub fn require_angles(&self, client: &mut Client) -> Result<(), ServoError> {
        let (modes, expected) = match self.is_dynamixel() {
            true => (3..=5, "3, 4 or 5"),
            false => (0..=0, "0"),
        };
        let (id, mode) = (self.id, self.mode(client)?);
        if modes.contains(&mode) {
            return Ok(());
        }
        Err(ServoError::Mode { id, mode, expected })
    }

    /// The goals that its operating mode permits, in steps.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn limits(&self, client: &mut Client) -> Result<(i32, i32), ServoError> {
        let goal = self.register("goal_position")?;
        let has_turns = self.is_dynamixel() && self.mode(client)? != 3;
        let least = self.read(client, "min_position_limit")?;
        let most = self.read(client, "max_position_limit")?;
        // An STS with 0 in both limits counts turns.
        let is_limited = !has_turns && (least, most) != (0, 0) && least <= most;
        Ok(if is_limited {
            (least, most)
        } else {
            (goal.min, goal.max)
        })
    }

    /// Makes the present position the goal; behind a limit, the limit, as a Dynamixel refuses the
    /// position there.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn hold(&self, client: &mut Client) -> Result<(), ServoError> {
        let (least, most) = self.limits(client)?;
        let position = self.read(client, "present_position")?;
        self.write(client, "goal_position", position.clamp(least, most))
    }

    /// Ends the motion: by a goal of 0, or the present position as the goal.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn halt(&self, client: &mut Client) -> Result<(), ServoError> {
        match (self.is_dynamixel(), self.mode(client)?) {
            (_, 1) => self.write(client, "goal_velocity", 0),
            (false, 2) => self.write(client, "goal_time", 0),
            (false, 3) => {
                // An increment is added to the goal, and the position is what is left of it.
                let left = self.read(client, "present_position")?;
                self.write(client, "goal_position", -left)
            }
            (true, 0) => self.write(client, "goal_current", 0),
            (true, 16) => self.write(client, "goal_pwm", 0),
            _ => self.hold(client),
        }
    }
}

/// The errors of a servo in words, by the bits that the meaning of the register names: `bits: 0
/// voltage 2 temperature`.
pub fn errors(register: &Register, value: i32) -> Vec<String> {
    let names = register.meaning.split_once("bits: ");
    let words: Vec<_> = names.map_or("", |(_, names)| names).split(' ').collect();
    let name = |bit: u32| {
        let mut pairs = words.chunks_exact(2);
        let named = pairs.find(|pair| pair[0].parse() == Ok(bit));
        named.map_or_else(|| format!("bit {bit}"), |pair| pair[1].to_owned())
    };
    let bits = (0..u8::BITS).filter(|bit| value & (1 << bit) != 0);
    bits.map(name).collect()
}

#[cfg(test)]
mod tests {
    use servo_bus::tables::{STS3215, XL330_M288};

    use super::*;

    #[test]
    fn errors_have_the_names_of_the_tables() {
        let of = |table: &'static Table| Device { id: 1, table }.error_register().unwrap();
        assert_eq!(errors(of(&STS3215), 0x21), ["voltage", "overload"]);
        assert_eq!(errors(of(&STS3215), 0x50), ["bit 4", "bit 6"]);
        assert_eq!(errors(of(&XL330_M288), 0x14), ["temperature", "shock"]);
        assert!(errors(of(&XL330_M288), 0).is_empty());
    }
}
