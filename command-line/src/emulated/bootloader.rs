//! Boards that start through the bootloader, and keep their flash in a file.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::sync::mpsc::Receiver;

use bootloader::layout::STM32F427;
use bootloader::{ACTUATOR_BOARD, State, Version};
use host_sim::can::node_fault::Change;
use host_sim::file;
use program_image::signed::{Description, development_key, read_key, sign_elf};
use virtual_board::board::ChipKind;
use virtual_board::flash::{BASE, SIZE};
use virtual_board::run::{Firmware, Flow, Script, View};

use super::programs::Program;
use crate::bounded::{self, MOST_BUILD};
use crate::error::Error;

/// What the options of the command line say of the bootloader.
#[derive(Debug, Default)]
pub struct BootOptions<'a> {
    /// The ELF file of the bootloader.
    pub elf: Option<&'a Path>,
    /// The private key of the image; the development key without it.
    pub key: Option<&'a Path>,
    /// The file of the flash.
    pub flash: Option<&'a Path>,
}

/// The bootloader, and the flash of a board that it starts for the first time.
pub struct Bootloader {
    /// Its program.
    pub firmware: Firmware,
    contents: Vec<(u64, Vec<u8>)>,
    file: Option<PathBuf>,
}

impl Bootloader {
    /// The bootloader of these options, with this program in its slot; `None` without one.
    ///
    /// # Errors
    /// For a file that cannot be read, a program that is not linked for the slot, and a chip that
    /// has no bootloader.
    pub fn read(
        options: &BootOptions<'_>,
        program: &Path,
        chip: ChipKind,
    ) -> Result<Option<Self>, Error> {
        let Some(elf) = options.elf else {
            return Ok(None);
        };
        if chip != ChipKind::F427 {
            let problem = "--boot-elf: only the STM32F427 has a bootloader".to_owned();
            return Err(Error::Conflict(problem));
        }
        let key = options.key.map(read_key).transpose()?;
        let key = key.unwrap_or_else(development_key);
        let version = Version::parse(env!("CARGO_PKG_VERSION")).unwrap_or_default();
        let description = Description {
            hardware: ACTUATOR_BOARD,
            version,
            replaces: None,
        };
        let bytes = bounded::read(program, MOST_BUILD)?;
        let image = sign_elf(program, bytes, &description, &key)?;
        let idle = State {
            floor: version,
            ..State::FIRST
        };
        let record = idle.words(0);
        let record = record.iter().flat_map(|word| word.to_le_bytes()).collect();
        let firmware = super::firmware(elf)?;
        if firmware.actuator_chip().is_ok() || firmware.check_comm_board().is_ok() {
            let path = elf.display();
            let problem =
                format!("--boot-elf: {path} is the program of a board, expected the bootloader");
            return Err(Error::Conflict(problem));
        }
        Ok(Some(Self {
            firmware,
            contents: vec![
                (STM32F427.slot.start().into(), image),
                (STM32F427.records[0].start.into(), record),
            ],
            file: options.flash.map(Into::into),
        }))
    }

    /// The file of the flash of a board; that of the first board has the name that was given.
    pub fn file(&self, number: u8) -> Option<PathBuf> {
        let file = self.file.clone()?;
        if number == 1 {
            return Some(file);
        }
        let mut name = file.into_os_string();
        name.push(format!(".{number}"));
        Some(name.into())
    }

    /// The flash of a board: that of its file, if there is one; otherwise with the program, and
    /// with these contents besides.
    ///
    /// # Errors
    /// For a file that cannot be read, or is no flash.
    pub fn flash(
        &self,
        number: u8,
        others: Vec<(u64, Vec<u8>)>,
    ) -> Result<Vec<(u64, Vec<u8>)>, String> {
        let kept = self.file(number).filter(|file| file.exists());
        let Some(file) = kept else {
            return Ok([self.contents.clone(), others].concat());
        };
        let bytes = std::fs::read(&file);
        let bytes = bytes.map_err(|error| format!("{}: {error}", file.display()))?;
        if bytes.len() as u64 != SIZE {
            let found = bytes.len();
            let file = file.display();
            return Err(format!(
                "{file} has {found} bytes, expected the {SIZE} of a flash"
            ));
        }
        // The bootloader is that of this start.
        let slot = u64::from(STM32F427.slot.start());
        let rest = bytes.get((slot - BASE) as usize..).unwrap_or_default();
        let beside = others
            .into_iter()
            .filter(|(at, _)| !(BASE..BASE + SIZE).contains(at));
        Ok(beside.chain([(slot, rest.to_vec())]).collect())
    }
}

/// Applies the faults at run time, ends a run, and writes the flash into its file.
pub struct Keeper {
    /// Faults of the board.
    faults: Receiver<Change>,
    /// Set when the run is to end.
    stop: Arc<AtomicBool>,
    /// The file, if the flash is kept.
    file: Option<PathBuf>,
    /// Why the file was not written.
    error: Option<io::Error>,
}

impl Keeper {
    /// For the board with this number, which has this program.
    pub fn new(
        (program, number): (&Program, u8),
        faults: Receiver<Change>,
        stop: &Arc<AtomicBool>,
    ) -> Self {
        let boot = program.boot.as_ref();
        Self {
            faults,
            stop: Arc::clone(stop),
            file: boot.and_then(|boot| boot.file(number)),
            error: None,
        }
    }

    /// After the run.
    ///
    /// # Errors
    /// Why the file was not written.
    pub fn into_result(self) -> Result<(), String> {
        self.error.map_or(Ok(()), |error| Err(error.to_string()))
    }

    fn keep(&mut self, view: &mut View<'_>) -> Flow {
        for change in self.faults.try_iter() {
            change.apply_to(&mut view.plant.defects);
        }
        if !self.stop.load(Relaxed) {
            return Flow::Continue;
        }
        if let Some(file) = self.file.take() {
            let words = (BASE..BASE + SIZE).step_by(4);
            let bytes: Vec<u8> = words
                .flat_map(|at| view.word(at).unwrap_or(u32::MAX).to_le_bytes())
                .collect();
            self.error = file::write(&file, &bytes).err().map(io::Error::other);
        }
        Flow::End
    }
}

impl Script for Keeper {
    fn at_edge(&mut self, view: &mut View<'_>) -> Flow {
        self.keep(view)
    }

    fn at_poll(&mut self, view: &mut View<'_>) -> Flow {
        self.keep(view)
    }
}
