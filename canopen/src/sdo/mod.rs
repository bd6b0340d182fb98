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
use block_download::BlockDownload;
use block_upload::BlockUpload;
use download::Download;
use segmented::{SegmentedDownload, SegmentedUpload};
use upload::Upload;

/// Longest string that is no constant and no DOMAIN.
pub(crate) const BUFFER: usize = 64;

/// A transfer without a frame for so long is aborted.
const TIMEOUT_US: u64 = 1_000_000;

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

#[derive(Clone, Copy, Debug)]
enum State {
    Idle,
    SegmentedDownload(SegmentedDownload),
    SegmentedUpload(SegmentedUpload),
    BlockDownload(BlockDownload),
    BlockUpload(BlockUpload),
    /// All data are there and the application is not ready with them; the reply when it is.
    Finishing(Download, Data),
}

/// The server and its only transfer.
#[derive(Debug)]
pub(crate) struct Server {
    state: State,
    address: Address,
    last_us: u64,
    reply: Option<Data>,
    buffer: [u8; BUFFER],
}

/// How a request goes on: the next state, and what is answered.
type Step = Result<(State, Option<Data>), Abort>;

impl Server {
    pub const fn new() -> Self {
        Self {
            state: State::Idle,
            address: Address::new(0, 0),
            last_us: 0,
            reply: None,
            buffer: [0; BUFFER],
        }
    }

    /// Ends the transfer, without telling the client.
    pub fn cancel(&mut self, objects: &mut impl Objects) {
        if let State::SegmentedDownload(SegmentedDownload { download, .. })
        | State::BlockDownload(BlockDownload { download, .. })
        | State::Finishing(download, _) = self.state
        {
            download.cancel(objects);
        }
        self.state = State::Idle;
        self.reply = None;
    }

    pub fn receive(&mut self, request: Data, objects: &mut impl Objects, now_us: u64) {
        self.last_us = now_us;
        let step = match self.state {
            _ if request[0] == 0x80 => return self.cancel(objects),
            State::BlockDownload(transfer) if transfer.takes_segments() => {
                transfer.segment(&request, &mut self.buffer, objects)
            }
            state => self.command(state, &request, objects),
        };
        self.take(step, objects);
    }

    fn command(&mut self, state: State, request: &Data, objects: &mut impl Objects) -> Step {
        let specifier = request[0] >> 5;
        let begins = matches!(specifier, 1 | 2)
            || (specifier == 5 && request[0] & 3 == 0)
            || (specifier == 6 && request[0] & 1 == 0);
        if begins {
            // A client that starts anew has given up what it had begun.
            self.cancel(objects);
            self.address = address(request);
        }
        let buffer = &mut self.buffer;
        match (specifier, state) {
            (1, _) => expedited::download(request, buffer, objects),
            (2, _) => expedited::upload(request, buffer, objects),
            (5, _) if begins => BlockUpload::begin(request, buffer, objects),
            (6, _) if begins => BlockDownload::begin(request, objects),
            (0, State::SegmentedDownload(transfer)) => transfer.segment(request, buffer, objects),
            (3, State::SegmentedUpload(transfer)) => transfer.segment(request, buffer, objects),
            (5, State::BlockUpload(transfer)) => transfer.answer(request),
            (6, State::BlockDownload(transfer)) => transfer.end(request, buffer, objects),
            _ => Err(Abort::Command),
        }
    }

    fn take(&mut self, step: Step, objects: &mut impl Objects) {
        match step {
            Ok((state, reply)) => {
                self.state = state;
                self.reply = reply;
            }
            Err(code) => self.abort(code, objects),
        }
    }

    fn abort(&mut self, code: Abort, objects: &mut impl Objects) {
        let idle = matches!(self.state, State::Idle);
        let begun = self.address;
        self.cancel(objects);
        let [low, high] = begun.index.to_le_bytes();
        let [a, b, c, d] = code.code().to_le_bytes();
        // Nothing was begun, and so nothing is named, where an idle server gets half a transfer.
        self.reply = Some(match (idle, code) {
            (true, Abort::Command) => [0x80, 0, 0, 0, a, b, c, d],
            _ => [0x80, low, high, begun.sub, a, b, c, d],
        });
    }

    pub fn tick(&mut self, objects: &mut impl Objects, now_us: u64) {
        if let State::Finishing(download, reply) = self.state {
            let step = download.finish(reply, &self.buffer, objects);
            // The client's patience is its own matter while the application works.
            self.last_us = now_us;
            return self.take(step, objects);
        }
        if !matches!(self.state, State::Idle) && now_us.saturating_sub(self.last_us) >= TIMEOUT_US {
            self.abort(Abort::Timeout, objects);
        }
    }

    pub fn transmit(&mut self, objects: &mut impl Objects, now_us: u64) -> Option<Data> {
        if let Some(reply) = self.reply.take() {
            return Some(reply);
        }
        let State::BlockUpload(mut transfer) = self.state else {
            return None;
        };
        match transfer.next(&self.buffer, objects) {
            Ok(segment) => {
                if segment.is_some() {
                    self.last_us = now_us;
                }
                self.state = State::BlockUpload(transfer);
                segment
            }
            Err(code) => {
                self.abort(code, objects);
                self.reply.take()
            }
        }
    }
}

/// Index and sub-index of a request.
fn address(request: &Data) -> Address {
    Address::new(u16::from_le_bytes([request[1], request[2]]), request[3])
}

/// The four bytes after them.
fn word(request: &Data) -> u32 {
    u32::from_le_bytes([request[4], request[5], request[6], request[7]])
}

/// An answer with the index and sub-index of the request.
fn reply(command: u8, request: &Data, word: u32) -> Data {
    let [a, b, c, d] = word.to_le_bytes();
    [command, request[1], request[2], request[3], a, b, c, d]
}
