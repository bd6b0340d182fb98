//! One value read or written by a frame.

/// What is to be done with a value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Operation {
    /// Read the value of a number.
    Read = 0,
    /// Write it.
    Write = 1,
    /// Read value `index` of the capture, record by record; the number does not matter.
    ReadCapture = 2,
    /// Read fault `index` of the history, the last one being 0; the number does not matter. The
    /// value is the fault in its high half and the low half of its control period.
    ReadHistory = 3,
}

/// A value with its number, or what is asked of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Access {
    /// What is to be done.
    pub operation: Operation,
    /// Which value: a table stands at [`Service`](crate::service::Service).
    pub number: u8,
    /// Place in a capture or a history.
    pub index: u16,
    /// The value: an integer in two's complement, or the bits of a number of single precision.
    pub value: u32,
}

impl Access {
    /// What eight bytes ask for; none where the operation is unknown.
    ///
    /// ```
    /// use firmware::frames::{Access, Operation};
    /// let access = Access::of_bytes([1, 25, 0, 0, 7, 0, 0, 0]).unwrap();
    /// assert_eq!((access.operation, access.number, access.value), (Operation::Write, 25, 7));
    /// ```
    pub const fn of_bytes([code, number, a, b, w, x, y, z]: [u8; 8]) -> Option<Self> {
        Some(Self {
            operation: match code {
                0 => Operation::Read,
                1 => Operation::Write,
                2 => Operation::ReadCapture,
                3 => Operation::ReadHistory,
                _ => return None,
            },
            number,
            index: u16::from_le_bytes([a, b]),
            value: u32::from_le_bytes([w, x, y, z]),
        })
    }

    /// The bytes of the answer.
    pub const fn bytes(&self, is_refused: bool) -> [u8; 8] {
        let [a, b] = self.index.to_le_bytes();
        let [w, x, y, z] = self.value.to_le_bytes();
        let refusal = if is_refused { 0x80 } else { 0 };
        [
            self.operation as u8 | refusal,
            self.number,
            a,
            b,
            w,
            x,
            y,
            z,
        ]
    }
}
