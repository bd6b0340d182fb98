//! A classical CAN frame, for drivers and tools without a frame type of their own.

use embedded_can::{ExtendedId, Frame, Id, StandardId};

use crate::message::copy;

/// A classical CAN frame: an 11-bit or 29-bit identifier and up to eight data bytes, or a remote
/// frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CanFrame {
    id: Id,
    remote: bool,
    /// 0 to 8.
    length: u8,
    /// Bytes beyond `length` are zero.
    data: [u8; 8],
}

impl CanFrame {
    /// A frame received by a controller. Data length codes 9 to 15 are allowed on the bus and mean
    /// 8 bytes (ISO 11898-1).
    ///
    /// ```
    /// use canopen::CanFrame;
    /// use embedded_can::{Frame, StandardId};
    /// let frame = CanFrame::received(StandardId::ZERO.into(), false, 15, [7; 8]);
    /// assert_eq!(frame.data(), [7; 8]);
    /// ```
    #[must_use]
    pub fn received(id: Id, remote: bool, length_code: u8, data: [u8; 8]) -> Self {
        let mut frame = Self {
            id,
            remote,
            length: length_code.min(8),
            data,
        };
        let used = if remote { 0 } else { usize::from(frame.length) };
        for byte in frame.data.iter_mut().skip(used) {
            *byte = 0;
        }
        frame
    }

    /// A frame with a numeric identifier, of 29 bits if `extended`; `None` if identifier or length
    /// is out of range.
    ///
    /// ```
    /// use canopen::CanFrame;
    /// assert!(CanFrame::raw(0x7FF, false, false, 8, [0; 8]).is_some());
    /// assert!(CanFrame::raw(0x800, false, false, 8, [0; 8]).is_none());
    /// assert!(CanFrame::raw(0x800, true, true, 9, [0; 8]).is_none());
    /// ```
    #[must_use]
    pub fn raw(id: u32, extended: bool, remote: bool, length: u8, data: [u8; 8]) -> Option<Self> {
        let id: Id = if extended {
            ExtendedId::new(id)?.into()
        } else {
            StandardId::new(u16::try_from(id).ok()?)?.into()
        };
        (length <= 8).then(|| Self::received(id, remote, length, data))
    }

    /// The identifier, and whether it is a 29-bit identifier.
    #[must_use]
    pub fn raw_id(&self) -> (u32, bool) {
        match self.id {
            Id::Standard(id) => (u32::from(id.as_raw()), false),
            Id::Extended(id) => (id.as_raw(), true),
        }
    }

    /// All eight data bytes; those beyond the length are zero.
    #[must_use]
    pub fn bytes(&self) -> [u8; 8] {
        self.data
    }
}

impl Frame for CanFrame {
    fn new(id: impl Into<Id>, data: &[u8]) -> Option<Self> {
        let mut bytes = [0; 8];
        let length = copy(&mut bytes, data);
        (length == data.len()).then(|| Self {
            id: id.into(),
            remote: false,
            length: length as u8,
            data: bytes,
        })
    }

    fn new_remote(id: impl Into<Id>, dlc: usize) -> Option<Self> {
        (dlc <= 8).then(|| Self::received(id.into(), true, dlc as u8, [0; 8]))
    }

    fn is_extended(&self) -> bool {
        matches!(self.id, Id::Extended(_))
    }

    fn is_remote_frame(&self) -> bool {
        self.remote
    }

    fn id(&self) -> Id {
        self.id
    }

    fn dlc(&self) -> usize {
        usize::from(self.length)
    }

    fn data(&self) -> &[u8] {
        let length = if self.remote { 0 } else { self.dlc() };
        self.data.get(..length).unwrap_or(&[])
    }
}
