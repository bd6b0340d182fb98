//! How much of the stack the program needs, with everything that it does at once.

use board_tests::frames::{BoardFrame, Frame, order};
use board_tests::runs::{Commander, firmware, run_script};
use virtual_board::faults::{Fault, Planned};
use virtual_board::run::{Firmware, Flow, Options, Script, View};

/// What the start-up paints the stack with (cortex-m-rt).
const PAINT: u32 = 0xcccc_cccc;

/// What stays free at the least, percent of what is needed.
pub const MARGIN_PCT: u64 = 25;

/// Numbers and orders of the excitation and the capture (`firmware::service`, `firmware::frames`).
const SHAPE: u8 = 128;
const TRIGGER: u8 = 169;
const RESTORE_DEFAULTS: u8 = 8;
const START_EXCITATION: u8 = 9;
const START_CAPTURE: u8 = 11;

/// Two saves, the second with an erase, while the loop is closed; then each excitation under a capture; then
/// the defaults.
fn everything(tick: u64) -> Option<Frame> {
    let excitation = tick.saturating_sub(700);
    let order = |order| Some(Frame::command(0, order));
    match tick {
        30 => order(order::ENABLE),
        60 => Some(Frame::write(0, 9_f32.to_bits())),
        70 | 300 => order(order::SAVE),
        290 => Some(Frame::write(0, 8.5_f32.to_bits())),
        600 => Some(Frame::write(TRIGGER, 1)),
        610 => order(START_CAPTURE),
        700..1700 => match excitation % 100 {
            0 => Some(Frame::write(SHAPE, (excitation / 100) as u32)),
            3 => order(START_EXCITATION),
            step if step % 5 == 1 => Some(Frame::command(0, order::NONE)),
            step if step % 5 == 4 => Some(Frame::read(0)),
            _ => None,
        },
        1700 => order(order::DISABLE),
        1710 => order(RESTORE_DEFAULTS),
        _ => (tick > 30 && tick.is_multiple_of(5)).then(|| Frame::command(10_000, order::NONE)),
    }
}

/// Ticks of the run.
const TICKS: u64 = 1750;

/// Bytes of the stack that were never in use.
pub fn untouched(firmware: &Firmware, view: &mut View<'_>) -> u64 {
    let lowest = firmware.address("_stack_end").expect("a symbol");
    let words = (lowest..).step_by(4);
    let painted = words.take_while(|address| view.word(*address) == Some(PAINT));
    4 * painted.count() as u64
}

/// Looks at the paint in the end.
struct Looking {
    commander: Commander,
    periods: u64,
    untouched: u64,
}

impl Script for Looking {
    fn at_edge(&mut self, view: &mut View<'_>) -> Flow {
        self.periods += 1;
        if self.periods == 4 * TICKS {
            self.untouched = untouched(firmware(), view);
        }
        self.commander.at_edge(view)
    }
}

#[test]
fn a_quarter_of_what_the_stack_needs_is_left_over() {
    let options = Options {
        // An interrupt more in the middle of everything: the bus fails and comes back.
        faults: vec![Planned::at_ms(6950, Fault::CanNoise { frames: 5 })],
        keeps_trace: true,
        ..Options::for_ms(4 * TICKS + 100)
    };
    let script = Looking {
        commander: Commander::new(everything),
        periods: 0,
        untouched: 0,
    };
    let finished = run_script(options, script);
    let operations = finished.flash_operations.len();
    assert!(operations > 100, "the saves did not run: {operations}");
    let address = |name| firmware().address(name).expect("a symbol");
    let size = address("_stack_start") - address("_stack_end");
    let need = size - finished.script.untouched;
    let margin_pct = 100 * finished.script.untouched / need;
    println!("stack: {need} bytes of {size} needed, {margin_pct} % left over");
    assert!(finished.script.untouched > 0, "it was used up");
    assert!(margin_pct >= MARGIN_PCT, "{margin_pct} %");
}
