//! The bring-up of an actuator board: what `firmware::bring_up` judges is measured here.

mod bench;
mod bus;
mod report;
mod steps;

use firmware::{
    bring_up::{BringUp, Step},
    supervisor::ResetCause,
};

use self::bench::{Bench, PERIODS_PER_MS};
use crate::{
    chip::pac::Interrupt,
    peripherals::{backup, wiring::Peripherals},
};

/// Upper bytes of the backup register while the watchdog is tested; the lowest one holds the time
/// since its start, ms.
const WATCHDOG_MARK: u32 = 0x7a5d_3c00;

/// Time without a reset after which the watchdog is dead, ms.
const WATCHDOG_TEST_MS: u32 = 100;

/// Runs the steps in their order until one fails; then the bridge is off. `mark` is the content of
/// the backup register at the start, and the interrupts are those of the bridge's timer.
pub fn run(peripherals: Peripherals, mark: u32, wakers: [Interrupt; 2]) -> ! {
    let is_watchdog = peripherals.reset_cause == ResetCause::Watchdog;
    let elapsed_ms = (mark & !0xff == WATCHDOG_MARK && is_watchdog).then_some(mark & 0xff);
    let mut bench = Bench::new(peripherals, wakers);
    let mut bring_up = BringUp::default();
    while let Some(step) = bring_up.next() {
        report::begin(step);
        let measured = match (step, elapsed_ms) {
            (Step::Watchdog, Some(ms)) => ms as i32,
            (Step::Watchdog, None) => starve_watchdog(&mut bench),
            _ => steps::measure(step, &mut bench),
        };
        bench.switch_off();
        report::end(step, measured, bring_up.judge(measured));
    }
    report::finish(bring_up.is_complete());
    loop {
        bench.switch_off();
        bench.next_period();
    }
}

/// Starts the watchdog and does not feed it. It resets the processor; if it does not, returns the
/// time for which it should have.
fn starve_watchdog(bench: &mut Bench) -> i32 {
    bench.start_watchdog();
    // Its time takes effect when it is fed after some cycles of its oscillator.
    (0..2 * PERIODS_PER_MS).for_each(|_| bench.next_period());
    for ms in 0..WATCHDOG_TEST_MS {
        backup::write(WATCHDOG_MARK | ms);
        (0..PERIODS_PER_MS).for_each(|_| bench.wait_for_edge());
    }
    backup::write(0);
    WATCHDOG_TEST_MS as i32
}
