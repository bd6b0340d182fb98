//! What the server asks of its user.

use core::task::Poll;

use crate::dictionary::Address;
use crate::{Abort, ErrorCode, NmtState, NodeId};

/// Why the node was reset.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reset {
    /// Power-on, or NMT "reset node": everything takes the values of power-on.
    Node,
    /// NMT "reset communication": only the communication objects do.
    Communication,
}

/// Which parameters 1010h stores, and 1011h restores.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ParameterGroup {
    /// Sub-index 1.
    All,
    /// Sub-index 2: 1000h to 1FFFh.
    Communication,
    /// Sub-index 3: 6000h to 9FFFh, and what belongs to it.
    Application,
    /// Sub-indices 4 to 127, as the manufacturer likes.
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

    /// Whether the communication parameters are among them.
    #[must_use]
    pub const fn has_communication(self) -> bool {
        matches!(self, Self::All | Self::Communication)
    }
}

/// Time of day as a TIME message carries it (CiA 301, 7.2.6).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TimeOfDay {
    /// Milliseconds after midnight.
    pub milliseconds: u32,
    /// Days since 1984-01-01.
    pub days: u16,
}

/// What happened on the network.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event {
    /// The NMT state changed, by a master or by 1029h.
    State(NmtState),
    /// A SYNC was received or sent: synchronous RPDOs have been applied. With its counter.
    Sync(Option<u8>),
    /// An RPDO was applied; its number from 1.
    Rpdo(u8),
    /// An RPDO did not come within its event time; its number from 1.
    RpdoTimeout(u8),
    /// A consumed heartbeat stayed out; the node-ID of its producer.
    HeartbeatLost(u8),
    /// A consumed heartbeat is there, for the first time or again.
    HeartbeatStarted(u8),
    /// A TIME message.
    Time(TimeOfDay),
    /// LSS gave the node this node-ID; it is used from the next reset of communication on.
    NodeId(Option<NodeId>),
    /// An error was raised.
    Error(ErrorCode),
}

/// Bit rate by LSS (CiA 305, table of bit timing 0).
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

/// The application behind the object dictionary.
///
/// Numbers come and go as `u64`: the bits of the data type, signed integers extended to 64 bits, so
/// that `value as i32` is right for every signed type of up to 32 bits. The server has checked access, length,
/// limits and relations before it calls. Addresses that no hook knows cannot occur, as all of
/// them are in the dictionary; answer [`Abort::NoObject`].
///
/// A hook that returns [`Poll::Pending`] is called again, with the same arguments, from
/// [`Node::tick`](crate::Node::tick) until it is ready: erasing flash takes longer than a control period.
#[allow(
    unused_variables,
    reason = "the defaults refuse; their parameters are named for the documentation"
)]
pub trait Application {
    /// The value of an object.
    ///
    /// # Errors
    ///
    /// Why it cannot be read now.
    fn read(&mut self, address: Address) -> Result<u64, Abort>;

    /// A new value for an object.
    ///
    /// # Errors
    ///
    /// Why it is refused; nothing may have changed then.
    fn write(&mut self, address: Address, value: u64) -> Result<(), Abort>;

    /// Whether objects marked as guarded must not change now: a drive answers whether it is enabled.
    fn guarded(&self) -> bool {
        false
    }

    /// A string that is no constant, of at most 64 bytes: fills `buffer` from its start and says
    /// how much.
    ///
    /// # Errors
    ///
    /// Why it cannot be read now.
    fn read_bytes(&mut self, address: Address, buffer: &mut [u8]) -> Result<usize, Abort> {
        Err(Abort::NoData)
    }

    /// A new value for a string.
    ///
    /// # Errors
    ///
    /// Why it is refused.
    fn write_bytes(&mut self, address: Address, value: &[u8]) -> Result<(), Abort> {
        Err(Abort::UnsupportedAccess)
    }

    /// Opens a DOMAIN for upload and says how many bytes it has.
    ///
    /// # Errors
    ///
    /// Why it cannot be read now.
    fn domain_size(&mut self, address: Address) -> Result<u32, Abort> {
        Err(Abort::NoData)
    }

    /// Fills all of `buffer` with what a DOMAIN has from `offset` on; at most seven bytes. A block transfer
    /// that lost frames reads again what it has read.
    ///
    /// # Errors
    ///
    /// Why it cannot be read any more.
    fn domain_read(
        &mut self,
        address: Address,
        offset: u32,
        buffer: &mut [u8],
    ) -> Result<(), Abort> {
        Err(Abort::NoData)
    }

    /// A download to a DOMAIN begins; `size` is what the client announced.
    ///
    /// # Errors
    ///
    /// Why it is refused.
    fn domain_begin(&mut self, address: Address, size: Option<u32>) -> Result<(), Abort> {
        Err(Abort::UnsupportedAccess)
    }

    /// The next bytes of a download, in order, at most seven. They are not yet to be relied on.
    ///
    /// # Errors
    ///
    /// Why they are refused.
    fn domain_write(&mut self, address: Address, offset: u32, data: &[u8]) -> Result<(), Abort> {
        Err(Abort::UnsupportedAccess)
    }

    /// All `size` bytes of a download are there, and their checksum is right.
    fn domain_end(&mut self, address: Address, size: u32) -> Poll<Result<(), Abort>> {
        Poll::Ready(Err(Abort::UnsupportedAccess))
    }

    /// A download to a DOMAIN ended before its end: what came of it is void. Or, with an address of 1010h or 1011h, nobody
    /// waits any more for a store or a restore that was [`Poll::Pending`].
    fn domain_cancel(&mut self, address: Address) {}

    /// The node was reset and its communication objects are about to take their power-on values.
    fn reset(&mut self, reset: Reset) {}

    /// The stored value of a communication object, if one was stored and not restored since.
    fn stored(&mut self, address: Address) -> Option<u32> {
        None
    }

    /// Stores parameters (1010h). `communication` gives those of the server, for [`Application::stored`].
    fn store(
        &mut self,
        group: ParameterGroup,
        communication: &mut dyn Iterator<Item = (Address, u32)>,
    ) -> Poll<Result<(), Abort>> {
        Poll::Ready(Err(Abort::Hardware))
    }

    /// Makes parameters take their defaults at the next reset (1011h).
    fn restore(&mut self, group: ParameterGroup) -> Poll<Result<(), Abort>> {
        Poll::Ready(Err(Abort::Hardware))
    }

    /// Something happened on the network.
    fn event(&mut self, event: Event) {}

    /// Whether the bit rate can be set.
    fn supports_bit_rate(&self, bit_rate: BitRate) -> bool {
        false
    }

    /// Switch to this bit rate now; the node is silent before and after.
    fn set_bit_rate(&mut self, bit_rate: BitRate) {}

    /// Stores node-ID and bit rate (LSS); `None` is what was not configured.
    ///
    /// # Errors
    ///
    /// [`Abort::UnsupportedAccess`] where nothing can be stored, any other where storing failed.
    fn store_lss(
        &mut self,
        node_id: Option<NodeId>,
        bit_rate: Option<BitRate>,
    ) -> Poll<Result<(), Abort>> {
        Poll::Ready(Err(Abort::UnsupportedAccess))
    }
}
