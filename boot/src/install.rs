//! What the bootloader does at a start.

use crate::{
    check::{Policy, Refusal, acceptable, header_of, whole},
    flash::{Flash, FlashError},
    header::{HEADER_SIZE, Header},
    layout::{Layout, Region},
    log,
    record::{Outcome, Phase, State},
    signature::Verifier,
};

/// Starts of a trial before the image is given up.
pub const MAXIMUM_STARTS: u8 = 3;

/// What to do after the start.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Decision {
    /// Run the slot.
    Run {
        /// The image is not confirmed: it needs a watchdog.
        is_trial: bool,
    },
    /// There is no image that may run: wait for one.
    Wait,
}

/// A flash with its layout, and what an image must fit.
#[derive(Debug)]
pub struct Bootloader<'a, F, V> {
    /// The flash.
    pub flash: &'a mut F,
    /// Its layout.
    pub layout: &'a Layout,
    /// The hardware of the board.
    pub hardware: u32,
    /// Checks signatures.
    pub verifier: V,
}

/// Why the board starts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cause {
    /// Power-on, or the reset pin: the slot is checked as a whole.
    PowerOn,
    /// A watchdog, or the program itself. A confirmed image is only looked for: the outputs must
    /// become safe at once, and the program checks its own flash (`firmware::integrity`).
    Restart,
}

/// The next step of an update.
enum Next {
    Continue,
    End(Decision),
}

