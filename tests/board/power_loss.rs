//! The supply fails in every operation of a save: afterwards the old parameters are there or the new.

use board_tests::frames::{Frame, order};
use board_tests::runs::{Commander, firmware};
use virtual_board::faults::{Fault, Planned};
use virtual_board::run::{Flow, Options, Script, View, run};

/// Which parameter is changed, by its number, and to what.
const NUMBER: u8 = 0;

fn schedule(tick: u64) -> Option<Frame> {
    match tick {
        30 => Some(Frame::write(NUMBER, 9.0_f32.to_bits())),
        40 => Some(Frame::command(0, order::SAVE)),
        _ => None,
    }
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
            if frame.id.value() == 0x381 && number == NUMBER && operation & 0x80 == 0 {
                self.value = Some(u32::from_le_bytes([a, b, c, d]));
            }
        }
        if ms.is_multiple_of(10) {
            let mut ask = Frame::write(NUMBER, 0);
            ask.data[0] = 0;
            port.send(now_ns, ask.on_the_wire());
        }
        if self.value.is_some() {
            Flow::End
        } else {
            Flow::On
        }
    }
}

fn run_with(faults: Vec<Planned>, ask_from_ms: u64) -> (Option<f32>, usize, usize) {
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
    let value = finished.script.value.map(f32::from_bits);
    (
        value,
        finished.flash_operations.len(),
        finished.resets.len(),
    )
}

#[test]
fn after_a_loss_of_supply_in_any_operation_of_a_save_a_valid_set_is_there() {
    let (saved, operations, _) = run_with(Vec::new(), 900);
    assert_eq!(saved, Some(9.0));
    assert!(operations > 20, "an erase and the words: {operations}");
    let default = {
        let (value, ..) = run_with(vec![Planned::at_ms(140, Fault::ResetPin)], 200);
        value.expect("it answers")
    };
    assert_ne!(default, 9.0);
    let mut kept = [0; 2];
    for operation in 0..operations as u64 {
        // A word takes 16 us, the erase the first 250 ms.
        let stages: &[u64] = if operation == 0 {
            &[0, 10, 130, 300, 500, 700, 900, 999]
        } else {
            &[500]
        };
        for &permille in stages {
            let cut = Fault::FlashCut {
                operation,
                permille,
            };
            let (value, _, resets) = run_with(vec![Planned::at_ms(1, cut)], 900);
            assert_eq!(resets, 1, "operation {operation}, {permille}");
            let value = value.expect("it answers");
            assert!(
                value == default || value == 9.0,
                "operation {operation}, {permille}: {value}"
            );
            kept[usize::from(value == 9.0)] += 1;
        }
    }
    println!(
        "{operations} operations: old {} times, new {} times",
        kept[0], kept[1]
    );
    assert!(kept[0] > 0);
}
