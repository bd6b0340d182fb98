//! Worst cases of the program: instructions of each call, and stack use.

use board_tests::frames::{
    Frame, LOAD, SAVE, Sent, control, nmt, read, sdo, sent, standard, start, write,
};
use board_tests::master::Master;
use board_tests::program::{firmware, run_script};
use virtual_board::faults::{Fault, Planned};
use virtual_board::plant::BoardPlantOptions;
use virtual_board::run::{Flow, Options, Script, Span, View};

use crate::bit_exact::command;

/// The interrupts that make up a control step without the node, and how often each runs in a tick.
const STEP: [(&str, u64); 3] = [("DMA2_STREAM0", 1), ("TIM1_UP_TIM10", 4), ("TIM1_CC", 3)];

/// The interrupt in which the node runs.
const NODE: &str = "UART7";

/// Instructions of a millisecond: a call of the node begins at a PWM edge and must end well before
/// the next one.
const MILLISECOND: u64 = 168_000;

/// Word that the start-up code fills the stack with (cortex-m-rt).
const PAINT: u32 = 0xcccc_cccc;

/// Minimum unused stack, percent of the used stack.
const MARGIN_PCT: u64 = 25;

/// Everything that takes long, one after the other: settings, saves with and without an erase,
/// defaults, excitations during a capture, uploads in segments and in a block that the client never
/// acknowledges, all with commands at 50 Hz; then a burst of commands at the full bus load, LSS,
/// and resets of communication and node in one call.
fn everything(tick: u64) -> Vec<Frame> {
    let excitation = tick.saturating_sub(1000);
    match tick {
        20 => vec![start()],
        60 | 400 => vec![write(0x1010, 1, SAVE, 4)],
        390 => vec![write(0x1017, 0, 500, 2)],
        700 => vec![read(0x1008, 0)],
        710 => vec![read(0x2031, 0)],
        720 => vec![write(0x2030, 3, 1, 1)],
        730 => vec![write(0x2030, 1, 1, 1)],
        1000..2000 => match excitation % 100 {
            0 => vec![write(0x2020, 3, (excitation / 100) as u32, 4)],
            3 => vec![write(0x2020, 1, 1, 1)],
            step if step % 5 == 1 => command(50),
            step if step % 5 == 4 => vec![read(0x6064, 0); 5],
            _ => Vec::new(),
        },
        // A block upload of the capture: 127 segments in one block.
        2010 => vec![upload_block(0x2032)],
        2012 => vec![begin_upload()],
        2100 => vec![control(0x0f, 1_000); 23],
        2101 => [
            vec![sdo([0x40, 0x18, 0x10, 1, 0, 0, 0, 0]); 8],
            vec![control(0x0f, 0); 15],
        ]
        .concat(),
        2150 => vec![
            standard(0x7e5, &[0x04, 1, 0, 0, 0, 0, 0, 0]),
            standard(0x7e5, &[0x17; 8]),
        ],
        2200 => vec![nmt(0x81), nmt(0x82), start()],
        2250 => vec![write(0x1011, 1, LOAD, 4)],
        2251.. => Vec::new(),
        _ if tick > 30 && tick.is_multiple_of(5) => command(tick % 2500),
        _ => Vec::new(),
    }
}

fn upload_block(index: u16) -> Frame {
    let [low, high] = index.to_le_bytes();
    sdo([0xa4, low, high, 0, 127, 0, 0, 0])
}

fn begin_upload() -> Frame {
    sdo([0xa3, 0, 0, 0, 0, 0, 0, 0])
}

/// Ticks of the run.
const TICKS: u64 = 2450;

/// Bytes of the stack that were never used.
fn untouched(view: &mut View<'_>) -> u64 {
    let lowest = firmware().address("_stack_end").expect("a symbol");
    let words = (lowest..).step_by(4);
    let painted = words.take_while(|address| view.word(*address) == Some(PAINT));
    4 * painted.count() as u64
}

/// Measures the stack at the end.
struct StackProbe<F> {
    master: Master<F>,
    untouched: u64,
}

impl<F: Fn(u64) -> Vec<Frame> + Send> Script for StackProbe<F> {
    fn at_edge(&mut self, view: &mut View<'_>) -> Flow {
        if self.master.tick() == Some(TICKS) {
            self.untouched = untouched(view);
        }
        self.master.at_edge(view)
    }
}

fn most(spans: &[Span]) -> u64 {
    spans
        .iter()
        .map(|span| span.instructions)
        .max()
        .unwrap_or(0)
}

#[test]
fn the_calls_of_the_node_end_in_their_periods_and_a_quarter_of_the_stack_is_unused() {
    let options = Options {
        plant: BoardPlantOptions::realistic(3),
        faults: vec![Planned::at_ms(8150, Fault::CanNoise { frames: 5 })],
        probes: (STEP.iter().map(|(name, _)| (*name).to_owned()))
            .chain([NODE, "gather", "device_control", "communicate"].map(str::to_owned))
            .collect(),
        ..Options::for_ms(4 * TICKS + 100)
    };
    let script = StackProbe {
        master: Master::new(everything),
        untouched: 0,
    };
    let finished = run_script(options, script);
    for (name, spans) in &finished.spans {
        let least = spans.iter().map(|span| span.instructions).min();
        println!(
            "{name:16} {:6} calls, {:6} to {:6} instructions",
            spans.len(),
            least.unwrap_or(0),
            most(spans)
        );
    }
    let operations = finished.flash_operations.len();
    assert!(operations > 400, "the saves did not run: {operations}");
    let sent = sent(&finished);
    let overrun = |sent: &&Sent| sent.frame.bytes().starts_with(&[0x10, 0x81]);
    assert_eq!(sent.iter().filter(overrun).count(), 0, "no frame was lost");
    let boot_up = standard(0x701, &[0]);
    let boots = sent.iter().filter(|sent| sent.frame == boot_up);
    assert_eq!(boots.count(), 3, "power-on and two resets");
    let step = STEP.map(|(name, times)| times * most(&finished.spans[name]));
    let call = most(&finished.spans[NODE]);
    println!(
        "the worst control step with its interrupts: {}, the longest call of the node: {call}",
        step.iter().sum::<u64>()
    );
    assert!(step.iter().sum::<u64>() < 5_000);
    assert!(call < MILLISECOND * 3 / 4, "{call}");

    let address = |name| firmware().address(name).expect("a symbol");
    let size = address("_stack_start") - address("_stack_end");
    let need = size - finished.script.untouched;
    let margin_pct = 100 * finished.script.untouched / need;
    println!("stack: {need} bytes of {size} needed, {margin_pct} % left over");
    assert!(finished.script.untouched > 0, "the stack was used up");
    assert!(margin_pct >= MARGIN_PCT, "{margin_pct} %");
}
