use crate::bench::Bench;

const TOO_LONG: u32 = 0x0607_0012;
const TOO_SHORT: u32 = 0x0607_0013;

fn abort(index: u16, sub: u8, code: u32) -> Option<[u8; 8]> {
    let ([low, high], [a, b, c, d]) = (index.to_le_bytes(), code.to_le_bytes());
    Some([0x80, low, high, sub, a, b, c, d])
}

#[test]
fn numbers_up_to_four_bytes_are_transferred_expedited() {
    let mut bench = Bench::new();
    bench.write(0x2020, 0, &[0xFE]).expect("unsigned");
    assert_eq!(bench.read(0x2020, 0), Ok(0xFE));
    bench
        .write(0x2001, 0, &(-1000_i16).to_le_bytes())
        .expect("in range");
    assert_eq!(
        bench.device.number(0x2001, 0) as i64,
        -1000,
        "sign-extended for the application"
    );
    assert_eq!(
        bench.sdo([0x40, 1, 0x20, 0, 0, 0, 0, 0]),
        Some([0x4B, 1, 0x20, 0, 0x18, 0xFC, 0, 0])
    );
    bench.write_u32(0x607A, 0, 0x8000_0001).expect("signed");
    assert_eq!(bench.read(0x607A, 0), Ok(0x8000_0001));
    assert_eq!(
        bench.device.number(0x607A, 0) as i64,
        i64::from(i32::MIN) + 1
    );
}

#[test]
fn a_download_without_indicated_size_uses_the_object_size() {
    let mut bench = Bench::new();
    assert_eq!(
        bench.sdo([0x22, 1, 0x20, 0, 5, 0, 9, 9]),
        Some([0x60, 1, 0x20, 0, 0, 0, 0, 0])
    );
    assert_eq!(bench.read(0x2001, 0), Ok(5));
    assert_eq!(
        bench.sdo([0x22, 4, 0x20, 0, 1, 2, 3, 4]),
        abort(0x2004, 0, TOO_SHORT)
    );
}

#[test]
fn each_refused_access_has_its_abort_code() {
    let mut bench = Bench::new();
    assert_eq!(bench.read(0x2FFF, 0), Err(0x0602_0000));
    assert_eq!(bench.read(0x1018, 5), Err(0x0609_0011));
    assert_eq!(bench.read(0x6040, 1), Err(0x0609_0011));
    assert_eq!(bench.read(0x2002, 0), Err(0x0601_0001));
    assert_eq!(bench.write_u16(0x6041, 0, 0), Err(0x0601_0002));
    assert_eq!(bench.write_u32(0x1000, 0, 0), Err(0x0601_0002));
    assert_eq!(bench.write_u32(0x6040, 0, 0), Err(TOO_LONG));
    assert_eq!(bench.write_u16(0x607A, 0, 0), Err(TOO_SHORT));
    assert_eq!(bench.write(0x2000, 0, &[3]), Err(0x0609_0031));
    assert_eq!(
        bench.write_u16(0x2001, 0, (-1001_i16) as u16),
        Err(0x0609_0032)
    );
    assert_eq!(
        bench.write(0x2003, 0, &1.6_f32.to_le_bytes()),
        Err(0x0609_0031)
    );
    assert_eq!(
        bench.write(0x2003, 0, &(-1.6_f32).to_le_bytes()),
        Err(0x0609_0032)
    );
    assert_eq!(
        bench.write(0x2003, 0, &f32::NAN.to_le_bytes()),
        Err(0x0609_0031)
    );
    assert_eq!(bench.write(0x2003, 0, &(-0.0_f32).to_le_bytes()), Ok(()));
    assert_eq!(
        bench.read(0x2010, 0),
        Err(0x0800_0024),
        "the domain is empty"
    );
}

#[test]
fn a_minimum_cannot_exceed_its_maximum() {
    let mut bench = Bench::new();
    let crossed = Err(0x0609_0036);
    assert_eq!(bench.write_u32(0x607D, 1, 60_001), crossed);
    assert_eq!(bench.write_u32(0x607D, 2, (-60_001_i32) as u32), crossed);
    assert_eq!(bench.write_u32(0x607D, 2, 90_000), Ok(()));
    assert_eq!(bench.write_u32(0x607D, 1, 60_001), Ok(()));
    assert_eq!(bench.write_u32(0x607D, 2, 60_000), crossed);
    assert_eq!(bench.read(0x607D, 2), Ok(90_000));
}

#[test]
fn guarded_objects_are_write_protected_while_the_drive_is_enabled() {
    let mut bench = Bench::operational();
    bench.device.enabled = true;
    assert_eq!(bench.write_u32(0x607D, 1, 0), Err(0x0800_0022));
    assert_eq!(bench.write_u16(0x6402, 0, 1), Err(0x0800_0022));
    assert_eq!(bench.write_u32(0x607A, 0, 5), Ok(()), "commands are not");
    bench.device.enabled = false;
    assert_eq!(bench.write_u32(0x607D, 1, 0), Ok(()));
}

