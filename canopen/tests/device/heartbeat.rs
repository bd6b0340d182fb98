use canopen::{BusEvent, Emergency, ErrorCode, Event, NmtState};

use crate::bench::{Bench, SentFrame};

fn heartbeats(sent: Vec<(u64, SentFrame)>) -> Vec<(u64, u8)> {
    sent.into_iter()
        .filter(|(_, (id, _))| *id == 0x705)
        .map(|(at, (_, data))| (at, data[0]))
        .collect()
}

#[test]
fn a_write_to_1017h_transmits_a_heartbeat_immediately() {
    let mut bench = Bench::new();
    let sent = bench.send(0x605, &[0x2B, 0x17, 0x10, 0, 100, 0, 0, 0]);
    assert!(sent.contains(&(0x705, vec![127])), "{sent:?}");
    assert_eq!(
        heartbeats(bench.run_ms(300)),
        [(100, 127), (200, 127), (300, 127)]
    );
}

#[test]
fn heartbeats_carry_the_nmt_state_and_end_with_a_period_of_zero() {
    let mut bench = Bench::new();
    bench.write_u16(0x1017, 0, 20).expect("any period");
    assert_eq!(
        bench.send(0, &[2, 5]),
        [(0x705, vec![4])],
        "a state change transmits a heartbeat immediately"
    );
    assert_eq!(heartbeats(bench.run_ms(20)), [(20, 4)], "also in STOPPED");
    bench.send(0, &[1, 5]);
    assert_eq!(heartbeats(bench.run_ms(20)), [(20, 5)]);
    bench.write_u16(0x1017, 0, 0).expect("any period");
    assert!(heartbeats(bench.run_ms(100)).is_empty());
}

#[test]
fn missed_heartbeats_are_not_caught_up_after_late_ticks() {
    let mut bench = Bench::new();
    bench.write_u16(0x1017, 0, 10).expect("any period");
    assert_eq!(bench.wait_us(1_000_000).len(), 1);
    assert_eq!(bench.wait_us(9_999).len(), 0);
    assert_eq!(bench.wait_us(1).len(), 1);
}

fn monitoring(error_behaviour: u8) -> Bench {
    let mut bench = Bench::operational();
    bench.write(0x1029, 1, &[error_behaviour]).expect("0 to 2");
    bench
        .write_u32(0x1016, 1, 9 << 16 | 50)
        .expect("node 9, 50 ms");
    bench.send(0x709, &[5]);
    bench
}

#[test]
fn a_lost_heartbeat_raises_an_error_and_changes_the_nmt_state_by_1029h() {
    for (behaviour, state) in [
        (0, NmtState::PreOperational),
        (1, NmtState::Operational),
        (2, NmtState::Stopped),
    ] {
        let mut bench = monitoring(behaviour);
        assert!(bench.run_ms(49).is_empty());
        bench.wait_us(1000);
        assert_eq!(bench.node.state(), state);
        assert!(bench.device.events.contains(&Event::HeartbeatLost(9)));
        bench.send(0, &[128, 5]);
        assert_eq!(bench.read(0x1001, 0), Ok(0x11));
        assert_eq!(bench.read(0x1003, 1), Ok(0x0009_8130));
    }
}

#[test]
fn the_emcy_of_a_lost_heartbeat_precedes_the_stop_that_it_causes_and_later_ones_wait() {
    let mut bench = monitoring(2);
    bench.write_u16(0x1017, 0, 500).expect("a heartbeat");
    bench.drain();
    let sent = bench.run_ms(60);
    let sent: Vec<_> = sent.into_iter().map(|(_, frame)| frame).collect();
    let emcy = (0x85, vec![0x30, 0x81, 0x11, 9, 0, 0, 0, 0]);
    assert_eq!(sent, [emcy, (0x705, vec![4])]);
    // An error in STOPPED is heard when the node leaves it.
    let late = Emergency::new(ErrorCode(0x5000), 0);
    bench.node.raise(late, &mut bench.device);
    assert!(bench.run_ms(20).is_empty());
    let sent = bench.send(0, &[128, 5]);
    assert!(
        sent.iter()
            .any(|(id, data)| *id == 0x85 && data[..2] == [0, 0x50])
    );
    assert_eq!(bench.read(0x1003, 1), Ok(0x5000));
}

