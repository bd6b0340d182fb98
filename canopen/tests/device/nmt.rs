use canopen::{Event, NmtState, Reset};

use crate::bench::Bench;

#[test]
fn boot_up_is_one_zero_byte_and_enters_pre_operational() {
    let mut bench = Bench::powered_on(Some(5));
    assert_eq!(bench.node.state(), NmtState::Initialising);
    assert_eq!(bench.drain(), [(0x705, vec![0])]);
    assert_eq!(bench.node.state(), NmtState::PreOperational);
    assert!(bench.run_ms(100).is_empty(), "boot-up is sent once");
}

#[test]
fn nmt_commands_address_this_node_or_all_nodes() {
    let mut bench = Bench::new();
    for (command, node, state) in [
        (1, 5, NmtState::Operational),
        (2, 0, NmtState::Stopped),
        (128, 5, NmtState::PreOperational),
        (1, 6, NmtState::PreOperational),
        (3, 5, NmtState::PreOperational),
        (1, 0, NmtState::Operational),
    ] {
        bench.send(0, &[command, node]);
        assert_eq!(bench.node.state(), state);
    }
    bench.send(0, &[2]);
    bench.send(0, &[2, 6, 5, 0, 0, 0, 0, 0]);
    bench.remote(0, 2);
    assert_eq!(bench.node.state(), NmtState::Operational);
    bench.send(0, &[2, 5, 1, 6, 0, 0, 0, 0]);
    assert_eq!(bench.node.state(), NmtState::Stopped, "trailing bytes");
}

#[test]
fn both_resets_send_boot_up_and_only_reset_node_resets_the_application() {
    for (command, reset) in [(129, Reset::Node), (130, Reset::Communication)] {
        let mut bench = Bench::operational();
        bench.write(0x2000, 0, &[2]).expect("in range");
        bench.write_u16(0x1017, 0, 50).expect("any period");
        assert_eq!(bench.send(0, &[command, 0]), [(0x705, vec![0])]);
        assert_eq!(bench.node.state(), NmtState::PreOperational);
        assert_eq!(bench.device.resets.last(), Some(&reset));
        assert_eq!(bench.read(0x1017, 0), Ok(0));
        assert_eq!(
            bench.read(0x2000, 0),
            Ok(if reset == Reset::Node { 0 } else { 2 })
        );
    }
}

#[test]
fn sdo_is_inactive_in_stopped() {
    let mut bench = Bench::operational();
    assert!(bench.sdo([0x40, 0, 0x10, 0, 0, 0, 0, 0]).is_some());
    bench.send(0, &[2, 5]);
    assert_eq!(bench.sdo([0x40, 0, 0x10, 0, 0, 0, 0, 0]), None);
    bench.send(0, &[128, 5]);
    assert!(bench.sdo([0x40, 0, 0x10, 0, 0, 0, 0, 0]).is_some());
}

#[test]
fn stopped_ends_an_sdo_transfer() {
    let mut bench = Bench::new();
    bench.sdo([0x21, 0x10, 0x20, 0, 20, 0, 0, 0]);
    bench.send(0, &[2, 5]);
    assert_eq!(bench.device.cancelled, 1);
    bench.send(0, &[128, 5]);
    let answer = bench.sdo([0, 1, 2, 3, 4, 5, 6, 7]).expect("an answer");
    assert_eq!(answer, [0x80, 0, 0, 0, 1, 0, 4, 5]);
}

#[test]
fn node_guarding_is_not_supported() {
    let mut bench = Bench::operational();
    assert!(bench.remote(0x705, 1).is_empty());
    assert_eq!(bench.read(0x100C, 0), Err(0x0602_0000));
    assert_eq!(bench.read(0x100D, 0), Err(0x0602_0000));
}

#[test]
fn the_node_is_self_starting_by_1f80h() {
    let mut bench = Bench::new();
    assert_eq!(
        bench.write_u32(0x1F80, 0, 1),
        Err(0x0609_0030),
        "no NMT master"
    );
    bench.write_u32(0x1F80, 0, 0).expect("self-starting");
    bench.save(1);
    let sent = bench.send(0, &[129, 5]);
    assert_eq!(sent[0], (0x705, vec![0]));
    assert_eq!(bench.node.state(), NmtState::Operational);
}

#[test]
fn the_application_receives_each_nmt_state() {
    let mut bench = Bench::operational();
    bench.send(0, &[2, 5]);
    let states: Vec<_> = bench
        .device
        .events
        .iter()
        .filter_map(|event| {
            if let Event::NmtState(state) = event {
                Some(*state)
            } else {
                None
            }
        })
        .collect();
    use NmtState::{Initialising, Operational, PreOperational, Stopped};
    assert_eq!(states, [Initialising, PreOperational, Operational, Stopped]);
}

#[test]
fn a_node_that_has_not_booted_up_obeys_resets_only() {
    let mut bench = Bench::powered_on(Some(5));
    assert_eq!(bench.send(0, &[1, 5]), [(0x705, vec![0])]);
    assert_eq!(bench.node.state(), NmtState::PreOperational);
    let mut bench = Bench::powered_on(Some(5));
    bench.send(0, &[129, 5]);
    assert_eq!(bench.device.resets, [Reset::Node, Reset::Node]);
}
