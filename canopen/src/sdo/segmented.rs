//! Segments of seven bytes, each confirmed (CiA 301, 7.2.4.3).

use super::{BUFFER, Data, Download, Objects, State, Step, Upload};
use crate::Abort;

const TOGGLE: u8 = 1 << 4;
const LAST: u8 = 1;

#[derive(Clone, Copy, Debug)]
pub(super) struct SegmentedDownload {
    pub download: Download,
    pub toggle: bool,
}

impl SegmentedDownload {
    pub fn segment(
        mut self,
        request: &Data,
        buffer: &mut [u8; BUFFER],
        objects: &mut impl Objects,
    ) -> Step {
        let [command, data @ ..] = request;
        if (command & TOGGLE != 0) != self.toggle {
            return Err(Abort::Toggle);
        }
        let unused = usize::from(command >> 1 & 7);
        self.download
            .take(data.get(..7 - unused).unwrap_or_default(), buffer, objects)?;
        let reply = [0x20 | command & TOGGLE, 0, 0, 0, 0, 0, 0, 0];
        if command & LAST != 0 {
            return self.download.finish(reply, buffer, objects);
        }
        self.toggle = !self.toggle;
        Ok((State::SegmentedDownload(self), Some(reply)))
    }
}

#[derive(Clone, Copy, Debug)]
pub(super) struct SegmentedUpload {
    pub upload: Upload,
    pub toggle: bool,
    pub offset: u32,
}

impl SegmentedUpload {
    pub fn segment(
        mut self,
        request: &Data,
        buffer: &[u8; BUFFER],
        objects: &mut impl Objects,
    ) -> Step {
        if (request[0] & TOGGLE != 0) != self.toggle {
            return Err(Abort::Toggle);
        }
        let mut reply = [0; 8];
        let [command, data @ ..] = &mut reply;
        let length = self.upload.read(self.offset, data, buffer, objects)?;
        self.offset = self.offset.saturating_add(length as u32);
        let last = self.offset >= self.upload.size;
        let unused = 7 - length as u8;
        *command = request[0] & TOGGLE | unused << 1 | if last { LAST } else { 0 };
        self.toggle = !self.toggle;
        let state = if last {
            State::Idle
        } else {
            State::SegmentedUpload(self)
        };
        Ok((state, Some(reply)))
    }
}
