//! SDO abort codes (CiA 301, table 22).

/// SDO abort code: the reason for which an SDO transfer or an object access is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u32)]
pub enum Abort {
    /// Toggle bit not alternated.
    Toggle = 0x0503_0000,
    /// SDO protocol timed out.
    Timeout = 0x0504_0000,
    /// Command specifier not valid or unknown.
    Command = 0x0504_0001,
    /// Invalid block size.
    BlockSize = 0x0504_0002,
    /// Invalid sequence number.
    SequenceNumber = 0x0504_0003,
    /// CRC error.
    Crc = 0x0504_0004,
    /// Out of memory.
    OutOfMemory = 0x0504_0005,
    /// Unsupported access to an object.
    UnsupportedAccess = 0x0601_0000,
    /// Attempt to read a write-only object.
    WriteOnly = 0x0601_0001,
    /// Attempt to write a read-only object.
    ReadOnly = 0x0601_0002,
    /// Object does not exist in the object dictionary.
    NoObject = 0x0602_0000,
    /// Object cannot be mapped to the PDO.
    NotMappable = 0x0604_0041,
    /// The mapped objects would exceed the length of the PDO.
    PdoLength = 0x0604_0042,
    /// General parameter incompatibility.
    Incompatible = 0x0604_0043,
    /// General internal incompatibility in the device.
    InternalIncompatible = 0x0604_0047,
    /// Access failed due to a hardware error.
    Hardware = 0x0606_0000,
    /// Length of the service parameter does not match the data type.
    Length = 0x0607_0010,
    /// Length of the service parameter is too high.
    TooLong = 0x0607_0012,
    /// Length of the service parameter is too low.
    TooShort = 0x0607_0013,
    /// Sub-index does not exist.
    NoSubIndex = 0x0609_0011,
    /// Invalid value for the parameter.
    Value = 0x0609_0030,
    /// Value of the parameter is too high.
    TooHigh = 0x0609_0031,
    /// Value of the parameter is too low.
    TooLow = 0x0609_0032,
    /// Maximum value is less than minimum value.
    MaximumBelowMinimum = 0x0609_0036,
    /// Resource not available.
    NoResource = 0x060A_0023,
    /// General error.
    General = 0x0800_0000,
    /// Data cannot be transferred or stored to the application.
    Store = 0x0800_0020,
    /// Data cannot be transferred or stored because of local control.
    LocalControl = 0x0800_0021,
    /// Data cannot be transferred or stored because of the present device state.
    DeviceState = 0x0800_0022,
    /// No object dictionary is present.
    NoDictionary = 0x0800_0023,
    /// No data available.
    NoData = 0x0800_0024,
}

impl Abort {
    /// The code transmitted on the bus.
    ///
    /// ```
    /// assert_eq!(canopen::Abort::ReadOnly.code(), 0x0601_0002);
    /// ```
    #[must_use]
    pub const fn code(self) -> u32 {
        self as u32
    }
}
