use canopen::{BusEvent, Emergency, ErrorCode, NmtState, register};

use crate::bench::Bench;

const FOLLOWING: ErrorCode = ErrorCode(0x8611);

fn error(code: u16) -> Emergency {
    Emergency {
        code: ErrorCode(code),
        register: register::PROFILE,
        instance: 3,
        information: [4, 5, 6, 7],
    }
}

#[test]
fn an_emcy_is_transmitted_when_an_error_is_raised_and_when_it_is_cleared() {
    let mut bench = Bench::new();
    bench.node.raise(error(0x8611), &mut bench.device);
    bench.node.raise(error(0x8611), &mut bench.device);
    assert_eq!(
        bench.drain(),
        [(0x85, vec![0x11, 0x86, 0x21, 3, 4, 5, 6, 7])]
    );
    assert_eq!(bench.node.error_register(), 0x21);
    bench.node.clear(FOLLOWING, 3);
    bench.node.clear(FOLLOWING, 3);
    assert_eq!(bench.drain(), [(0x85, vec![0, 0, 0, 3, 4, 5, 6, 7])]);
}

#[test]
fn the_error_register_keeps_the_bits_of_remaining_errors() {
    let mut bench = Bench::new();
    bench.node.raise(
        Emergency::new(ErrorCode(0x2310), register::CURRENT),
        &mut bench.device,
    );
    bench.node.raise(
        Emergency::new(ErrorCode(0x4310), register::TEMPERATURE),
        &mut bench.device,
    );
    assert_eq!(bench.read(0x1001, 0), Ok(0x0B));
    bench.drain();
    bench.node.clear(ErrorCode(0x2310), 0);
    assert_eq!(bench.drain(), [(0x85, vec![0, 0, 0x09, 0, 0, 0, 0, 0])]);
    assert_eq!(bench.read(0x1001, 0), Ok(0x09));
}

#[test]
fn the_history_lists_the_newest_error_first_and_is_cleared_only_by_zero() {
    let mut bench = Bench::new();
    assert_eq!(bench.read(0x1003, 0), Ok(0));
    assert_eq!(bench.read(0x1003, 1), Err(0x0800_0024));
    for code in 0x1000..0x100A {
        bench.node.raise(error(code), &mut bench.device);
    }
    assert_eq!(bench.read(0x1003, 0), Ok(8));
    assert_eq!(bench.read(0x1003, 1), Ok(0x0003_1009));
    assert_eq!(bench.read(0x1003, 8), Ok(0x0003_1002));
    assert_eq!(bench.write(0x1003, 0, &[1]), Err(0x0609_0030));
    assert_eq!(bench.write(0x1003, 0, &[0]), Ok(()));
    assert_eq!(bench.read(0x1003, 0), Ok(0));
    assert_eq!(bench.write_u32(0x1003, 1, 0), Err(0x0601_0002));
}

#[test]
fn the_inhibit_time_delays_emcy() {
    let mut bench = Bench::new();
    bench.write_u16(0x1015, 0, 100).expect("10 ms");
    for code in [0x1000, 0x1001, 0x1002] {
        bench.node.raise(error(code), &mut bench.device);
    }
    assert_eq!(bench.drain().len(), 1);
    let times: Vec<_> = bench.run_ms(30).into_iter().map(|(at, _)| at).collect();
    assert_eq!(times, [10, 20]);
}

#[test]
fn no_emcy_is_transmitted_while_1014h_is_not_valid_or_the_node_is_stopped() {
    let mut bench = Bench::new();
    bench.send(0, &[2, 5]);
    bench.node.raise(error(0x1000), &mut bench.device);
    assert!(bench.drain().is_empty());
    assert_eq!(
        bench.send(0, &[128, 5]).len(),
        1,
        "transmitted as soon as permitted"
    );
    bench.write_u32(0x1014, 0, 0x8000_0085).expect("off");
    bench.node.raise(error(0x1001), &mut bench.device);
    assert!(bench.drain().is_empty());
    assert_eq!(bench.read(0x1003, 1), Ok(0x0003_1001));
}

