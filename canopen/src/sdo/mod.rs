//! SDO server (CiA 301, 7.2.4): one channel, the default one.

mod block_download;
mod block_upload;
mod crc;
mod download;
mod expedited;
mod segmented;
mod upload;

use core::task::Poll;

use crate::Abort;
use crate::dictionary::{Address, Row};
use crate::timer::Timer;

/// Longest string that is no constant and no DOMAIN.
pub(crate) const BUFFER: usize = 64;

/// A transfer without a frame for so long is aborted.
const TIMEOUT: Timer = Timer::ms(1000);

/// The data of one SDO frame.
pub(crate) type Data = [u8; 8];

/// What the server needs of the objects.
pub(crate) trait Objects {
    fn entry(&self, address: Address) -> Result<&'static Row, Abort>;
    /// Refuses what may not be written at all, now, or at this length.
    fn check_write(&self, row: &Row, length: Option<u32>) -> Result<(), Abort>;
    fn constant_text(&self, row: &Row) -> Option<&'static [u8]>;
    fn read(&mut self, row: &Row, buffer: &mut [u8]) -> Result<usize, Abort>;
    fn write(&mut self, row: &Row, data: &[u8]) -> Poll<Result<(), Abort>>;
    fn domain_size(&mut self, address: Address) -> Result<u32, Abort>;
    fn domain_read(&mut self, address: Address, offset: u32, to: &mut [u8]) -> Result<(), Abort>;
    fn domain_begin(&mut self, address: Address, size: Option<u32>) -> Result<(), Abort>;
    fn domain_write(&mut self, address: Address, offset: u32, data: &[u8]) -> Result<(), Abort>;
    fn domain_end(&mut self, address: Address, size: u32) -> Poll<Result<(), Abort>>;
    fn domain_cancel(&mut self, address: Address);
}

/// How far a transfer is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    /// There is none.
    Idle,
    SegmentedDownload,
    SegmentedUpload,
    /// The next frame is a segment of a block download.
    BlockDownload,
    /// The last segment of a block download is there; its end has to follow.
    BlockDownloaded,
    /// The size of a block upload was answered; the client has to start.
    BlockUpload,
    /// Segments of a block go out.
    BlockSending,
    /// The block is out and has to be confirmed.
    BlockSent,
    /// All blocks are confirmed and the end was sent.
    BlockUploaded,
    /// All data are there and the application is not ready with them; the reply is for when it is.
    Finishing,
}

/// Where the data come from, or go to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Place {
    /// The server's buffer.
    Buffer,
    /// A constant.
    Text(&'static [u8]),
    /// The application's.
    Domain,
}

/// The transfer under way, of any kind.
#[derive(Clone, Copy, Debug)]
struct Transfer {
    address: Address,
    place: Place,
    /// Bytes of an upload, or those that the client announced of a download.
    size: Option<u32>,
    /// Bytes that are received; of an upload those that are sent, of one in blocks those that are confirmed.
    offset: u32,
    /// The toggle bit of the next segment.
    toggle: u8,
    /// Segments of this block that came in order, or are out.
    sequence: u8,
    /// Segments that an uploaded block has.
    block: u8,
    /// Whether there is a checksum, which it is, and up to where it goes: segments that are sent again do not count again.
    checked: bool,
    crc: u16,
    summed: u32,
    /// The last segment of a block download, of which only the end tells how much is data.
    last: [u8; 7],
}

impl Transfer {
    const NEW: Self = Self {
        address: Address::new(0, 0),
        place: Place::Buffer,
        size: None,
        offset: 0,
        toggle: 0,
        sequence: 0,
        block: 0,
        checked: false,
        crc: 0,
        summed: 0,
        last: [0; 7],
    };
}

/// The server and its only transfer.
#[derive(Debug)]
pub(crate) struct Server {
    state: State,
    transfer: Transfer,
    timeout: Timer,
    reply: Option<Data>,
    buffer: [u8; BUFFER],
}

