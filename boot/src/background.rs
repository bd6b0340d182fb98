//! What the program of the board writes while it drives: an image to the staging area, and records
//! to the log. Each call starts at most one operation of the flash and never waits for one.
//!
//! The order of the operations is that of the bootloader: the header of the staged image comes
//! last, and a record counts when it was read back. The supply is cut in each of these operations
//! in the tests of this crate.

use core::task::Poll;

use crate::{
    flash::{FlashError, PolledFlash},
    header::{CRC, HEADER_SIZE, Header},
    layout::{Region, Sector},
    log::{self, Place},
    record::State,
};

/// Why an image was not staged.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StageError {
    /// The program has another CRC than its header states.
    Program,
    /// The flash cannot be erased or written, or reads differently.
    Flash,
}

impl From<FlashError> for StageError {
    fn from(FlashError: FlashError) -> Self {
        Self::Flash
    }
}

/// Bytes of which the CRC is computed in a call: as long as a word is programmed.
const CHECKED_BYTES: u32 = 64;

/// The next step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Step {
    /// Erase the sector of this index.
    Erase(usize),
    /// Write the word at this offset behind the header's place.
    Program(u32),
    /// Compute the CRC of the program in the flash from this offset on.
    Check(u32, u32),
    /// Write the word of the header at this offset.
    Header(u32),
}

/// An image on its way to the staging area.
#[derive(Debug, Clone)]
pub struct Staging {
    region: Region,
    length: u32,
    step: Step,
}

impl Staging {
    /// An image of this many bytes, header included, which the region has room for.
    pub fn new(region: Region, length: u32) -> Self {
        Self {
            region,
            length,
            step: Step::Erase(0),
        }
    }

    /// Goes on with the image, whose bytes are in these elements, little endian. Ready once.
    ///
    /// # Errors
    /// Why the image is not staged. No header is in the staging area then.
    pub fn poll(
        &mut self,
        flash: &mut impl PolledFlash,
        image: &[i32],
    ) -> Poll<Result<(), StageError>> {
        match flash.ended() {
            Poll::Pending => return Poll::Pending,
            Poll::Ready(Err(error)) => return Poll::Ready(Err(error.into())),
            Poll::Ready(Ok(())) => {}
        }
        match self.step {
            Step::Erase(index) => match self.sector(index) {
                Some(sector) => {
                    flash.start_erase(sector.number);
                    self.step = Step::Erase(index.saturating_add(1));
                }
                None => self.step = Step::Program(HEADER_SIZE),
            },
            Step::Program(offset) if offset < self.length => {
                self.program(flash, image, offset);
                self.step = Step::Program(offset.saturating_add(4));
            }
            Step::Program(_) => self.step = Step::Check(HEADER_SIZE, CRC_START),
            Step::Check(offset, crc) if offset < self.length => {
                let bytes = CHECKED_BYTES.min(self.length.saturating_sub(offset));
                let address = self.region.start().saturating_add(offset);
                let crc = continued(crc, flash.bytes(address, bytes));
                self.step = Step::Check(offset.saturating_add(bytes), crc);
            }
            Step::Check(_, crc) => {
                let header = header_in(image);
                if header.is_none_or(|header| header.program_crc != !crc) {
                    return Poll::Ready(Err(StageError::Program));
                }
                self.step = Step::Header(0);
            }
            Step::Header(offset) if offset < HEADER_SIZE => {
                self.program(flash, image, offset);
                self.step = Step::Header(offset.saturating_add(4));
            }
            Step::Header(_) => {
                let staged = Header::read(flash.bytes(self.region.start(), HEADER_SIZE));
                let is_staged = staged.is_some() && staged == header_in(image);
                return Poll::Ready(is_staged.then_some(()).ok_or(StageError::Flash));
            }
        }
        Poll::Pending
    }

    /// The sector of this index, if the image reaches it.
    fn sector(&self, index: usize) -> Option<&Sector> {
        let end = self.region.start().saturating_add(self.length);
        let sector = self.region.sectors.get(index);
        sector.filter(|sector| sector.start < end)
    }

    fn program(&self, flash: &mut impl PolledFlash, image: &[i32], offset: u32) {
        let word = image
            .get((offset / 4) as usize)
            .map_or(u32::MAX, |word| *word as u32);
        if word != u32::MAX {
            flash.start_program(self.region.start().saturating_add(offset), word);
        }
    }
}

/// Start of a CRC-32 that [`continued`] computes piece by piece.
const CRC_START: u32 = u32::MAX;

/// The CRC register after these bytes. The result is its complement.
fn continued(register: u32, bytes: &[u8]) -> u32 {
    // The digest is continued from its register, which the algorithm reflects.
    let mut digest = CRC.digest_with_initial(register.reverse_bits());
    digest.update(bytes);
    !digest.finalize()
}

/// The header of the image in these elements.
pub fn header_in(image: &[i32]) -> Option<Header> {
    let mut bytes = [0; HEADER_SIZE as usize];
    let (words, _) = bytes.as_chunks_mut::<4>();
    for (to, from) in words.iter_mut().zip(image) {
        *to = from.to_le_bytes();
    }
    Header::read(&bytes)
}

/// A record on its way to the log.
#[derive(Debug, Clone)]
pub struct Appending {
    state: State,
    attempts: usize,
    place: Option<Place>,
    /// Words of it that are written, or being written.
    count: usize,
}

impl Appending {
    /// A record of this state.
    pub fn new(state: State) -> Self {
        Self {
            state,
            attempts: 0,
            place: None,
            count: 0,
        }
    }

    /// The state that the record contains.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// Goes on with the record. Ready once, after it was read back.
    ///
    /// # Errors
    /// The flash cannot be erased or written.
    pub fn poll(
        &mut self,
        flash: &mut impl PolledFlash,
        sectors: &[Sector; 2],
    ) -> Poll<Result<(), FlashError>> {
        let has_failed = match flash.ended() {
            Poll::Pending => return Poll::Pending,
            Poll::Ready(ended) => ended.is_err(),
        };
        let Some(place) = self.place.filter(|_| !has_failed) else {
            if self.attempts >= log::ATTEMPTS {
                return Poll::Ready(Err(FlashError));
            }
            self.attempts += 1;
            let place = log::next(flash, sectors);
            self.count = 0;
            self.place = Some(place);
            if let Some(sector) = place.erase {
                flash.start_erase(sector);
            }
            return Poll::Pending;
        };
        let words = self.state.words(place.sequence);
        match words.get(self.count) {
            Some(word) => {
                let offset = 4 * self.count as u32;
                flash.start_program(place.address.saturating_add(offset), *word);
                self.count += 1;
                Poll::Pending
            }
            None if log::record(flash, place.address) == words => Poll::Ready(Ok(())),
            None => {
                self.place = None;
                Poll::Pending
            }
        }
    }
}