#[test]
fn a_recovered_heartbeat_clears_the_error() {
    let mut bench = monitoring(1);
    let sent = bench.run_ms(50);
    assert_eq!(sent, [(50, (0x85, vec![0x30, 0x81, 0x11, 9, 0, 0, 0, 0]))]);
    assert_eq!(
        bench.send(0x709, &[127]),
        [(0x85, vec![0, 0, 0, 9, 0, 0, 0, 0])]
    );
    assert_eq!(bench.read(0x1001, 0), Ok(0));
    assert_eq!(bench.run_ms(50).len(), 1, "a second loss is reported");
}

#[test]
fn a_duplicate_consumer_is_refused_and_disabling_a_consumer_clears_its_error() {
    let mut bench = monitoring(1);
    assert_eq!(bench.write_u32(0x1016, 2, 9 << 16 | 70), Err(0x0604_0043));
    bench.run_ms(60);
    assert_eq!(bench.read(0x1001, 0), Ok(0x11));
    bench.write_u32(0x1016, 1, 0).expect("off");
    assert_eq!(bench.read(0x1001, 0), Ok(0));
    assert_eq!(bench.write(0x1029, 1, &[3]), Err(0x0609_0030));
}

#[test]
fn a_heartbeat_of_another_node_or_of_a_consumer_without_a_time_is_not_heard() {
    let mut bench = monitoring(1);
    bench.write_u32(0x1016, 2, 11 << 16).expect("no time");
    let heard = bench.device.events.len();
    assert!(bench.run_ms(40).is_empty());
    bench.send(0x70A, &[5]);
    bench.send(0x70B, &[5]);
    assert_eq!(bench.device.events.len(), heard);
    assert_eq!(bench.run_ms(10).len(), 1, "node 9 is lost at its time");
}

#[test]
fn a_boot_up_suspends_the_monitoring_and_keeps_the_error_until_the_next_heartbeat() {
    let mut bench = monitoring(1);
    bench.send(0x709, &[0]);
    assert!(bench.run_ms(100).is_empty(), "suspended");
    bench.send(0x709, &[5]);
    assert_eq!(bench.run_ms(50).len(), 1, "lost");
    assert!(bench.send(0x709, &[0]).is_empty(), "no heartbeat yet");
    let reset = (0x85, vec![0, 0, 0, 9, 0, 0, 0, 0]);
    assert_eq!(bench.send(0x709, &[127]), [reset]);
}

#[test]
fn all_emcys_before_a_stop_are_sent_and_none_in_it() {
    let mut bench = monitoring(2);
    let error = |code| Emergency::new(ErrorCode(code), 0);
    bench.node.raise(error(0x5000), &mut bench.device);
    bench.node.raise(error(0x5001), &mut bench.device);
    bench.now_us += 50_000;
    let sent = bench.wait_us(0);
    let codes: Vec<_> = sent.iter().map(|(_, data)| data[..2].to_vec()).collect();
    assert_eq!(codes, [[0, 0x50], [1, 0x50], [0x30, 0x81]]);
    // Another communication error, and the node is in STOPPED already.
    bench.node.raise(error(0x5002), &mut bench.device);
    bench.node.bus_event(BusEvent::BusOff, &mut bench.device);
    assert!(bench.run_ms(10).is_empty());
}

#[test]
fn a_communication_error_leaves_a_stopped_node_stopped() {
    let mut bench = monitoring(0);
    bench.send(0, &[2, 5]);
    bench.run_ms(50);
    assert!(bench.device.events.contains(&Event::HeartbeatLost(9)));
    assert_eq!(bench.node.state(), NmtState::Stopped);
}
