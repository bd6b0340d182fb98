//! The programs of the boards on a bus.

use std::path::{Path, PathBuf};

use ::firmware::drive::ServoModel;
use virtual_board::board::ChipKind;
use virtual_board::faults::Planned;
use virtual_board::run::{Firmware, FirmwareError};

use super::bootloader::{BootOptions, Bootloader};
use crate::bounded::{self, MOST_BUILD};
use crate::error::Error;

/// In place of a program: an actuator that runs natively.
const NATIVE: &str = "native";

/// The program of an emulated actuator board.
pub struct Program {
    /// The program itself.
    pub firmware: Firmware,
    /// The chip that it is for.
    pub chip: ChipKind,
    /// The bootloader, if the board starts through it.
    pub boot: Option<Bootloader>,
}

impl Program {
    fn read(path: &Path, boot: &BootOptions<'_>) -> Result<Self, Error> {
        let firmware = firmware(path)?;
        let chip = firmware.actuator_chip().map_err(failed)?;
        Ok(Self {
            boot: Bootloader::read(boot, path, chip)?,
            firmware,
            chip,
        })
    }
}

/// The protocol that the parameters of the actuator boards select.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Interface {
    /// CANopen, with node-IDs from 1.
    CanOpen,
    /// DroneCAN.
    DroneCan,
    /// The servo bus, as this servo, with IDs from 1.
    ServoBus(ServoModel),
}

/// The programs of the boards.
pub struct Programs {
    /// Those of the first actuators and of all further ones; none for a native actuator.
    actuators: Vec<Option<Program>>,
    faults: Vec<Planned>,
    /// What the actuators are commanded by.
    pub interface: Interface,
}

impl Programs {
    /// Reads the ELF files of the first actuators, of which the last one is that of all further
    /// actuators too. The faults are those of the first emulated actuator board.
    ///
    /// # Errors
    /// For a file that is not the program of its board, for a bootloader or faults without an
    /// emulated actuator board, and for a native actuator on a servo bus.
    pub fn read(
        actuators: &[PathBuf],
        boot: &BootOptions<'_>,
        faults: Vec<Planned>,
        interface: Interface,
    ) -> Result<Self, Error> {
        let read = |path: &PathBuf| {
            let is_emulated = path != Path::new(NATIVE);
            is_emulated.then(|| Program::read(path, boot)).transpose()
        };
        let actuators = actuators.iter().map(read).collect::<Result<Vec<_>, _>>()?;
        let needs_one = boot.elf.is_some() || !faults.is_empty();
        if needs_one && actuators.iter().all(Option::is_none) {
            return Err(Error::Conflict(
                "--boot-elf and --faults need an emulated actuator board, and all are native"
                    .into(),
            ));
        }
        let is_servo_bus = matches!(interface, Interface::ServoBus(_));
        if is_servo_bus && actuators.iter().any(Option::is_none) {
            return Err(Error::Conflict(
                "--elf native: on a servo bus all actuators have emulated boards".into(),
            ));
        }
        Ok(Self {
            actuators,
            faults,
            interface,
        })
    }

    /// The program of the actuator with this number, from 1; none if it is native.
    pub fn of(&self, number: u8) -> Option<&Program> {
        let index = usize::from(number) - 1;
        let last = self.actuators.last();
        self.actuators.get(index).or(last)?.as_ref()
    }

    /// What kind of actuators there are with this number of them, before the noun.
    pub fn kind(&self, count: u8) -> &'static str {
        let emulated = (1..=count).filter(|number| self.of(*number).is_some());
        match emulated.count() {
            0 => "native ",
            all if all == usize::from(count) => "emulated ",
            _ => "emulated and native ",
        }
    }

    /// The faults of the actuator board with this number.
    pub fn faults(&self, number: u8) -> Vec<Planned> {
        let first = self.actuators.iter().position(Option::is_some);
        match first {
            Some(first) if first + 1 == usize::from(number) => self.faults.clone(),
            _ => Vec::new(),
        }
    }
}

/// Reads the program of the communication board.
///
/// # Errors
/// For a file that is not this program.
pub fn comm_board(path: &Path) -> Result<Firmware, Error> {
    let comm = firmware(path)?;
    comm.check_comm_board().map_err(failed)?;
    Ok(comm)
}

/// Reads the ELF file of a board's program.
///
/// # Errors
/// For a file that cannot be read or is not an ELF file.
pub fn firmware(path: &Path) -> Result<Firmware, Error> {
    let bytes = bounded::read(path, MOST_BUILD)?;
    Firmware::of(path, bytes).map_err(failed)
}

fn failed(error: FirmwareError) -> Error {
    Error::Board(error.to_string())
}