impl<F: Flash, V: Verifier> Bootloader<'_, F, V> {
    /// Continues an update that was interrupted, executes one that is requested, or runs the slot.
    ///
    /// A flash that cannot be written leaves the board waiting, with the log as it is: the next
    /// start tries again.
    pub fn start(&mut self, cause: Cause) -> Decision {
        loop {
            match self.step(cause) {
                Ok(Next::Continue) => {}
                Ok(Next::End(decision)) => return decision,
                Err(FlashError) => return Decision::Wait,
            }
        }
    }

    /// The present state.
    pub fn state(&self) -> State {
        log::newest(self.flash, &self.layout.records).map_or(State::FIRST, |newest| newest.state)
    }

    /// Checks whether the staged image may be installed.
    ///
    /// # Errors
    /// Why it must not run.
    pub fn check_staged(&self) -> Result<(), Refusal> {
        self.acceptable(&self.layout.staging, &self.state())
            .map(|_| ())
    }

    /// Requests that the staged image be installed at the next [`Bootloader::start`].
    ///
    /// # Errors
    /// Why the image is refused; nothing is changed then.
    pub fn request(&mut self) -> Result<Result<(), FlashError>, Refusal> {
        let state = self.state();
        let header = self.acceptable(&self.layout.staging, &state)?;
        Ok(self.append(state.request(header.identity())))
    }

    fn step(&mut self, cause: Cause) -> Result<Next, FlashError> {
        let Some(newest) = log::newest(self.flash, &self.layout.records) else {
            return self.first();
        };
        let state = newest.state;
        if state.phase == Phase::Idle {
            return self.run_or_repair(&state, cause);
        }
        if !defect::is(defect::Planted::StaleRecord) {
            // What follows is decided by a record of this start.
            self.append(state)?;
        }
        match state.phase {
            Phase::Idle => self.run_or_repair(&state, cause),
            Phase::Backup => self.back_up(state),
            Phase::Install => self.install(state),
            Phase::Trial => self.try_out(state),
            Phase::Restore => self.restore(state),
        }
    }

    /// The first start of a board, or one that has lost its log: the slot was written by a
    /// programmer, hence its signature is checked once.
    fn first(&mut self) -> Result<Next, FlashError> {
        let slot = self.acceptable(&self.layout.slot, &State::FIRST);
        let floor = slot.map(|header| header.version).unwrap_or_default();
        self.append(State {
            floor,
            ..State::FIRST
        })?;
        if slot.is_err() && whole(self.flash, &self.layout.slot).is_some() {
            // Whole, but not signed.
            self.erase(&self.layout.slot, HEADER_SIZE)?;
        }
        Ok(Next::Continue)
    }

    fn run_or_repair(&mut self, state: &State, cause: Cause) -> Result<Next, FlashError> {
        let decision = Decision::Run { is_trial: false };
        let found = match cause {
            Cause::PowerOn => whole(self.flash, &self.layout.slot),
            Cause::Restart => header_of(self.flash, &self.layout.slot),
        };
        if found.is_some() {
            return Ok(Next::End(decision));
        }
        // A word of the slot has changed. The image that was installed last may still be staged,
        // and after a rollback it is the backup.
        let source = match state.outcome {
            Outcome::Confirmed => (&self.layout.staging, state.image),
            _ => (&self.layout.backup, state.backup),
        };
        let (region, identity) = source;
        match self.acceptable(region, state) {
            Ok(header) if header.identity() == identity => {
                self.copy(region, &self.layout.slot, &header)?;
                Ok(Next::End(decision))
            }
            _ => Ok(Next::End(Decision::Wait)),
        }
    }

    fn back_up(&mut self, state: State) -> Result<Next, FlashError> {
        let staged = self.acceptable(&self.layout.staging, &state);
        if staged.is_ok_and(|header| header.identity() == state.image) {
            let slot = self.acceptable(&self.layout.slot, &state).ok();
            if defect::is(defect::Planted::InstallBeforeBackup) {
                self.append(state.with_phase(Phase::Install))?;
            }
            if let Some(header) = &slot {
                self.copy(&self.layout.slot, &self.layout.backup, header)?;
            }
            let backup = slot.map_or(0, |header| header.identity());
            let next = State { backup, ..state };
            self.append(next.with_phase(Phase::Install))?;
        } else {
            self.append(state.ended(Outcome::Refused))?;
        }
        Ok(Next::Continue)
    }

    fn install(&mut self, state: State) -> Result<Next, FlashError> {
        match self.acceptable(&self.layout.staging, &state) {
            Ok(header) if header.identity() == state.image => {
                if defect::is(defect::Planted::TrialBeforeCopy) {
                    self.append(state.with_phase(Phase::Trial))?;
                }
                self.copy(&self.layout.staging, &self.layout.slot, &header)?;
                self.append(state.with_phase(Phase::Trial))?;
            }
            // The staged image has changed since the request.
            _ => self.append(state.with_phase(Phase::Restore))?,
        }
        Ok(Next::Continue)
    }

    fn try_out(&mut self, state: State) -> Result<Next, FlashError> {
        let slot = whole(self.flash, &self.layout.slot);
        let is_whole = slot.is_some_and(|header| header.identity() == state.image)
            || defect::is(defect::Planted::TrialBeforeCopy);
        if !is_whole || state.starts >= MAXIMUM_STARTS {
            self.append(state.with_phase(Phase::Restore))?;
            return Ok(Next::Continue);
        }
        let starts = state.starts.saturating_add(1);
        self.append(State { starts, ..state })?;
        Ok(Next::End(Decision::Run { is_trial: true }))
    }

    fn restore(&mut self, state: State) -> Result<Next, FlashError> {
        let ended = match self.acceptable(&self.layout.backup, &state) {
            Ok(header) if header.identity() == state.backup => {
                self.copy(&self.layout.backup, &self.layout.slot, &header)?;
                state.ended(Outcome::RolledBack)
            }
            // There was no image before. The one that has failed must not run.
            _ => {
                self.erase(&self.layout.slot, HEADER_SIZE)?;
                state.ended(Outcome::Failed)
            }
        };
        self.append(ended)?;
        Ok(Next::Continue)
    }

    fn append(&mut self, state: State) -> Result<(), FlashError> {
        log::append(self.flash, &self.layout.records, &state)
    }

    fn acceptable(&self, region: &Region, state: &State) -> Result<Header, Refusal> {
        let policy = Policy {
            hardware: self.hardware,
            floor: state.floor,
        };
        let capacity = self.layout.slot.size();
        acceptable(self.flash, region, capacity, &policy, &self.verifier)
    }

    /// Erases the sectors of the first bytes of a region.
    pub(crate) fn erase(&mut self, region: &Region, length: u32) -> Result<(), FlashError> {
        let end = region.start().saturating_add(length);
        for sector in region.sectors.iter().filter(|sector| sector.start < end) {
            self.flash.erase(sector.number)?;
        }
        Ok(())
    }

    /// Copies an image and reads it back. The header comes last, so that an incomplete copy is
    /// none.
    fn copy(&mut self, from: &Region, to: &Region, header: &Header) -> Result<(), FlashError> {
        let length = HEADER_SIZE.saturating_add(header.length);
        self.erase(to, length)?;
        let (from, to) = (from.start(), to.start());
        for offset in (HEADER_SIZE..length).chain(0..HEADER_SIZE).step_by(4) {
            let word = self.flash.word(from.saturating_add(offset));
            if word != u32::MAX {
                self.flash.program(to.saturating_add(offset), word)?;
            }
        }
        if self.flash.bytes(from, length) == self.flash.bytes(to, length) {
            Ok(())
        } else {
            Err(FlashError)
        }
    }
}

/// Defects that the tests plant, to show that they find them.
mod defect {
    /// A defect.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum Planted {
        /// A record from before this start is trusted.
        StaleRecord,
        /// The record of the next phase is written before the backup is made.
        InstallBeforeBackup,
        /// The same before the image is copied.
        TrialBeforeCopy,
    }

    #[cfg(test)]
    std::thread_local! {
        pub static PLANTED: core::cell::Cell<Option<Planted>> =
            const { core::cell::Cell::new(None) };
    }

    #[cfg(test)]
    pub fn is(defect: Planted) -> bool {
        PLANTED.get() == Some(defect)
    }

    #[cfg(not(test))]
    pub const fn is(_: Planted) -> bool {
        false
    }
}

#[cfg(test)]
pub(crate) use defect::{PLANTED, Planted};
