//! `actuator serve --elf`: actuators whose boards are emulated.

use std::path::PathBuf;

use clap::Args;

use crate::error::Error;

/// Emulated boards in place of native actuators.
#[derive(Debug, Clone, Args)]
pub struct Boards {
    /// Folder `boards` of a release: all actuators run its program on emulated boards, behind its
    /// bootloader
    #[arg(long, value_name = "FOLDER", groups = ["emulated", "boot"])]
    #[arg(conflicts_with_all = ["elf", "comm_elf"])]
    boards: Option<PathBuf>,
    /// Program of the emulated actuator boards; repeated, those of actuators 1, 2 and so on
    ///
    /// The last one is that of all further actuators. `native` in place of a file stands for an
    /// actuator that is not emulated. The actuators of a CAN bus need --comm-elf too; servos on a
    /// serial bus (--protocol) do not.
    #[arg(long, value_name = "FILE", group = "emulated")]
    pub elf: Vec<PathBuf>,
    /// Program of the emulated communication board
    #[arg(long, value_name = "FILE", requires = "elf")]
    pub comm_elf: Option<PathBuf>,
    /// Bootloader of the emulated actuator boards, which starts the program
    #[cfg(feature = "board")]
    #[arg(long, value_name = "FILE", requires = "elf", group = "boot")]
    boot_elf: Option<PathBuf>,
    /// Private key that signs the program for the bootloader [default: the development key]
    #[cfg(feature = "board")]
    #[arg(long, value_name = "FILE", requires = "boot")]
    key: Option<PathBuf>,
    /// Keeps the flash in this file from one start to the next; that of node 2 in FILE.2, and so on
    #[cfg(feature = "board")]
    #[arg(long, value_name = "FILE", requires = "boot")]
    flash: Option<PathBuf>,
    /// Plan of faults of the first emulated actuator board
    #[cfg(feature = "board")]
    #[arg(long, value_name = "PLAN", requires = "emulated")]
    faults: Option<PathBuf>,
}

impl Boards {
    /// With the programs of the folder, where one is given.
    pub fn with_folder(&self) -> Self {
        let Some(folder) = &self.boards else {
            return self.clone();
        };
        Self {
            elf: vec![folder.join("actuator-board.elf")],
            comm_elf: Some(folder.join("comm-board.elf")),
            #[cfg(feature = "board")]
            boot_elf: Some(folder.join("actuator-boot.elf")),
            ..self.clone()
        }
    }

    /// The programs that this bus has: a communication board belongs to a CAN bus, and to no other.
    ///
    /// # Errors
    /// For actuators without it, and for servos with it.
    pub fn check(&self, is_serial: bool) -> Result<(), Error> {
        let problem = match (is_serial, self.comm_elf.is_some()) {
            (true, true) => "--comm-elf belongs to a CAN bus, and this protocol has a serial bus",
            (false, false) if !self.elf.is_empty() => {
                "--elf needs --comm-elf: emulated actuators are reached through a communication board"
            }
            _ => return Ok(()),
        };
        Err(Error::Conflict(problem.into()))
    }

    /// The number of actuators, which is that of the programs unless this one is given.
    ///
    /// # Errors
    /// For more programs than actuators.
    pub fn count(&self, given: Option<u8>) -> Result<u8, Error> {
        let programs = self.elf.len().max(1);
        let count = given.map_or(programs, usize::from);
        match u8::try_from(count) {
            Ok(actuators) if programs <= count && actuators <= 127 => Ok(actuators),
            _ => Err(Error::Conflict(format!(
                "{programs} programs (--elf) for {} actuators (--nodes)",
                count.min(127)
            ))),
        }
    }

    /// Reads the programs of the actuator boards.
    ///
    /// # Errors
    /// For a file that is not the program of its board, and for a plan that cannot be read.
    #[cfg(feature = "board")]
    pub fn read(
        &self,
        interface: crate::emulated::Interface,
    ) -> Result<crate::emulated::Programs, Error> {
        let boot = crate::emulated::BootOptions {
            elf: self.boot_elf.as_deref(),
            key: self.key.as_deref(),
            flash: self.flash.as_deref(),
        };
        let faults = self.faults.as_deref().map(crate::board::plan).transpose()?;
        let faults = faults.unwrap_or_default();
        crate::emulated::Programs::read(&self.elf, &boot, faults, interface)
    }
}
