use canopen::{BitRate, Event, NmtState, NodeId};

use crate::bench::Bench;

const IDENTITY: [u32; 4] = [0x1234, 0x5341, 0x0001_0000, 0xCAFE_F00D];

fn lss(bench: &mut Bench, data: [u8; 8]) -> Option<[u8; 8]> {
    let mut sent = bench.send(0x7E5, &data);
    sent.retain(|(id, _)| *id == 0x7E4);
    sent.pop()
        .map(|(_, data)| data.try_into().expect("eight bytes"))
}

fn with_number(command: u8, number: u32) -> [u8; 8] {
    let [a, b, c, d] = number.to_le_bytes();
    [command, a, b, c, d, 0, 0, 0]
}

fn configuring(node_id: Option<u8>) -> Bench {
    let mut bench = Bench::powered_on(node_id);
    bench.drain();
    assert_eq!(lss(&mut bench, [4, 1, 0, 0, 0, 0, 0, 0]), None);
    bench
}

#[test]
fn a_node_without_a_node_id_responds_to_lss_only() {
    let mut bench = Bench::powered_on(None);
    assert!(bench.drain().is_empty());
    assert!(bench.send(0, &[1, 0]).is_empty());
    assert!(
        bench
            .send(0x605, &[0x40, 0, 0x10, 0, 0, 0, 0, 0])
            .is_empty()
    );
    assert_eq!(
        lss(&mut bench, [0x4C, 0, 0, 0, 0, 0, 0, 0]),
        Some([0x50, 0, 0, 0, 0, 0, 0, 0])
    );
}

#[test]
fn a_node_boots_up_with_the_node_id_that_lss_assigns() {
    let mut bench = configuring(None);
    assert_eq!(
        lss(&mut bench, [0x5E, 0, 0, 0, 0, 0, 0, 0]).expect("an answer")[1],
        255
    );
    assert_eq!(
        lss(&mut bench, [0x11, 42, 0, 0, 0, 0, 0, 0]),
        Some([0x11, 0, 0, 0, 0, 0, 0, 0])
    );
    assert_eq!(
        bench.device.events.last(),
        Some(&Event::NodeId(NodeId::new(42)))
    );
    assert_eq!(
        bench.send(0x7E5, &[4, 0, 0, 0, 0, 0, 0, 0]),
        [(0x700 + 42, vec![0])]
    );
    assert_eq!(bench.node.state(), NmtState::PreOperational);
    let answer = bench.send(0x600 + 42, &[0x40, 0, 0x18, 1, 0, 0, 0, 0]);
    assert_eq!(
        answer,
        [(0x580 + 42, vec![0x43, 0, 0x18, 1, 0xAA, 1, 0, 0x40])]
    );
}

#[test]
fn a_new_node_id_takes_effect_with_reset_communication() {
    let mut bench = configuring(Some(5));
    lss(&mut bench, [0x11, 6, 0, 0, 0, 0, 0, 0]);
    assert!(lss(&mut bench, [4, 0, 0, 0, 0, 0, 0, 0]).is_none());
    assert!(bench.read(0x1000, 0).is_ok(), "still node 5");
    assert_eq!(bench.send(0, &[130, 5]), [(0x706, vec![0])]);
}

#[test]
fn a_node_id_out_of_range_is_refused() {
    let mut bench = configuring(None);
    for bad in [0, 128, 254] {
        assert_eq!(
            lss(&mut bench, [0x11, bad, 0, 0, 0, 0, 0, 0]),
            Some([0x11, 1, 0, 0, 0, 0, 0, 0])
        );
    }
    assert_eq!(
        lss(&mut bench, [0x11, 255, 0, 0, 0, 0, 0, 0]),
        Some([0x11, 0, 0, 0, 0, 0, 0, 0])
    );
}

#[test]
fn lss_configuration_requires_the_configuration_state() {
    let mut bench = Bench::powered_on(None);
    for command in [0x11, 0x13, 0x15, 0x17, 0x5A, 0x5B, 0x5C, 0x5D, 0x5E] {
        assert_eq!(
            lss(&mut bench, [command, 1, 0, 0, 0, 0, 0, 0]),
            None,
            "{command:#X}"
        );
    }
}

