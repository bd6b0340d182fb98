//! PDO COB-IDs and mapping.

use crate::bench::Bench;

const VALUE: Result<(), u32> = Err(0x0609_0030);
const UNSUPPORTED: Result<(), u32> = Err(0x0601_0000);
const NOT_MAPPABLE: Result<(), u32> = Err(0x0604_0041);
const LENGTH: Result<(), u32> = Err(0x0604_0042);

/// Maps TPDO 2, which is not valid.
fn map(bench: &mut Bench, words: &[u32]) -> Result<(), u32> {
    bench.write(0x1A01, 0, &[0])?;
    for (sub, word) in (1..).zip(words) {
        bench.write_u32(0x1A01, sub, *word)?;
    }
    bench.write(0x1A01, 0, &[words.len() as u8])
}

#[test]
fn default_cob_ids_contain_the_node_id() {
    let mut bench = Bench::new();
    assert_eq!(bench.read(0x1400, 1), Ok(0x205));
    assert_eq!(bench.read(0x1800, 1), Ok(0x4000_0185));
    assert_eq!(bench.read(0x1801, 1), Ok(0xC000_0285));
    assert_eq!(bench.read(0x1200, 1), Ok(0x605));
    assert_eq!(bench.read(0x1A00, 0), Ok(2));
    assert_eq!(bench.read(0x1800, 4), Err(0x0609_0011));
}

#[test]
fn a_cob_id_with_bit_30_clear_is_accepted() {
    let mut bench = Bench::new();
    assert_eq!(bench.write_u32(0x1801, 1, 0x285), Ok(()));
    assert_eq!(bench.read(0x1801, 1), Ok(0x285));
}

#[test]
fn a_pdo_cob_id_changes_only_while_the_pdo_is_not_valid() {
    let mut bench = Bench::new();
    assert_eq!(bench.write_u32(0x1800, 1, 0x4000_0190), VALUE);
    assert_eq!(bench.write_u32(0x1800, 1, 0xC000_0190), Ok(()));
    for restricted in [
        0x0, 0x7F, 0x101, 0x180, 0x581, 0x601, 0x6E0, 0x701, 0x7FF, 0x1185,
    ] {
        assert_eq!(
            bench.write_u32(0x1800, 1, 0x4000_0000 | restricted),
            VALUE,
            "{restricted:#X}"
        );
    }
    assert_eq!(bench.write_u32(0x1800, 1, 0x4000_0190), Ok(()));
}

#[test]
fn a_valid_pdo_may_be_written_with_the_same_identifier_and_another_bit_30() {
    let mut bench = Bench::new();
    assert_eq!(bench.write_u32(0x1800, 1, 0x185), Ok(()));
    assert_eq!(bench.write_u32(0x1800, 1, 0x4000_0185), Ok(()));
}

#[test]
fn the_identifier_of_a_pdo_that_is_not_valid_has_11_bits_or_bit_29() {
    let mut bench = Bench::new();
    for good in [0x8000_07FF, 0xA000_1185] {
        assert_eq!(bench.write_u32(0x1801, 1, good), Ok(()), "{good:#X}");
    }
    for bad in [0x8000_0800, 0x8000_1185] {
        assert_eq!(bench.write_u32(0x1801, 1, bad), VALUE, "{bad:#X}");
    }
}

#[test]
fn inhibit_time_and_sync_start_value_change_only_while_the_pdo_is_not_valid() {
    let mut bench = Bench::new();
    assert_eq!(bench.write_u16(0x1800, 3, 10), Err(0x0800_0022));
    assert_eq!(bench.write(0x1800, 6, &[1]), Err(0x0800_0022));
    assert_eq!(bench.write_u16(0x1801, 3, 10), Ok(()));
    assert_eq!(bench.write(0x1801, 6, &[240]), Ok(()));
    assert_eq!(bench.write(0x1801, 6, &[241]), VALUE);
}

