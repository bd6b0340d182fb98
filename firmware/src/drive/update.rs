//! Firmware update while the drive goes on (CiA 302-3): the image comes by object 1F50h:1 into the
//! capture buffer, from where the program of the board stages it; 1F51h:1 requests its
//! installation by the bootloader.
//!
//! The image is checked here for what needs no key: header, length, hardware and version; while it
//! is staged, for its CRC. The bootloader checks the signature before it installs (`boot/`).
//!
//! A download that is broken off leaves its beginning in the capture buffer until a recording needs
//! it. Object 2104h has its identity and length, and the offset at which the next download continues.
//!
//! A new image is on trial until its self-test has passed: in the first second all measurements
//! have come, no control period was missed, and neither data nor program were found changed. An
//! image that fails restarts the board, and the bootloader gives it up after three starts.

use core::task::Poll;

use bootloader::{HEADER_SIZE, Outcome, Policy, Version, background::header_in};
use canopen::Abort;

use super::Drive;
use crate::{
    application::BoardState,
    capture::Capture,
    faults::{Fault, FaultSet},
    timing::{COMMUNICATION_PERIODS, periods, thousandths},
};

pub use bootloader::background::StageError;

/// What the program of the board has read of the bootloader.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Slots {
    /// Identity of the image that runs.
    pub identity: u32,
    /// Its version.
    pub version: Version,
    /// What a new image must fit.
    pub policy: Policy,
    /// Bytes for an image, its header included.
    pub capacity: u32,
    /// How the last installation ended.
    pub outcome: Outcome,
    /// Whether the image that runs is confirmed: only then another one is staged.
    pub is_confirmed: bool,
    /// The image in the staging area, if there is one that was not installed yet.
    pub staged: Option<Image>,
}

/// An image, or its beginning.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Image {
    /// The identity in its header.
    pub identity: u32,
    /// Bytes of it, header included.
    pub bytes: u32,
}

/// What the board has of the next image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kept {
    Nothing,
    /// So much of it, in the capture buffer.
    Beginning(Image),
    /// All of it: it is being staged, or is staged.
    Whole(Image),
}

impl Kept {
    fn image(self) -> Option<Image> {
        match self {
            Self::Nothing => None,
            Self::Beginning(image) | Self::Whole(image) => Some(image),
        }
    }
}

/// What the program of the board shall do.
#[derive(Debug)]
pub enum UpdateOrder<'a> {
    /// Write an image to the staging area, and return the buffer by [`Drive::staged`].
    Stage {
        /// The image, four bytes in each element, little endian.
        buffer: &'a mut [i32],
        /// Bytes of it.
        length: u32,
    },
    /// Write the record that the image which runs is confirmed, then call [`Drive::confirmed`].
    Confirm(Version),
    /// Write the request to install the image of this identity, then call [`Drive::requested`].
    Install(u32),
}

/// Error of the last download (CiA 302-3, object 1F57h).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Error {
    None = 0,
    NoValidProgram = 1,
    Write = 5,
}

/// The speed below which the shaft is at rest, mdeg/s: that of the end of a quick stop.
const REST_MDEG_S: u32 = 5_000;

/// Length of the self-test, control periods: a second.
const SELF_TEST_PERIODS: u32 = periods(1000) as u32;

/// Calls of the device from the request of an installation to the restart, 100 ms: its response has
/// left the board by then, on a bus that gives it a frame in that time.
const RESTART_CALLS: u8 = periods(100) as u8 * COMMUNICATION_PERIODS.len() as u8;

/// What an image that works does not report. Others, as an under-voltage, are not its own.
const FAILURES: FaultSet = FaultSet::of(&[
    Fault::EncoderInvalid,
    Fault::MeasurementLost,
    Fault::LoopOverrun,
    Fault::WatchdogReset,
    Fault::DataCorrupt,
    Fault::ProgramCorrupt,
]);

