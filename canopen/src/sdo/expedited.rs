//! SDO initiate download and upload (CiA 301, 7.2.4.3): up to four bytes are transferred expedited,
//! more in segments.

use super::{Data, ObjectAccess, SdoServer, TransferState, word};
use crate::Abort;

impl SdoServer {
    pub(super) fn download(
        &mut self,
        request: &Data,
        objects: &mut impl ObjectAccess,
    ) -> Result<(), Abort> {
        let [command, _, _, _, data @ ..] = request;
        let (expedited, sized) = (command & 2 != 0, command & 1 != 0);
        let length = if !expedited {
            sized.then(|| word(request))
        } else if sized {
            Some(u32::from(4 - (command >> 2 & 3)))
        } else {
            // If no size is indicated, the data type determines it; a type without a fixed size
            // takes all four bytes.
            let entry = objects.entry(self.transfer.address)?;
            Some(entry.data_type().size().map_or(4, u32::from))
        };
        self.begin_download(TransferState::SegmentedDownload, length, objects)?;
        self.answer_with_object(0x60, 0);
        if expedited {
            // A type longer than four bytes without indicated size remains incomplete: `finish`
            // aborts with "too short".
            let data = length
                .and_then(|length| data.get(..length as usize))
                .unwrap_or(data);
            self.receive_data(data, objects)?;
            self.finish(objects)?;
        }
        Ok(())
    }

    pub(super) fn upload(&mut self, objects: &mut impl ObjectAccess) -> Result<(), Abort> {
        self.begin_upload(objects)?;
        self.answer_upload(objects)
    }

    /// Answers an upload request, expedited if the data fit into one frame.
    pub(super) fn answer_upload(&mut self, objects: &mut impl ObjectAccess) -> Result<(), Abort> {
        let size = self.size();
        if !matches!(size, 1..=4) {
            self.state = TransferState::SegmentedUpload;
            self.answer_with_object(0x41, size);
            return Ok(());
        }
        let mut data = [0; 4];
        self.read(0, &mut data, objects)?;
        let unused = (4 - size) as u8;
        self.answer_with_object(0x43 | unused << 2, u32::from_le_bytes(data));
        Ok(())
    }
}
