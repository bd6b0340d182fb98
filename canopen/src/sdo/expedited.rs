//! Initiate (CiA 301, 7.2.4.3): up to four bytes go in the same frame, more in segments.

use super::segmented::{SegmentedDownload, SegmentedUpload};
use super::{BUFFER, Data, Download, Objects, State, Step, Upload, address, reply, word};

pub(super) fn download(
    request: &Data,
    buffer: &mut [u8; BUFFER],
    objects: &mut impl Objects,
) -> Step {
    let [command, _, _, _, data @ ..] = request;
    let (expedited, sized) = (command & 2 != 0, command & 1 != 0);
    let accepted = reply(0x60, request, 0);
    if !expedited {
        let announced = sized.then(|| word(request));
        let download = Download::begin(address(request), announced, objects)?;
        return Ok((
            State::SegmentedDownload(SegmentedDownload {
                download,
                toggle: false,
            }),
            Some(accepted),
        ));
    }
    let row = objects.entry(address(request))?;
    let length = if sized {
        4 - (command >> 2 & 3)
    } else {
        // Without a size the data type tells; what has none takes all four bytes.
        row.data_type().size().unwrap_or(4)
    };
    let mut download = Download::begin(address(request), Some(u32::from(length)), objects)?;
    // What needs more than four bytes and names no size stays without some and is too short.
    let data = data.get(..usize::from(length)).unwrap_or(data);
    let taken = download.take(data, buffer, objects);
    let step = taken.and_then(|()| download.finish(accepted, buffer, objects));
    if step.is_err() {
        download.cancel(objects);
    }
    step
}

pub(super) fn upload(
    request: &Data,
    buffer: &mut [u8; BUFFER],
    objects: &mut impl Objects,
) -> Step {
    let upload = Upload::begin(address(request), buffer, objects)?;
    answer_upload(upload, request, buffer, objects)
}

/// The answer to an upload request, in one frame where that suffices.
pub(super) fn answer_upload(
    upload: Upload,
    request: &Data,
    buffer: &[u8; BUFFER],
    objects: &mut impl Objects,
) -> Step {
    if !matches!(upload.size, 1..=4) {
        let transfer = SegmentedUpload {
            upload,
            toggle: false,
            offset: 0,
        };
        return Ok((
            State::SegmentedUpload(transfer),
            Some(reply(0x41, request, upload.size)),
        ));
    }
    let mut data = [0; 4];
    upload.read(0, &mut data, buffer, objects)?;
    let unused = (4 - upload.size) as u8;
    let answer = reply(0x43 | unused << 2, request, u32::from_le_bytes(data));
    Ok((State::Idle, Some(answer)))
}
