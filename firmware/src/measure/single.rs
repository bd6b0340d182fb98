//! A number in single precision that is compared by its bits.

/// As words two of them are equal if and only if every bit is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct Single(u32);

impl Single {
    /// This number.
    pub const fn new(value: f32) -> Self {
        Self(value.to_bits())
    }

    /// The number.
    pub const fn get(self) -> f32 {
        f32::from_bits(self.0)
    }
}
