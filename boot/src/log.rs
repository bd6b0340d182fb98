//! The log of states: two sectors to which records are appended, written in turn.
//!
//! The newest valid record counts. A record that a loss of power left incomplete fails its CRC and
//! is passed over. When a sector is full the other one is erased first, so that one sector always
//! holds the newest record.
//!
//! A word whose programming was interrupted may read differently at each start. Hence whoever acts
//! on a record appends it anew in the same start ([`append`] reads it back): what is done after
//! that was decided by a record that no loss of power has touched.

use crate::{
    flash::{Flash, FlashError, ReadFlash},
    layout::Sector,
    record::{FORMAT, FORMAT_OFFSET, SIZE, State, WORDS},
};

/// Attempts to append a record, each in the next place.
pub(crate) const ATTEMPTS: usize = 4;

/// The newest record.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Newest {
    /// The state that it holds.
    pub state: State,
    sequence: u32,
    /// Index of its sector.
    sector: usize,
    address: u32,
}

/// Where the next record goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Place {
    /// The sector to be erased first.
    pub erase: Option<u8>,
    /// The address of its first word.
    pub address: u32,
    /// Its sequence number.
    pub sequence: u32,
}

/// The newest record, if any.
pub fn newest(flash: &impl ReadFlash, sectors: &[Sector; 2]) -> Option<Newest> {
    let mut newest: Option<Newest> = None;
    for (number, sector) in sectors.iter().enumerate() {
        // Most places are erased: the first look is at one word.
        let is_record = |address: &u32| flash.word(address.saturating_add(FORMAT_OFFSET)) == FORMAT;
        for address in places(sector).filter(is_record) {
            let Some((sequence, state)) = State::read(record(flash, address)) else {
                continue;
            };
            if newest.is_none_or(|newest| newest.sequence < sequence) {
                newest = Some(Newest {
                    state,
                    sequence,
                    sector: number,
                    address,
                });
            }
        }
    }
    newest
}

/// Where the record after the newest one goes.
pub fn next(flash: &impl ReadFlash, sectors: &[Sector; 2]) -> Place {
    let [first, second] = sectors;
    let newest = newest(flash, sectors);
    // A record that was cut off may read right at a later start. It has the number behind that of
    // the newest one; what is written now, behind it, has a greater one.
    let sequence = newest.map_or(0, |newest| {
        let passed_over = passed_over(flash, sectors, &newest);
        newest.sequence.wrapping_add(1).wrapping_add(passed_over)
    });
    let begin = |sector: &Sector| Place {
        erase: Some(sector.number),
        address: sector.start,
        sequence,
    };
    let Some(Newest { sector, .. }) = newest else {
        return begin(first);
    };
    let (present, other) = match sector {
        0 => (first, second),
        _ => (second, first),
    };
    match free(flash, present) {
        Some(address) => Place {
            erase: None,
            address,
            sequence,
        },
        None => begin(other),
    }
}

/// Appends a record and reads it back.
///
/// # Errors
/// The flash cannot be erased or written.
pub fn append(
    flash: &mut impl Flash,
    sectors: &[Sector; 2],
    state: &State,
) -> Result<(), FlashError> {
    for _ in 0..ATTEMPTS {
        let place = next(flash, sectors);
        let words = state.words(place.sequence);
        let written = write(flash, &place, words);
        if written.is_ok() && record(flash, place.address) == words {
            return Ok(());
        }
    }
    Err(FlashError)
}

fn write(flash: &mut impl Flash, place: &Place, words: [u32; WORDS]) -> Result<(), FlashError> {
    if let Some(sector) = place.erase {
        flash.erase(sector)?;
    }
    for (offset, word) in (0..).step_by(4).zip(words) {
        flash.program(place.address.saturating_add(offset), word)?;
    }
    Ok(())
}

/// Number of places behind the newest record, in its sector, that are not erased.
fn passed_over(flash: &impl ReadFlash, sectors: &[Sector; 2], newest: &Newest) -> u32 {
    let Some(sector) = sectors.get(newest.sector) else {
        return 0;
    };
    let end = free(flash, sector).unwrap_or(sector.start.saturating_add(sector.size));
    (end.saturating_sub(newest.address) / SIZE).saturating_sub(1)
}

/// The first place behind the last one that is not erased; `None` if the sector is full.
fn free(flash: &impl ReadFlash, sector: &Sector) -> Option<u32> {
    let is_used = |address: &u32| record(flash, *address) != [u32::MAX; WORDS];
    let free = match places(sector).rev().find(is_used) {
        Some(last) => last.saturating_add(SIZE),
        None => sector.start,
    };
    (free.saturating_add(SIZE) <= sector.start.saturating_add(sector.size)).then_some(free)
}

/// The addresses of all records of a sector.
fn places(sector: &Sector) -> impl DoubleEndedIterator<Item = u32> {
    let start = sector.start;
    (0..sector.size / SIZE).map(move |number| start.saturating_add(number * SIZE))
}

pub(crate) fn record(flash: &impl ReadFlash, address: u32) -> [u32; WORDS] {
    let mut words = [0; WORDS];
    for (offset, word) in (0..).step_by(4).zip(&mut words) {
        *word = flash.word(address.saturating_add(offset));
    }
    words
}
