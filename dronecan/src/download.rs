//! The download of a program: the node reads a file of the node that offers it.

use crate::application::Application;
use crate::{Payload, Reader};

/// Longest path of a file.
const PATH: usize = 200;

/// Bytes of a whole part of a file; a shorter one is the last.
const PART: usize = 256;

/// Time after which a part is requested again, us.
const RETRY_US: u64 = 500_000;

/// Requests of a part before the download is given up.
const TRIES: u8 = 10;

/// A file that is being read.
#[derive(Debug)]
pub(crate) struct Download {
    server: u8,
    path: [u8; PATH],
    length: usize,
    offset: u32,
    /// Number of the request without a response.
    transfer_id: u8,
    /// Requests of the present part.
    tries: u8,
    due_us: u64,
}

/// How a download goes on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Progress {
    Running,
    /// It has ended, well or not.
    Ended,
}

impl Download {
    /// The download of `BeginFirmwareUpdate` from a node; `None` for a path that is too long.
    pub fn new(request: &[u8], from: u8, now_us: u64) -> Option<Self> {
        let (server, path) = request.split_first()?;
        let mut stored = [0; PATH];
        stored.get_mut(..path.len())?.copy_from_slice(path);
        Some(Self {
            server: if *server == 0 { from } else { *server & 0x7F },
            path: stored,
            length: path.len(),
            offset: 0,
            transfer_id: 0,
            tries: 0,
            due_us: now_us,
        })
    }

    /// The node that has the file.
    pub const fn server(&self) -> u8 {
        self.server
    }

    /// The next request, of this number, if it is due.
    pub fn poll(&mut self, transfer_id: u8, now_us: u64) -> Option<Payload> {
        if now_us < self.due_us || self.tries >= TRIES {
            return None;
        }
        self.tries += 1;
        self.transfer_id = transfer_id;
        self.due_us = now_us.saturating_add(RETRY_US);
        let mut payload = Payload::new();
        let path = self.path.get(..self.length).unwrap_or(&[]);
        payload.unsigned(self.offset.into(), 40).put(path);
        Some(payload)
    }

    /// Whether no response has come to the last request.
    pub fn is_abandoned(&self, now_us: u64) -> bool {
        self.tries >= TRIES && now_us >= self.due_us
    }

    /// Takes the response of this number from the node that has the file.
    pub fn receive(
        &mut self,
        transfer_id: u8,
        response: &[u8],
        now_us: u64,
        app: &mut impl Application,
    ) -> Progress {
        if transfer_id != self.transfer_id || self.tries == 0 {
            return Progress::Running;
        }
        let mut reader = Reader::new(response);
        let error = reader.signed(16);
        let bytes = reader.rest();
        let is_read = reader.is_complete() && error == 0;
        if !is_read || !app.write_update(self.offset, bytes) {
            app.cancel_update();
            return Progress::Ended;
        }
        self.offset = self.offset.saturating_add(bytes.len() as u32);
        if bytes.len() < PART {
            if !app.end_update(self.offset) {
                app.cancel_update();
            }
            return Progress::Ended;
        }
        (self.tries, self.due_us) = (0, now_us);
        Progress::Running
    }
}
