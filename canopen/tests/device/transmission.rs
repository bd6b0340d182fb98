//! Transmission and application of PDOs other than by SYNC.

use canopen::Event;
use canopen::dictionary::Address;

use crate::bench::Bench;

/// A bench with a valid TPDO 2 that maps 2020h.
fn bench(transmission: u8, inhibit_100us: u16, event_ms: u16) -> Bench {
    let mut bench = Bench::new();
    bench.write(0x1A01, 0, &[0]).expect("not valid");
    bench.write_u32(0x1A01, 1, 0x2020_0008).expect("mappable");
    bench.write(0x1A01, 0, &[1]).expect("one object");
    bench.write(0x1801, 2, &[transmission]).expect("a type");
    bench
        .write_u16(0x1801, 3, inhibit_100us)
        .expect("not valid");
    bench.write_u16(0x1801, 5, event_ms).expect("any");
    bench
        .write_u32(0x1801, 1, 0x285)
        .expect("remote frames allowed");
    bench.start();
    bench
}

fn times(bench: &mut Bench, time_ms: u64) -> Vec<u64> {
    bench
        .run_ms(time_ms)
        .into_iter()
        .filter(|(_, (id, _))| *id == 0x285)
        .map(|(at, _)| at)
        .collect()
}

#[test]
fn an_event_driven_tpdo_is_transmitted_at_start_and_on_each_change() {
    let mut bench = Bench::new();
    bench.send(0, &[1, 5]);
    assert_eq!(bench.wait_us(1000), [(0x185, vec![0; 6])]);
    assert!(bench.run_ms(100).is_empty());
    bench.device.set(0x6041, 0x0237);
    bench.node.object_changed(Address::new(0x6041, 0));
    assert_eq!(bench.wait_us(1000), [(0x185, vec![0x37, 2, 0, 0, 0, 0])]);
    bench.node.object_changed(Address::new(0x6040, 0));
    assert!(bench.run_ms(10).is_empty(), "not mapped");
    bench.node.request_tpdo(1);
    assert_eq!(bench.run_ms(10).len(), 1);
}

#[test]
fn a_negative_number_does_not_reach_the_object_behind_it() {
    let mut bench = Bench::new();
    bench.write(0x1A01, 0, &[0]).expect("not valid");
    bench.write_u32(0x1A01, 1, 0x6061_0008).expect("mappable");
    bench.write_u32(0x1A01, 2, 0x6041_0010).expect("mappable");
    bench.write(0x1A01, 0, &[2]).expect("two objects");
    bench.write_u32(0x1801, 1, 0x285).expect("valid");
    bench.device.set(0x6061, -1);
    bench.device.set(0x6041, 0x0237);
    bench.send(0, &[1, 5]);
    let frames = bench.run_ms(10).into_iter().map(|(_, frame)| frame);
    let own: Vec<_> = frames.filter(|(id, _)| *id == 0x285).collect();
    assert_eq!(own.first(), Some(&(0x285, vec![0xFF, 0x37, 2])));
}

#[test]
fn pdos_are_active_in_operational_only() {
    let mut bench = bench(254, 0, 5);
    assert_eq!(times(&mut bench, 10).len(), 2);
    for command in [128, 2] {
        bench.send(0, &[command, 5]);
        assert!(times(&mut bench, 20).is_empty());
        bench.send(0x205, &[15, 0, 0, 0, 0, 0]);
        assert_eq!(bench.device.number(0x6040, 0), 0);
    }
}

#[test]
fn the_event_timer_does_not_drift() {
    assert_eq!(times(&mut bench(254, 0, 4), 12), [4, 8, 12]);
    assert_eq!(times(&mut bench(255, 0, 7), 21), [7, 14, 21]);
    assert!(times(&mut bench(254, 0, 0), 100).is_empty());
}

#[test]
fn an_event_restarts_the_event_timer() {
    let mut bench = bench(254, 0, 10);
    times(&mut bench, 6);
    bench.node.request_tpdo(2);
    assert_eq!(times(&mut bench, 12), [1, 11]);
}

