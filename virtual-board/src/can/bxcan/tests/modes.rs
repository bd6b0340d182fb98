use super::*;

#[test]
fn out_of_reset_the_controller_sleeps_and_hears_nothing() {
    let mut bench = Bench::new();
    assert_eq!(bench.read(MSR) & 0b11, 0b10);
    assert_eq!(bench.read(MCR), 0x0001_0002);
    bench.port().send(0, frame(1, &[]));
    bench.run_us(500);
    assert_eq!(bench.read(RF0R), 0);
    assert_eq!(bench.port().waiting(), 1, "nobody acknowledged");
}

#[test]
fn the_bit_timing_is_written_in_initialisation_alone() {
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
fn initialisation_waits_for_the_frame_on_its_way() {
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
fn sleep_is_acknowledged_and_traffic_wakes() {
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
    // The frame that woke it is lost to it, but repeated, as nobody acknowledged.
    assert_eq!(bench.read(RF0R), 1);
}

#[test]
fn a_silent_controller_listens_without_a_trace() {
    let mut bench = Bench::with(0, BTR_1M | 1 << 31);
    bench.transmit(0, 5, 0);
    bench.run_us(1_000);
    assert!(bench.wire().take_log().is_empty());
    bench.port().send(0, frame(1, &[]));
    bench.run_us(100);
    assert_eq!(bench.port().waiting(), 1, "it does not acknowledge");
}

#[test]
fn a_looped_controller_hears_itself_and_needs_nobody() {
    let mut bench = Bench::with(0, BTR_1M | 1 << 30);
    bench.wire().fault = WireFault::Open;
    bench.transmit(0, 0x123, 0x5a);
    bench.run_us(200);
    assert_eq!(bench.read(TSR) & 0b11, 0b11);
    assert_eq!((bench.read(RF0R), bench.read(RI0R)), (1, 0x123 << 21));
    assert_eq!(bench.wire().take_log().len(), 1);
}

#[test]
fn silent_and_looped_it_never_touches_the_wire() {
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
