//! The CRC of the program, in software: the emulated chip has no model of the CRC unit.

/// The computation.
pub type CrcUnit = firmware::integrity::SoftwareCrc;
