//! The controller without its registers: buffers, filters, FIFO, bus-off.

use rigless::soc::RegisterSpec;

use super::super::{ErrorState, Frame, Id, Outcome, Station, WireFault, arbitrate};
use super::memory::MessageRam;
use super::registers::{LBCK, cccr, ir};
use super::{FdCan, Mode};

static NO_REGISTERS: [RegisterSpec; 0] = [];

/// Offsets of the lists, bytes: filters of both kinds, two received frames, three buffers.
const STANDARD: u32 = 0x000;
const EXTENDED: u32 = 0x010;
const FIFO: u32 = 0x020;
const BUFFERS: u32 = 0x100;

/// 42 MHz / 3, 1 + 11 + 2 quanta, jump width 2: 1 Mbit/s.
const BIT_TIMING: u32 = 1 << 25 | 2 << 16 | 10 << 8 | 1;

/// A controller on the bus.
fn controller() -> FdCan {
    let mut can = FdCan::new(None, MessageRam::new(&NO_REGISTERS), &NO_REGISTERS);
    can.clock_hz = 42_000_000;
    can.settings.bit_timing = BIT_TIMING;
    can.settings.standard_filters = STANDARD | 1 << 16;
    can.settings.extended_filters = EXTENDED | 1 << 16;
    can.settings.fifo = FIFO | 2 << 16;
    can.settings.buffers = BUFFERS | 3 << 16;
    can.settings.complete_enabled = 0b111;
    can.settings.cancelled_enabled = 0b111;
    can.control = 0;
    can.mode = Mode::Running;
    can
}

fn frame(id: u16) -> Frame {
    Frame::data_frame(Id::Standard(id), &[1, 2, 3])
}

/// Writes a frame into a buffer and requests it.
fn request(can: &mut FdCan, buffer: u32, frame: &Frame) {
    can.ram.store(BUFFERS + 16 * buffer, frame);
    can.request(1 << buffer);
}

/// Carries the frame that the controller offers, with this outcome.
fn carry(can: &mut FdCan, fault: WireFault, listener: bool) -> Outcome {
    let other = Station {
        offer: None,
        state: ErrorState::Active,
        is_silent: false,
        needs_acknowledge: true,
        ..can.station().expect("it is on the bus")
    };
    let stations = [can.station(), listener.then_some(other)];
    let transfer = arbitrate(&stations, fault, false).expect("a frame");
    can.begin(1, transfer, 0);
    can.finish_current(1);
    transfer.outcome
}

#[test]
fn buffers_are_transmitted_by_priority_and_reported() {
    let mut can = controller();
    request(&mut can, 0, &frame(0x300));
    request(&mut can, 2, &frame(0x100));
    assert_eq!(can.next_buffer(), Some((2, frame(0x100))));
    assert_eq!(carry(&mut can, WireFault::None, true), Outcome::Delivered);
    assert_eq!((can.pending, can.transmitted), (0b001, 0b100));
    assert_ne!(can.flags & ir::TC, 0);
}

#[test]
fn a_cancelled_buffer_is_not_transmitted_unless_it_is_on_the_bus() {
    let mut can = controller();
    request(&mut can, 1, &frame(5));
    can.cancel(0b010);
    assert_eq!((can.pending, can.cancelled), (0, 0b010));
    request(&mut can, 1, &frame(5));
    assert_eq!(can.cancelled, 0);
    let transfer = arbitrate(&[can.station()], WireFault::None, false).expect("a frame");
    can.begin(1, transfer, 0);
    can.cancel(0b010);
    assert_eq!(can.pending, 0b010, "its attempt is under way");
    can.finish_current(1);
    assert_eq!(transfer.outcome, Outcome::Unacknowledged);
    assert_eq!((can.pending, can.cancelled), (0, 0b010));
}

#[test]
fn frames_of_the_filters_reach_the_fifo_and_a_third_one_is_lost() {
    let mut can = controller();
    can.control = cccr::TEST;
    can.settings.test = LBCK;
    let extended = Frame::data_frame(Id::Extended(0x1234_5678), &[9]);
    let write = |can: &FdCan, offset: u32, word: u32| can.ram.write(offset, word);
    write(
        &can,
        STANDARD,
        0b01 << 30 | 0b001 << 27 | 0x111 << 16 | 0x222,
    );
    write(&can, EXTENDED, 0b001 << 29 | 0x1234_5678);
    write(&can, EXTENDED + 4, 0b01 << 30 | 0x1234_5678);
    for (frame, level) in [
        (frame(0x222), 1),
        (frame(0x223), 1),
        (extended, 2),
        (frame(0x111), 2),
    ] {
        request(&mut can, 0, &frame);
        carry(&mut can, WireFault::None, false);
        assert_eq!(can.fifo.level, level, "{frame:?}");
    }
    assert_ne!(can.flags & ir::RF0L, 0);
    assert_eq!(can.ram.frame(FIFO), frame(0x222));
    assert_eq!(can.ram.frame(FIFO + 16), extended);
    can.acknowledge(0);
    assert_eq!((can.fifo.get, can.fifo.level), (1, 1));
    can.acknowledge(1);
    assert_eq!((can.fifo.get, can.fifo.level), (0, 0));
}

#[test]
fn bus_off_sets_init_and_ends_after_129_times_11_bits() {
    let mut can = controller();
    request(&mut can, 0, &frame(1));
    for _ in 0..32 {
        assert_eq!(can.control & cccr::INIT, 0);
        assert_eq!(carry(&mut can, WireFault::Short, true), Outcome::BitError);
    }
    assert_eq!(can.control & cccr::INIT, cccr::INIT);
    assert!(can.station().is_none());
    can.control = 0;
    can.advance_mode(0);
    let ready_ns = 129 * 11 * 1000;
    assert_eq!(can.mode, Mode::Joining { ready_ns });
    can.advance_mode(ready_ns - 1);
    assert!(can.station().is_none());
    can.advance_mode(ready_ns);
    assert_eq!(
        can.station().map(|station| station.state),
        Some(ErrorState::Active)
    );
}
