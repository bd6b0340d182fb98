//! Worst cases of the program: instructions of each call, and stack use.

use board_tests::frames::{Frame, Sent, sent, standard};
use board_tests::master::Master;
use board_tests::program::{firmware, run_script};
use board_tests::workloads::{TICKS, everything};
use static_bounds::Bounds;
use virtual_board::faults::{Fault, Planned};
use virtual_board::plant::BoardPlantOptions;
use virtual_board::run::{Flow, Options, Script, Span, View};

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
    let bounds = Bounds::of_the_board().expect("every loop has a bound");
    for (name, bound) in &bounds.times {
        if let Some(spans) = finished.spans.get(*name) {
            assert!(most(spans) <= bound.instructions, "{name}");
        }
    }
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
    assert!(need <= bounds.stack.total(), "{:?}", bounds.stack);
    assert!(margin_pct >= MARGIN_PCT, "{margin_pct} %");
}
