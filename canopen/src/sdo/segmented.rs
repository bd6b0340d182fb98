//! SDO segmented transfer (CiA 301, 7.2.4.3): segments of seven bytes, each confirmed.

use super::{Data, ObjectAccess, SdoServer, TransferState};
use crate::Abort;

const TOGGLE: u8 = 1 << 4;
const LAST: u8 = 1;

impl SdoServer {
    /// Checks and alternates the toggle bit; returns that of this segment.
    fn alternate(&mut self, command: u8) -> Result<u8, Abort> {
        let toggle = command & TOGGLE;
        if toggle != self.transfer.toggle {
            return Err(Abort::Toggle);
        }
        self.transfer.toggle ^= TOGGLE;
        Ok(toggle)
    }

    pub(super) fn download_segment(
        &mut self,
        request: &Data,
        objects: &mut impl ObjectAccess,
    ) -> Result<(), Abort> {
        let [command, data @ ..] = request;
        let toggle = self.alternate(*command)?;
        let unused = usize::from(command >> 1 & 7);
        self.receive_data(data.get(..7 - unused).unwrap_or_default(), objects)?;
        self.answer([0x20 | toggle, 0, 0, 0], 0);
        if command & LAST != 0 {
            self.finish(objects)?;
        }
        Ok(())
    }

    pub(super) fn upload_segment(
        &mut self,
        request: &Data,
        objects: &mut impl ObjectAccess,
    ) -> Result<(), Abort> {
        let toggle = self.alternate(request[0])?;
        let mut segment = [0; 8];
        let [command, data @ ..] = &mut segment;
        let (length, last) = self.read(self.transfer.offset, data, objects)?;
        *command = toggle | (7 - length as u8) << 1 | if last { LAST } else { 0 };
        self.transfer.offset += length as u32;
        self.reply = Some(segment);
        if last {
            self.state = TransferState::Idle;
        }
        Ok(())
    }
}
