//! The bounds of the actuator board's program.

use std::fs;

use object::{Object, ObjectSymbol};
use static_bounds::{Bounds, Error};

/// Cycles from a PWM edge to the control step, in which the encoder is read: 38 us
/// (`docs/hardware.md`, timing of a tick).
const ENCODER_READ: u64 = 38 * 168;
/// Cycles of a PWM period: the control step ends before the next edge, at which its duty takes
/// effect.
const PWM_PERIOD: u64 = 168_000;
/// Bytes of the stack (`memory.x`).
const STACK: u64 = 32 * 1024;

const LOOPS: &str = include_str!("../loops.txt");

fn cycles_without_caches(bounds: &Bounds, handler: &str) -> u64 {
    let (_, cost) = bounds
        .times
        .iter()
        .find(|(name, _)| *name == handler)
        .unwrap();
    cost.cycles_without_caches()
}

#[test]
fn for_all_inputs_the_control_step_ends_before_the_next_pwm_edge_and_the_stack_suffices() {
    let bounds = Bounds::of_the_board().unwrap();
    print!("{}", bounds.document());
    // Preempted by the reception of three frames, the depth of the FIFO: below 500 cycles each.
    let frames = 3 * 500;
    let step = cycles_without_caches(&bounds, "DMA2_STREAM0");
    assert!(ENCODER_READ + step + frames < PWM_PERIOD, "{step}");
    assert!(bounds.stack.total() < STACK, "{:?}", bounds.stack);
}

/// The loops of the checksum have a bound each by the size of what they cover.
#[test]
fn the_device_is_not_larger_than_the_bounds_of_its_checksum_assume() {
    let elf = fs::read(cross_build::board_elf()).unwrap();
    let elf = object::File::parse(&*elf).unwrap();
    let device = elf.symbols().find(|symbol| {
        let name = symbol.name().unwrap_or_default();
        name.contains("__rtic_internal_local_init_device")
    });
    let bytes = device.expect("the device has a symbol").size();
    assert!(bytes <= 5_376, "{bytes}");
    assert!(LOOPS.contains("at most 5,376 bytes"));
}

#[test]
fn a_loop_without_a_bound_is_refused_with_its_function() {
    let elf = fs::read(cross_build::board_elf()).unwrap();
    let without_latch: String = LOOPS
        .lines()
        .filter(|line| !line.contains("FaultLog::latch"))
        .map(|line| format!("{line}\n"))
        .collect();
    let error = Bounds::new(&elf, &[], &without_latch).unwrap_err();
    let Error::Loops {
        function,
        found,
        expected,
    } = error
    else {
        panic!("{error}");
    };
    assert!(function.ends_with("Drive::step"), "{function}");
    assert_eq!((found.len(), expected), (3, 2));
}