#[test]
fn the_emcy_cob_id_changes_only_while_emcy_is_not_valid() {
    let mut bench = Bench::new();
    assert_eq!(bench.read(0x1014, 0), Ok(0x85));
    assert_eq!(bench.write_u32(0x1014, 0, 0x86), Err(0x0609_0030));
    assert_eq!(bench.write_u32(0x1014, 0, 0x8000_0086), Ok(()));
    assert_eq!(
        bench.write_u32(0x1014, 0, 0x601),
        Err(0x0609_0030),
        "restricted CAN-ID"
    );
    assert_eq!(bench.write_u32(0x1014, 0, 0x86), Ok(()));
    bench.node.raise(error(0x1000), &mut bench.device);
    assert_eq!(bench.drain()[0].0, 0x86);
}

#[test]
fn controller_state_changes_raise_communication_errors() {
    let mut bench = Bench::operational();
    bench
        .node
        .bus_event(BusEvent::ErrorPassive, &mut bench.device);
    bench.node.bus_event(BusEvent::Overrun, &mut bench.device);
    let codes: Vec<_> = bench
        .drain()
        .iter()
        .map(|(_, data)| u16::from_le_bytes([data[0], data[1]]))
        .collect();
    assert_eq!(codes, [0x8120, 0x8110]);
    bench.node.bus_event(BusEvent::Recovered, &mut bench.device);
    assert_eq!(bench.node.error_register(), 0);
    bench.node.bus_event(BusEvent::BusOff, &mut bench.device);
    assert_eq!(bench.node.state(), NmtState::PreOperational, "by 1029h");
    bench.drain();
    bench
        .node
        .bus_event(BusEvent::BusOffRecovered, &mut bench.device);
    assert_eq!(bench.drain()[0].1[..3], [0x40, 0x81, 0x11]);
}

#[test]
fn more_errors_than_fit_are_limited_and_can_all_be_cleared() {
    let mut bench = Bench::new();
    for code in 0x1000..0x1010 {
        bench.node.raise(error(code), &mut bench.device);
    }
    assert_eq!(bench.drain().len(), 8);
    for code in 0x1000..0x1010 {
        bench.node.clear(ErrorCode(code), 3);
    }
    assert_eq!(bench.node.error_register(), 0);
}

#[test]
fn errors_with_the_same_bit_of_the_register_share_it() {
    let mut bench = Bench::new();
    for code in [0x1000, 0x1001] {
        bench.node.raise(error(code), &mut bench.device);
        assert_eq!(bench.node.error_register(), 0x21);
    }
    let mut bench = Bench::new();
    let generic = Emergency::new(ErrorCode(0x1000), register::GENERIC);
    bench.node.raise(generic, &mut bench.device);
    assert_eq!(bench.node.error_register(), 1);
}

#[test]
fn the_bits_of_the_register_are_those_of_cia_301() {
    use register::{COMMUNICATION, CURRENT, GENERIC, MANUFACTURER, PROFILE, TEMPERATURE, VOLTAGE};
    assert_eq!([GENERIC, CURRENT, VOLTAGE, TEMPERATURE], [1, 2, 4, 8]);
    assert_eq!([COMMUNICATION, PROFILE, MANUFACTURER], [0x10, 0x20, 0x80]);
}

#[test]
fn an_error_beyond_those_that_can_be_active_has_its_bit_in_its_emcy() {
    let mut bench = Bench::new();
    for code in 0x1000..0x1010 {
        bench.node.raise(error(code), &mut bench.device);
        bench.drain();
    }
    let more = Emergency::new(ErrorCode(0x2310), register::CURRENT);
    bench.node.raise(more, &mut bench.device);
    assert_eq!(bench.drain()[0].1[..3], [0x10, 0x23, 0x23]);
    assert_eq!(bench.node.error_register(), 0x21);
}