#[derive(Debug)]
enum Phase<'a> {
    Idle,
    /// The image is coming; so many of its bytes are there.
    Receiving(&'a mut [i32], u32),
    /// The image is complete and fits: its bytes.
    Received(&'a mut [i32], u32),
    /// The program of the board writes it.
    Staging,
}

/// What is to be done beside the image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Request {
    None,
    /// The program of the board is to confirm.
    Confirm,
    /// It is to request the installation.
    Install,
    /// It writes the record of one or the other.
    Writing,
    /// The board restarts after so many calls without power.
    Restart(u8),
}

/// The update.
#[derive(Debug)]
pub(super) struct Update<'a> {
    slots: Option<Slots>,
    phase: Phase<'a>,
    request: Request,
    error: Error,
    kept: Kept,
    /// Where in the image the next download begins, and where the present one began.
    next_offset: u32,
    offset: u32,
    /// The image is installed as soon as it is staged and the drive is at rest without power.
    is_to_install: bool,
}

impl<'a> Update<'a> {
    pub const NEW: Self = Self {
        slots: None,
        phase: Phase::Idle,
        request: Request::None,
        error: Error::None,
        kept: Kept::Nothing,
        next_offset: 0,
        offset: 0,
        is_to_install: false,
    };

    /// A download begins.
    pub fn begin(&mut self, capture: &mut Capture<'a>, size: Option<u32>) -> Result<(), Abort> {
        let slots = self.slots.ok_or(Abort::UnsupportedAccess)?;
        let is_idle = matches!(self.phase, Phase::Idle) && self.request == Request::None;
        if !slots.is_confirmed || !is_idle {
            return Err(Abort::DeviceState);
        }
        let offset = core::mem::take(&mut self.next_offset);
        if size.is_some_and(|size| size > slots.capacity.saturating_sub(offset)) {
            return Err(Abort::TooLong);
        }
        let buffer = capture.lend().ok_or(Abort::DeviceState)?;
        self.phase = Phase::Receiving(buffer, offset);
        self.error = Error::None;
        self.kept = Kept::Nothing;
        self.offset = offset;
        self.is_to_install = false;
        Ok(())
    }

    /// Where the next download continues, object 2104h:3.
    pub fn set_next_offset(&mut self, offset: u32) -> Result<(), Abort> {
        let is_known = match self.kept {
            Kept::Beginning(image) => offset == image.bytes,
            _ => false,
        };
        if offset != 0 && !is_known {
            return Err(Abort::Value);
        }
        self.next_offset = offset;
        Ok(())
    }

    /// A recording takes the buffer: the beginning of an image is lost.
    pub fn forget_beginning(&mut self) {
        if let Kept::Beginning(_) = self.kept {
            self.kept = Kept::Nothing;
            self.next_offset = 0;
        }
    }

    /// The next bytes.
    pub fn write(&mut self, offset: u32, data: &[u8]) -> Result<(), Abort> {
        let Phase::Receiving(buffer, received) = &mut self.phase else {
            return Err(Abort::DeviceState);
        };
        let start = self.offset.saturating_add(offset);
        for (at, byte) in (start as usize..).zip(data) {
            let place = buffer.get_mut(at / 4).ok_or(Abort::TooLong)?;
            let shift = 8 * (at as u32 % 4);
            *place = *place & !(0xff << shift) | i32::from(*byte) << shift;
        }
        *received = start.saturating_add(data.len() as u32);
        Ok(())
    }

    /// All bytes are there. The image is staged afterwards, which the flash status shows.
    pub fn end(&mut self, capture: &mut Capture<'a>, size: u32) -> Result<(), Abort> {
        match core::mem::replace(&mut self.phase, Phase::Idle) {
            Phase::Receiving(buffer, _) => match self.fitting(buffer, size) {
                Some(image) => {
                    self.phase = Phase::Received(buffer, image.bytes);
                    self.kept = Kept::Whole(image);
                    Ok(())
                }
                None => {
                    self.error = Error::NoValidProgram;
                    capture.take_back(buffer);
                    Err(Abort::Value)
                }
            },
            other => {
                self.phase = other;
                Err(Abort::DeviceState)
            }
        }
    }