#[test]
fn write_protection_applies_to_a_transfer_in_progress() {
    let mut bench = Bench::new();
    assert!(bench.sdo([0x21, 0x7D, 0x60, 1, 4, 0, 0, 0]).is_some());
    bench.device.enabled = true;
    assert_eq!(
        bench.sdo([0x07, 1, 0, 0, 0, 0, 0, 0]),
        abort(0x607D, 1, 0x0800_0022)
    );
}

#[test]
fn strings_and_long_numbers_are_transferred_in_segments() {
    let mut bench = Bench::new();
    assert_eq!(
        bench.sdo([0x40, 8, 0x10, 0, 0, 0, 0, 0]),
        Some([0x41, 8, 0x10, 0, 15, 0, 0, 0])
    );
    assert_eq!(
        bench.sdo([0x60, 0, 0, 0, 0, 0, 0, 0]),
        Some(*b"\x00CANOPEN")
    );
    assert_eq!(
        bench.sdo([0x70, 0, 0, 0, 0, 0, 0, 0]),
        Some(*b"\x10-EXAMPL")
    );
    assert_eq!(
        bench.sdo([0x60, 0, 0, 0, 0, 0, 0, 0]),
        Some(*b"\x0DE\0\0\0\0\0\0")
    );
    assert_eq!(
        bench.sdo([0x70, 0, 0, 0, 0, 0, 0, 0]),
        abort(0, 0, 0x0504_0001),
        "the transfer has ended"
    );

    assert_eq!(
        bench.sdo([0x21, 4, 0x20, 0, 8, 0, 0, 0]),
        Some([0x60, 4, 0x20, 0, 0, 0, 0, 0])
    );
    assert_eq!(
        bench.sdo([0, 1, 2, 3, 4, 5, 6, 7]),
        Some([0x20, 0, 0, 0, 0, 0, 0, 0])
    );
    assert_eq!(
        bench.sdo([0x1D, 8, 0, 0, 0, 0, 0, 0]),
        Some([0x30, 0, 0, 0, 0, 0, 0, 0])
    );
    assert_eq!(bench.device.number(0x2004, 0), 0x0807_0605_0403_0201);
}

#[test]
fn a_string_may_have_any_length_up_to_its_maximum() {
    let mut bench = Bench::new();
    assert_eq!(
        bench.sdo([0x40, 5, 0x20, 0, 0, 0, 0, 0]),
        Some([0x41, 5, 0x20, 0, 0, 0, 0, 0])
    );
    assert_eq!(
        bench.sdo([0x60, 0, 0, 0, 0, 0, 0, 0]),
        Some([0x0F, 0, 0, 0, 0, 0, 0, 0])
    );
    assert_eq!(
        bench.sdo([0x21, 5, 0x20, 0, 33, 0, 0, 0]),
        abort(0x2005, 0, TOO_LONG)
    );
    assert_eq!(
        bench.sdo([0x20, 5, 0x20, 0, 0, 0, 0, 0]),
        Some([0x60, 5, 0x20, 0, 0, 0, 0, 0])
    );
    for toggle in [0, 0x10, 0, 0x10] {
        assert_eq!(
            bench.sdo([toggle, 1, 1, 1, 1, 1, 1, 1]),
            Some([0x20 | toggle, 0, 0, 0, 0, 0, 0, 0])
        );
    }
    assert_eq!(
        bench.sdo([0x01, 1, 1, 1, 1, 1, 1, 1]),
        abort(0x2005, 0, TOO_LONG),
        "35 bytes where 32 may be"
    );
}

#[test]
fn a_string_of_more_than_64_bytes_ends_with_the_segment_that_does_not_fit() {
    let mut bench = Bench::new();
    bench.sdo([0x20, 6, 0x20, 0, 0, 0, 0, 0]);
    for toggle in [0, 0x10].into_iter().cycle().take(9) {
        let answer = bench.sdo([toggle, 1, 1, 1, 1, 1, 1, 1]);
        assert_eq!(answer, Some([0x20 | toggle, 0, 0, 0, 0, 0, 0, 0]));
    }
    let answer = bench.sdo([0x10, 1, 1, 1, 1, 1, 1, 1]);
    assert_eq!(answer, abort(0x2006, 0, TOO_LONG));
}

