//! Messages between the control loop and the communication, with check values.
//!
//! The check value covers every field that the message's [`Hash`] covers: each word is added
//! without carry to the sum rotated by five bits, so a change within one word always changes the
//! sum.

use core::hash::{Hash, Hasher};

/// A message with its check value.
///
/// ```
/// use firmware::check_value::Checked;
///
/// let mut message = Checked::new(7_u32);
/// assert_eq!(message.get(), Some(&7));
/// assert!(message.update(|value| *value = 8));
/// assert_eq!(message.get(), Some(&8));
/// ```
#[derive(Debug, Clone, Copy)]
pub struct Checked<T> {
    value: T,
    check: u32,
    changes: u32,
}

impl<T: Hash> Checked<T> {
    /// A message with the check value of its present content.
    pub fn new(value: T) -> Self {
        let check = check_value(&value);
        Self {
            value,
            check,
            changes: 0,
        }
    }

    /// Becomes a message of this content, in place.
    pub fn replace(&mut self, value: &T)
    where
        T: Copy,
    {
        self.value = *value;
        self.check = check_value(value);
        self.changes = 0;
    }

    /// The content, unless it differs from its check value.
    pub fn get(&self) -> Option<&T> {
        (check_value(&self.value) == self.check).then_some(&self.value)
    }

    /// The content, without comparing it with its check value: for displays.
    pub fn unverified(&self) -> &T {
        &self.value
    }

    /// The check value.
    pub fn check(&self) -> u32 {
        self.check
    }

    /// Number of changes, attempted ones included; wraps.
    pub fn changes(&self) -> u32 {
        self.changes
    }

    /// Makes the check value wrong: whoever verifies the message detects it as corrupt.
    pub fn invalidate(&mut self) {
        self.check = !check_value(&self.value);
        self.changes = self.changes.wrapping_add(1);
    }

    /// Changes the content. Returns false, without a change, if the content differs from its check
    /// value: the check value never becomes valid for corrupt content. It counts as a change even
    /// so: the corrupt message is posted, and the loop detects it.
    pub fn update(&mut self, change: impl FnOnce(&mut T)) -> bool {
        let is_intact = self.get().is_some();
        if is_intact {
            change(&mut self.value);
            self.check = check_value(&self.value);
        }
        self.changes = self.changes.wrapping_add(1);
        is_intact
    }
}

/// The check value of a message.
pub fn check_value(message: &impl Hash) -> u32 {
    let mut sum = Sum(!0);
    message.hash(&mut sum);
    sum.0
}

/// The sum of words.
struct Sum(u32);

impl Sum {
    #[inline]
    fn add(&mut self, word: u32) {
        self.0 = self.0.rotate_left(5) ^ word;
    }
}

impl Hasher for Sum {
    fn finish(&self) -> u64 {
        self.0.into()
    }

    /// Arrays of integers.
    fn write(&mut self, bytes: &[u8]) {
        let (words, rest) = bytes.as_chunks();
        for word in words {
            self.add(u32::from_ne_bytes(*word));
        }
        for byte in rest {
            self.add(u32::from(*byte));
        }
    }

    #[inline]
    fn write_u8(&mut self, value: u8) {
        self.add(value.into());
    }

    #[inline]
    fn write_u16(&mut self, value: u16) {
        self.add(value.into());
    }

    #[inline]
    fn write_u32(&mut self, value: u32) {
        self.add(value);
    }

    #[inline]
    fn write_u64(&mut self, value: u64) {
        self.add(value as u32);
        self.add((value >> 32) as u32);
    }

    #[inline]
    fn write_u128(&mut self, value: u128) {
        self.write_u64(value as u64);
        self.write_u64((value >> 64) as u64);
    }

    /// Lengths and discriminants, which fit a word.
    #[inline]
    fn write_usize(&mut self, value: usize) {
        self.add(value as u32);
    }
}

#[cfg(test)]
mod tests {
    use model_core::control::encoder_correction::{EncoderCorrection, EncoderHarmonics};

    use super::*;
    use crate::{control_loop::LoopParameters, drive::StoredParameters};

    #[test]
    fn every_changed_bit_of_a_word_is_detected_and_is_not_updated() {
        for (word, bit) in (0..8).flat_map(|word| (0..32).map(move |bit| (word, bit))) {
            let mut message = Checked::new([0x5a5a_1234_u32; 8]);
            message.value[word] ^= 1 << bit;
            assert_eq!(message.get(), None);
            let before = message.changes();
            assert!(!message.update(|value| value[word] ^= 1 << bit));
            assert_ne!(message.changes(), before, "it is posted");
        }
    }

    #[test]
    fn the_order_of_words_counts() {
        assert_ne!(check_value(&[1_u32, 2]), check_value(&[2_u32, 1]));
    }

    #[test]
    fn each_parameter_of_the_loop_is_covered() {
        let parameters = LoopParameters::of(&StoredParameters::DEFAULT);
        let check = check_value(&parameters);
        let mut other = parameters;
        other.axis.max_velocity ^= 1;
        assert_ne!(check_value(&other), check);
        other = parameters;
        other.board.stop.brake_faults ^= 1;
        assert_ne!(check_value(&other), check);
        other = parameters;
        other.failsafe.failsafe_position_mdeg ^= 1;
        assert_ne!(check_value(&other), check);
        let harmonics = EncoderHarmonics {
            second_mdeg: (0, 1),
            ..EncoderHarmonics::default()
        };
        other = parameters;
        other.encoder = EncoderCorrection::new(&harmonics, other.board.control.mounting());
        assert_ne!(check_value(&other), check);
    }
}
