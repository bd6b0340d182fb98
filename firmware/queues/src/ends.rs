//! The two ends of a queue.

use core::{cell::Cell, marker::PhantomData};

use crate::{Queue, Slot};

/// A type that names a queue; [`channel!`](crate::channel) declares one.
pub trait Channel: Sized + 'static {
    /// An element.
    type Item: Send + 'static;

    /// The queue: always the same one, which no other type names.
    fn queue() -> &'static Queue<[Slot<Self::Item>]>;

    /// Both ends.
    ///
    /// # Safety
    /// At most one call for each queue: each end has one owner. [`Channel::queue`] is as stated
    /// there.
    #[must_use]
    #[allow(unsafe_code, reason = "argued above")]
    unsafe fn split() -> (Producer<Self>, Consumer<Self>) {
        (Producer(PhantomData), Consumer(PhantomData))
    }
}

/// Declares a type that names a queue: the type of an element, and the capacity, a power of two.
#[macro_export]
macro_rules! channel {
    ($(#[$attribute:meta])* $visibility:vis $name:ident: [$item:ty; $capacity:expr]) => {
        $(#[$attribute])*
        $visibility struct $name;

        impl $crate::Channel for $name {
            type Item = $item;

            #[inline(always)]
            fn queue() -> &'static $crate::Queue<[$crate::Slot<$item>]> {
                static QUEUE: $crate::Queue<[$crate::Slot<$item>; $capacity]> =
                    $crate::Queue::new();
                &QUEUE
            }
        }
    };
}

/// The end that writes, in one task.
pub struct Producer<C>(PhantomData<Cell<C>>);

impl<C: Channel> Producer<C> {
    /// Adds an element.
    ///
    /// # Errors
    /// The element, if there is no room or the queue is not intact.
    #[inline]
    #[allow(unsafe_code, reason = "argued below")]
    pub fn enqueue(&mut self, element: C::Item) -> Result<(), C::Item> {
        // SAFETY: there is one producer of the queue (`Channel::split`), in use by this task.
        unsafe { C::queue().enqueue(element) }
    }

    /// Whether there is room for an element.
    #[must_use]
    #[inline]
    pub fn has_room(&self) -> bool {
        C::queue().room() > 0
    }

    /// Whether there is an element that has not been read.
    #[must_use]
    #[inline]
    pub fn has_waiting(&self) -> bool {
        C::queue().waiting().is_some_and(|(_, length)| length > 0)
    }

    /// Whether no bit of the positions has changed.
    #[must_use]
    #[inline]
    pub fn is_intact(&self) -> bool {
        C::queue().waiting().is_some()
    }
}

/// The end that reads, in one task.
pub struct Consumer<C>(PhantomData<Cell<C>>);

impl<C: Channel> Consumer<C> {
    /// Removes the oldest element; `None` if there is none or the queue is not intact.
    #[inline]
    #[allow(unsafe_code, reason = "argued below")]
    pub fn dequeue(&mut self) -> Option<C::Item> {
        // SAFETY: there is one consumer of the queue (`Channel::split`), in use by this task.
        unsafe { C::queue().dequeue() }
    }

    /// The oldest element, which remains; `None` as [`Consumer::dequeue`].
    #[must_use]
    #[inline]
    #[allow(unsafe_code, reason = "argued below")]
    pub fn peek(&self) -> Option<&C::Item> {
        // SAFETY: as in `dequeue`, which needs this consumer alone and ends the borrow.
        unsafe { C::queue().peek() }
    }

    /// Whether no bit of the positions has changed.
    #[must_use]
    #[inline]
    pub fn is_intact(&self) -> bool {
        C::queue().waiting().is_some()
    }
}
