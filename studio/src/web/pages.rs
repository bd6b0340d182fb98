//! The way from all other threads to the pages.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::Relaxed};
use std::sync::mpsc::{SyncSender, TrySendError};

use mio::Waker;
use serde_json::Value;
use tungstenite::Bytes;

/// Number of a page, which is not used again.
pub type PageId = u64;

/// A message for pages.
#[derive(Debug, Clone)]
pub enum Message {
    /// To one page.
    One(PageId, String),
    /// To all pages.
    All(String),
    /// Samples that were recorded before, to one page.
    Past(PageId, Bytes),
    /// Samples, to all pages: their number and their bytes.
    Samples(u64, Bytes),
}

/// Messages that wait for the thread of the server: those of several seconds.
pub const MESSAGES: usize = 4096;

/// Sends messages to the pages; never waits.
#[derive(Clone)]
pub struct Pages {
    sender: SyncSender<Message>,
    waker: Arc<Waker>,
    losses: Arc<Losses>,
}

/// What did not reach the thread of the server.
#[derive(Debug, Default)]
pub struct Losses {
    /// Samples.
    pub samples: AtomicU64,
    /// A message was lost that a page needs: all have to start anew.
    pub has_lost_text: AtomicBool,
}

impl Pages {
    /// Over this channel.
    pub fn new(sender: SyncSender<Message>, waker: Arc<Waker>, losses: Arc<Losses>) -> Self {
        Self {
            sender,
            waker,
            losses,
        }
    }

    fn send(&self, message: Message) {
        match self.sender.try_send(message) {
            Ok(()) | Err(TrySendError::Disconnected(_)) => {}
            Err(TrySendError::Full(Message::Samples(number, _))) => {
                self.losses.samples.fetch_add(number, Relaxed);
            }
            Err(TrySendError::Full(_)) => self.losses.has_lost_text.store(true, Relaxed),
        }
        // It fails if the server has ended; then this thread ends too.
        let _ = self.waker.wake();
    }

    /// An event for all pages.
    pub fn tell_all(&self, event: &Value) {
        self.send(Message::All(event.to_string()));
    }

    /// An event or an answer for one page.
    pub fn tell(&self, page: PageId, event: &Value) {
        self.send(Message::One(page, event.to_string()));
    }

    /// Samples for a page that has just joined.
    pub fn past(&self, page: PageId, bytes: Vec<u8>) {
        self.send(Message::Past(page, bytes.into()));
    }

    /// Samples for all pages.
    pub fn samples(&self, number: u64, bytes: Vec<u8>) {
        self.send(Message::Samples(number, bytes.into()));
    }
}