impl Server {
    pub const NEW: Self = Self {
        state: State::Idle,
        transfer: Transfer::NEW,
        timeout: Timer::OVER,
        reply: None,
        buffer: [0; BUFFER],
    };

    pub fn receive(&mut self, request: &Data, objects: &mut impl Objects) {
        self.timeout = TIMEOUT;
        self.reply = None;
        let done = match self.state {
            _ if request[0] == 0x80 => return self.cancel(objects),
            State::BlockDownload => self.block_segment(request, objects),
            _ => self.command(request, objects),
        };
        self.judge(done, objects);
    }

    fn command(&mut self, request: &Data, objects: &mut impl Objects) -> Result<(), Abort> {
        use State::{BlockDownloaded, SegmentedDownload, SegmentedUpload};
        use State::{BlockSending, BlockSent, BlockUpload, BlockUploaded};
        let specifier = request[0] >> 5;
        let begins = matches!(specifier, 1 | 2)
            || (specifier == 5 && request[0] & 3 == 0)
            || (specifier == 6 && request[0] & 1 == 0);
        if begins {
            // A client that starts anew has given up what it had begun.
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

    /// The next frame to the client.
    #[cfg_attr(target_os = "none", inline(never))]
    fn answer(&mut self, head: [u8; 4], word: u32) {
        let ([a, b, c, d], [e, f, g, h]) = (head, word.to_le_bytes());
        self.reply = Some([a, b, c, d, e, f, g, h]);
    }

    /// The same with index and sub-index.
    fn answer_of_object(&mut self, command: u8, word: u32) {
        let Address { index, sub } = self.transfer.address;
        let [low, high] = index.to_le_bytes();
        self.answer([command, low, high, sub], word);
    }

    /// Ends the transfer, without telling the client.
    pub fn cancel(&mut self, objects: &mut impl Objects) {
        use State::{BlockDownload, BlockDownloaded, Finishing, SegmentedDownload};
        let Transfer { address, place, .. } = self.transfer;
        if let SegmentedDownload | BlockDownload | BlockDownloaded | Finishing = self.state
            && (place == Place::Domain || matches!(address.index, 0x1010 | 0x1011))
        {
            objects.domain_cancel(address);
        }
        self.state = State::Idle;
        self.reply = None;
    }

    fn judge(&mut self, done: Result<(), Abort>, objects: &mut impl Objects) {
        if let Err(code) = done {
            self.abort(code, objects);
        }
    }

    fn abort(&mut self, code: Abort, objects: &mut impl Objects) {
        if self.state == State::Idle && code == Abort::Command {
            // Nothing was begun, and so nothing is named, where an idle server gets half a transfer.
            self.transfer.address = Address::new(0, 0);
        }
        self.cancel(objects);
        self.answer_of_object(0x80, code.code());
    }

    pub fn pass(&mut self, elapsed: Timer) {
        self.timeout.pass(elapsed);
    }

    pub fn tick(&mut self, objects: &mut impl Objects) {
        if self.state == State::Finishing {
            // The client's patience is its own matter while the application works.
            self.timeout = TIMEOUT;
            let done = self.finish(objects);
            self.judge(done, objects);
        } else if self.state != State::Idle && self.timeout.is_over() {
            self.abort(Abort::Timeout, objects);
        }
    }

    #[cfg_attr(target_os = "none", inline(never))]
    pub fn transmit(&mut self, objects: &mut impl Objects) -> Option<Data> {
        if self.state == State::Finishing {
            return None;
        }
        if self.reply.is_none() && self.state == State::BlockSending {
            self.timeout = TIMEOUT;
            let done = self.send_segment(objects);
            self.judge(done, objects);
        }
        self.reply.take()
    }
}

/// The four bytes after them.
fn word(request: &Data) -> u32 {
    u32::from_le_bytes([request[4], request[5], request[6], request[7]])
}
