//! Which images may be installed, and which may run.

use crate::{
    flash::ReadFlash,
    header::{CRC, HEADER_SIZE, Header, Version},
    layout::Region,
    signature::{Verifier, image_hash},
};

/// Why an image is refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Refusal {
    /// No image, or its header is damaged.
    NoHeader = 1,
    /// The length is 0, no multiple of 4, or larger than the slot.
    Length = 2,
    /// For other hardware.
    Hardware = 3,
    /// Not signed by the key of this bootloader.
    Signature = 4,
    /// The program is not the one whose hash is signed.
    Program = 5,
    /// Older than the version that runs, and no recovery image for that version.
    Version = 6,
}

/// What an image must fit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Policy {
    /// The hardware.
    pub hardware: u32,
    /// The latest version that was confirmed.
    pub floor: Version,
}

impl Policy {
    /// Whether an image of this header fits, apart from signature and program; `capacity` is the
    /// size of the slot.
    ///
    /// # Errors
    /// Why it does not.
    pub fn check(&self, header: &Header, capacity: u32) -> Result<(), Refusal> {
        if header.length == 0
            || !header.length.is_multiple_of(4)
            || header.length > capacity.saturating_sub(HEADER_SIZE)
        {
            return Err(Refusal::Length);
        }
        if header.hardware != self.hardware {
            return Err(Refusal::Hardware);
        }
        let is_recovery = header.replaces != Version::default() && header.replaces == self.floor;
        if header.version < self.floor && !is_recovery {
            return Err(Refusal::Version);
        }
        Ok(())
    }
}

/// The header of the image in a region, which may be installed: it fits, it is signed, and its
/// program is the one that was signed.
///
/// # Errors
/// Why it must not run.
pub fn acceptable(
    flash: &impl ReadFlash,
    region: &Region,
    capacity: u32,
    policy: &Policy,
    verifier: &impl Verifier,
) -> Result<Header, Refusal> {
    let header = header_of(flash, region).ok_or(Refusal::NoHeader)?;
    policy.check(&header, capacity.min(region.size()))?;
    if !verifier.verify(header.key, &header.signed(), &header.signature) {
        return Err(Refusal::Signature);
    }
    let program = program(flash, region, header.length);
    if image_hash(program) != header.hash || CRC.checksum(program) != header.program_crc {
        return Err(Refusal::Program);
    }
    Ok(header)
}

/// The header of the image in a region whose header and program have their CRC. The bootloader
/// alone writes the slot, after it has checked the signature: a start needs no more than this.
pub fn whole(flash: &impl ReadFlash, region: &Region) -> Option<Header> {
    let header = header_of(flash, region)?;
    let capacity = region.size().saturating_sub(HEADER_SIZE);
    if header.length > capacity {
        return None;
    }
    let crc = CRC.checksum(program(flash, region, header.length));
    (crc == header.program_crc).then_some(header)
}

/// The header in a region, whose program is not checked.
pub fn header_of(flash: &impl ReadFlash, region: &Region) -> Option<Header> {
    Header::read(flash.bytes(region.start(), HEADER_SIZE))
}

fn program<'a>(flash: &'a impl ReadFlash, region: &Region, length: u32) -> &'a [u8] {
    flash.bytes(region.start().saturating_add(HEADER_SIZE), length)
}