    /// The client has given up, or is gone: it may continue later.
    pub fn cancel(&mut self, capture: &mut Capture<'a>) {
        match core::mem::replace(&mut self.phase, Phase::Idle) {
            Phase::Receiving(buffer, bytes) => {
                let header = header_in(buffer).filter(|_| bytes >= HEADER_SIZE);
                self.kept = header.map_or(Kept::Nothing, |header| {
                    let identity = header.identity();
                    Kept::Beginning(Image { identity, bytes })
                });
                capture.take_back(buffer);
            }
            other => self.phase = other,
        }
    }

    /// The image if its header fits, at the end of a download of this size.
    fn fitting(&self, buffer: &[i32], size: u32) -> Option<Image> {
        let slots = self.slots?;
        let header = header_in(buffer)?;
        let bytes = self.offset.saturating_add(size);
        let is_whole = bytes == HEADER_SIZE.saturating_add(header.length);
        let fits = slots.policy.check(&header, slots.capacity).is_ok();
        (is_whole && fits).then(|| Image {
            identity: header.identity(),
            bytes,
        })
    }

    /// The image that was received is to be installed.
    pub fn install_when_possible(&mut self) {
        self.is_to_install = true;
    }

    /// Whether an image is being received or installed.
    pub fn is_updating(&self) -> bool {
        self.is_to_install
            || !matches!(self.phase, Phase::Idle)
            || matches!(self.request, Request::Install | Request::Restart(_))
    }

    /// What the program of the board shall do, once.
    fn take_order(&mut self) -> Option<UpdateOrder<'a>> {
        match core::mem::replace(&mut self.phase, Phase::Idle) {
            Phase::Received(buffer, length) => {
                self.phase = Phase::Staging;
                return Some(UpdateOrder::Stage { buffer, length });
            }
            other => self.phase = other,
        }
        let order = match self.request {
            Request::Confirm => UpdateOrder::Confirm(self.slots?.version),
            Request::Install => UpdateOrder::Install(self.kept.image()?.identity),
            _ => return None,
        };
        self.request = Request::Writing;
        Some(order)
    }
}

impl<'a> Drive<'a> {
    /// Sets that the board has a bootloader. Without this, object 1F50h refuses.
    pub fn set_slots(&mut self, slots: Slots) {
        self.update.slots = Some(slots);
        let staged = slots.staged.filter(|_| slots.is_confirmed);
        self.update.kept = staged.map_or(Kept::Nothing, Kept::Whole);
    }

