//! The acceptance filter is corrected while it is in use.

use board_tests::frames::{Frame, read, responses};
use board_tests::master::{ENABLED_TICK, Master, PERIODS, driven};
use board_tests::program::run_script;
use virtual_board::board::ChipKind;
use virtual_board::faults::{Fault, FilterBit, Planned};
use virtual_board::run::{Flow, Options, Script, View};

/// Control periods between two frames of [`driven`].
const PAUSE: u64 = 5;

/// PWM periods, 1 ms each, from a flip to the next frame of [`driven`]: the longest pause between
/// two corrections of the filter, and two more, since a frame that ends in the microsecond in which
/// its bank is corrected is lost.
const CORRECTED_PERIODS: u64 = 6;

const IDENTIFIER_BITS: u32 = 28 * 32;
const BANKS: u32 = 14;

/// Target position (CiA 402-2, 607Ah).
const TARGET_POSITION: u16 = 0x607a;

/// Another target each time.
fn target_mdeg(tick: u64) -> i32 {
    tick as i32
}

/// A process data object with a target, and half a pause later a request of that target.
fn frames(tick: u64) -> Vec<Frame> {
    if tick > ENABLED_TICK && tick % PAUSE == 2 {
        vec![read(TARGET_POSITION, 0)]
    } else {
        driven(tick, target_mdeg(tick))
    }
}

/// Flips the next bit of the filter before each frame with a target.
struct Flips<I> {
    master: Master<fn(u64) -> Vec<Frame>>,
    bits: I,
    periods: u64,
}

impl<I: Iterator<Item = FilterBit> + Send> Script for Flips<I> {
    fn at_edge(&mut self, view: &mut View<'_>) -> Flow {
        let next = self.periods + CORRECTED_PERIODS;
        let is_due = next > PERIODS * ENABLED_TICK && next.is_multiple_of(PERIODS * PAUSE);
        if is_due && let Some(bit) = self.bits.next() {
            let fault = Fault::AcceptanceFilter(bit);
            view.plan(Planned::at_ns(view.now_ns(), fault));
        }
        self.periods += 1;
        self.master.at_edge(view)
    }
}

#[test]
fn a_flip_of_any_bit_of_the_acceptance_filter_is_corrected_within_6_ms() {
    const BITS: u64 = (IDENTIFIER_BITS + BANKS) as u64;
    const LAST: u64 = ENABLED_TICK + PAUSE * BITS;
    for chip in [ChipKind::F427, ChipKind::H743] {
        let identifiers = (0..IDENTIFIER_BITS).map(FilterBit::Identifiers);
        let flips = Flips {
            master: Master::new(frames as fn(u64) -> Vec<Frame>),
            bits: identifiers.chain((0..BANKS).map(FilterBit::Activation)),
            periods: 0,
        };
        let options = Options {
            chip,
            // The control period of the other chip is a thousandth longer.
            ..Options::for_ms((LAST + 4 * PAUSE) * PERIODS)
        };
        let mut finished = run_script(options, flips);
        assert_eq!(finished.script.bits.next(), None);
        let responses = responses(&finished);
        let read = responses.iter().map(|response| {
            let [.., a, b, c, d] = *response;
            i32::from_le_bytes([a, b, c, d])
        });
        let sent = (ENABLED_TICK..=LAST).step_by(PAUSE as usize);
        let is_received = read.take(sent.clone().count()).eq(sent.map(target_mdeg));
        assert!(is_received, "{chip:?}: a frame was lost");
    }
}