#[test]
fn the_inhibit_time_separates_two_transmissions() {
    let mut bench = bench(254, 50, 0);
    times(&mut bench, 20);
    bench.node.request_tpdo(2);
    assert_eq!(times(&mut bench, 1), [1]);
    bench.node.request_tpdo(2);
    bench.node.request_tpdo(2);
    assert_eq!(
        times(&mut bench, 20),
        [5],
        "5 ms after the last, and once for both requests"
    );
}

#[test]
fn the_inhibit_time_delays_the_event_timer() {
    assert_eq!(times(&mut bench(254, 100, 4), 40).len(), 4);
}

#[test]
fn the_event_timer_may_change_while_the_pdo_is_valid() {
    let mut bench = bench(254, 0, 100);
    bench.write_u16(0x1801, 5, 3).expect("allowed");
    assert_eq!(times(&mut bench, 6), [3, 6]);
}

#[test]
fn remote_frames_are_answered_where_bit_30_allows_it() {
    for transmission in [253, 254, 255] {
        let mut bench = bench(transmission, 0, 0);
        bench.device.set(0x2020, 7);
        assert_eq!(bench.remote(0x285, 1), [(0x285, vec![7])], "{transmission}");
        assert!(bench.remote(0x185, 6).is_empty(), "bit 30 of TPDO 1 is set");
    }
    let mut bench = bench(253, 0, 5);
    assert!(
        times(&mut bench, 20).is_empty(),
        "type 253 is transmitted on remote request only"
    );
}

#[test]
fn an_event_driven_rpdo_is_applied_immediately_and_reported() {
    let mut bench = Bench::operational();
    bench.send(0x205, &[15, 0, 0x10, 0x27, 0, 0]);
    assert_eq!(bench.device.number(0x607A, 0), 10_000);
    assert_eq!(bench.device.events.last(), Some(&Event::Rpdo(1)));
}

#[test]
fn an_rpdo_timeout_is_raised_and_cleared_by_reception() {
    let mut bench = Bench::operational();
    bench.write_u16(0x1400, 5, 20).expect("any");
    assert!(
        bench.run_ms(100).is_empty(),
        "monitoring starts with the first frame"
    );
    bench.send(0x205, &[0; 6]);
    assert_eq!(
        bench.run_ms(20),
        [(20, (0x85, vec![0x50, 0x82, 0x11, 1, 0, 0, 0, 0]))]
    );
    assert!(bench.device.events.contains(&Event::RpdoTimeout(1)));
    assert!(bench.run_ms(100).is_empty(), "reported once");
    assert_eq!(bench.send(0x205, &[0; 6])[0].1[..3], [0, 0, 0]);
}

#[test]
fn frames_are_distinguished_and_discarded_process_data_is_sampled_again() {
    let mut bench = Bench::operational();
    bench.drain();
    let id = |raw| embedded_can::Id::from(embedded_can::StandardId::new(raw).expect("11 bits"));
    assert!(bench.node.is_process_data(id(0x185)));
    for other in [0x85, 0x585, 0x705, 0x205] {
        assert!(!bench.node.is_process_data(id(other)), "{other:x}");
    }
    assert!(bench.node.is_emergency(id(0x85)) && !bench.node.is_emergency(id(0x185)));
    assert!(bench.node.is_sync(id(0x80)) && !bench.node.is_sync(id(0x85)));
    bench.node.repeat_process_data();
    let sent = bench.run_ms(1);
    assert!(sent.iter().any(|(_, (id, _))| *id == 0x185), "{sent:x?}");
}

#[test]
fn another_event_timer_restarts_the_monitoring_of_an_rpdo_with_the_next_frame() {
    let mut bench = Bench::operational();
    bench.run_ms(1);
    bench.write_u16(0x1400, 5, 20).expect("any");
    bench.send(0x205, &[0; 6]);
    bench.write_u16(0x1400, 5, 30).expect("any");
    assert!(bench.run_ms(100).is_empty());
    bench.send(0x205, &[0; 6]);
    assert!(bench.run_ms(29).is_empty());
    assert_eq!(bench.run_ms(1).len(), 1);
}
