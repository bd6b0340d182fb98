//! Fields of a data type: least significant byte first, and in each byte from its highest bit on.

use crate::float16;

/// Longest payload that a node sends: a request of a file with the longest path.
pub const CAPACITY: usize = 232;

/// Reads fields. Beyond the end every field is zero, as the specification's implicit extension has
/// it; [`Reader::is_complete`] returns whether that happened.
#[derive(Debug, Clone, Copy)]
pub struct Reader<'a> {
    bytes: &'a [u8],
    /// Bits read.
    at: usize,
}

impl<'a> Reader<'a> {
    /// A reader at the beginning of a payload.
    #[must_use]
    pub const fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0 }
    }

    /// An unsigned integer of up to 64 bits.
    ///
    /// ```
    /// use dronecan::Reader;
    /// // 13 bits: the low byte, then the upper five bits.
    /// let mut reader = Reader::new(&[0x34, 0b10010_101]);
    /// assert_eq!([reader.unsigned(13), reader.unsigned(3)], [0x1234, 0b101]);
    /// ```
    pub fn unsigned(&mut self, bits: u32) -> u64 {
        let mut value = 0;
        let mut shift = 0;
        while shift < bits.min(64) {
            let count = (bits - shift).min(8);
            value |= u64::from(self.part(count)) << shift;
            shift += count;
        }
        value
    }

    /// A signed integer of 1 to 64 bits.
    pub fn signed(&mut self, bits: u32) -> i64 {
        let unused = 64_u32.saturating_sub(bits) & 63;
        (self.unsigned(bits) << unused) as i64 >> unused
    }

    /// A `float16`.
    pub fn float16(&mut self) -> f32 {
        float16::from_bits(self.unsigned(16) as u16)
    }

    /// A `float32`.
    pub fn float32(&mut self) -> f32 {
        f32::from_bits(self.unsigned(32) as u32)
    }

    /// All bytes that remain, from the next whole one on.
    #[must_use]
    pub fn rest(&self) -> &'a [u8] {
        self.bytes.get(self.at.div_ceil(8)..).unwrap_or(&[])
    }

    /// Leaves out bytes.
    pub fn skip(&mut self, bytes: usize) {
        self.at = self.at.saturating_add(bytes.saturating_mul(8));
    }

    /// Whether all fields were there.
    #[must_use]
    pub const fn is_complete(&self) -> bool {
        self.at <= self.bytes.len() * 8
    }

    /// Up to eight bits, the highest first.
    fn part(&mut self, count: u32) -> u8 {
        let byte = |at: usize| u16::from(self.bytes.get(at).copied().unwrap_or(0));
        let (at, offset) = (self.at / 8, self.at as u32 % 8);
        let two = byte(at) << 8 | byte(at + 1);
        self.at = self.at.saturating_add(count as usize);
        ((two << offset) >> 8) as u8 >> (8 - count)
    }
}

/// A payload to be sent. What does not fit is left out, and [`Payload::is_complete`] reports it.
#[derive(Debug, Clone)]
pub struct Payload {
    bytes: [u8; CAPACITY],
    /// Bits written.
    at: usize,
}

impl Default for Payload {
    fn default() -> Self {
        Self::new()
    }
}

impl Payload {
    /// An empty payload.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            bytes: [0; CAPACITY],
            at: 0,
        }
    }

    /// An unsigned integer of up to 64 bits.
    ///
    /// ```
    /// use dronecan::Payload;
    /// let mut payload = Payload::new();
    /// payload.unsigned(0x1234, 13).unsigned(0b101, 3);
    /// assert_eq!(payload.bytes(), [0x34, 0b10010_101]);
    /// ```
    pub fn unsigned(&mut self, value: u64, bits: u32) -> &mut Self {
        let mut shift = 0;
        while shift < bits.min(64) {
            let count = (bits - shift).min(8);
            self.part((value >> shift) as u8, count);
            shift += count;
        }
        self
    }

    /// A `float16`.
    pub fn float16(&mut self, value: f32) -> &mut Self {
        self.unsigned(float16::to_bits(value).into(), 16)
    }

    /// Bytes.
    pub fn put(&mut self, bytes: &[u8]) -> &mut Self {
        for byte in bytes {
            self.part(*byte, 8);
        }
        self
    }

    /// The bytes; unused bits of the last one are zero.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        self.bytes.get(..self.at.div_ceil(8)).unwrap_or(&self.bytes)
    }

    /// Whether everything has fitted.
    #[must_use]
    pub const fn is_complete(&self) -> bool {
        self.at <= CAPACITY * 8
    }

    /// The low bits of a byte, the highest first.
    fn part(&mut self, byte: u8, count: u32) {
        let (at, offset) = (self.at / 8, self.at as u32 % 8);
        let aligned = u16::from(byte << (8 - count)) << 8 >> offset;
        for (place, part) in self.bytes.iter_mut().skip(at).zip(aligned.to_be_bytes()) {
            *place |= part;
        }
        self.at = self.at.saturating_add(count as usize);
    }
}
