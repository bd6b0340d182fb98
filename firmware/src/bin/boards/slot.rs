//! One place between two priorities: what is put there waits until it is taken. A queue of the crate
//! `heapless` keeps one place more than it holds, which is 256 bytes for a set of parameters.

use core::{
    cell::UnsafeCell,
    mem::MaybeUninit,
    sync::atomic::{
        AtomicBool,
        Ordering::{Acquire, Release},
    },
};

/// The place.
pub struct Slot<T> {
    is_full: AtomicBool,
    content: UnsafeCell<MaybeUninit<T>>,
}

// SAFETY: while the place is empty its one giver alone touches the content, while it is full its one
// taker alone; both hand over by the flag.
unsafe impl<T: Send> Sync for Slot<T> {}

/// The one who puts.
pub struct Giver<T: 'static>(&'static Slot<T>);

/// The one who takes.
pub struct Taker<T: 'static>(&'static Slot<T>);

impl<T> Slot<T> {
    /// An empty place.
    pub const fn new() -> Self {
        Self {
            is_full: AtomicBool::new(false),
            content: UnsafeCell::new(MaybeUninit::uninit()),
        }
    }

    /// Its two ends.
    pub fn split(&'static mut self) -> (Giver<T>, Taker<T>) {
        (Giver(self), Taker(self))
    }
}

impl<T> Giver<T> {
    /// Whether nothing waits there.
    pub fn is_empty(&self) -> bool {
        !self.0.is_full.load(Acquire)
    }

    /// Puts something there; whether it could: nothing is done where something waits already.
    pub fn put(&mut self, content: T) -> bool {
        let is_empty = self.is_empty();
        if is_empty {
            // SAFETY: the place is empty.
            unsafe { (*self.0.content.get()).write(content) };
            self.0.is_full.store(true, Release);
        }
        is_empty
    }
}

impl<T> Taker<T> {
    /// What waits there.
    pub fn take(&mut self) -> Option<T> {
        if !self.0.is_full.load(Acquire) {
            return None;
        }
        // SAFETY: the place is full, and from the flag on it is empty.
        let content = unsafe { (*self.0.content.get()).assume_init_read() };
        self.0.is_full.store(false, Release);
        Some(content)
    }
}
