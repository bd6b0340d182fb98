//! Initiate (CiA 301, 7.2.4.3): up to four bytes go in the same frame, more in segments.

use super::{Data, Objects, Server, State, word};
use crate::Abort;

impl Server {
    pub(super) fn download(
        &mut self,
        request: &Data,
        objects: &mut impl Objects,
    ) -> Result<(), Abort> {
        let [command, _, _, _, data @ ..] = request;
        let (expedited, sized) = (command & 2 != 0, command & 1 != 0);
        let length = if !expedited {
            sized.then(|| word(request))
        } else if sized {
            Some(u32::from(4 - (command >> 2 & 3)))
        } else {
            // Without a size the data type tells; what has none takes all four bytes.
            let row = objects.entry(self.transfer.address)?;
            Some(row.data_type().size().map_or(4, u32::from))
        };
        self.begin_download(State::SegmentedDownload, length, objects)?;
        self.answer_of_object(0x60, 0);
        if expedited {
            // What needs more than four bytes and names no size stays without some and is too short.
            let data = length
                .and_then(|length| data.get(..length as usize))
                .unwrap_or(data);
            self.take(data, objects)?;
            self.finish(objects)?;
        }
        Ok(())
    }

    pub(super) fn upload(&mut self, objects: &mut impl Objects) -> Result<(), Abort> {
        self.begin_upload(objects)?;
        self.answer_upload(objects)
    }

    /// The answer to an upload request, in one frame where that suffices.
    pub(super) fn answer_upload(&mut self, objects: &mut impl Objects) -> Result<(), Abort> {
        let size = self.size();
        if !matches!(size, 1..=4) {
            self.state = State::SegmentedUpload;
            self.answer_of_object(0x41, size);
            return Ok(());
        }
        let mut data = [0; 4];
        self.read(0, &mut data, objects)?;
        let unused = (4 - size) as u8;
        self.answer_of_object(0x43 | unused << 2, u32::from_le_bytes(data));
        Ok(())
    }
}
