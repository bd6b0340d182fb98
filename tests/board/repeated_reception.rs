//! Received process data are processed twice: what changes one of both is noticed.

use std::ops::Range;

use board_tests::frames::Frame;
use board_tests::master::{Master, PERIODS, driven};
use board_tests::program::{firmware, run_script};
use virtual_board::run::{Flow, Options, Script, View};

use crate::disturbed::{Driving, Flip, is_told, motion, run};

/// Control periods of a run.
const END: u64 = 160;

/// Control periods between two frames of [`driven`].
const PAUSE: u64 = 5;

/// Frames with process data before the one that is disturbed: the drive is enabled and moves.
const RECEPTIONS: u64 = 15;

/// A target that no other word of the device equals for long.
fn target_mdeg(tick: u64) -> i32 {
    17 * tick as i32
}

fn frames(tick: u64) -> Vec<Frame> {
    driven(tick, target_mdeg(tick))
}

/// Looks for the words of the device that hold the target.
struct Finder {
    master: Driving,
    edges: u64,
    /// Addresses that held it whenever the device was read.
    found: Vec<u64>,
}

impl Script for Finder {
    fn at_edge(&mut self, view: &mut View<'_>) -> Flow {
        let tick = self.edges / PERIODS;
        let is_received = tick % PAUSE == PAUSE - 1;
        if self.edges.is_multiple_of(PERIODS) && tick > END / 2 && is_received {
            let target = target_mdeg(tick + 1 - PAUSE) as u32;
            self.found
                .retain(|address| view.word(*address) == Some(target));
        }
        self.edges += 1;
        self.master.at_edge(view)
    }
}

fn device() -> Range<u64> {
    let device = firmware().symbol_containing("init_device");
    device.expect("a variable")
}

/// Address of the target position, with which the commands begin.
fn commands() -> u64 {
    let finder = Finder {
        master: Master::new(frames),
        edges: 0,
        found: device().step_by(4).collect(),
    };
    let found = run_script(Options::for_ms(4 * END), finder).script.found;
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
