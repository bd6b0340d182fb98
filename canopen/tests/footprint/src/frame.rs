//! A frame as a driver has it.

use embedded_can::{Frame, Id};

#[derive(Clone, Copy)]
pub struct BoardFrame {
    id: Id,
    remote: bool,
    length: u8,
    data: [u8; 8],
}

impl Frame for BoardFrame {
    fn new(id: impl Into<Id>, data: &[u8]) -> Option<Self> {
        let mut bytes = [0; 8];
        for (to, from) in bytes.get_mut(..data.len())?.iter_mut().zip(data) {
            *to = *from;
        }
        Some(Self {
            id: id.into(),
            remote: false,
            length: data.len() as u8,
            data: bytes,
        })
    }

    fn new_remote(id: impl Into<Id>, dlc: usize) -> Option<Self> {
        (dlc <= 8).then(|| Self {
            id: id.into(),
            remote: true,
            length: dlc as u8,
            data: [0; 8],
        })
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
        self.data
            .get(..usize::from(self.length))
            .unwrap_or(&self.data)
    }
}
