use crate::bench::{Bench, SentFrame};

/// CRC of CiA 301, calculated bit by bit from its polynomial.
fn crc(data: &[u8]) -> [u8; 2] {
    let mut crc = 0_u16;
    for byte in data {
        crc ^= u16::from(*byte) << 8;
        for _ in 0..8 {
            crc = if crc & 0x8000 == 0 {
                crc << 1
            } else {
                crc << 1 ^ 0x1021
            };
        }
    }
    crc.to_le_bytes()
}

fn pattern(length: usize) -> Vec<u8> {
    (0..length).map(|at| (at * 7 + at / 256) as u8).collect()
}

fn begin_upload(bench: &mut Bench, block: u8) -> Option<[u8; 8]> {
    bench.sdo([0xA4, 0x10, 0x20, 0, block, 0, 0, 0])
}

fn segments(sent: Vec<SentFrame>) -> Vec<Vec<u8>> {
    sent.into_iter()
        .filter(|(id, _)| *id == 0x585)
        .map(|(_, data)| data)
        .collect()
}

/// Block upload; `lose` returns the maximum number of segments to confirm in each block.
fn upload(bench: &mut Bench, block: u8, lose: impl Fn(usize) -> usize) -> Vec<u8> {
    let answer = begin_upload(bench, block).expect("an answer");
    assert_eq!(answer[..4], [0xC6, 0x10, 0x20, 0]);
    let size = u32::from_le_bytes(answer[4..].try_into().expect("four bytes")) as usize;
    let mut data = Vec::new();
    let mut out = segments(bench.send(0x605, &[0xA3, 0, 0, 0, 0, 0, 0, 0]));
    for round in 0.. {
        assert!(out.len() <= usize::from(block));
        for (at, segment) in out.iter().enumerate() {
            assert_eq!(usize::from(segment[0] & 0x7F), at + 1, "in order");
        }
        let kept = out.len().min(lose(round));
        let last = out
            .get(kept.wrapping_sub(1))
            .is_some_and(|segment| segment[0] & 0x80 != 0);
        data.extend(
            out.iter()
                .take(kept)
                .flat_map(|segment| segment[1..].to_vec()),
        );
        out = segments(bench.send(0x605, &[0xA2, kept as u8, block, 0, 0, 0, 0, 0]));
        if last {
            break;
        }
    }
    let [end] = out.as_slice() else {
        panic!("{out:?}")
    };
    assert_eq!(end[0] & 0xE3, 0xC1);
    data.truncate(data.len() - usize::from(end[0] >> 2 & 7));
    assert_eq!(data.len(), size);
    assert_eq!(end[1..3], crc(&data));
    assert!(bench.send(0x605, &[0xA1, 0, 0, 0, 0, 0, 0, 0]).is_empty());
    data
}

#[test]
fn block_uploads_of_all_lengths_are_complete_and_have_a_valid_crc() {
    let mut bench = Bench::new();
    for length in (1..30).chain([888, 889, 890, 1778, 5000, 1 << 16]) {
        bench.device.domain = pattern(length);
        for block in [1, 5, 127] {
            if length < 6000 || block == 127 {
                assert_eq!(upload(&mut bench, block, |_| 127), bench.device.domain);
            }
        }
    }
}

#[test]
fn lost_segments_are_repeated_and_enter_the_crc_once() {
    let mut bench = Bench::new();
    bench.device.domain = pattern(1000);
    let lossy = |round| if round % 2 == 0 { round % 9 } else { 127 };
    assert_eq!(upload(&mut bench, 20, lossy), bench.device.domain);
}

#[test]
fn a_block_size_outside_1_to_127_is_refused() {
    let mut bench = Bench::new();
    bench.device.domain = pattern(100);
    for block in [0, 128, 255] {
        assert_eq!(
            begin_upload(&mut bench, block),
            Some([0x80, 0x10, 0x20, 0, 2, 0, 4, 5])
        );
    }
    begin_upload(&mut bench, 4);
    bench.send(0x605, &[0xA3, 0, 0, 0, 0, 0, 0, 0]);
    assert_eq!(
        bench.sdo([0xA2, 4, 0, 0, 0, 0, 0, 0]),
        Some([0x80, 0x10, 0x20, 0, 2, 0, 4, 5])
    );
}

#[test]
fn a_confirmation_beyond_the_transmitted_segments_is_refused() {
    let mut bench = Bench::new();
    bench.device.domain = pattern(100);
    begin_upload(&mut bench, 4);
    bench.send(0x605, &[0xA3, 0, 0, 0, 0, 0, 0, 0]);
    assert_eq!(
        bench.sdo([0xA2, 5, 4, 0, 0, 0, 0, 0]),
        Some([0x80, 0x10, 0x20, 0, 3, 0, 4, 5])
    );
}

