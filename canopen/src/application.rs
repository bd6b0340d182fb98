//! The interface between the CANopen device and its application.

use core::task::Poll;

use crate::dictionary::{Address, Entry};
use crate::{Abort, ErrorCode, NmtState, NodeId};

/// Kind of reset.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reset {
    /// Power-on or NMT "reset node": all objects take their power-on values.
    Node,
    /// NMT "reset communication": only the communication objects take their power-on values.
    Communication,
}

/// Group of parameters that 1010h stores and 1011h restores.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ParameterGroup {
    /// Sub-index 1.
    All,
    /// Sub-index 2: 1000h to 1FFFh.
    Communication,
    /// Sub-index 3: application parameters, 6000h to 9FFFh and related manufacturer objects.
    Application,
    /// Sub-indices 4 to 127: manufacturer-specific.
    Manufacturer(u8),
}

impl ParameterGroup {
    pub(crate) const fn from_sub(sub: u8) -> Self {
        match sub {
            1 => Self::All,
            2 => Self::Communication,
            3 => Self::Application,
            other => Self::Manufacturer(other),
        }
    }

    /// Whether the group contains the communication parameters.
    #[must_use]
    pub const fn has_communication(self) -> bool {
        matches!(self, Self::All | Self::Communication)
    }
}

/// Time of day of a TIME message (CiA 301, 7.2.6).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TimeOfDay {
    /// Milliseconds after midnight.
    pub milliseconds: u32,
    /// Days since 1984-01-01.
    pub days: u16,
}

/// Network event reported to the application.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event {
    /// The NMT state changed, by an NMT command or by the error behaviour object 1029h.
    NmtState(NmtState),
    /// A SYNC was received or transmitted and the synchronous RPDOs are applied; its counter, if
    /// any.
    Sync(Option<u8>),
    /// An RPDO was applied; RPDO number, from 1.
    Rpdo(u8),
    /// An RPDO was not received within its event time; RPDO number, from 1.
    RpdoTimeout(u8),
    /// A consumed heartbeat timed out; node-ID of the producer.
    HeartbeatLost(u8),
    /// The first heartbeat of a producer was received, initially or after a time-out; its node-ID.
    HeartbeatStarted(u8),
    /// A TIME message was received.
    Time(TimeOfDay),
    /// LSS configured this node-ID; it takes effect with the next reset communication.
    NodeId(Option<NodeId>),
    /// An error was raised.
    Error(ErrorCode),
}

/// LSS bit rate (CiA 305, bit timing table 0).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BitRate {
    /// 1 Mbit/s.
    Kbit1000,
    /// 800 kbit/s.
    Kbit800,
    /// 500 kbit/s.
    Kbit500,
    /// 250 kbit/s.
    Kbit250,
    /// 125 kbit/s.
    Kbit125,
    /// 50 kbit/s.
    Kbit50,
    /// 20 kbit/s.
    Kbit20,
    /// 10 kbit/s.
    Kbit10,
    /// Automatic detection.
    Automatic,
}

/// The application that owns the values of the object dictionary.
///
/// Numbers are passed as `u64`: the bits of the data type, signed integers sign-extended to 64
/// bits, so that `value as i32` is correct for every signed type of up to 32 bits. The server
/// checks access, length, limits and relations before each call. Only entries of the dictionary
/// are passed; return [`Abort::NoObject`] for any other.
///
/// A method that returns [`Poll::Pending`] is called again with the same arguments from
/// [`Node::tick`](crate::Node::tick) until it returns [`Poll::Ready`]: erasing flash takes longer
/// than a control period.
#[allow(
    unused_variables,
    reason = "default implementations refuse; parameter names document the interface"
)]
pub trait Application {
    /// Reads an object.
    ///
    /// # Errors
    ///
    /// The reason for which the object cannot be read now.
    fn read(&mut self, entry: &Entry) -> Result<u64, Abort>;

    /// Writes an object.
    ///
    /// # Errors
    ///
    /// The reason for which the value is refused; the object must be unchanged. With
    /// [`Abort::NoResource`] an SDO is not refused: its reply waits, and the write is repeated with
    /// each [`Node::tick`](crate::Node::tick).
    fn write(&mut self, entry: &Entry, value: u64) -> Result<(), Abort>;

    /// Whether objects marked [`guarded`](crate::dictionary::Entry::guarded) are write-protected
    /// now, and LSS does not change a node-ID and a bit rate that are configured. A drive returns
    /// whether it is enabled.
    fn guarded(&self) -> bool {
        false
    }

