//! A board that is updated, with the supply cut here and there: what runs after each start?

use core::task::Poll;
use std::{format, string::String, vec::Vec};

use super::{
    images::{HARDWARE, Remembering, header, image},
    model::{Model, PARAMETERS, SMALL},
};
use crate::{
    background::{Appending, Staging, header_in},
    flash::{FlashError, ReadFlash},
    header::HEADER_SIZE,
    install::{Bootloader, Cause, Decision},
    record::{Outcome, Phase, State},
};

/// Starts after which an update has ended, with a few to spare: one for the request, four for a
/// trial that fails, one after each of two cuts.
const STARTS: usize = 20;

/// Whether the new program works.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NewProgram {
    /// It confirms itself.
    Works,
    /// It never does.
    Fails,
}

/// An update of a board from one version to another.
#[derive(Debug)]
pub struct Update {
    old: Vec<u8>,
    new: Vec<u8>,
    program: NewProgram,
    verifier: Remembering,
}

impl Update {
    /// An update to a program that works, or not.
    pub fn new(program: NewProgram) -> Self {
        Self {
            old: image(1),
            new: image(2),
            program,
            verifier: Remembering::new(),
        }
    }

    /// A board with the old image, as a programmer leaves it.
    pub fn board(&self) -> Model {
        let mut flash = Model::new();
        flash.load(SMALL.slot.start(), &self.old);
        flash
    }

    fn bootloader<'a>(&'a self, flash: &'a mut Model) -> Bootloader<'a, Model, &'a Remembering> {
        Bootloader {
            flash,
            layout: &SMALL,
            hardware: HARDWARE,
            verifier: &self.verifier,
        }
    }

    /// Starts the board until the update has ended or the supply is cut; returns whether it has
    /// ended.
    ///
    /// # Errors
    /// What went wrong: the board waits for an image, or runs one that is not whole, not signed or
    /// not confirmed.
    pub fn run(&self, flash: &mut Model) -> Result<bool, String> {
        for start in 0..STARTS {
            flash.power_on();
            // The program restarts by itself or by its watchdog.
            let cause = if start == 0 {
                Cause::PowerOn
            } else {
                Cause::Restart
            };
            let decision = self.bootloader(flash).start(cause);
            if flash.is_off() {
                return Ok(false);
            }
            if self.program(flash, decision)? {
                return Ok(true);
            }
            if flash.is_off() {
                return Ok(false);
            }
        }
        Err(format!("not ended after {STARTS} starts"))
    }

    /// The program that the bootloader has started; returns whether the update has ended.
    fn program(&self, flash: &mut Model, decision: Decision) -> Result<bool, String> {
        let Decision::Run { is_trial } = decision else {
            return Err("no image runs".into());
        };
        let runs = |image: &Vec<u8>| flash.bytes(SMALL.slot.start(), image.len() as u32) == image;
        let (runs_old, runs_new) = (runs(&self.old), runs(&self.new));
        if !runs_old && !runs_new {
            return Err("an image runs that is not whole".into());
        }
        let state = self.bootloader(flash).state();
        match (is_trial, runs_new) {
            (true, false) => Err("the old image is on trial".into()),
            (true, true) if self.program == NewProgram::Works => {
                let confirmed = state.confirm(header(&self.new).version);
                let _ = append(flash, confirmed);
                Ok(false)
            }
            (true, true) => Ok(false),
            (false, true) if state.outcome != Outcome::Confirmed => {
                Err("a new image runs that was not confirmed".into())
            }
            (false, true) => Ok(true),
            (false, false) if state.outcome == Outcome::RolledBack => match self.program {
                NewProgram::Fails => Ok(true),
                NewProgram::Works => Err("a working image was rolled back".into()),
            },
            // A request that read right at one start only was refused, as the image was staged
            // again meanwhile.
            (false, false)
                if state.phase != Phase::Idle
                    || !matches!(state.outcome, Outcome::None | Outcome::Refused) =>
            {
                Err(format!("{state:?} with the old image"))
            }
            (false, false) => {
                let _ = self.update(flash);
                Ok(false)
            }
        }
    }

    /// Writes the new image to the staging area and requests its installation, as the program does.
    fn update(&self, flash: &mut Model) -> Result<(), FlashError> {
        let (words, _) = self.new.as_chunks::<4>();
        let image: Vec<i32> = words.iter().map(|word| i32::from_le_bytes(*word)).collect();
        let mut staging = Staging::new(SMALL.staging, self.new.len() as u32);
        let staged = repeated(|| staging.poll(flash, &image));
        staged.map_err(|_| FlashError)?;
        let state = self.bootloader(flash).state();
        let header = header_in(&image).ok_or(FlashError)?;
        append(flash, state.request(header.identity()))
    }

    /// Checks what must hold at the end.
    ///
    /// # Errors
    /// What does not.
    pub fn check_end(&self, flash: &Model) -> Result<(), String> {
        let expected = match self.program {
            NewProgram::Works => &self.new,
            NewProgram::Fails => &self.old,
        };
        if flash.bytes(SMALL.slot.start(), expected.len() as u32) != expected {
            return Err("another image than expected at the end".into());
        }
        let parameters = PARAMETERS.start as u32;
        let length = PARAMETERS.len() as u32;
        if flash.bytes(parameters, length) != Model::new().bytes(parameters, length) {
            return Err("the parameters have changed".into());
        }
        Ok(())
    }
}

/// The program appends a record.
fn append(flash: &mut Model, state: State) -> Result<(), FlashError> {
    let mut appending = Appending::new(state);
    repeated(|| appending.poll(flash, &SMALL.records))
}

/// Calls until the result is there, as the program does.
pub fn repeated<T>(mut poll: impl FnMut() -> Poll<T>) -> T {
    loop {
        if let Poll::Ready(ended) = poll() {
            return ended;
        }
    }
}

const _: () = assert!(HEADER_SIZE as usize + super::images::PROGRAM <= 768);