#[test]
fn switch_state_selective_and_inquire_services_use_the_identity() {
    let mut bench = Bench::new();
    for (command, number) in (0x40..0x43).zip(IDENTITY) {
        assert_eq!(lss(&mut bench, with_number(command, number)), None);
    }
    let wrong = lss(&mut bench, with_number(0x43, IDENTITY[3] + 1));
    assert_eq!(wrong, None);
    let answers: Vec<_> = (0x40..0x44)
        .zip(IDENTITY)
        .map(|(command, number)| lss(&mut bench, with_number(command, number)))
        .collect();
    assert_eq!(answers[3], Some([0x44, 0, 0, 0, 0, 0, 0, 0]));
    for (command, number) in (0x5A..0x5E).zip(IDENTITY) {
        assert_eq!(
            lss(&mut bench, with_number(command, 0)),
            Some(with_number(command, number))
        );
    }
    assert_eq!(
        lss(&mut bench, [0x5E, 0, 0, 0, 0, 0, 0, 0]),
        Some([0x5E, 5, 0, 0, 0, 0, 0, 0])
    );
}

#[test]
fn identify_remote_slave_matches_ranges() {
    let mut bench = Bench::new();
    let numbers = [
        IDENTITY[0],
        IDENTITY[1],
        0,
        0x0002_0000,
        IDENTITY[3],
        u32::MAX,
    ];
    let answers: Vec<_> = (0x46..0x4C)
        .zip(numbers)
        .map(|(command, number)| lss(&mut bench, with_number(command, number)))
        .collect();
    assert_eq!(answers[..5], [None; 5]);
    assert_eq!(answers[5], Some([0x4F, 0, 0, 0, 0, 0, 0, 0]));
}

fn fast_scan(bench: &mut Bench, number: u32, bit: u8, sub: u8, next: u8) -> bool {
    let [a, b, c, d] = number.to_le_bytes();
    let answer = lss(bench, [0x51, a, b, c, d, bit, sub, next]);
    assert!(answer.is_none_or(|answer| answer == [0x4F, 0, 0, 0, 0, 0, 0, 0]));
    answer.is_some()
}

#[test]
fn fast_scan_selects_a_node_without_a_node_id() {
    let mut bench = Bench::powered_on(None);
    assert!(fast_scan(&mut bench, 0, 0x80, 0, 0));
    for (sub, expected) in (0..4).zip(IDENTITY) {
        let mut number = 0;
        for bit in (0..32).rev() {
            if !fast_scan(&mut bench, number, bit, sub, sub) {
                number |= 1 << bit;
            }
        }
        assert_eq!(number, expected);
        assert!(fast_scan(&mut bench, number, 0, sub, (sub + 1) % 4));
    }
    assert_eq!(
        lss(&mut bench, [0x11, 7, 0, 0, 0, 0, 0, 0]),
        Some([0x11, 0, 0, 0, 0, 0, 0, 0])
    );
}

#[test]
fn fast_scan_selects_every_node_of_one_identity() {
    let mut benches = [0; 3].map(|_| Bench::powered_on(None));
    let mut scan = |number, bit, sub, next| {
        let answers = benches
            .each_mut()
            .map(|bench| fast_scan(bench, number, bit, sub, next));
        assert!(answers == [answers[0]; 3], "on the bus they are one answer");
        answers[0]
    };
    assert!(scan(0, 0x80, 0, 0));
    for (sub, number) in (0..4).zip(IDENTITY) {
        assert!(
            (0..32)
                .rev()
                .all(|bit| scan(number >> bit << bit, bit, sub, sub))
        );
        assert!(scan(number, 0, sub, (sub + 1) % 4));
    }
    for bench in &mut benches {
        // Inquire node-ID: each is being configured, and none takes part in another scan.
        assert!(lss(bench, [0x5E, 0, 0, 0, 0, 0, 0, 0]).is_some());
        assert!(!fast_scan(bench, 0, 0x80, 0, 0));
    }
}

#[test]
fn fast_scan_is_ignored_by_a_node_with_a_node_id() {
    let mut bench = Bench::new();
    assert!(!fast_scan(&mut bench, 0, 0x80, 0, 0));
    assert_eq!(lss(&mut bench, [0x4C, 0, 0, 0, 0, 0, 0, 0]), None);
}

