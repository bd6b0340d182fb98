//! The checks of the drivers with mocks: they pass, and each finds the defects that it is for.

use std::{cell::RefCell, convert::Infallible, rc::Rc};

use crate::mocks::{Bus, EncoderTransfer, Nor, Port, Timer};
use drivers::{
    bridge::HBridge,
    can::{CanPort, Mode, NbCan},
    checks::{self, Failure},
    encoder::{As5045, Blocking, SELECT_NS, Timed},
    store::NorFlashPages,
};
use embedded_hal::{
    delay::DelayNs,
    digital::{ErrorType, OutputPin},
};
use embedded_hal_mock::eh1::{
    delay::NoopDelay,
    digital::{Mock as Pin, State, Transaction as Edge},
    spi::{Mock as Spi, Transaction},
};
use model_core::control::encoder_word::{EncoderCount, EncoderWord, Magnet};

fn word(count: u16) -> u32 {
    EncoderWord::of(EncoderCount::new(count), Magnet::Steady).bits()
}

/// The step in which a check fails; 0 if it passes.
fn step<T>(result: Result<T, Failure>) -> u8 {
    result.map_or_else(|failure| failure.step, |_| 0)
}

/// Ends transfers.
struct Time(Rc<RefCell<bool>>);

impl DelayNs for Time {
    fn delay_ns(&mut self, _: u32) {
        *self.0.borrow_mut() = true;
    }
}

/// Runs the encoder's check with a timed bus.
fn timed<P: OutputPin>(transfer: EncoderTransfer, pin: P) -> (Result<EncoderCount, Failure>, P) {
    let mut time = Time(transfer.has_ended.clone());
    let mut encoder = As5045::new(Timed::new(transfer, pin));
    let result = checks::encoder(&mut encoder, &mut time);
    (result, encoder.release().release().1)
}

#[test]
fn a_timed_encoder_passes_and_is_selected_for_each_transfer() {
    let transfer = EncoderTransfer {
        word: word(1234),
        ..EncoderTransfer::default()
    };
    let [high, low] = [State::High, State::Low].map(Edge::set);
    // Without a transfer; the first transfer and a second end of it; an aborted one and the last.
    let edges = [&high, &high, &low, &high, &high, &low, &low, &high].map(Clone::clone);
    let (result, mut pin) = timed(transfer, Pin::new(&edges));
    assert_eq!(result.map(EncoderCount::get), Ok(1234));
    pin.done();
}

/// A pin that nothing observes.
struct AnyPin;

impl ErrorType for AnyPin {
    type Error = Infallible;
}

impl OutputPin for AnyPin {
    fn set_low(&mut self) -> Result<(), Infallible> {
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}

#[test]
fn a_disconnected_encoder_and_a_shifted_transfer_are_found() {
    let disconnected = EncoderTransfer::default();
    assert_eq!(step(timed(disconnected, AnyPin).0), 2);
    let shifted = EncoderTransfer {
        word: word(1234),
        residue: true,
        ..EncoderTransfer::default()
    };
    assert_eq!(step(timed(shifted, AnyPin).0), 4);
}

#[test]
fn an_encoder_at_any_spi_device_passes() {
    let [_, a, b, c] = (word(77) << 5).to_be_bytes();
    let transfer = [
        Transaction::transaction_start(),
        Transaction::delay(SELECT_NS),
        Transaction::read_vec(vec![a, b, c]),
        Transaction::transaction_end(),
    ];
    let transfers = [transfer.clone(), transfer.clone(), transfer].concat();
    let mut encoder = As5045::new(Blocking::new(Spi::new(&transfers)));
    let count = checks::encoder(&mut encoder, &mut NoopDelay::new());
    assert_eq!(count.map(EncoderCount::get), Ok(77));
    encoder.release().release().done();
}

#[test]
fn the_bridge_passes_and_its_defects_are_found() {
    let check = |timer| step(checks::bridge(&mut HBridge::new(timer), Timer::trip));
    assert_eq!(check(Timer::new()), 0);
    let dead_break = Timer {
        has_dead_break: true,
        ..Timer::new()
    };
    assert_eq!(check(dead_break), 8);
    let swapped = Timer {
        has_swapped_legs: true,
        ..Timer::new()
    };
    assert_eq!(check(swapped), 2);
    let stuck = Timer {
        is_stuck_on: true,
        ..Timer::new()
    };
    assert_eq!(check(stuck), 1);
}

/// Carries the frames of a bus.
struct Carry(Rc<RefCell<Bus>>);

impl DelayNs for Carry {
    fn delay_ns(&mut self, _: u32) {
        self.0.borrow_mut().carry();
    }
}

#[test]
fn the_controller_passes_and_a_silent_one_is_found() {
    for (mode, expected) in [(Mode::LoopBack, 0), (Mode::Full, 3)] {
        let mut port = Port::default();
        port.join(1000, mode);
        let mut time = Carry(port.0.clone());
        let result = checks::can(&mut NbCan(port), &mut time);
        assert_eq!(step(result), expected, "{mode:?}");
    }
}

#[test]
fn the_store_passes_with_any_length_of_a_row_and_its_defects_are_found() {
    fn check<const WRITE: usize>(stuck_bit: Option<usize>, fails: bool) -> u8 {
        let flash = Nor::<WRITE> {
            stuck_bit,
            fails,
            ..Nor::new()
        };
        step(checks::store(
            NorFlashPages::new(flash),
            &mut NoopDelay::new(),
        ))
    }
    let checks = [check::<1>, check::<4>, check::<8>, check::<32>];
    for check in checks {
        assert_eq!(check(None, false), 0);
        assert_eq!(check(None, true), 1);
        assert_eq!(check(Some(8 * 1024 + 100), false), 1);
    }
}
