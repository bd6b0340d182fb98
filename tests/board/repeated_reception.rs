//! Received process data are processed twice: what changes one of both is noticed, and what changes
//! a frame before both.

use std::ops::Range;

use board_tests::frames::{Frame, faults, with_id};
use board_tests::master::{ENABLED_TICK, Master, PERIODS, driven};
use board_tests::program::{firmware, run_script};
use virtual_board::run::{Flow, Options, Script, View};

use crate::disturbed::{Driving, Flip, is_told, motion, run};

/// Control periods of a run.
const END: u64 = 160;

/// Control periods between two frames of [`driven`].
const PAUSE: u64 = 5;

/// Frames with process data before the one that is disturbed: the drive is enabled and moves.
const RECEPTIONS: u64 = 15;

/// Of these, without a target.
const BEFORE_TARGETS: u64 = 3;

/// Error code of lost frames (CiA 301, table 26: CAN overrun, objects lost).
const CAN_OVERRUN: [u8; 2] = 0x8110_u16.to_le_bytes();

/// A target that no other word of the device equals for long.
fn target_mdeg(tick: u64) -> i32 {
    17 * tick as i32
}

fn frames(tick: u64) -> Vec<Frame> {
    driven(tick, target_mdeg(tick))
}

/// Looks for the words that hold the target.
struct Finder {
    master: Driving,
    edges: u64,
    /// The word in which a target is looked for.
    word: fn(i32) -> u32,
    /// Control periods after which it is looked for.
    ticks: Range<u64>,
    /// Addresses that held it each time.
    found: Vec<u64>,
}

impl Script for Finder {
    fn at_edge(&mut self, view: &mut View<'_>) -> Flow {
        let tick = self.edges / PERIODS;
        let is_received = tick % PAUSE == PAUSE - 1;
        if self.edges.is_multiple_of(PERIODS) && self.ticks.contains(&tick) && is_received {
            let word = (self.word)(target_mdeg(tick + 1 - PAUSE));
            self.found
                .retain(|address| view.word(*address) == Some(word));
        }
        self.edges += 1;
        self.master.at_edge(view)
    }
}

/// Addresses of the words of a variable that hold this word of the targets of these control
/// periods.
fn find(variable: &str, word: fn(i32) -> u32, ticks: Range<u64>) -> Vec<u64> {
    let variable = firmware().symbol_containing(variable).expect("a variable");
    let finder = Finder {
        master: Master::new(frames),
        edges: 0,
        word,
        ticks,
        found: variable.step_by(4).collect(),
    };
    run_script(Options::for_ms(4 * END), finder).script.found
}

/// Address of the target position, with which the commands begin.
fn commands() -> u64 {
    let found = find("init_device", |target| target as u32, END / 2 + 1..END);
    // The words before are those of the received frame.
    *found.last().expect("the device holds the target")
}

#[test]
fn a_flip_before_one_of_both_processings_of_process_data_is_told_or_without_effect() {
    let run = |flip| run(frames, 4 * END, flip);
    let undisturbed = motion(&run(None));
    let mut told = [0; 2];
    let first = commands();
    // Target position, target velocity, its offset; behind the controlword the mode.
    for (word, bit) in [(0, 3), (1, 3), (2, 3), (3, 19)] {
        for (processing, told) in told.iter_mut().enumerate() {
            let disturbed = run(Some(Flip {
                address: first + 4 * word,
                bit,
                before: "receive_process_data",
                entry: 2 * RECEPTIONS + 1 + processing as u64,
            }));
            *told += usize::from(is_told(&disturbed, &undisturbed));
        }
    }
    // Each frame writes the target position anew, and nothing else that is inverted here.
    assert_eq!(told, [3, 3]);
}

#[test]
fn a_flip_in_a_frame_that_waits_is_told_as_a_lost_frame() {
    // Controlword and lower half of the target, in the frame that is disturbed.
    let word = |target_mdeg| 0x0f | (target_mdeg as u32) << 16;
    let tick = ENABLED_TICK + PAUSE * (RECEPTIONS - BEFORE_TARGETS);
    let found = find("queues..ReceivedFrames", word, tick..tick + PAUSE);
    let &[data] = &found[..] else {
        panic!("{found:x?}");
    };
    let lost_frames = |flip| {
        let finished = run(frames, 4 * END, flip);
        assert!(faults(&finished).is_empty());
        let emergencies = with_id(&finished, 0x081);
        emergencies
            .filter(|(_, data)| data[..2] == CAN_OVERRUN)
            .count()
    };
    assert_eq!(lost_frames(None), 0);
    // Identifier, length, both halves of the data, check value.
    for address in (data - 8..=data + 8).step_by(4) {
        let flip = Flip {
            address,
            bit: 3,
            before: "receive_twice",
            entry: RECEPTIONS + 1,
        };
        assert_eq!(lost_frames(Some(flip)), 1, "{address:x}");
    }
}
