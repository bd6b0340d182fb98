//! Communication parameters: what is written is read, and what a reset keeps.

use canopen::{Emergency, ErrorCode, register};

use crate::bench::Bench;

#[test]
fn every_communication_parameter_reads_as_it_was_written() {
    let mut bench = Bench::new();
    // Sub-indices of the same object in this order: 1019h while 1006h is zero.
    for (index, sub, size, value) in [
        (0x1005, 0, 4, 0x81),
        (0x1007, 0, 4, 700),
        (0x1019, 0, 1, 9),
        (0x1006, 0, 4, 20_000),
        (0x1012, 0, 4, 0x190),
        (0x1014, 0, 4, 0x8000_0086),
        (0x1015, 0, 2, 250),
        (0x1016, 1, 4, 8 << 16 | 400),
        (0x1016, 2, 4, 9 << 16 | 500),
        (0x1017, 0, 2, 1000),
        (0x1029, 1, 1, 2),
        (0x1400, 2, 1, 1),
        (0x1400, 5, 2, 300),
        (0x1401, 1, 4, 0x8000_0307),
        (0x1801, 2, 1, 252),
        (0x1801, 3, 2, 77),
        (0x1801, 5, 2, 123),
        (0x1801, 6, 1, 9),
        // A write of any other parameter makes 1020h zero.
        (0x1020, 1, 4, 0x1234_5678),
        (0x1020, 2, 4, 0x9ABC_DEF0),
    ] {
        let bytes = u32::to_le_bytes(value);
        let done = bench.write(index, sub, &bytes[..size]);
        assert_eq!(done, Ok(()), "{index:x}:{sub}");
        assert_eq!(bench.read(index, sub), Ok(value), "{index:x}:{sub}");
    }
}

#[test]
fn bit_31_of_1005h_is_ignored_and_bit_30_of_1014h_is_refused() {
    let mut bench = Bench::new();
    assert_eq!(bench.write_u32(0x1005, 0, 0x8000_0080), Ok(()));
    assert_eq!(bench.read(0x1005, 0), Ok(0x80));
    for reserved in [0x4000_0085, 0xC000_0085] {
        assert_eq!(bench.write_u32(0x1014, 0, reserved), Err(0x0609_0030));
    }
}

#[test]
fn a_minimum_may_equal_its_maximum() {
    let mut bench = Bench::new();
    assert_eq!(bench.write_u32(0x607D, 1, 60_000), Ok(()));
    assert_eq!(bench.read(0x607D, 1), bench.read(0x607D, 2));
}

/// Errors with a bit of the error register each, and whether a reset of the communication clears
/// them.
const ERRORS: [(u16, u8, u8, bool); 4] = [
    // Of the server: the heartbeat of node 9.
    (0x8130, 9, register::COMMUNICATION, true),
    // Of the application: from instance 128 on, or with other codes.
    (0x8130, 128, register::MANUFACTURER, false),
    (0x8130, 129, register::CURRENT, false),
    (0x1000, 3, register::PROFILE, false),
];

#[test]
fn a_reset_of_the_communication_clears_the_errors_of_the_server_only() {
    let mut bench = Bench::new();
    for (code, instance, register, _) in ERRORS {
        let error = Emergency {
            instance,
            ..Emergency::new(ErrorCode(code), register)
        };
        bench.node.raise(error, &mut bench.device);
    }
    let bits = |bits: u8, (_, _, register, _): &(u16, u8, u8, bool)| bits | register;
    let all = ERRORS.iter().fold(register::GENERIC, bits);
    assert_eq!(bench.node.error_register(), all);
    bench.send(0, &[130, 5]);
    let kept = ERRORS.iter().filter(|(.., cleared)| !cleared);
    assert_eq!(bench.node.error_register(), kept.fold(1, bits));
    // The history is no parameter.
    assert_eq!(bench.read(0x1003, 0), Ok(4));
    bench.send(0, &[129, 5]);
    assert_eq!(bench.node.error_register(), 0);
    assert_eq!(bench.read(0x1003, 0), Ok(0));
}

#[test]
fn a_reset_of_the_communication_discards_emcys_that_were_not_sent() {
    let mut bench = Bench::new();
    bench.send(0, &[2, 5]);
    let error = Emergency::new(ErrorCode(0x1000), register::PROFILE);
    bench.node.raise(error, &mut bench.device);
    assert_eq!(bench.send(0, &[130, 5]), [(0x705, vec![0])]);
    assert!(bench.run_ms(10).is_empty());
}

#[test]
fn the_boot_up_counts_as_the_first_heartbeat() {
    let mut bench = Bench::new();
    bench.write_u16(0x1017, 0, 500).expect("any period");
    bench.save(1);
    assert_eq!(bench.send(0, &[130, 5]), [(0x705, vec![0])]);
    assert_eq!(bench.run_ms(500), [(500, (0x705, vec![127]))]);
}
