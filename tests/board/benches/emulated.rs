//! Speed of the emulated board in closed loop, alone and with others on one bus.
//!
//!     cargo bench -p board-tests --bench emulated --profile release --ignore-rust-version

use std::thread;
use std::time::Instant;

use board_tests::chain::saved;
use board_tests::frames::{control, standard, to_wire};
use board_tests::master::{driven, to_and_fro};
use board_tests::program::{firmware, run_master};
use firmware::drive::StoredParameters;
use virtual_board::can::Port;
use virtual_board::plant::BoardPlantOptions;
use virtual_board::run::{Attachments, Flow, Options, SharedBus, View, run_with};

/// Virtual time of a run, ms.
const FIRST_MS: u64 = 1_000;
const ALONE_MS: u64 = 60_000;
const TOGETHER_MS: u64 = 10_000;

const MOST_BOARDS: u32 = 8;

/// Seed of the plant's noise.
const SEED: u64 = 1;

fn options(ms: u64) -> Options {
    Options {
        plant: BoardPlantOptions::realistic(SEED),
        keeps_trace: false,
        ..Options::for_ms(ms)
    }
}

/// A board that a master moves to and fro, with a new target in each control period.
fn alone(ms: u64) {
    run_master(options(ms), |tick| driven(tick, to_and_fro(tick)));
}

/// The master of several boards: starts and enables all, then commands each every 20 ms.
fn master(boards: u32) -> Port {
    let mut port = Port::at_rate(1_000_000);
    port.send(80_000_000, to_wire(&standard(0, &[1, 0])));
    let words = [0x06, 0x07].into_iter().chain(std::iter::repeat(0x0f));
    for (ms, word) in (100..TOGETHER_MS).step_by(20).zip(words) {
        for node in 1..=boards {
            let data = control(word, to_and_fro(ms / 4)).bytes();
            let frame = standard(0x400 + node as u16, &data[..6]);
            port.send(ms * 1_000_000, to_wire(&frame));
        }
    }
    port
}

/// Boards on one bus, each in a thread of its own.
fn together(boards: u32) {
    let bus = SharedBus::new(vec![master(boards)], boards as usize);
    let start = |(node_id, connection)| {
        let mut parameters = StoredParameters::DEFAULT;
        parameters.board.bus.node_id = node_id;
        let options = Options {
            contents: vec![saved(&parameters)],
            ..options(TOGETHER_MS)
        };
        let attachments = Attachments {
            bus: Some(connection),
            ..Attachments::default()
        };
        let idle = |_: &mut View<'_>| Flow::Continue;
        thread::spawn(move || {
            let finished = run_with(firmware(), options, idle, attachments);
            let gaps = finished.expect("the run succeeds").gaps;
            assert!(gaps.is_empty(), "{gaps}");
        })
    };
    let threads: Vec<_> = (1..).zip(bus.connections()).map(start).collect();
    for thread in threads {
        thread.join().expect("no panic");
    }
}

/// Prints how much faster than real time a run of this virtual time is.
fn measure(name: &str, ms: u64, run: impl FnOnce()) {
    let start = Instant::now();
    run();
    let times = ms as f64 * 1e-3 / start.elapsed().as_secs_f64();
    println!("figure emulated closed loop, {name} = {times:.2} times real time");
}

fn main() {
    firmware();
    // The first run of a process translates the program; the next ones take its code over.
    measure("first second of a program", FIRST_MS, || alone(FIRST_MS));
    measure("1 board", ALONE_MS, || alone(ALONE_MS));
    // Nearly without translation.
    measure("1 board, next 60 s", ALONE_MS, || alone(ALONE_MS));
    // The same holds for each board of a bus.
    together(MOST_BOARDS);
    for boards in [2, 4, MOST_BOARDS] {
        let name = format!("{boards} boards on one bus");
        measure(&name, TOGETHER_MS, || together(boards));
    }
}
