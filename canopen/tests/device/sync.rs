//! SYNC, synchronous PDOs and TIME.

use canopen::{Event, TimeOfDay};

use crate::bench::Bench;

/// A bench with TPDO 1 of a transmission type, SYNC counter overflow and SYNC start value.
fn bench(transmission: u8, overflow: u8, start: u8) -> Bench {
    let mut bench = Bench::new();
    bench.write_u32(0x1800, 1, 0x8000_0185).expect("off");
    bench.write(0x1800, 2, &[transmission]).expect("a type");
    bench.write(0x1800, 6, &[start]).expect("off");
    bench.write(0x1019, 0, &[overflow]).expect("no period");
    bench.write_u32(0x1800, 1, 0x185).expect("on");
    bench.start();
    bench
}

/// Numbers of the SYNCs 1, 2, ... to which TPDO 1 responds.
fn answered(bench: &mut Bench, count: u8, overflow: u8) -> Vec<u8> {
    (1..=count)
        .filter(|at| {
            let counter = [if overflow == 0 {
                0
            } else {
                (at - 1) % overflow + 1
            }];
            let data: &[u8] = if overflow == 0 { &[] } else { &counter };
            bench.send(0x80, data).iter().any(|(id, _)| *id == 0x185)
        })
        .collect()
}

#[test]
fn cyclic_tpdos_are_transmitted_with_every_nth_sync() {
    assert_eq!(answered(&mut bench(1, 0, 0), 4, 0), [1, 2, 3, 4]);
    assert_eq!(answered(&mut bench(3, 0, 0), 9, 0), [3, 6, 9]);
    assert_eq!(answered(&mut bench(240, 0, 0), 240, 0), [240]);
}

#[test]
fn counting_starts_at_the_sync_start_value() {
    assert_eq!(answered(&mut bench(1, 10, 4), 6, 10), [4, 5, 6]);
    assert_eq!(answered(&mut bench(3, 10, 4), 12, 10), [4, 7, 10]);
    assert_eq!(
        answered(&mut bench(2, 0, 4), 4, 0),
        [2, 4],
        "without a counter the start value is ignored"
    );
}

#[test]
fn an_acyclic_tpdo_is_transmitted_with_the_sync_after_an_event() {
    let mut bench = bench(0, 0, 0);
    assert!(answered(&mut bench, 3, 0).is_empty());
    bench.node.request_tpdo(1);
    assert!(bench.run_ms(10).is_empty());
    assert_eq!(answered(&mut bench, 3, 0), [1]);
}

#[test]
fn type_252_samples_with_sync_and_transmits_on_remote_request() {
    let mut bench = bench(252, 0, 0);
    bench.device.set(0x6041, 1);
    assert!(bench.send(0x80, &[]).is_empty());
    bench.device.set(0x6041, 2);
    assert_eq!(bench.remote(0x185, 6)[0].1[0], 1);
}

#[test]
fn a_remote_request_before_the_first_sync_samples_immediately() {
    let mut bench = bench(252, 0, 0);
    bench.device.set(0x6041, 3);
    assert_eq!(bench.remote(0x185, 6)[0].1[0], 3);
    // The same after another start: no state remains of the previous one.
    bench.send(0x80, &[]);
    bench.send(0, &[128, 5]);
    bench.device.set(0x6041, 4);
    bench.start();
    assert_eq!(bench.remote(0x185, 6)[0].1[0], 4);
}

#[test]
fn a_synchronous_rpdo_is_applied_with_sync_and_the_last_frame_wins() {
    let mut bench = Bench::new();
    bench.write(0x1400, 2, &[1]).expect("a type");
    bench.start();
    bench.send(0x205, &[6, 0, 0, 0, 0, 0]);
    bench.send(0x205, &[7, 0, 0, 0, 0, 0]);
    assert_eq!(bench.device.number(0x6040, 0), 0);
    bench.send(0x80, &[]);
    assert_eq!(bench.device.number(0x6040, 0), 7);
    bench.device.set(0x6040, 0);
    bench.send(0x80, &[]);
    assert_eq!(bench.device.number(0x6040, 0), 0, "applied once");
}

