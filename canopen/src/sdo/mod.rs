//! SDO server (CiA 301, 7.2.4) with the default SDO channel.

mod block_download;
mod block_upload;
mod crc;
mod download;
mod expedited;
mod segmented;
mod upload;

use core::task::Poll;

use crate::Abort;
use crate::dictionary::{Address, Entry};
use crate::timer::Timer;

/// Maximum length of a string that is neither a constant nor a DOMAIN.
pub(crate) const BUFFER: usize = 64;

/// SDO timeout: a transfer without a frame for this time is aborted.
const TIMEOUT: Timer = Timer::from_ms(1000);

/// The data of one SDO frame.
pub(crate) type Data = [u8; 8];

/// Object access as required by the SDO server.
pub(crate) trait ObjectAccess {
    fn entry(&self, address: Address) -> Result<&'static Entry, Abort>;
    /// Returns an abort code if the object is not writable, is write-protected now, or has another
    /// length.
    fn check_write(&self, entry: &Entry, length: Option<u32>) -> Result<(), Abort>;
    fn constant_text(&self, entry: &Entry) -> Option<&'static [u8]>;
    fn read(&mut self, entry: &Entry, buffer: &mut [u8]) -> Result<usize, Abort>;
    fn write(&mut self, entry: &Entry, data: &[u8]) -> Poll<Result<(), Abort>>;
    fn domain_size(&mut self, address: Address) -> Result<u32, Abort>;
    fn domain_read(&mut self, address: Address, offset: u32, to: &mut [u8]) -> Result<(), Abort>;
    fn domain_begin(&mut self, address: Address, size: Option<u32>) -> Result<(), Abort>;
    fn domain_write(&mut self, address: Address, offset: u32, data: &[u8]) -> Result<(), Abort>;
    fn domain_end(&mut self, address: Address, size: u32) -> Poll<Result<(), Abort>>;
    fn domain_cancel(&mut self, address: Address);
}

/// State of the transfer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum TransferState {
    /// No transfer.
    Idle,
    SegmentedDownload,
    SegmentedUpload,
    /// Block download: the next frame is a segment.
    BlockDownload,
    /// Block download: the last segment is received, "end block download" must follow.
    BlockDownloaded,
    /// Block upload: initiated, "start upload" must follow.
    BlockUpload,
    /// Block upload: segments of a block are being transmitted.
    BlockSending,
    /// Block upload: the block is transmitted, its confirmation must follow.
    BlockSent,
    /// Block upload: all blocks are confirmed, "end block upload" is transmitted.
    BlockUploaded,
    /// All data are received and the application is busy; the reply follows when it has finished.
    Finishing,
}

/// Source of uploaded or destination of downloaded data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum DataLocation {
    /// The server's buffer.
    Buffer,
    /// A constant string.
    Text(&'static [u8]),
    /// A DOMAIN of the application.
    Domain,
}

/// The transfer in progress, of any type.
#[derive(Clone, Copy, Debug)]
struct Transfer {
    address: Address,
    location: DataLocation,
    /// Size of an upload, or size that the client indicated for a download, in bytes.
    size: Option<u32>,
    /// Bytes received (download), transmitted (segmented upload) or confirmed (block upload).
    offset: u32,
    /// Toggle bit of the next segment.
    toggle: u8,
    /// Segments of this block received in order, or transmitted.
    sequence: u8,
    /// Block size of an upload, in segments.
    block: u8,
    /// Whether the transfer uses a CRC, its value, and the offset up to which it is calculated:
    /// repeated segments are not included again.
    uses_crc: bool,
    crc: u16,
    crc_offset: u32,
    /// Last segment of a block download; "end block download" indicates how many of its bytes are
    /// data.
    last: [u8; 7],
}

impl Transfer {
    const NEW: Self = Self {
        address: Address::new(0, 0),
        location: DataLocation::Buffer,
        size: None,
        offset: 0,
        toggle: 0,
        sequence: 0,
        block: 0,
        uses_crc: false,
        crc: 0,
        crc_offset: 0,
        last: [0; 7],
    };
}

/// The SDO server with its one transfer.
#[derive(Debug)]
pub(crate) struct SdoServer {
    state: TransferState,
    transfer: Transfer,
    timeout: Timer,
    reply: Option<Data>,
    buffer: [u8; BUFFER],
}

impl SdoServer {
    pub const NEW: Self = Self {
        state: TransferState::Idle,
        transfer: Transfer::NEW,
        timeout: Timer::EXPIRED,
        reply: None,
        buffer: [0; BUFFER],
    };