#[test]
fn an_upload_below_the_protocol_switch_threshold_is_not_a_block_transfer() {
    let mut bench = Bench::new();
    let answer = bench.sdo([0xA4, 0, 0x10, 0, 127, 4, 0, 0]);
    assert_eq!(answer, Some([0x43, 0, 0x10, 0, 0x92, 1, 2, 0]));
    assert_eq!(
        bench.sdo([0xA4, 0, 0x10, 0, 127, 3, 0, 0]),
        Some([0xC6, 0, 0x10, 0, 4, 0, 0, 0])
    );
    assert_eq!(
        bench.sdo([0xA0, 8, 0x10, 0, 127, 20, 0, 0]),
        Some([0x41, 8, 0x10, 0, 15, 0, 0, 0]),
        "segmented upload"
    );
}

/// Sends a block of `data` without the segments in `lost`; returns the confirmation, if any.
fn block(bench: &mut Bench, data: &[u8], lost: &[usize]) -> Option<u8> {
    let count = data.len().div_ceil(7);
    let mut confirmed = None;
    for (at, bytes) in data.chunks(7).take(127).enumerate() {
        if lost.contains(&at) {
            continue;
        }
        let mut segment = [0; 8];
        segment[0] = (at as u8 + 1) | if at + 1 == count { 0x80 } else { 0 };
        segment[1..=bytes.len()].copy_from_slice(bytes);
        if let Some(answer) = bench.sdo(segment) {
            assert_eq!((answer[0], answer[2]), (0xA2, 127));
            confirmed = Some(answer[1]);
        }
    }
    confirmed
}

fn begin_download(bench: &mut Bench, size: u32) {
    let [a, b, c, d] = size.to_le_bytes();
    let answer = bench.sdo([0xC6, 0x10, 0x20, 0, a, b, c, d]);
    assert_eq!(answer, Some([0xA4, 0x10, 0x20, 0, 127, 0, 0, 0]));
}

fn end_download(bench: &mut Bench, data: &[u8], checksum: [u8; 2]) -> Vec<u8> {
    let unused = (7 - data.len() % 7) % 7;
    let [low, high] = checksum;
    let mut sent = bench.send(
        0x605,
        &[0xC1 | (unused as u8) << 2, low, high, 0, 0, 0, 0, 0],
    );
    sent.extend(bench.run_ms(5).into_iter().map(|(_, sent)| sent));
    assert_eq!(sent.len(), 1);
    sent.remove(0).1
}

fn download(bench: &mut Bench, data: &[u8], lost: impl Fn(usize) -> Vec<usize>) -> Vec<u8> {
    begin_download(bench, data.len() as u32);
    let mut sent = 0;
    for round in 0.. {
        let lost = lost(round);
        let confirmed = block(bench, &data[sent..], &lost).expect("a confirmation");
        sent = (sent + usize::from(confirmed) * 7).min(data.len());
        if sent == data.len() {
            break;
        }
    }
    end_download(bench, data, crc(data))
}

#[test]
fn block_downloads_of_all_lengths_are_complete() {
    let mut bench = Bench::new();
    for length in (1..30).chain([888, 889, 890, 1778, 5000, 1 << 16]) {
        let data = pattern(length);
        assert_eq!(download(&mut bench, &data, |_| vec![])[0], 0xA1);
        assert_eq!(bench.device.domain, data);
    }
}

#[test]
fn segments_after_a_gap_are_requested_again() {
    let mut bench = Bench::new();
    let data = pattern(2000);
    let lost = |round| {
        if round < 3 {
            vec![round * 5, 40]
        } else {
            vec![]
        }
    };
    assert_eq!(download(&mut bench, &data, lost)[0], 0xA1);
    assert_eq!(bench.device.domain, data);
}

#[test]
fn a_wrong_crc_leaves_the_object_unchanged() {
    let mut bench = Bench::new();
    bench.device.domain = vec![1, 2, 3];
    let data = pattern(20);
    begin_download(&mut bench, 20);
    assert_eq!(block(&mut bench, &data, &[]), Some(3));
    let [low, high] = crc(&data);
    let answer = end_download(&mut bench, &data, [low ^ 1, high]);
    assert_eq!(answer, [0x80, 0x10, 0x20, 0, 4, 0, 4, 5]);
    assert_eq!(
        (bench.device.domain.as_slice(), bench.device.cancelled),
        (&[1, 2, 3][..], 1)
    );
}