#[test]
fn the_bit_rate_switches_between_two_switch_delays() {
    let mut bench = configuring(Some(5));
    assert_eq!(
        lss(&mut bench, [0x13, 0, 9, 0, 0, 0, 0, 0]),
        Some([0x13, 1, 0, 0, 0, 0, 0, 0])
    );
    assert_eq!(
        lss(&mut bench, [0x13, 0, 5, 0, 0, 0, 0, 0]),
        Some([0x13, 1, 0, 0, 0, 0, 0, 0])
    );
    assert_eq!(
        lss(&mut bench, [0x13, 1, 2, 0, 0, 0, 0, 0]),
        Some([0x13, 1, 0, 0, 0, 0, 0, 0])
    );
    assert_eq!(
        lss(&mut bench, [0x13, 0, 2, 0, 0, 0, 0, 0]),
        Some([0x13, 0, 0, 0, 0, 0, 0, 0])
    );
    bench
        .write_u16(0x1017, 0, 1)
        .expect("a heartbeat that shows silence");
    assert_eq!(lss(&mut bench, [0x15, 10, 0, 0, 0, 0, 0, 0]), None);
    assert!(bench.run_ms(9).is_empty());
    assert!(bench.device.bit_rates.is_empty());
    assert!(bench.run_ms(10).is_empty());
    assert_eq!(bench.device.bit_rates, [BitRate::Kbit500]);
    assert!(!bench.run_ms(2).is_empty());
}

#[test]
fn store_configuration_waits_for_the_application() {
    let mut bench = configuring(Some(5));
    lss(&mut bench, [0x11, 9, 0, 0, 0, 0, 0, 0]);
    lss(&mut bench, [0x13, 0, 4, 0, 0, 0, 0, 0]);
    assert_eq!(lss(&mut bench, [0x17, 0, 0, 0, 0, 0, 0, 0]), None);
    let sent = bench.run_ms(10);
    assert_eq!(sent.len(), 1);
    assert_eq!(sent[0].1, (0x7E4, vec![0x17, 0, 0, 0, 0, 0, 0, 0]));
    assert_eq!(
        bench.device.stored_lss,
        Some((NodeId::new(9), Some(BitRate::Kbit125)))
    );
}

#[test]
fn an_enabled_drive_keeps_its_node_id_and_bit_rate() {
    let mut bench = configuring(Some(5));
    bench.device.enabled = true;
    for command in [0x11, 0x13] {
        assert_eq!(
            lss(&mut bench, [command, 0, 2, 0, 0, 0, 0, 0]),
            Some([command, 255, 0, 0, 0, 0, 0, 0])
        );
    }
    bench.device.enabled = false;
    assert_eq!(
        lss(&mut bench, [0x13, 0, 2, 0, 0, 0, 0, 0]),
        Some([0x13, 0, 0, 0, 0, 0, 0, 0])
    );
    // A node without a node-ID has no SDO server by which it could be unlocked.
    let mut bench = configuring(None);
    bench.device.enabled = true;
    assert_eq!(
        lss(&mut bench, [0x11, 7, 0, 0, 0, 0, 0, 0]),
        Some([0x11, 0, 0, 0, 0, 0, 0, 0])
    );
}

#[test]
fn lss_works_in_stopped() {
    let mut bench = Bench::new();
    bench.send(0, &[2, 5]);
    lss(&mut bench, [4, 1, 0, 0, 0, 0, 0, 0]);
    assert!(lss(&mut bench, [0x5E, 0, 0, 0, 0, 0, 0, 0]).is_some());
}

#[test]
fn a_node_that_is_being_configured_or_has_a_new_node_id_is_not_found() {
    let mut bench = configuring(None);
    assert!(!fast_scan(&mut bench, 0, 0x80, 0, 0), "being configured");
    lss(&mut bench, [0x11, 42, 0, 0, 0, 0, 0, 0]);
    assert_eq!(lss(&mut bench, [0x4C, 0, 0, 0, 0, 0, 0, 0]), None);
}

#[test]
fn only_the_way_back_to_the_waiting_state_boots_up_and_ends_the_configuration() {
    let mut bench = configuring(None);
    lss(&mut bench, [0x11, 42, 0, 0, 0, 0, 0, 0]);
    assert!(bench.send(0x7E5, &[4, 1, 0, 0, 0, 0, 0, 0]).is_empty());
    assert_eq!(bench.node.state(), NmtState::Initialising);
    let mut bench = configuring(Some(5));
    lss(&mut bench, [4, 0, 0, 0, 0, 0, 0, 0]);
    assert_eq!(lss(&mut bench, [0x5E, 0, 0, 0, 0, 0, 0, 0]), None);
}
