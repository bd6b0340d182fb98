//! The parts of a shutdown that need the chip: the restart, its mark, and the brake at the start of
//! a corrupt program.

use cortex_m::{
    asm::delay,
    peripheral::{DWT, SCB},
};
use drivers::bridge::Bridge as _;
use firmware::replicated::{BRAKING_PERIODS, RESTART_MARK};

use super::{
    timing::{CONTROL_RATE_HZ, CORE_HZ},
    watchdog_supervisor::WatchdogSupervisor,
};
use crate::peripherals::{ActuatorBridge, backup};

/// Restarts the processor at the end of a shutdown. The mark is constant, so that a program that
/// jumps here by a skipped instruction restarts in the same way.
pub fn restart() -> ! {
    backup::write(RESTART_MARK);
    SCB::sys_reset()
}

/// Whether the last reset was the end of a shutdown, once. The clock of the power controller is
/// enabled.
pub fn take_mark() -> bool {
    let mark = backup::read();
    backup::write(0);
    mark == RESTART_MARK
}

/// Brakes for as long as a shutdown before a program that is not as built starts its tasks: its
/// control step may fail after each start, and the motor would be free between the resets by the
/// watchdog. The counter of the bridge's timer has not started, and both compare values are 0: the
/// low sides are closed.
pub fn brake_before_the_tasks(bridge: &mut ActuatorBridge, watchdog: &mut WatchdogSupervisor) {
    bridge.brake();
    bridge.begin_pwm_period();
    for _ in 0..BRAKING_PERIODS {
        watchdog.feed();
        wait_for_a_control_period();
    }
}

/// By the cycle counter, which the supervisor has started, as the cycles of a loop depend on the
/// core. If the counter does not count, the watchdog resets the processor.
fn wait_for_a_control_period() {
    const POLL_HZ: u32 = 100_000;
    let start = DWT::cycle_count();
    while DWT::cycle_count().wrapping_sub(start) < CORE_HZ / CONTROL_RATE_HZ {
        delay(CORE_HZ / POLL_HZ);
    }
}
