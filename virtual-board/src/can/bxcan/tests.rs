//! Tests through the registers, as a firmware uses the controller.

mod bench;
mod errors;
mod modes;

use super::super::{Frame, Id, Port, Wire, WireFault};
use bench::*;

fn frame(id: u16, data: &[u8]) -> Frame {
    Frame::data_frame(Id::Standard(id), data)
}

#[test]
fn a_frame_goes_out_and_its_mailbox_empties() {
    let mut bench = Bench::running();
    bench.transmit(0, 0x181, 0x0403_0201);
    assert_eq!(bench.read(TSR) >> 26 & 7, 0b110);
    bench.run_us(200);
    // RQCP0, TXOK0; all empty.
    assert_eq!(bench.read(TSR) & 0xff, 0b11);
    assert_eq!(bench.read(TSR) >> 26 & 7, 0b111);
    let received = bench.port().take_received();
    assert_eq!(received.len(), 1);
    assert_eq!(received[0].1, frame(0x181, &[1, 2, 3, 4]));
    bench.write(TSR, 1);
    assert_eq!(bench.read(TSR) & 0xff, 0);
}

#[test]
fn mailboxes_are_sent_in_the_order_of_identifiers_or_of_requests() {
    for (control, expected) in [(0, [0x100, 0x200, 0x300]), (1 << 2, [0x300, 0x100, 0x200])] {
        let mut bench = Bench::with(control, BTR_1M);
        // Keeps the wire busy while the mailboxes fill.
        bench.port().send(0, frame(1, &[0; 8]));
        bench.run_us(20);
        bench.transmit(0, 0x300, 0);
        bench.transmit(1, 0x100, 0);
        bench.transmit(2, 0x200, 0);
        // LOW marks the pending mailbox of the lowest priority, and CODE is its number.
        let lowest = if control == 0 { 0 } else { 2 };
        assert_eq!(bench.read(TSR) >> 29, 1 << lowest);
        assert_eq!(bench.read(TSR) >> 24 & 3, lowest);
        bench.run_us(1_000);
        let ids: Vec<_> = bench
            .port()
            .take_received()
            .iter()
            .map(|(_, f)| f.id.value())
            .collect();
        assert_eq!(ids, expected);
    }
}

#[test]
fn a_lower_identifier_from_outside_goes_first() {
    let mut bench = Bench::running();
    bench.port().send(0, frame(1, &[0; 8]));
    bench.run_us(20);
    bench.port().send(0, frame(0x10, &[]));
    bench.transmit(0, 0x20, 0);
    bench.run_us(1_000);
    let ids: Vec<_> = bench
        .wire()
        .take_log()
        .iter()
        .map(|sent| sent.frame.id.value())
        .collect();
    assert_eq!(ids, [1, 0x10, 0x20]);
    // Arbitration was lost once, and the frame was sent afterwards.
    assert_eq!(bench.read(TSR) & 0xff, 0b11);
}

#[test]
fn without_retransmission_a_lost_arbitration_empties_the_mailbox() {
    let mut bench = Bench::with(1 << 4, BTR_1M);
    bench.port().send(0, frame(1, &[0; 8]));
    bench.run_us(20);
    bench.port().send(0, frame(0x10, &[]));
    bench.transmit(0, 0x20, 0);
    bench.run_us(1_000);
    // RQCP, ALST.
    assert_eq!(bench.read(TSR) & 0xff, 0b101);
}

#[test]
fn a_pending_frame_can_be_aborted_and_its_registers_are_protected() {
    let mut bench = Bench::running();
    bench.port().send(0, frame(1, &[0; 8]));
    bench.run_us(20);
    bench.transmit(0, 0x20, 7);
    bench.write(TDL0R, 8);
    assert_eq!(bench.read(TDL0R), 7);
    bench.write(TSR, 1 << 7);
    assert_eq!(bench.read(TSR) & 0xff, 1);
    bench.run_us(1_000);
    assert!(bench.port().take_received().is_empty());
}

#[test]
fn frames_come_in_by_the_filters_and_are_released() {
    let mut bench = Bench::running();
    bench
        .port()
        .send(0, frame(0x201, &[1, 2, 3, 4, 5, 6, 7, 8]));
    bench
        .port()
        .send(0, Frame::data_frame(Id::Extended(0x1234_5678), &[9]));
    bench.run_us(1_000);
    assert_eq!(bench.read(RF0R), 2);
    assert_eq!(bench.read(RI0R), 0x201 << 21);
    assert_eq!(bench.read(RDT0R), 8);
    assert_eq!(bench.read(RDL0R), 0x0403_0201);
    assert_eq!(bench.read(RDH0R), 0x0807_0605);
    bench.write(RF0R, 1 << 5);
    assert_eq!(bench.read(RI0R), 0x1234_5678 << 3 | 4);
    bench.write(RF0R, 1 << 5);
    assert_eq!(bench.read(RF0R), 0);
}

#[test]
fn four_unread_frames_overrun_the_fifo_and_set_the_overrun_flag() {
    let mut bench = Bench::running();
    bench.write(IER, 1 << 3);
    for id in 1..=4 {
        bench.port().send(0, frame(id, &[]));
    }
    bench.run_us(1_000);
    assert_eq!(bench.read(RF0R), 3 | 1 << 3 | 1 << 4);
    assert!(bench.line(1));
    bench.write(RF0R, 1 << 4);
    assert!(!bench.line(1));
}

#[test]
fn the_interrupt_lines_follow_their_flags() {
    let mut bench = Bench::running();
    // TMEIE, FMPIE0.
    bench.write(IER, 1 | 1 << 1);
    assert!(!bench.line(0) && !bench.line(1));
    bench.transmit(0, 5, 0);
    bench.run_us(200);
    assert!(bench.line(0));
    bench.write(TSR, 1);
    assert!(!bench.line(0));
    bench.port().send(0, frame(1, &[]));
    bench.run_us(200);
    assert!(bench.line(1));
    bench.write(RF0R, 1 << 5);
    assert!(!bench.line(1));
}

#[test]
fn a_time_stamp_counts_bits_and_is_sent_in_the_frame() {
    let mut bench = Bench::with(1 << 7, BTR_1M);
    bench.run_us(100);
    // TGT, eight bytes.
    bench.write(TDT0R, 1 << 8 | 8);
    bench.write(TI0R, 5 << 21 | 1);
    bench.run_us(300);
    let (ended_ns, sent) = bench.port().take_received()[0];
    let stamp = u16::from_le_bytes([sent.data[6], sent.data[7]]);
    assert_eq!(bench.read(TDT0R) >> 16, u64::from(stamp));
    let started_us = ended_ns / 1000 - u64::from(sent.bits_on_the_wire());
    // The stamp itself changes the number of stuff bits by one or two; stamps count from the
    // request to join the bus.
    assert!(u64::from(stamp).abs_diff(started_us - bench.joined_us) <= 3);
}
