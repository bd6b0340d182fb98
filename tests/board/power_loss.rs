//! The supply fails in every operation of a save: afterwards the old parameters are there or the new.

use board_tests::frames::{BoardFrame, Frame, order};
use board_tests::runs::{Commander, Schedule, firmware, run_schedule, statuses};
use firmware::faults::Fault as Told;
use firmware::parameters::BoardParameters;
use virtual_board::faults::{Fault, Planned};
use virtual_board::flash::Operation;
use virtual_board::rig::Bridge;
use virtual_board::run::{Flow, Options, Script, View, run};

/// The over-current limit as it is by default, and as it is saved one time after the other, mA.
const LIMITS_MA: [u32; 3] = [
    BoardParameters::DEFAULT.current.over_current_ma as u32,
    1234,
    1235,
];

/// Its number.
fn number() -> u8 {
    let is_it = |number: &u8| {
        let meaning = BoardParameters::meaning(*number);
        meaning.is_some_and(|meaning| meaning.name() == "over_current_ma")
    };
    (0..128).find(is_it).expect("it has a number")
}

/// Writes the limit of this number at a tick, and saves it a little later.
fn save(tick: u64, at: u64, limit: usize) -> Option<Frame> {
    match tick.checked_sub(at)? {
        0 => Some(Frame::write(number(), LIMITS_MA[limit])),
        10 => Some(Frame::command(0, order::SAVE)),
        _ => None,
    }
}

/// When the first save is over: two control periods a word.
const FIRST_SAVE_MS: u64 = 800;

/// When the second is, with up to 500 ms for the erase.
const TWO_SAVES_MS: u64 = 2000;

fn first_save(tick: u64) -> Option<Frame> {
    save(tick, 30, 1)
}

/// The second save erases the other page first.
fn two_saves(tick: u64) -> Option<Frame> {
    save(tick, 30, 1).or_else(|| save(tick, 190, 2))
}

/// Reads the parameter by frames at the end, or some time after the supply has come back.
struct Asker {
    commander: Commander,
    ask_from_ms: u64,
    value: Option<u32>,
}

/// From power-on until the board has started and measured, ms.
const STARTED_MS: u64 = 60;

impl Script for Asker {
    fn at_edge(&mut self, view: &mut View<'_>) -> Flow {
        let now_ns = view.now_ns();
        let ms = now_ns / 1_000_000;
        if view.resets() > 0 {
            self.ask_from_ms = self.ask_from_ms.min(ms + STARTED_MS);
        }
        if ms < self.ask_from_ms {
            return self.commander.at_edge(view);
        }
        let Some(port) = view.port(0) else {
            return Flow::End;
        };
        for (_, frame) in port.take_heard() {
            let [operation, number, _, _, a, b, c, d] = frame.data;
            if frame.id.value() == 0x381 && number == self::number() && operation == 0 {
                self.value = Some(u32::from_le_bytes([a, b, c, d]));
            }
        }
        if ms.is_multiple_of(10) {
            port.send(now_ns, Frame::read(self::number()).on_the_wire());
        }
        if self.value.is_some() {
            Flow::End
        } else {
            Flow::On
        }
    }
}

/// A CRC that stands by half cannot be told from a page that has gone bad.
#[test]
fn a_first_save_that_was_cut_in_its_crc_is_told_as_corrupt_parameters_and_the_board_stays_off() {
    let (_, operations, _) = run_with(first_save, Vec::new(), FIRST_SAVE_MS);
    let cut = Fault::FlashCut {
        operation: operations.len() as u64 - 1,
        permille: 500,
    };
    let options = Options {
        faults: vec![Planned::at_ms(1, cut)],
        ..Options::for_ms(FIRST_SAVE_MS + 400)
    };
    let finished = run_schedule(options, first_save);
    let reset_ns = finished.resets.first().expect("the supply came back").at.0;
    let told = statuses(&finished);
    let mut after = told.iter().filter(|(at_ns, _)| *at_ns > reset_ns);
    let (_, last) = after.next_back().expect("the board tells something");
    assert_eq!(u16::from(last.fault), Told::ParametersCorrupt.number());
    let rows = finished.trace.rows.iter();
    assert!(rows.clone().any(|row| row.at_ns > reset_ns));
    for row in rows.filter(|row| row.at_ns > reset_ns) {
        assert_eq!(row.bridge, Bridge::Coast, "{} ns", row.at_ns);
    }
}

fn run_with(
    schedule: Schedule,
    faults: Vec<Planned>,
    ask_from_ms: u64,
) -> (Option<u32>, Vec<Operation>, usize) {
    let options = Options {
        faults,
        ..Options::for_ms(ask_from_ms + 500)
    };
    let script = Asker {
        commander: Commander::new(schedule),
        ask_from_ms,
        value: None,
    };
    let finished = run(firmware(), options, script).expect("it runs");
    assert!(finished.gaps.is_empty(), "{}", finished.gaps);
    let value = finished.script.value;
    (value, finished.flash_operations, finished.resets.len())
}

/// Cuts the supply in every operation from `first` on, and counts which of two sets is there then.
fn cut_everywhere(schedule: Schedule, sets: [u32; 2], first: usize, end_ms: u64) -> [u32; 2] {
    let (saved, operations, _) = run_with(schedule, Vec::new(), end_ms);
    assert_eq!(saved, Some(sets[1]));
    let mut kept = [0; 2];
    for (number, operation) in operations.iter().enumerate().skip(first) {
        let stages: &[u64] = match operation {
            Operation::Erase { .. } => &[0, 10, 130, 300, 500, 700, 900, 999],
            Operation::Program { .. } => &[500],
        };
        for &permille in stages {
            let cut = Fault::FlashCut {
                operation: number as u64,
                permille,
            };
            let (value, _, resets) = run_with(schedule, vec![Planned::at_ms(1, cut)], end_ms);
            assert_eq!(resets, 1, "operation {number}, {permille}");
            let set = sets.iter().position(|set| Some(*set) == value);
            let set = set.unwrap_or_else(|| panic!("operation {number}, {permille}: {value:?}"));
            kept[set] += 1;
        }
    }
    println!("old {} times, new {} times", kept[0], kept[1]);
    kept
}

#[test]
fn after_a_loss_of_supply_in_any_word_of_the_first_save_a_valid_set_is_there() {
    let kept = cut_everywhere(first_save, [LIMITS_MA[0], LIMITS_MA[1]], 0, FIRST_SAVE_MS);
    assert!(kept[0] > 20, "{kept:?}");
}

#[test]
fn after_a_loss_of_supply_in_an_erase_or_a_word_after_it_a_valid_set_is_there() {
    let (_, operations, _) = run_with(two_saves, Vec::new(), TWO_SAVES_MS);
    let is_erase = |operation: &Operation| matches!(operation, Operation::Erase { .. });
    let erase = operations
        .iter()
        .position(is_erase)
        .expect("a page that may have held something is erased");
    let kept = cut_everywhere(two_saves, [LIMITS_MA[1], LIMITS_MA[2]], erase, TWO_SAVES_MS);
    assert!(kept[0] > 8, "{kept:?}");
}