#[test]
fn rpdos_are_applied_before_tpdos_are_sampled() {
    let mut bench = bench(1, 0, 0);
    bench.write(0x1400, 2, &[0]).expect("a type");
    bench.write_u32(0x1800, 1, 0x8000_0185).expect("off");
    bench.write(0x1A00, 0, &[0]).expect("off");
    bench.write_u32(0x1A00, 1, 0x6040_0010).expect("mappable");
    bench.write(0x1A00, 0, &[1]).expect("one object");
    bench.write_u32(0x1800, 1, 0x185).expect("on");
    bench.send(0x205, &[9, 0, 0, 0, 0, 0]);
    assert_eq!(bench.send(0x80, &[]), [(0x185, vec![9, 0])]);
}

#[test]
fn a_sync_length_error_is_cleared_by_a_valid_sync() {
    let mut bench = bench(1, 10, 0);
    let sent = bench.send(0x80, &[]);
    assert_eq!(sent[0], (0x85, vec![0x40, 0x82, 0x11, 0, 0, 0, 0, 0]));
    assert_eq!(bench.send(0x80, &[1])[0].1[..3], [0, 0, 0]);
}

#[test]
fn the_sync_producer_counts_to_its_overflow_value() {
    let mut bench = Bench::new();
    bench.write(0x1019, 0, &[3]).expect("no period");
    bench.write_u32(0x1006, 0, 10_000).expect("any");
    assert!(bench.run_ms(50).is_empty(), "SYNC is not produced yet");
    bench
        .write_u32(0x1005, 0, 0x4000_0080)
        .expect("same identifier");
    let sent = bench.run_ms(40);
    let expected =
        [(10, 1), (20, 2), (30, 3), (40, 1)].map(|(at, count)| (at, (0x80, vec![count])));
    assert_eq!(sent, expected);
    assert!(
        bench.device.events.contains(&Event::Sync(Some(3))),
        "the node receives its own SYNC"
    );
}

#[test]
fn sync_parameters_are_write_protected_while_sync_is_produced() {
    let mut bench = Bench::new();
    bench.write_u32(0x1006, 0, 10_000).expect("any");
    assert_eq!(bench.write(0x1019, 0, &[10]), Err(0x0800_0022));
    bench.write_u32(0x1006, 0, 0).expect("off");
    assert_eq!(bench.write(0x1019, 0, &[240]), Ok(()));
    for bad in [1, 241, 255] {
        assert_eq!(bench.write(0x1019, 0, &[bad]), Err(0x0609_0030));
    }
    bench.write_u32(0x1005, 0, 0x4000_0080).expect("produces");
    assert_eq!(bench.write_u32(0x1005, 0, 0x4000_0081), Err(0x0609_0030));
    assert_eq!(bench.write_u32(0x1005, 0, 0x81), Ok(()));
    assert_eq!(bench.write_u32(0x1005, 0, 0x701), Err(0x0609_0030));
}

#[test]
fn a_sync_period_above_35_minutes_is_refused() {
    const LONGEST_US: u32 = i32::MAX as u32;
    let mut bench = Bench::new();
    assert_eq!(bench.write_u32(0x1006, 0, LONGEST_US + 1), Err(0x0609_0031));
    bench.write_u32(0x1005, 0, 0x4000_0080).expect("produces");
    bench.write_u32(0x1006, 0, LONGEST_US).expect("the longest");
    for _ in 0..2 {
        assert!(bench.wait_us(u64::from(LONGEST_US) - 1).is_empty());
        assert_eq!(bench.wait_us(1), [(0x80, vec![])]);
    }
}

