//! A queue of fixed size.

/// First in, first out; what does not fit is refused.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ring<T, const N: usize> {
    slots: [Option<T>; N],
    first: usize,
    length: usize,
}

impl<T: Copy, const N: usize> Ring<T, N> {
    pub const fn new() -> Self {
        Self {
            slots: [None; N],
            first: 0,
            length: 0,
        }
    }

    /// Whether there was room.
    pub fn push(&mut self, value: T) -> bool {
        if self.length >= N {
            return false;
        }
        // first < N and length < N, hence no overflow and one subtraction suffices.
        let end = self.first + self.length;
        let Some(slot) = self.slots.get_mut(if end < N { end } else { end - N }) else {
            return false;
        };
        *slot = Some(value);
        self.length += 1;
        true
    }

    pub fn pop(&mut self) -> Option<T> {
        let value = self.slots.get_mut(self.first)?.take()?;
        self.first = if self.first + 1 < N {
            self.first + 1
        } else {
            0
        };
        self.length -= 1;
        Some(value)
    }
}

#[cfg(test)]
mod tests {
    use super::Ring;

    #[test]
    fn keeps_the_order_around_the_end_and_refuses_what_is_too_much() {
        let mut ring = Ring::<u8, 3>::new();
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
