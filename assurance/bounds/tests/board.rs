//! The bounds of the actuator board's program.

use std::fs;

use board_tests::master::Master;
use board_tests::program::run_script;
use board_tests::workloads::{TICKS, everything};
use program_handlers::{STEP_BEGINS_US, handlers};
use static_bounds::{Bounds, Error, HandlerBound};
use virtual_board::board::CORE_HZ;
use virtual_board::plant::BoardPlantOptions;
use virtual_board::run::Options;

/// Cycles of a PWM period: the control step ends before the next edge, at which its duty takes
/// effect.
const PWM_PERIOD: u64 = CORE_HZ / 1000;
/// Bytes of the stack (`memory.x`).
const STACK: u64 = 32 * 1024;

const LOOPS: &str = include_str!("../loops.txt");

#[test]
fn for_all_inputs_the_control_step_ends_before_the_next_pwm_edge_and_the_stack_suffices() {
    let bounds = Bounds::of_the_board().unwrap();
    print!("{}", bounds.document());
    // A task of a lower priority locks it out for the exchange of two references.
    let locked = 100;
    let mut handlers = bounds.times.iter();
    let step = handlers.find(|bound| bound.handler.task == "control_step");
    let step = step.unwrap().cost.cycles_without_caches();
    let before = STEP_BEGINS_US * PWM_PERIOD / 1000;
    assert!(before + step + locked < PWM_PERIOD, "{step}");
    assert!(bounds.stack.total() < STACK, "{:?}", bounds.stack);
}

/// The worst cases of all inputs are not less than those of many: of every service of the board.
#[test]
fn no_handler_executes_more_instructions_than_its_bound_or_runs_more_often_than_assumed() {
    let bounds = Bounds::of_the_board().unwrap();
    let name = |bound: &HandlerBound| bound.handler.interrupt.clone();
    let options = Options {
        plant: BoardPlantOptions::realistic(3),
        keeps_trace: false,
        probes: bounds.times.iter().map(name).collect(),
        ..Options::for_ms(4 * TICKS)
    };
    let finished = run_script(options, Master::new(everything));
    let spans = |bound: &HandlerBound| &finished.spans[&name(bound)];
    let step = bounds
        .times
        .iter()
        .find(|bound| bound.handler.task == "control_step")
        .unwrap();
    let periods = spans(step).len() as u64;
    for bound in &bounds.times {
        let most = spans(bound).iter().map(|span| span.instructions).max();
        assert!(most <= Some(bound.cost.instructions), "{bound:?}: {most:?}");
        // The first control period is not whole, and resets interrupt others.
        let runs = spans(bound).len() as u64;
        assert!(
            runs <= bound.handler.runs * (periods + 4),
            "{bound:?}: {runs}"
        );
    }
}

#[test]
fn the_handlers_of_the_program_are_those_of_its_vector_table() {
    let elf = fs::read(cross_build::board_elf()).unwrap();
    let found = handlers(&elf).unwrap();
    let step = found.iter().find(|it| it.task == "control_step").unwrap();
    // Stream 0 of DMA2 is interrupt 56 of the STM32F427 (RM0090, table 62).
    assert_eq!(
        ("DMA2_STREAM0", 16 + 56),
        (&*step.interrupt, step.exception)
    );
    let error = handlers(&elf[..100]).unwrap_err();
    assert!(matches!(error, program_handlers::Error::Elf(_)), "{error}");
}

#[test]
fn a_loop_without_a_bound_is_refused_with_its_function() {
    let elf = fs::read(cross_build::board_elf()).unwrap();
    let without_latch: String = LOOPS
        .lines()
        .filter(|line| !line.contains("Application::latch"))
        .map(|line| format!("{line}\n"))
        .collect();
    let error = Bounds::new(&elf, &without_latch).unwrap_err();
    let Error::Loops {
        function,
        found,
        expected,
    } = error
    else {
        panic!("{error}");
    };
    assert!(function.ends_with("Loop::step"), "{function}");
    assert_eq!((found.len(), expected), (1, 0));
}
