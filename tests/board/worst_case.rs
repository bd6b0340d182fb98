//! Worst cases of the program: instructions of each handler, and stack use.

use board_tests::frames::{Frame, Sent, sent, standard};
use board_tests::master::Master;
use board_tests::program::{LOOP_PRIORITY, firmware, handlers, run_script};
use board_tests::workloads::{TICKS, everything};
use virtual_board::board::CORE_HZ;
use virtual_board::faults::{Fault, Planned};
use virtual_board::plant::BoardPlantOptions;
use virtual_board::run::{Finished, Flow, Handler, Options, Script, Span, View};

/// The task in which the node runs.
const NODE: &str = "communication_cycle";

/// Instructions of half a control period: what the communication may take of it.
const HALF_A_PERIOD: u64 = CORE_HZ / 500;

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

/// Most difference between two starts of the control step, counted from the first PWM edge of its
/// control period: the encoder's transfer ends at a fixed time behind it, and nothing but a PWM
/// edge or a sampling instant, which are never due then, has the priority of the step.
const JITTER_NS: u64 = 2_000;

/// The earliest and the latest start of a control step after a PWM edge.
fn starts_ns<S>(finished: &Finished<S>) -> (u64, u64) {
    let rows = &finished.trace.rows;
    let since_edge = |span: &Span| {
        let edge = rows.partition_point(|row| row.at_ns <= span.at_ns);
        Some(span.at_ns - rows.get(edge.checked_sub(1)?)?.at_ns)
    };
    let handlers = handlers();
    let step = handlers.iter().find(|it| it.task == "control_step");
    let spans = &finished.spans[&step.expect("listed").interrupt];
    let starts: Vec<u64> = spans.iter().filter_map(since_edge).collect();
    let ends = starts.iter().min().zip(starts.iter().max());
    ends.map_or((0, 0), |(least, most)| (*least, *most))
}

#[test]
fn the_communication_ends_in_its_period_delays_no_step_and_a_quarter_of_the_stack_is_unused() {
    let handlers = handlers();
    let interrupts = handlers.iter().map(|handler| handler.interrupt.clone());
    let options = Options {
        plant: BoardPlantOptions::realistic(3),
        faults: vec![Planned::at_ms(8150, Fault::CanNoise { frames: 5 })],
        probes: interrupts.collect(),
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
    let longest = |handler: &&Handler| most(&finished.spans[&handler.interrupt]);
    let of_the_loop = handlers.iter().filter(|it| it.priority == LOOP_PRIORITY);
    let sum: u64 = of_the_loop.map(|it| it.runs * longest(&it)).sum();
    let node = handlers.iter().find(|it| it.task == NODE).expect("listed");
    let cycle = longest(&node);
    println!(
        "the loop, each handler in its longest run: {sum}, the longest communication cycle: {cycle}"
    );
    assert!(sum < 13_500, "{sum}");
    assert!(cycle < HALF_A_PERIOD, "{cycle}");

    let (least_ns, most_ns) = starts_ns(&finished);
    println!("the control step starts {least_ns} to {most_ns} ns after the edge");
    assert!(most_ns - least_ns < JITTER_NS, "{least_ns} to {most_ns}");

    let address = |name| firmware().address(name).expect("a symbol");
    let size = address("_stack_start") - address("_stack_end");
    let need = size - finished.script.untouched;
    let margin_pct = 100 * finished.script.untouched / need;
    println!("stack: {need} bytes of {size} needed, {margin_pct} % left over");
    assert!(finished.script.untouched > 0, "the stack was used up");
    assert!(margin_pct >= MARGIN_PCT, "{margin_pct} %");
}
