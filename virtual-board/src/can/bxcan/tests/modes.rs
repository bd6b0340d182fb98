use super::*;

#[test]
fn after_a_reset_the_controller_sleeps_and_receives_nothing() {
    let mut bench = Bench::new();
    assert_eq!(bench.read(MSR) & 0b11, 0b10);
    assert_eq!(bench.read(MCR), 0x0001_0002);
    bench.port().send(0, frame(1, &[]));
    bench.run_us(500);
    assert_eq!(bench.read(RF0R), 0);
    assert_eq!(bench.port().queued(), 1, "no station acknowledged");
}

#[test]
fn the_bit_timing_is_writable_only_in_initialisation_mode() {
    let mut bench = Bench::running();
    bench.write(BTR, 0);
    assert_eq!(bench.read(BTR), BTR_1M);
}

#[test]
fn it_joins_after_eleven_recessive_bits() {
    let mut bench = Bench::with(0, BTR_1M);
    bench.write(MCR, 1);
    bench.write(MCR, 0);
    bench.run_us(10);
    assert_eq!(bench.read(MSR) & 1, 1);
    bench.run_us(2);
    assert_eq!(bench.read(MSR) & 1, 0);
}

#[test]
fn initialisation_waits_for_the_end_of_the_frame() {
    let mut bench = Bench::running();
    bench.transmit(0, 5, 0);
    bench.run_us(10);
    bench.write(MCR, 1);
    assert_eq!(bench.read(MSR) & 1, 0);
    bench.run_us(200);
    assert_eq!(bench.read(MSR) & 1, 1);
    assert_eq!(bench.read(TSR) & 0b11, 0b11);
}

#[test]
fn sleep_is_acknowledged_and_traffic_wakes_the_controller_up() {
    let mut bench = Bench::running();
    bench.write(IER, 1 << 16 | 1 << 17);
    // AWUM.
    bench.write(MCR, 1 << 1 | 1 << 5);
    assert_eq!(bench.read(MSR) & 0b1_0010, 0b1_0010);
    assert!(bench.line(3));
    bench.write(MSR, 1 << 4);
    assert!(!bench.line(3));
    bench.port().send(0, frame(1, &[]));
    bench.run_us(1_000);
    assert_eq!(bench.read(MSR) & 0b1011, 0b1000);
    assert!(bench.line(3));
    // The frame that woke the controller up is not received, but repeated: it was not
    // acknowledged.
    assert_eq!(bench.read(RF0R), 1);
}

#[test]
fn a_silent_controller_neither_transmits_nor_acknowledges() {
    let mut bench = Bench::with(0, BTR_1M | 1 << 31);
    bench.transmit(0, 5, 0);
    bench.run_us(1_000);
    assert!(bench.wire().take_log().is_empty());
    bench.port().send(0, frame(1, &[]));
    bench.run_us(100);
    assert_eq!(bench.port().queued(), 1, "it does not acknowledge");
}

/// `ESR.LEC`.
fn last_error(bench: &mut Bench) -> u64 {
    bench.read(ESR) >> 4 & 7
}

#[test]
fn a_silent_controller_receives_unacknowledged_frames_once_their_sender_is_passive() {
    let mut bench = Bench::with(0, BTR_1M | 1 << 31);
    bench.write(ESR, 7 << 4);
    bench.port().send(0, frame(1, &[]));
    // Less than 16 attempts of 57 bits.
    bench.run_us(500);
    assert_eq!(
        (bench.read(RF0R), last_error(&mut bench)),
        (0, 2),
        "a form error"
    );
    // 16 attempts of 82 bits at most.
    bench.run_us(1_000);
    assert_ne!(bench.read(RF0R) & 3, 0);
    assert_eq!(last_error(&mut bench), 0);
    assert_eq!(bench.port().queued(), 1, "still not acknowledged");
}

#[test]
fn a_silent_controller_of_another_bit_rate_detects_errors_and_destroys_nothing() {
    let mut bench = Bench::with(0, BTR_500K | 1 << 31);
    let other = Port::at_rate(1_000_000);
    bench.wire().ports.push(other);
    bench.write(ESR, 7 << 4);
    bench.port().send(0, frame(1, &[]));
    bench.run_us(200);
    assert_eq!(bench.port().queued(), 0, "the other port acknowledges");
    assert_eq!(
        (bench.read(RF0R), last_error(&mut bench)),
        (0, 1),
        "a stuff error"
    );
}

#[test]
fn in_loop_back_mode_the_controller_receives_its_own_frames_without_an_acknowledgement() {
    let mut bench = Bench::with(0, BTR_1M | 1 << 30);
    bench.wire().fault = WireFault::Open;
    bench.transmit(0, 0x123, 0x5a);
    bench.run_us(200);
    assert_eq!(bench.read(TSR) & 0b11, 0b11);
    assert_eq!((bench.read(RF0R), bench.read(RI0R)), (1, 0x123 << 21));
    assert_eq!(bench.wire().take_log().len(), 1);
}

#[test]
fn in_silent_loop_back_mode_no_frame_reaches_the_bus() {
    let mut bench = Bench::with(0, BTR_1M | 3 << 30);
    bench.transmit(0, 0x123, 0x5a);
    bench.run_us(200);
    assert_eq!((bench.read(RF0R), bench.read(RDL0R)), (1, 0x5a));
    assert!(bench.wire().take_log().is_empty());
}

#[test]
fn a_software_reset_keeps_the_filters() {
    let mut bench = Bench::running();
    bench.write(MCR, 1 << 15);
    assert_eq!(bench.read(MCR), 0x0001_0002);
    assert_eq!(bench.read(0x21c), 1);
}