    /// What the program of the board shall do for an update, once.
    pub fn take_update(&mut self) -> Option<UpdateOrder<'a>> {
        self.update.take_order()
    }

    /// The end of [`UpdateOrder::Stage`]: its buffer, and how it ended.
    pub fn staged(&mut self, buffer: &'a mut [i32], result: Result<(), StageError>) {
        self.capture.take_back(buffer);
        self.update.phase = Phase::Idle;
        self.update.error = match result {
            Ok(()) => return,
            Err(StageError::Program) => Error::NoValidProgram,
            Err(StageError::Flash) => Error::Write,
        };
        self.update.kept = Kept::Nothing;
        self.update.is_to_install = false;
    }

    /// The end of [`UpdateOrder::Confirm`]. A record that cannot be written is tried again.
    pub fn confirmed(&mut self, is_written: bool) {
        self.update.request = Request::None;
        if let Some(slots) = self.update.slots.as_mut().filter(|_| is_written) {
            slots.is_confirmed = true;
            slots.policy.floor = slots.version;
            slots.outcome = Outcome::Confirmed;
        }
    }

    /// The end of [`UpdateOrder::Install`].
    pub fn requested(&mut self, is_written: bool) {
        if is_written {
            self.update.request = Request::Restart(RESTART_CALLS);
        } else {
            self.update.request = Request::None;
            self.update.error = Error::Write;
        }
    }

    /// One call of the device; returns whether the board shall restart now. It never does while the
    /// drive has power or the shaft moves.
    pub fn step_update(&mut self) -> bool {
        self.test_itself();
        if self.is_driving() || !self.is_at_rest() {
            return false;
        }
        match self.update.request {
            Request::Restart(0) => true,
            Request::Restart(calls) => {
                self.update.request = Request::Restart(calls.saturating_sub(1));
                false
            }
            _ => false,
        }
    }

    /// Judges an image on trial after its first second.
    fn test_itself(&mut self) {
        let is_on_trial = self.update.slots.is_some_and(|slots| !slots.is_confirmed);
        let tick = self.outputs.telemetry.tick;
        if !is_on_trial || self.update.request != Request::None || tick < SELF_TEST_PERIODS {
            return;
        }
        let has_started = self.outputs.state != BoardState::Initialising;
        // Without power most faults are present only, and not latched.
        let faults = self.latched().or(self.outputs.telemetry.present);
        let has_failed = !faults.and(FAILURES).is_empty();
        self.update.request = if has_started && !has_failed {
            Request::Confirm
        } else {
            Request::Restart(RESTART_CALLS)
        };
    }

    fn is_at_rest(&self) -> bool {
        thousandths(self.outputs.telemetry.rate).unsigned_abs() < REST_MDEG_S
    }

    /// Requests the installation of the staged image. The server has refused it while the drive has
    /// power.
    pub(super) fn install(&mut self) -> Result<(), Abort> {
        let update = &self.update;
        let is_whole = matches!(update.kept, Kept::Whole(_));
        let is_staged = is_whole && matches!(update.phase, Phase::Idle);
        if !is_staged || update.request != Request::None || !self.is_at_rest() {
            return Err(Abort::DeviceState);
        }
        self.update.request = Request::Install;
        Ok(())
    }

    /// Requests the installation that was asked for in advance, once it is possible.
    pub(super) fn install_if_asked(&mut self) {
        if self.update.is_to_install && !self.is_driving() && self.install().is_ok() {
            self.update.is_to_install = false;
        }
    }

    /// All bytes of an image are there.
    pub(super) fn end_download(&mut self, size: u32) -> Poll<Result<(), Abort>> {
        Poll::Ready(self.update.end(&mut self.capture, size))
    }

    /// Object 2104h: what the board has of the next image.
    pub(super) fn download(&self) -> Image {
        const NOTHING: Image = Image {
            identity: 0,
            bytes: 0,
        };
        self.update.kept.image().unwrap_or(NOTHING)
    }

    /// Object 2104h:3.
    pub(super) fn download_offset(&self) -> u32 {
        self.update.next_offset
    }

    /// Major and minor version of the program; 0.0 for one without bootloader.
    pub(super) fn program_version(&self) -> (u8, u8) {
        let Version(version) = self.update.slots.map_or(Version(0), |slots| slots.version);
        ((version >> 24) as u8, (version >> 12) as u8)
    }

    /// Object 1F56h.
    pub(super) fn program_identity(&self) -> u32 {
        self.update.slots.map_or(0, |slots| slots.identity)
    }

    /// Object 1F57h.
    pub(super) fn flash_status(&self) -> u32 {
        let outcome = self.update.slots.map_or(0, |slots| slots.outcome as u32);
        let is_trial = self.update.slots.is_some_and(|slots| !slots.is_confirmed);
        let is_busy = matches!(self.update.phase, Phase::Received(..) | Phase::Staging)
            || matches!(self.update.request, Request::Install | Request::Writing);
        u32::from(is_trial) << 24
            | outcome << 16
            | (self.update.error as u32) << 1
            | u32::from(is_busy)
    }
}