    pub fn receive(&mut self, request: &Data, objects: &mut impl ObjectAccess) {
        self.timeout = TIMEOUT;
        self.reply = None;
        let done = match self.state {
            _ if request[0] == 0x80 => return self.cancel(objects),
            TransferState::BlockDownload => self.block_segment(request, objects),
            _ => self.command(request, objects),
        };
        self.abort_on_error(done, objects);
    }

    fn command(&mut self, request: &Data, objects: &mut impl ObjectAccess) -> Result<(), Abort> {
        use TransferState::{BlockDownloaded, SegmentedDownload, SegmentedUpload};
        use TransferState::{BlockSending, BlockSent, BlockUpload, BlockUploaded};
        let specifier = request[0] >> 5;
        let begins = matches!(specifier, 1 | 2)
            || (specifier == 5 && request[0] & 3 == 0)
            || (specifier == 6 && request[0] & 1 == 0);
        if begins {
            // A new initiate request implies that the client has given up the previous transfer.
            self.cancel(objects);
            let index = u16::from_le_bytes([request[1], request[2]]);
            self.transfer = Transfer {
                address: Address::new(index, request[3]),
                ..Transfer::NEW
            };
        }
        match (specifier, self.state) {
            (1, _) => self.download(request, objects),
            (2, _) => self.upload(objects),
            (5, _) if begins => self.begin_block_upload(request, objects),
            (6, _) if begins => self.begin_block_download(request, objects),
            (0, SegmentedDownload) => self.download_segment(request, objects),
            (3, SegmentedUpload) => self.upload_segment(request, objects),
            (5, BlockUpload | BlockSending | BlockSent | BlockUploaded) => {
                self.continue_block_upload(request)
            }
            (6, BlockDownloaded) => self.end_block_download(request, objects),
            _ => Err(Abort::Command),
        }
    }

    /// Sets the reply to the client.
    fn answer(&mut self, head: [u8; 4], word: u32) {
        let ([a, b, c, d], [e, f, g, h]) = (head, word.to_le_bytes());
        self.reply = Some([a, b, c, d, e, f, g, h]);
    }

    /// Sets a reply that carries index and sub-index.
    fn answer_with_object(&mut self, command: u8, word: u32) {
        let Address { index, sub } = self.transfer.address;
        let [low, high] = index.to_le_bytes();
        self.answer([command, low, high, sub], word);
    }

    /// Ends the transfer without a reply to the client.
    pub fn cancel(&mut self, objects: &mut impl ObjectAccess) {
        use TransferState::{BlockDownload, BlockDownloaded, Finishing, SegmentedDownload};
        let Transfer {
            address, location, ..
        } = self.transfer;
        if let SegmentedDownload | BlockDownload | BlockDownloaded | Finishing = self.state
            && (location == DataLocation::Domain || matches!(address.index, 0x1010 | 0x1011))
        {
            objects.domain_cancel(address);
        }
        self.state = TransferState::Idle;
        self.reply = None;
    }

    fn abort_on_error(&mut self, done: Result<(), Abort>, objects: &mut impl ObjectAccess) {
        if let Err(code) = done {
            self.abort(code, objects);
        }
    }

    fn abort(&mut self, code: Abort, objects: &mut impl ObjectAccess) {
        if self.state == TransferState::Idle && code == Abort::Command {
            // A segment without a transfer has no object to name in the abort.
            self.transfer.address = Address::new(0, 0);
        }
        self.cancel(objects);
        self.answer_with_object(0x80, code.code());
    }

    pub fn advance(&mut self, elapsed: Timer) {
        self.timeout.advance(elapsed);
    }

    pub fn tick(&mut self, objects: &mut impl ObjectAccess) {
        if self.state == TransferState::Finishing {
            // No time-out on the server's side while the application is busy.
            self.timeout = TIMEOUT;
            let done = self.finish(objects);
            self.abort_on_error(done, objects);
        } else if self.state != TransferState::Idle && self.timeout.is_expired() {
            self.abort(Abort::Timeout, objects);
        }
    }

    pub fn transmit(&mut self, objects: &mut impl ObjectAccess) -> Option<Data> {
        if self.state == TransferState::Finishing {
            return None;
        }
        if self.reply.is_none() && self.state == TransferState::BlockSending {
            self.timeout = TIMEOUT;
            let done = self.send_segment(objects);
            self.abort_on_error(done, objects);
        }
        // Without a reply, as in most cycles, nothing is copied.
        self.reply.is_some().then(|| self.reply.take()).flatten()
    }
}

/// Bytes 4 to 7 of a request.
fn word(request: &Data) -> u32 {
    u32::from_le_bytes([request[4], request[5], request[6], request[7]])
}
