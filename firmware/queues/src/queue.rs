//! The memory of a queue.

use core::{cell::UnsafeCell, mem::MaybeUninit};

use crate::position::Position;

/// Memory for an element.
pub struct Slot<T>(UnsafeCell<MaybeUninit<T>>);

/// A queue with these slots: an array of [`Slot`], or a slice of them.
pub struct Queue<S: ?Sized> {
    written: Position,
    read: Position,
    slots: S,
}

// SAFETY: a slot is used by one end at a time, as the positions say which one owns it, and each
// position is set by one end only (`Channel::split`). Elements go from one task to another one.
#[allow(unsafe_code, reason = "both ends use the memory of the slots")]
unsafe impl<T: Send> Sync for Slot<T> {}

impl<T, const CAPACITY: usize> Queue<[Slot<T>; CAPACITY]> {
    /// An empty queue, whose capacity is a power of two, at most 2^15.
    #[must_use]
    pub const fn new() -> Self {
        const { assert!(CAPACITY.is_power_of_two() && CAPACITY <= 1 << 15) };
        Self {
            written: Position::new(),
            read: Position::new(),
            slots: [const { Slot(UnsafeCell::new(MaybeUninit::uninit())) }; CAPACITY],
        }
    }
}

impl<T, const CAPACITY: usize> Default for Queue<[Slot<T>; CAPACITY]> {
    fn default() -> Self {
        Self::new()
    }
}

impl<T> Queue<[Slot<T>]> {
    /// The position of the oldest element and the number of elements, unless a bit of the positions
    /// has changed. For an end: its own position does not change meanwhile, and that of the other
    /// end advances only within the capacity.
    #[inline]
    pub(crate) fn waiting(&self) -> Option<(u16, u16)> {
        let written = self.written.get()?;
        let read = self.read.get()?;
        let length = written.wrapping_sub(read);
        (usize::from(length) <= self.slots.len()).then_some((read, length))
    }

    /// Number of elements that there is room for.
    #[inline]
    pub(crate) fn room(&self) -> usize {
        self.waiting()
            .map_or(0, |(_, length)| self.slots.len() - usize::from(length))
    }

    #[inline]
    fn slot(&self, position: u16) -> Option<*mut MaybeUninit<T>> {
        let last = self.slots.len().wrapping_sub(1);
        let slot = self.slots.get(usize::from(position) & last)?;
        Some(slot.0.get())
    }

    /// # Errors
    /// The element, if there is no room or a bit of the positions has changed.
    ///
    /// # Safety
    /// No other task writes.
    #[inline]
    #[allow(unsafe_code, reason = "argued below")]
    pub(crate) unsafe fn enqueue(&self, element: T) -> Result<(), T> {
        let waiting = self.waiting();
        let free = waiting.filter(|(_, length)| usize::from(*length) < self.slots.len());
        let Some((read, length)) = free else {
            return Err(element);
        };
        let position = read.wrapping_add(length);
        let Some(slot) = self.slot(position) else {
            return Err(element);
        };
        // SAFETY: the reader does not use a slot at or behind the position of the writer, which
        // only this task sets.
        unsafe { (*slot).write(element) };
        self.written.set(position.wrapping_add(1));
        Ok(())
    }

    /// The oldest element, which remains.
    ///
    /// # Safety
    /// No other task reads.
    #[inline]
    #[allow(unsafe_code, reason = "argued below")]
    pub(crate) unsafe fn peek(&self) -> Option<&T> {
        let (read, length) = self.waiting()?;
        if length == 0 {
            return None;
        }
        // SAFETY: the writer has written the slot, and does not use it before the position of the
        // reader, which only this task sets, has passed it.
        self.slot(read)
            .map(|slot| unsafe { (*slot).assume_init_ref() })
    }

    /// # Safety
    /// No other task reads.
    #[inline]
    #[allow(unsafe_code, reason = "argued below")]
    pub(crate) unsafe fn dequeue(&self) -> Option<T> {
        let (read, length) = self.waiting()?;
        if length == 0 {
            return None;
        }
        // SAFETY: as in `peek`; the element is not read again, as the position passes its slot.
        let element = self
            .slot(read)
            .map(|slot| unsafe { (*slot).assume_init_read() });
        self.read.set(read.wrapping_add(1));
        element
    }
}

#[cfg(test)]
#[allow(unsafe_code, reason = "each test has queues of its own")]
mod tests {
    use super::*;

    #[test]
    fn with_a_changed_bit_of_a_position_nothing_is_written_or_read() {
        for (start, length) in [(0, 0), (3, 1), (u16::MAX, 4)] {
            for bit in 0..64 {
                let queue: Queue<[Slot<u32>; 4]> = Queue::new();
                queue.read.set(start);
                queue.written.set(start.wrapping_add(length));
                let queue: &Queue<[Slot<u32>]> = &queue;
                assert_eq!(queue.waiting(), Some((start, length)));
                let position = [&queue.read, &queue.written][bit / 32];
                position.change(bit % 32);
                assert_eq!(queue.waiting(), None);
                assert_eq!(queue.room(), 0);
                // SAFETY: no other task uses the queue.
                unsafe {
                    assert_eq!(queue.enqueue(1), Err(1));
                    assert_eq!(queue.peek(), None);
                    assert_eq!(queue.dequeue(), None);
                }
                position.change(bit % 32);
                assert_eq!(queue.waiting(), Some((start, length)));
            }
        }
    }

    #[test]
    fn more_elements_than_the_capacity_are_a_changed_position() {
        let queue: Queue<[Slot<u32>; 4]> = Queue::new();
        let queue: &Queue<[Slot<u32>]> = &queue;
        queue.written.set(5);
        assert_eq!(queue.waiting(), None);
        queue.read.set(u16::MAX);
        queue.written.set(4);
        assert_eq!(queue.waiting(), None);
    }
}
