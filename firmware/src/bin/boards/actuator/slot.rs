//! One place between two priorities: what is put there waits until it is taken. A queue of the crate
//! `heapless` keeps one place more than it holds, which is a whole set of parameters.

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
pub struct Giver<T: 'static> {
    slot: &'static Slot<T>,
    has_put: bool,
}

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
        let giver = Giver {
            slot: self,
            has_put: false,
        };
        (giver, Taker(self))
    }
}

impl<T> Giver<T> {
    /// Whether nothing waits there.
    pub fn is_empty(&self) -> bool {
        !self.slot.is_full.load(Acquire)
    }

    /// Puts something there; whether it could: nothing is done where something waits already.
    pub fn put(&mut self, content: T) -> bool {
        self.put_new(|| content)
    }

    /// The same with what is made only if it can be put, and in its place.
    #[inline]
    pub fn put_new(&mut self, content: impl FnOnce() -> T) -> bool {
        let is_empty = self.is_empty();
        if is_empty {
            // SAFETY: the place is empty.
            unsafe { (*self.slot.content.get()).write(content()) };
            self.slot.is_full.store(true, Release);
            self.has_put = true;
        }
        is_empty
    }
}

impl<T: Copy> Giver<T> {
    /// What was put there last, taken or not.
    pub fn last(&self) -> Option<&T> {
        // SAFETY: something has been written, and nobody but this giver writes; who takes it, copies.
        self.has_put
            .then(|| unsafe { (*self.slot.content.get()).assume_init_ref() })
    }
}

impl<T: Copy> Taker<T> {
    /// What waits there.
    pub fn take(&mut self) -> Option<T> {
        self.take_as(|content| *content)
    }

    /// What can be made of that where it lies.
    #[inline]
    pub fn take_as<R>(&mut self, made: impl FnOnce(&T) -> R) -> Option<R> {
        if !self.0.is_full.load(Acquire) {
            return None;
        }
        // SAFETY: the place is full, and from the flag on it is empty.
        let made = made(unsafe { (*self.0.content.get()).assume_init_ref() });
        self.0.is_full.store(false, Release);
        Some(made)
    }
}