#[test]
fn a_size_other_than_the_indicated_one_is_refused() {
    let mut bench = Bench::new();
    let data = pattern(14);
    for (announced, code) in [(15_u32, 0x13), (13, 0x12)] {
        begin_download(&mut bench, announced);
        block(&mut bench, &data, &[]);
        assert_eq!(
            end_download(&mut bench, &data, crc(&data)),
            [0x80, 0x10, 0x20, 0, code, 0, 7, 6]
        );
    }
    let answer = bench.sdo([0xC6, 0x10, 0x20, 0, 1, 0, 1, 0]);
    assert_eq!(
        answer,
        Some([0x80, 0x10, 0x20, 0, 5, 0, 4, 5]),
        "64 KiB and a byte"
    );
}

#[test]
fn a_sequence_number_of_zero_is_refused() {
    let mut bench = Bench::new();
    begin_download(&mut bench, 100);
    assert_eq!(
        bench.sdo([0, 1, 2, 3, 4, 5, 6, 7]),
        Some([0x80, 0x10, 0x20, 0, 3, 0, 4, 5])
    );
}

#[test]
fn an_abort_between_segments_ends_a_block_download() {
    let mut bench = Bench::new();
    begin_download(&mut bench, 100);
    assert_eq!(bench.sdo([0x80, 0x10, 0x20, 0, 0, 0, 0, 8]), None);
    assert_eq!(bench.read(0x1000, 0), Ok(0x0002_0192));
}

#[test]
fn numbers_and_strings_can_be_transferred_in_blocks() {
    let mut bench = Bench::new();
    assert_eq!(
        bench.sdo([0xC6, 1, 0x20, 0, 2, 0, 0, 0]),
        Some([0xA4, 1, 0x20, 0, 127, 0, 0, 0])
    );
    assert_eq!(
        bench.sdo([0x81, 0x2C, 1, 0, 0, 0, 0, 0]),
        Some([0xA2, 1, 127, 0, 0, 0, 0, 0])
    );
    let [low, high] = crc(&[0x2C, 1]);
    let answer = bench.sdo([0xC1 | 5 << 2, low, high, 0, 0, 0, 0, 0]);
    assert_eq!(answer, Some([0xA1, 0, 0, 0, 0, 0, 0, 0]));
    assert_eq!(bench.read(0x2001, 0), Ok(300));
    assert_eq!(
        bench.sdo([0xC6, 1, 0x20, 0, 3, 0, 0, 0]),
        Some([0x80, 1, 0x20, 0, 0x12, 0, 7, 6])
    );
}

#[test]
fn a_client_may_do_without_size_and_crc() {
    let mut bench = Bench::new();
    let data = pattern(10);
    // The bytes of the size are reserved.
    for (begin, checksum) in [(0xC4, crc(&data)), (0xC2, [0; 2]), (0xC0, [0; 2])] {
        let size = if begin & 2 == 0 { 0 } else { 10 };
        let answer = bench.sdo([begin, 0x10, 0x20, 0, size, 0, 0, 0]);
        assert_eq!(answer, Some([0xA4, 0x10, 0x20, 0, 127, 0, 0, 0]));
        assert_eq!(block(&mut bench, &data, &[]), Some(2));
        assert_eq!(end_download(&mut bench, &data, checksum)[0], 0xA1);
        assert_eq!(bench.device.domain, data);
        bench.device.domain.clear();
    }
    bench.device.domain = data;
    bench.sdo([0xA0, 0x10, 0x20, 0, 127, 0, 0, 0]);
    assert_eq!(
        segments(bench.send(0x605, &[0xA3, 0, 0, 0, 0, 0, 0, 0])).len(),
        2
    );
    let end = bench.sdo([0xA2, 2, 127, 0, 0, 0, 0, 0]);
    assert_eq!(end, Some([0xC1 | 4 << 2, 0, 0, 0, 0, 0, 0, 0]));
}

#[test]
fn an_empty_object_is_one_segment_which_is_repeated_until_it_is_confirmed() {
    let mut bench = Bench::new();
    let answer = bench.sdo([0xA4, 5, 0x20, 0, 127, 0, 0, 0]);
    assert_eq!(answer, Some([0xC6, 5, 0x20, 0, 0, 0, 0, 0]));
    let segment = Some([0x81, 0, 0, 0, 0, 0, 0, 0]);
    assert_eq!(bench.sdo([0xA3, 0, 0, 0, 0, 0, 0, 0]), segment);
    assert_eq!(bench.sdo([0xA2, 0, 127, 0, 0, 0, 0, 0]), segment);
    let end = bench.sdo([0xA2, 1, 127, 0, 0, 0, 0, 0]);
    assert_eq!(end, Some([0xC1 | 7 << 2, 0, 0, 0, 0, 0, 0, 0]));
}