#[test]
fn a_synchronous_tpdo_outside_the_window_is_discarded() {
    let mut bench = bench(1, 0, 0);
    bench.write_u32(0x1007, 0, 500).expect("any");
    bench.node.receive(
        &crate::bench::data_frame(0x80, &[]),
        bench.now_us,
        &mut bench.device,
    );
    assert!(bench.wait_us(501).is_empty());
    assert_eq!(bench.send(0x80, &[]).len(), 1);
    bench.node.receive(
        &crate::bench::data_frame(0x80, &[]),
        bench.now_us,
        &mut bench.device,
    );
    assert_eq!(bench.wait_us(500).len(), 1, "at its end it is inside");
}

#[test]
fn the_application_receives_the_time_of_day() {
    let mut bench = Bench::new();
    bench.send(0x100, &[0x01, 0x02, 0x03, 0xF4, 0x10, 0x27]);
    let time = TimeOfDay {
        milliseconds: 0x0403_0201,
        days: 10_000,
    };
    assert_eq!(bench.device.events.last(), Some(&Event::Time(time)));
    let heard = bench.device.events.len();
    bench.send(0x100, &[1, 2, 3, 4, 5]);
    bench.write_u32(0x1012, 0, 0x100).expect("off");
    bench.send(0x100, &[1, 2, 3, 4, 5, 6]);
    assert_eq!(bench.device.events.len(), heard);
    assert_eq!(
        bench.write_u32(0x1012, 0, 0x4000_0100),
        Err(0x0609_0030),
        "no producer"
    );
}

/// A bench whose RPDO 1 waits for a SYNC with a frame.
fn waiting() -> Bench {
    let mut bench = Bench::new();
    bench.write(0x1400, 2, &[1]).expect("a type");
    bench.start();
    bench.send(0x205, &[6, 0, 0, 0, 0, 0]);
    assert_eq!(bench.device.number(0x6040, 0), 0);
    bench
}

#[test]
fn data_that_wait_for_a_sync_are_discarded_when_the_pdo_restarts() {
    type Restart = fn(&mut Bench);
    let restarts: [Restart; 2] = [
        |bench| bench.write(0x1400, 2, &[1]).expect("a type"),
        |bench| {
            bench.send(0, &[128, 5]);
            bench.start();
        },
    ];
    for restart in restarts {
        let mut bench = waiting();
        restart(&mut bench);
        bench.send(0x80, &[]);
        assert_eq!(bench.device.number(0x6040, 0), 0);
    }
    let mut bench = waiting();
    bench.write_u32(0x1400, 1, 0x205).expect("as before");
    bench.send(0x80, &[]);
    assert_eq!(bench.device.number(0x6040, 0), 6, "no restart");
}

#[test]
fn an_event_driven_tpdo_is_not_transmitted_by_sync() {
    let mut bench = bench(254, 0, 0);
    bench.run_ms(1);
    assert!(answered(&mut bench, 255, 0).is_empty());
}

#[test]
fn the_counter_of_sync_restarts_when_the_node_leaves_stopped_and_then_only() {
    let mut bench = Bench::operational();
    bench.write(0x1019, 0, &[10]).expect("no period");
    bench.write_u32(0x1006, 0, 10_000).expect("any");
    bench.write_u32(0x1005, 0, 0x4000_0080).expect("produces");
    let mut next = |commands: &[u8]| {
        for command in commands {
            bench.send(0, &[*command, 5]);
        }
        let sent = bench.run_ms(10);
        let syncs: Vec<_> = sent.iter().filter(|(_, (id, _))| *id == 0x80).collect();
        assert_eq!(syncs.len(), 1, "{sent:x?}");
        syncs[0].1.1[0]
    };
    assert_eq!(
        [next(&[]), next(&[]), next(&[128]), next(&[1])],
        [1, 2, 3, 4]
    );
    assert_eq!([next(&[2, 1]), next(&[]), next(&[2, 128])], [1, 2, 1]);
}
