//! Identifiers of frames.

use embedded_can::ExtendedId;

/// What a transfer is, and of which data type.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A message to all nodes.
    Message(u16),
    /// A request to this node.
    Request {
        /// Data type.
        service: u8,
        /// The node that shall respond.
        to: u8,
    },
    /// A response to this node.
    Response {
        /// Data type.
        service: u8,
        /// The node that has requested it.
        to: u8,
    },
}

impl Kind {
    /// The node for which a service transfer is; `None` for a message, which is for all.
    #[must_use]
    pub const fn receiver(self) -> Option<u8> {
        match self {
            Self::Message(_) => None,
            Self::Request { to, .. } | Self::Response { to, .. } => Some(to),
        }
    }
}

/// The fields of an identifier.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FrameId {
    /// Priority, 0 to 31; 0 is the highest one.
    pub priority: u8,
    /// The transfer.
    pub kind: Kind,
    /// The sender; 0 for an anonymous one.
    pub source: u8,
}

impl FrameId {
    /// The fields of an identifier; `None` if they contradict each other.
    ///
    /// ```
    /// use dronecan::{FrameId, Kind};
    /// use embedded_can::ExtendedId;
    /// let status = ExtendedId::new(0x1801_550A).unwrap();
    /// let id = FrameId { priority: 24, kind: Kind::Message(341), source: 10 };
    /// assert_eq!(FrameId::parse(status), Some(id));
    /// assert_eq!(id.raw(0), status);
    /// ```
    #[must_use]
    pub fn parse(id: ExtendedId) -> Option<Self> {
        let raw = id.as_raw();
        let source = raw as u8 & 0x7F;
        let is_service = raw & 0x80 != 0;
        let (service, to) = ((raw >> 16) as u8, (raw >> 8) as u8 & 0x7F);
        let kind = match (is_service, raw & 0x8000 != 0) {
            (true, _) if source == 0 || to == 0 => return None,
            (true, true) => Kind::Request { service, to },
            (true, false) => Kind::Response { service, to },
            // Two bits of the type; the others tell anonymous senders apart.
            (false, _) if source == 0 => Kind::Message((raw >> 8) as u16 & 3),
            (false, _) => Kind::Message((raw >> 8) as u16),
        };
        Some(Self {
            priority: (raw >> 24) as u8,
            kind,
            source,
        })
    }

    /// The identifier; that of an anonymous message has this discriminator.
    #[must_use]
    pub fn raw(&self, discriminator: u16) -> ExtendedId {
        let service = |service: u8, to: u8| (service as u32) << 16 | (to as u32 & 0x7F) << 8 | 0x80;
        let middle = match self.kind {
            Kind::Message(data_type) if self.source == 0 => {
                (discriminator as u32 & 0x3FFF) << 10 | (data_type as u32 & 3) << 8
            }
            Kind::Message(data_type) => (data_type as u32) << 8,
            Kind::Request { service: of, to } => service(of, to) | 0x8000,
            Kind::Response { service: of, to } => service(of, to),
        };
        let raw = (self.priority as u32 & 31) << 24 | middle | self.source as u32 & 0x7F;
        ExtendedId::new(raw).unwrap_or(ExtendedId::MAX)
    }
}