    /// Whether an SDO that writes this object waits now: its reply is withheld, and the write is
    /// checked and repeated with each [`Node::tick`](crate::Node::tick). A drive returns whether a
    /// command that was written before has still to act, so that a parameter acts behind it.
    fn defers(&self, entry: &Entry) -> bool {
        false
    }

    /// Reads a string that is not a constant, of at most 64 bytes, into `buffer`; returns its
    /// length.
    ///
    /// # Errors
    ///
    /// The reason for which the string cannot be read now.
    fn read_bytes(&mut self, address: Address, buffer: &mut [u8]) -> Result<usize, Abort> {
        Err(Abort::NoData)
    }

    /// Writes a string.
    ///
    /// # Errors
    ///
    /// The reason for which the value is refused.
    fn write_bytes(&mut self, address: Address, value: &[u8]) -> Result<(), Abort> {
        Err(Abort::UnsupportedAccess)
    }

    /// Opens a DOMAIN for upload; returns its size in bytes.
    ///
    /// # Errors
    ///
    /// The reason for which the domain cannot be read now.
    fn domain_size(&mut self, address: Address) -> Result<u32, Abort> {
        Err(Abort::NoData)
    }

    /// Fills all of `buffer`, at most seven bytes, with the content of a DOMAIN from `offset`. A
    /// block upload that lost frames reads the same offsets again.
    ///
    /// # Errors
    ///
    /// The reason for which the domain can no longer be read.
    fn domain_read(
        &mut self,
        address: Address,
        offset: u32,
        buffer: &mut [u8],
    ) -> Result<(), Abort> {
        Err(Abort::NoData)
    }

    /// Begins a download to a DOMAIN; `size` is the size that the client indicated.
    ///
    /// # Errors
    ///
    /// The reason for which the download is refused.
    fn domain_begin(&mut self, address: Address, size: Option<u32>) -> Result<(), Abort> {
        Err(Abort::UnsupportedAccess)
    }

    /// Receives the next bytes of a download, in order, at most seven. They are not verified yet.
    ///
    /// # Errors
    ///
    /// The reason for which the bytes are refused.
    fn domain_write(&mut self, address: Address, offset: u32, data: &[u8]) -> Result<(), Abort> {
        Err(Abort::UnsupportedAccess)
    }

    /// Completes a download: all `size` bytes are received and their checksum is correct.
    fn domain_end(&mut self, address: Address, size: u32) -> Poll<Result<(), Abort>> {
        Poll::Ready(Err(Abort::UnsupportedAccess))
    }

    /// A download to a DOMAIN was aborted: discard the received data. For an address of 1010h or
    /// 1011h, the requester of a pending store or restore ([`Poll::Pending`]) aborted.
    fn domain_cancel(&mut self, address: Address) {}

    /// The node is being reset; its communication objects take their power-on values after this
    /// call.
    fn reset(&mut self, reset: Reset) {}

    /// The stored value of a communication object; `None` if none is stored or its default is
    /// restored.
    fn stored(&mut self, address: Address) -> Option<u32> {
        None
    }

    /// Stores parameters (1010h). `communication` yields the communication parameters of the
    /// server, which [`Application::stored`] returns later.
    fn store(
        &mut self,
        group: ParameterGroup,
        communication: &mut dyn Iterator<Item = (Address, u32)>,
    ) -> Poll<Result<(), Abort>> {
        Poll::Ready(Err(Abort::Hardware))
    }

    /// Restores default parameters (1011h); they take effect at the next reset.
    fn restore(&mut self, group: ParameterGroup) -> Poll<Result<(), Abort>> {
        Poll::Ready(Err(Abort::Hardware))
    }

    /// Reports a network event.
    fn event(&mut self, event: Event) {}

    /// Whether the device supports the bit rate.
    fn supports_bit_rate(&self, bit_rate: BitRate) -> bool {
        false
    }

    /// Switches to this bit rate now; the node transmits nothing during the switch delay before and
    /// after it.
    fn set_bit_rate(&mut self, bit_rate: BitRate) {}

    /// Stores the LSS node-ID and bit rate; `None` means not configured.
    ///
    /// # Errors
    ///
    /// [`Abort::UnsupportedAccess`] if the device has no storage, any other code if storing failed.
    fn store_lss(
        &mut self,
        node_id: Option<NodeId>,
        bit_rate: Option<BitRate>,
    ) -> Poll<Result<(), Abort>> {
        Poll::Ready(Err(Abort::UnsupportedAccess))
    }
}
