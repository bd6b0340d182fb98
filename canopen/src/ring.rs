//! Queue of fixed capacity.

/// First-in first-out queue; a value that does not fit is refused.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ring<T, const N: usize> {
    slots: [T; N],
    first: usize,
    length: usize,
}

impl<T: Copy, const N: usize> Ring<T, N> {
    /// An empty queue; `unused` fills the unoccupied slots.
    pub const fn new(unused: T) -> Self {
        Self {
            slots: [unused; N],
            first: 0,
            length: 0,
        }
    }

    pub fn len(&self) -> usize {
        self.length
    }

    pub fn clear(&mut self) {
        self.length = 0;
    }

    /// Returns whether there was room.
    pub fn push(&mut self, value: T) -> bool {
        if self.length >= N {
            return false;
        }
        let Some(slot) = self.slots.get_mut((self.first + self.length) % N) else {
            return false;
        };
        *slot = value;
        self.length += 1;
        true
    }

    pub fn pop(&mut self) -> Option<T> {
        self.length = self.length.checked_sub(1)?;
        let value = self.slots.get(self.first).copied();
        self.first = (self.first + 1) % N;
        value
    }
}

#[cfg(test)]
mod tests {
    use super::Ring;

    #[test]
    fn order_is_kept_across_the_wrap_and_values_are_refused_when_full() {
        let mut ring = Ring::<u8, 3>::new(0);
        for start in 0..10 {
            assert!((start..start + 3).all(|value| ring.push(value)));
            assert!(!ring.push(99));
            assert_eq!(ring.pop(), Some(start));
            assert_eq!(
                [ring.pop(), ring.pop(), ring.pop()],
                [Some(start + 1), Some(start + 2), None]
            );
        }
    }
}
