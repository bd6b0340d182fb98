use super::*;

/// TEC, REC, LEC, flags.
fn errors(bench: &mut Bench) -> (u64, u64, u64, u64) {
    let esr = bench.read(ESR);
    (esr >> 16 & 0xff, esr >> 24, esr >> 4 & 7, esr & 7)
}

#[test]
fn without_an_acknowledgement_the_transmitter_becomes_error_passive_and_not_bus_off() {
    let mut bench = Bench::running();
    bench.wire().fault = WireFault::Open;
    bench.write(IER, 1 << 9 | 1 << 15);
    bench.transmit(0, 0x181, 0);
    bench.run_us(20_000);
    assert_eq!(errors(&mut bench), (128, 0, 3, 0b011));
    assert!(bench.line(3), "the passive limit causes an interrupt");
    bench.write(MSR, 1 << 2);
    assert!(!bench.line(3));
    bench.wire().fault = WireFault::None;
    bench.run_us(1_000);
    assert_eq!(errors(&mut bench), (127, 0, 0, 0b001));
    assert_eq!(bench.port().take_received().len(), 1);
}

#[test]
fn a_shorted_wire_causes_bus_off_until_the_next_initialisation() {
    let mut bench = Bench::running();
    bench.write(IER, 1 << 10 | 1 << 15);
    bench.wire().fault = WireFault::Short;
    bench.transmit(0, 0x181, 0);
    bench.run_us(2_000);
    assert_eq!(errors(&mut bench), (255, 0, 5, 0b111));
    assert!(bench.line(3));
    bench.wire().fault = WireFault::None;
    bench.run_us(10_000);
    assert_eq!(
        errors(&mut bench).3,
        0b111,
        "it does not recover automatically"
    );
    // The firmware requests initialisation: 128 x 11 bits later the controller is on the bus again
    // and sends.
    bench.write(MCR, 1);
    bench.write(MCR, 0);
    bench.run_us(1_408);
    assert_eq!(errors(&mut bench).3, 0b111);
    bench.run_us(500);
    assert_eq!(errors(&mut bench), (0, 0, 0, 0));
    assert_eq!(bench.port().take_received().len(), 1);
}

#[test]
fn automatic_bus_off_management_recovers_after_128_times_11_bits() {
    let mut bench = Bench::with(1 << 6, BTR_1M);
    bench.wire().fault = WireFault::Short;
    bench.transmit(0, 0x181, 0);
    // 16 failed frames of 18 bits, then 16 of 26 with the suspended transmission.
    bench.run_us(16 * 18 + 16 * 26);
    assert_eq!(errors(&mut bench).3, 0b111);
    bench.wire().fault = WireFault::None;
    bench.run_us(1_350);
    assert_eq!(errors(&mut bench).3, 0b111);
    bench.run_us(200);
    assert_eq!(errors(&mut bench).3, 0);
    assert_eq!(bench.port().take_received().len(), 1);
}

#[test]
fn a_wrong_bit_rate_destroys_its_own_and_the_others_frames() {
    let mut bench = Bench::with(0, BTR_500K);
    bench.port().send(0, frame(1, &[]));
    bench.run_us(500);
    let (_, receive, last, _) = errors(&mut bench);
    assert!(receive >= 8, "{receive}");
    assert_eq!(last, 1);
    // After 16 error flags it is error-passive and disturbs no frame; no station acknowledges.
    bench.run_us(20_000);
    assert_eq!(errors(&mut bench).3, 0b011);
    assert_eq!(bench.port().queued(), 1);
    bench.write(TSR, 0);
    bench.transmit(0, 0x181, 0);
    bench.run_us(50_000);
    assert!(bench.port().take_received().is_empty());
}

#[test]
fn a_disturbed_frame_is_sent_again_and_counted() {
    let mut bench = Bench::running();
    bench.write(IER, 1 << 11 | 1 << 15);
    bench.wire().noise = 2;
    bench.transmit(0, 0x181, 0);
    bench.run_us(1_000);
    // Two errors add 8 each, the good frame subtracts 1.
    assert_eq!(errors(&mut bench), (15, 0, 0, 0));
    assert!(bench.line(3), "an error code causes an interrupt");
    assert_eq!(bench.read(TSR) & 0xff, 0b11);
    assert_eq!(bench.port().take_received().len(), 1);
}

#[test]
fn without_retransmission_an_error_empties_the_mailbox() {
    let mut bench = Bench::with(1 << 4, BTR_1M);
    bench.wire().fault = WireFault::Open;
    bench.transmit(0, 0x181, 0);
    bench.run_us(1_000);
    // RQCP, TERR.
    assert_eq!(bench.read(TSR) & 0xff, 0b1001);
    assert_eq!(errors(&mut bench).0, 8);
}

#[test]
fn the_warning_limit_interrupts_at_96() {
    let mut bench = Bench::running();
    bench.write(IER, 1 << 8 | 1 << 15);
    bench.wire().noise = 11;
    bench.transmit(0, 0x181, 0);
    bench.run_us(2_000);
    assert!(!bench.line(3));
    bench.wire().noise = 2;
    bench.transmit(0, 0x181, 0);
    bench.run_us(2_000);
    assert!(bench.line(3));
}
