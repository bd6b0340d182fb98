//! The checks of the drivers pass on both chips, and find defects that are seeded around the chip.

use board_tests::program::run_program;
use cross_build::{driver_checks_elf, driver_checks_h743_elf};
use virtual_board::board::ChipKind;
use virtual_board::faults::{Fault, Planned};
use virtual_board::plant::{EncoderWire, Stuck};
use virtual_board::run::{Firmware, Flow, Options, Script, View};

/// Results of encoder, bridge, CAN controller and store, as the program has them: 0 before its end,
/// 1 if it passed, otherwise 256 plus the number of the step that failed.
type Results = [u32; 4];

const PASSED: u32 = 1;

/// Runs the checks with these faults until `is_over` or 20 s have passed.
fn run(chip: ChipKind, faults: Vec<Fault>, is_over: fn(&Results) -> bool) -> Results {
    let elf = match chip {
        ChipKind::F427 => driver_checks_elf(),
        ChipKind::H743 => driver_checks_h743_elf(),
    };
    let program = Firmware::read(elf).expect("an ELF file");
    let address = program.address("DRIVER_CHECKS").expect("the results");
    let options = Options {
        chip,
        faults: faults
            .into_iter()
            .map(|fault| Planned::at_ms(0, fault))
            .collect(),
        keeps_trace: false,
        ..Options::for_ms(20_000)
    };
    let script = Watching {
        address,
        is_over,
        results: Results::default(),
    };
    run_program(&program, options, script).script.results
}

/// Reads the results at each edge.
struct Watching {
    address: u64,
    is_over: fn(&Results) -> bool,
    results: Results,
}

impl Script for Watching {
    fn at_edge(&mut self, view: &mut View<'_>) -> Flow {
        for (result, word) in self.results.iter_mut().zip((self.address..).step_by(4)) {
            *result = view.word(word).expect("memory");
        }
        if (self.is_over)(&self.results) {
            Flow::End
        } else {
            Flow::Continue
        }
    }
}

#[test]
fn the_drivers_pass_their_checks_on_both_chips() {
    for chip in [ChipKind::F427, ChipKind::H743] {
        let results = run(chip, Vec::new(), |results| {
            results.iter().all(|result| *result != 0)
        });
        assert_eq!(results, [PASSED; 4], "{chip:?}");
    }
}

#[test]
fn a_broken_encoder_wire_and_a_break_input_that_is_low_are_found_on_both_chips() {
    let broken = Fault::EncoderWire {
        line: EncoderWire::Data,
        stuck: Stuck::Low,
    };
    for chip in [ChipKind::F427, ChipKind::H743] {
        let results = run(chip, vec![broken.clone(), Fault::BridgeTrip], |results| {
            results[1] != 0
        });
        // No valid word; not driven.
        assert_eq!(results[..2], [256 + 2, 256 + 2], "{chip:?}");
    }
}
