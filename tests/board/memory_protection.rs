//! Only the tasks of the loop can write its memory.
//!
//! The emulator discards its translated code at each change of the permissions, so that these runs
//! are short.

use board_tests::frames::{Frame, control, faults, start};
use board_tests::master::Master;
use board_tests::program::{firmware, run_master, run_script};
use virtual_board::faults::{Fault, MemoryLocation, Planned};
use virtual_board::run::{Flow, Options, Script, View};

use crate::disturbed::{Driving, frames, motion};

/// Instant of the wrong write, ms: the program has started.
const FROM_MS: u64 = 60;

/// Window watchdog, start of the program, and the encoder's first words.
const UNTIL_MS: u64 = FROM_MS + 25 + 30;

/// Commands in each control period, which the communication posts to the loop.
fn commands(tick: u64) -> Vec<Frame> {
    match tick {
        8 => vec![start()],
        10.. => vec![control(0x06, 0)],
        _ => Vec::new(),
    }
}

/// Fault 19, reset by the watchdog.
const WATCHDOG_RESET: u8 = 19;

/// Finds where the communication keeps the address of the memory for its next commands.
struct Finder {
    master: Driving,
    found: Vec<(u64, u32)>,
}

impl Script for Finder {
    fn at_edge(&mut self, view: &mut View<'_>) -> Flow {
        let messages = firmware()
            .symbol_containing("init_messages")
            .expect("a variable");
        let task = firmware()
            .symbol_containing("local_resource_comm_task")
            .expect("a variable");
        let words = task
            .step_by(4)
            .filter_map(|address| Some((address, view.word(address)?)));
        self.found = words
            .filter(|(_, word)| messages.contains(&u64::from(*word)))
            .collect();
        self.master.at_edge(view)
    }
}

/// Flips that lead the communication into the memory of the loop with its next commands.
fn flips_into_the_loop() -> Vec<Planned> {
    let finder = Finder {
        master: Master::new(commands),
        found: Vec::new(),
    };
    let found = run_script(Options::for_ms(FROM_MS), finder).script.found;
    let memory = firmware()
        .symbol_containing("CONTROL_LOOP")
        .expect("a variable");
    let middle = (memory.start + memory.end) / 2;
    let (address, word) = *found.first().expect("an address of messages");
    let wrong_bits = (0..32).filter(|bit| (u64::from(word) ^ middle) >> bit & 1 != 0);
    let place = || MemoryLocation::Address(address);
    let flips = wrong_bits.map(|bit| Fault::FlipRam {
        place: place(),
        bit,
    });
    flips.map(|flip| Planned::at_ms(FROM_MS, flip)).collect()
}

#[test]
fn a_write_of_the_communication_into_the_memory_of_the_loop_resets_the_processor() {
    let options = Options {
        faults: flips_into_the_loop(),
        protects_memory: true,
        ..Options::for_ms(UNTIL_MS)
    };
    let finished = run_master(options, commands);
    let faults = faults(&finished);
    let (_, fault) = *faults.first().expect("a message");
    assert_eq!(fault, WATCHDOG_RESET, "{faults:?}");
}

#[test]
fn the_protection_does_not_change_what_the_board_does() {
    let run = |protects_memory| {
        let options = Options {
            protects_memory,
            ..Options::for_ms(FROM_MS)
        };
        motion(&run_master(options, frames))
    };
    assert_eq!(run(true), run(false));
}
