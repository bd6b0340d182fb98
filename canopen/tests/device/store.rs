use canopen::Reset;

use crate::bench::Bench;

const SAVE: u32 = u32::from_le_bytes(*b"save");
const LOAD: u32 = u32::from_le_bytes(*b"load");

#[test]
fn stored_parameters_are_loaded_after_a_reset() {
    let mut bench = Bench::new();
    bench.write_u16(0x1017, 0, 250).expect("any period");
    bench.write(0x2000, 0, &[2]).expect("in range");
    bench.save(1);
    bench.write_u16(0x1017, 0, 20).expect("any period");
    bench.write(0x2000, 0, &[1]).expect("in range");
    bench.send(0, &[129, 5]);
    assert_eq!(bench.device.resets.last(), Some(&Reset::Node));
    assert_eq!(
        (bench.read(0x1017, 0), bench.read(0x2000, 0)),
        (Ok(250), Ok(2))
    );
}

#[test]
fn parameter_groups_are_stored_separately() {
    let mut bench = Bench::new();
    bench.write_u16(0x1017, 0, 250).expect("any period");
    bench.write(0x2000, 0, &[2]).expect("in range");
    bench.save(3);
    bench.send(0, &[129, 5]);
    assert_eq!(
        (bench.read(0x1017, 0), bench.read(0x2000, 0)),
        (Ok(0), Ok(2))
    );
    bench.write_u16(0x1017, 0, 250).expect("any period");
    bench.write(0x2000, 0, &[1]).expect("in range");
    bench.save(2);
    bench.send(0, &[129, 5]);
    assert_eq!(
        (bench.read(0x1017, 0), bench.read(0x2000, 0)),
        (Ok(250), Ok(2))
    );
}

#[test]
fn restored_defaults_take_effect_at_the_next_reset() {
    let mut bench = Bench::new();
    bench.write_u16(0x1017, 0, 250).expect("any period");
    bench.save(1);
    bench.write_u32(0x1011, 1, LOAD).expect("the signature");
    assert_eq!(bench.read(0x1017, 0), Ok(250));
    bench.send(0, &[130, 5]);
    assert_eq!(bench.read(0x1017, 0), Ok(0));
}

#[test]
fn a_wrong_signature_is_refused() {
    let mut bench = Bench::new();
    assert_eq!(bench.read(0x1010, 1), Ok(1));
    assert_eq!(bench.write_u32(0x1010, 1, LOAD), Err(0x0800_0020));
    assert_eq!(bench.write_u32(0x1011, 1, SAVE), Err(0x0800_0020));
    assert_eq!(bench.write_u16(0x1010, 1, 7), Err(0x0607_0013));
    assert_eq!(bench.write(0x1010, 0, &[7]), Err(0x0601_0002));
}

#[test]
fn a_complete_pdo_configuration_is_restored() {
    let mut bench = Bench::new();
    for (index, sub, value) in [(0x1801, 1, 0xC000_0285), (0x1A01, 0, 0)] {
        let width = if sub == 0 { 1 } else { 4 };
        bench
            .write(index, sub, &u32::to_le_bytes(value)[..width])
            .expect("allowed");
    }
    bench.write_u32(0x1A01, 1, 0x2001_0010).expect("mappable");
    bench.write(0x1A01, 0, &[1]).expect("one object");
    bench.write_u16(0x1801, 5, 10).expect("10 ms");
    bench.write(0x1019, 0, &[10]).expect("no period");
    bench.write_u32(0x1006, 0, 1_000_000).expect("any");
    bench.write_u32(0x1801, 1, 0x4000_0285).expect("valid");
    bench.save(1);
    bench.send(0, &[130, 5]);
    assert_eq!(bench.read(0x1A01, 1), Ok(0x2001_0010));
    assert_eq!(
        (bench.read(0x1019, 0), bench.read(0x1006, 0)),
        (Ok(10), Ok(1_000_000))
    );
    bench.start();
    let times: Vec<_> = bench
        .run_ms(20)
        .into_iter()
        .filter(|(_, (id, _))| *id == 0x285)
        .collect();
    assert_eq!(times.len(), 2);
}

#[test]
fn invalid_stored_parameters_disable_only_the_affected_pdo() {
    let mut bench = Bench::new();
    bench.save(1);
    for (address, value) in &mut bench.device.stored {
        *value = match (address.index, address.sub) {
            (0x1A00, 0) => 255,
            (0x1600, 1) => 0x1234_5678,
            (0x1005, 0) => 0x701,
            (0x1016, 1) => u32::MAX,
            _ => *value,
        };
    }
    bench.send(0, &[130, 5]);
    assert_eq!(bench.read(0x1800, 1), Ok(0xC000_0185));
    assert_eq!(bench.read(0x1A00, 0), Ok(0));
    assert_eq!(bench.read(0x1400, 1), Ok(0x8000_0205));
    bench.start();
    bench.run_ms(100);
}

#[test]
fn a_change_of_the_configuration_clears_1020h() {
    let mut bench = Bench::new();
    let date = |bench: &mut Bench| (bench.read(0x1020, 1), bench.read(0x1020, 2));
    let set = |bench: &mut Bench| {
        bench.write_u32(0x1020, 1, 7).expect("any");
        bench.write_u32(0x1020, 2, 8).expect("any");
        assert_eq!(date(bench), (Ok(7), Ok(8)));
    };
    set(&mut bench);
    bench.write_u16(0x2001, 0, 5).expect("process data");
    assert_eq!(date(&mut bench), (Ok(7), Ok(8)));
    bench.save(1);
    bench.send(0, &[130, 5]);
    assert_eq!(date(&mut bench), (Ok(7), Ok(8)));
    bench.write(0x2000, 0, &[1]).expect("in range");
    assert_eq!(date(&mut bench), (Ok(0), Ok(0)));
    set(&mut bench);
    bench.write_u16(0x1017, 0, 100).expect("any");
    assert_eq!(date(&mut bench), (Ok(0), Ok(0)));
}
