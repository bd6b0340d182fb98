//! The log of the board, read from its memory as a debugger does.

use std::path::Path;

use board_tests::frames::Frame;
use board_tests::master::{Master, driven, to_and_fro};
use board_tests::program::{firmware, run_script};
use cross_build::board_elf;
use virtual_board::run::{Firmware, Flow, Options, Script, View};

/// Offsets in the control block after its 16-byte identifier: buffer, size, written, read (SEGGER
/// UM08001).
const BUFFER: u64 = 28;
const SIZE: u64 = 32;
const WRITTEN: u64 = 36;

/// Reads the buffer at the end.
struct Reader<F> {
    master: Master<F>,
    periods: u64,
    bytes: Vec<u8>,
}

fn word(view: &mut View<'_>, address: u64) -> u64 {
    view.word(address).expect("memory").into()
}

/// What a program has written into the buffer, up to its present end.
pub fn buffer(view: &mut View<'_>, program: &Firmware) -> Vec<u8> {
    let block = program.address("_SEGGER_RTT").expect("a symbol");
    let letters: Vec<u8> = (0..16 / 4)
        .flat_map(|k| (word(view, block + 4 * k) as u32).to_le_bytes())
        .collect();
    assert_eq!(&letters[..10], b"SEGGER RTT");
    let buffer = word(view, block + BUFFER);
    let written = word(view, block + WRITTEN);
    assert!(written < word(view, block + SIZE));
    (0..written)
        .map(|k| (word(view, (buffer + k) & !3) >> (8 * ((buffer + k) & 3))) as u8)
        .collect()
}

/// The lines of a log, with the strings of the program's ELF file.
pub fn lines(elf: &Path, bytes: &[u8]) -> Vec<String> {
    let elf = std::fs::read(elf).expect("the ELF was built");
    let table = defmt_decoder::Table::parse(&elf).expect("a table");
    let table = table.expect("a log");
    let mut decoder = table.new_stream_decoder();
    decoder.received(bytes);
    let mut lines = Vec::new();
    while let Ok(frame) = decoder.decode() {
        lines.push(frame.display_message().to_string());
    }
    println!("{lines:#?}");
    lines
}

impl<F: Fn(u64) -> Vec<Frame> + Send> Script for Reader<F> {
    fn at_edge(&mut self, view: &mut View<'_>) -> Flow {
        self.periods += 1;
        if self.periods == 500 {
            self.bytes = buffer(view, firmware());
        }
        self.master.at_edge(view)
    }
}

#[test]
fn the_log_decodes_with_the_strings_of_the_elf() {
    let script = Reader {
        master: Master::new(|tick| driven(tick, to_and_fro(tick))),
        periods: 0,
        bytes: Vec::new(),
    };
    let finished = run_script(Options::for_ms(600), script);
    let lines = lines(board_elf(), &finished.script.bytes);
    assert_eq!(
        lines,
        [
            "reset cause 0, parameters from 1, option bytes ffcaae1",
            "state 1, fault 0",
            "state 2, fault 0",
        ]
    );
}