#[test]
fn only_the_standard_transmission_types_are_accepted() {
    let mut bench = Bench::new();
    for (index, good, bad) in [
        (
            0x1400,
            &[0, 1, 240, 254, 255][..],
            &[241, 251, 252, 253][..],
        ),
        (0x1800, &[0, 1, 240, 252, 253, 254, 255], &[241, 251]),
    ] {
        for transmission in good {
            assert_eq!(
                bench.write(index, 2, &[*transmission]),
                Ok(()),
                "{index:X} {transmission}"
            );
        }
        for transmission in bad {
            assert_eq!(
                bench.write(index, 2, &[*transmission]),
                VALUE,
                "{index:X} {transmission}"
            );
        }
    }
}

#[test]
fn a_mapping_changes_only_while_the_pdo_is_not_valid_and_sub_index_0_is_zero() {
    let mut bench = Bench::new();
    assert_eq!(bench.write(0x1A00, 0, &[0]), UNSUPPORTED);
    assert_eq!(bench.write_u32(0x1A00, 1, 0x6041_0010), UNSUPPORTED);
    assert_eq!(
        bench.write_u32(0x1A01, 1, 0x6041_0010),
        UNSUPPORTED,
        "three objects are mapped"
    );
    assert_eq!(map(&mut bench, &[0x6041_0010]), Ok(()));
}

#[test]
fn a_mapping_changes_in_operational() {
    let mut bench = Bench::operational();
    bench.device.set(0x2020, 0x12);
    bench.device.set(0x2001, -2);
    assert_eq!(map(&mut bench, &[0x2020_0008, 0x2001_0010]), Ok(()));
    assert_eq!(bench.write_u32(0x1801, 1, 0x4000_0285), Ok(()));
    assert_eq!(bench.wait_us(1000), [(0x285, vec![0x12, 0xFE, 0xFF])]);
}

#[test]
fn objects_that_are_not_mappable_are_refused() {
    let mut bench = Bench::new();
    assert_eq!(map(&mut bench, &[0x2FFF_0008]), Err(0x0602_0000));
    assert_eq!(map(&mut bench, &[0x1018_0920]), Err(0x0609_0011));
    assert_eq!(map(&mut bench, &[0x2000_0008]), NOT_MAPPABLE);
    assert_eq!(map(&mut bench, &[0x6041_0008]), NOT_MAPPABLE, "16 bits");
    assert_eq!(map(&mut bench, &[0x6041_0000]), NOT_MAPPABLE);
    assert_eq!(
        map(&mut bench, &[0x0005_0008]),
        Err(0x0602_0000),
        "dummy entries are allowed in RPDOs only"
    );
    assert_eq!(map(&mut bench, &[0x2004_0040]), Ok(()), "eight bytes");
    assert_eq!(map(&mut bench, &[0x2004_0040, 0x2020_0008]), LENGTH);
    assert_eq!(bench.write(0x1A01, 0, &[9]), LENGTH);
    assert_eq!(bench.write(0x1A01, 0, &[255]), LENGTH);
    assert_eq!(
        map(&mut bench, &[0x6041_0010, 0]),
        Err(0x0602_0000),
        "an enabled entry is empty"
    );
    let rpdo = [(0, 0), (1, 0x6041_0010)].map(|(sub, word)| {
        let width = if sub == 0 { 1 } else { 4 };
        bench.write(0x1601, sub, &u32::to_le_bytes(word)[..width])
    });
    assert_eq!(rpdo, [Ok(()), NOT_MAPPABLE], "read only");
    let dummy = bench.write_u32(0x1601, 1, 0x0005_0108);
    assert_eq!(dummy, Err(0x0602_0000), "a dummy entry has sub-index 0");
}

