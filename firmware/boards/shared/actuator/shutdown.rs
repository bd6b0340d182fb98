//! The parts of a shutdown that need the chip: the restart, its mark, and the brake at the start of
//! a corrupt program.

use cortex_m::{asm::delay, peripheral::SCB};
use drivers::bridge::Bridge as _;
use firmware::shutdown::{BRAKING_PERIODS, RESTART_MARK};

use super::{
    timing::{CONTROL_RATE_HZ, CORE_HZ},
    watchdog_supervisor::WatchdogSupervisor,
};
use crate::peripherals::{ActuatorBridge, backup};

/// Restarts the processor at the end of a shutdown. The mark depends on nothing: a program that
/// gets here otherwise restarts in the same way, and brakes.
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

/// Brakes for at least as long as a shutdown, before the tasks start of a program that is not as
/// built: its control step may fail in each start, and the motor would be free between the resets
/// by the watchdog. The counter of the bridge's timer has not started, and both compare values are
/// 0: the low sides are closed.
pub fn brake_before_the_tasks(bridge: &mut ActuatorBridge, watchdog: &mut WatchdogSupervisor) {
    bridge.brake();
    bridge.begin_pwm_period();
    for _ in 0..BRAKING_PERIODS {
        watchdog.feed();
        delay(CORE_HZ / CONTROL_RATE_HZ);
    }
}