#[test]
fn data_that_differ_from_the_indicated_size_are_refused() {
    let mut bench = Bench::new();
    bench.sdo([0x21, 5, 0x20, 0, 6, 0, 0, 0]);
    assert_eq!(
        bench.sdo([0x01, 1, 1, 1, 1, 1, 1, 1]),
        abort(0x2005, 0, TOO_LONG)
    );
    bench.sdo([0x21, 5, 0x20, 0, 8, 0, 0, 0]);
    assert_eq!(
        bench.sdo([0x01, 1, 1, 1, 1, 1, 1, 1]),
        abort(0x2005, 0, TOO_SHORT)
    );
    assert!(bench.device.strings.is_empty());
}

#[test]
fn a_toggle_bit_that_does_not_alternate_aborts_the_transfer() {
    let mut bench = Bench::new();
    bench.sdo([0x40, 8, 0x10, 0, 0, 0, 0, 0]);
    assert_eq!(
        bench.sdo([0x70, 0, 0, 0, 0, 0, 0, 0]),
        abort(0x1008, 0, 0x0503_0000)
    );
    bench.sdo([0x21, 0x10, 0x20, 0, 20, 0, 0, 0]);
    bench.sdo([0x00, 1, 1, 1, 1, 1, 1, 1]);
    assert_eq!(
        bench.sdo([0x00, 1, 1, 1, 1, 1, 1, 1]),
        abort(0x2010, 0, 0x0503_0000)
    );
    assert_eq!(bench.device.cancelled, 1);
}

#[test]
fn a_transfer_times_out_after_one_second() {
    let mut bench = Bench::new();
    bench.sdo([0x40, 8, 0x10, 0, 0, 0, 0, 0]);
    assert!(bench.run_ms(999).is_empty());
    bench.sdo([0x60, 0, 0, 0, 0, 0, 0, 0]);
    assert!(
        bench.run_ms(999).is_empty(),
        "a frame restarts the time-out"
    );
    let sent = bench.run_ms(1);
    assert_eq!(sent, [(1, (0x585, vec![0x80, 8, 0x10, 0, 0, 0, 4, 5]))]);
    assert!(bench.run_ms(2000).is_empty());
}

#[test]
fn an_abort_of_the_client_is_not_answered() {
    let mut bench = Bench::new();
    bench.sdo([0x21, 0x10, 0x20, 0, 20, 0, 0, 0]);
    assert_eq!(bench.sdo([0x80, 0x10, 0x20, 0, 0, 0, 0, 8]), None);
    assert_eq!(bench.device.cancelled, 1);
    assert!(bench.run_ms(2000).is_empty());
}

#[test]
fn a_new_initiate_request_replaces_a_transfer() {
    let mut bench = Bench::new();
    bench.sdo([0x21, 0x10, 0x20, 0, 20, 0, 0, 0]);
    assert_eq!(bench.read(0x1000, 0), Ok(0x0002_0192));
    assert_eq!(bench.device.cancelled, 1);
    assert!(bench.run_ms(2000).is_empty());
}

#[test]
fn unknown_command_specifiers_are_aborted_and_other_lengths_are_ignored() {
    let mut bench = Bench::new();
    for command in [0xE0, 0xFF, 0x00, 0x60, 0xA1, 0xA2, 0xA3, 0xC1, 0x81] {
        let answer = bench
            .sdo([command, 0, 0x10, 0, 0, 0, 0, 0])
            .expect("an answer");
        assert_eq!(answer[4..], [1, 0, 4, 5], "{command:#X}");
    }
    for length in 0..8 {
        assert!(
            bench
                .send(0x605, &[0x40, 0, 0x10, 0, 0, 0, 0][..length])
                .is_empty()
        );
        assert!(bench.remote(0x605, length as u8).is_empty());
    }
    assert!(bench.remote(0x605, 8).is_empty());
}

#[test]
fn the_reply_waits_for_a_pending_application() {
    let mut bench = Bench::new();
    bench.sdo([0x21, 0x10, 0x20, 0, 5, 0, 0, 0]);
    assert_eq!(bench.sdo([0x05, 1, 2, 3, 4, 5, 0, 0]), None);
    let sent = bench.run_ms(5);
    assert_eq!(sent.len(), 1);
    assert_eq!(sent[0].1, (0x585, vec![0x20, 0, 0, 0, 0, 0, 0, 0]));
    assert_eq!(bench.device.domain, [1, 2, 3, 4, 5]);
}

#[test]
fn a_29_bit_identifier_does_not_match_an_11_bit_identifier() {
    let mut bench = Bench::new();
    let data = [0x40, 0, 0x10, 0, 0, 0, 0, 0];
    let frame = canopen::CanFrame::raw(0x605, true, false, 8, data).expect("a frame");
    assert!(bench.receive(&frame).is_empty());
    let stop = canopen::CanFrame::raw(0, true, false, 2, [2, 5, 0, 0, 0, 0, 0, 0]);
    bench.receive(&stop.expect("a frame"));
    assert!(bench.read(0x1000, 0).is_ok(), "not stopped");
}