#[test]
fn an_rpdo_writes_mapped_objects_and_skips_dummy_entries() {
    let mut bench = Bench::operational();
    bench.write(0x1601, 0, &[0]).expect("not valid");
    for (sub, word) in [
        (1, 0x2020_0008),
        (2, 0x0006_0010),
        (3, 0x2001_0010),
        (4, 0x0005_0008),
    ] {
        bench.write_u32(0x1601, sub, word).expect("mappable");
    }
    bench.write(0x1601, 0, &[4]).expect("six bytes");
    bench.write_u32(0x1401, 1, 0x305).expect("valid");
    bench.send(0x305, &[1, 9, 9, 0xFD, 0xFF, 9]);
    assert_eq!(bench.device.number(0x2020, 0), 1);
    assert_eq!(bench.device.number(0x2001, 0) as i64, -3);
    assert_eq!(bench.device.number(0x2021, 0), 0);
}

#[test]
fn an_rpdo_write_obeys_limits_and_write_protection() {
    let mut bench = Bench::operational();
    bench.write(0x1601, 0, &[0]).expect("not valid");
    bench.write_u32(0x1601, 1, 0x2001_0010).expect("mappable");
    bench.write_u32(0x1601, 2, 0x2020_0008).expect("mappable");
    bench.write(0x1601, 0, &[2]).expect("three bytes");
    bench.write_u32(0x1401, 1, 0x305).expect("valid");
    // 8200h, in the register "communication", of RPDO 2, with the object.
    let refused = (0x85, vec![0x00, 0x82, 0x11, 2, 0x01, 0x20, 0, 0]);
    assert_eq!(bench.send(0x305, &[0xE9, 3, 7]), [refused]);
    assert_eq!(bench.device.number(0x2001, 0), 0, "1001 is above its limit");
    assert_eq!(
        bench.device.number(0x2020, 0),
        7,
        "the other objects are written"
    );
    assert!(bench.send(0x305, &[0xE9, 3, 7]).is_empty(), "once");
    let reset = (0x85, vec![0x00, 0, 0, 2, 0x01, 0x20, 0, 0]);
    assert_eq!(bench.send(0x305, &[1, 0, 7]), [reset]);
}

#[test]
fn pdos_support_29_bit_identifiers() {
    let mut bench = Bench::operational();
    bench.write_u32(0x1400, 1, 0x8000_0205).expect("off");
    bench.write_u32(0x1400, 1, 0x3234_5678).expect("29 bits");
    let frame = |id, extended| {
        canopen::CanFrame::raw(id, extended, false, 6, [15, 0, 1, 0, 0, 0, 0, 0]).expect("a frame")
    };
    bench.receive(&frame(0x678, false));
    assert_eq!(bench.device.number(0x6040, 0), 0);
    bench.receive(&frame(0x1234_5678, true));
    assert_eq!(bench.device.number(0x6040, 0), 15);
}

#[test]
fn a_short_rpdo_raises_an_error_until_a_valid_one_and_a_long_rpdo_is_truncated() {
    let mut bench = Bench::operational();
    assert_eq!(
        bench.send(0x205, &[15, 0]),
        [(0x85, vec![0x10, 0x82, 0x11, 1, 0, 0, 0, 0])]
    );
    assert!(bench.send(0x205, &[15, 0]).is_empty());
    assert_eq!(bench.device.number(0x6040, 0), 0, "no object is written");
    assert_eq!(
        bench.send(0x205, &[15, 0, 1, 0, 0, 0, 9, 9])[0].1[..3],
        [0, 0, 0]
    );
    assert_eq!(
        (
            bench.device.number(0x6040, 0),
            bench.device.number(0x607A, 0)
        ),
        (15, 1)
    );
}

#[test]
fn the_error_of_an_rpdo_names_its_number() {
    let mut bench = Bench::operational();
    bench.write_u32(0x1401, 1, 0x305).expect("valid");
    let emcy = (0x85, vec![0x10, 0x82, 0x11, 2, 0, 0, 0, 0]);
    assert_eq!(bench.send(0x305, &[1]), [emcy]);
}
