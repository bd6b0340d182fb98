//! The result of each step: in the log, and in memory for a debugger.

use core::sync::atomic::{AtomicI32, AtomicU32, Ordering::Relaxed};

use firmware::bring_up::{NOT_MEASURED, Step, Verdict};

const STEPS: usize = Step::ALL.len();

/// Number of the step that runs, from 1; [`ENDED`] when none does any more.
#[unsafe(no_mangle)]
static BRING_UP_STEP: AtomicU32 = AtomicU32::new(0);
/// Verdict of each step.
#[unsafe(no_mangle)]
static BRING_UP_VERDICTS: [AtomicU32; STEPS] = [const { AtomicU32::new(0) }; STEPS];
/// Measurement of each step.
#[unsafe(no_mangle)]
static BRING_UP_MEASURED: [AtomicI32; STEPS] = [const { AtomicI32::new(NOT_MEASURED) }; STEPS];

/// `BRING_UP_STEP` after the last step.
const ENDED: u32 = 255;

/// A step begins.
pub fn begin(step: Step) {
    BRING_UP_STEP.store(step as u32 + 1, Relaxed);
    match step {
        Step::Break => defmt::info!("now pull BREAK_N to ground, or lift SENSE_F above 120 mV"),
        Step::CanBus => defmt::info!("now a CAN adapter at 1 Mbit/s must acknowledge"),
        Step::ShaftByHand => defmt::info!("now turn the shaft by hand by an eighth of a turn"),
        _ => {}
    }
}

/// A step has ended.
pub fn end(step: Step, measured: i32, verdict: Verdict) {
    let number = step as usize;
    if let Some(slot) = BRING_UP_MEASURED.get(number) {
        slot.store(measured, Relaxed);
    }
    if let Some(slot) = BRING_UP_VERDICTS.get(number) {
        slot.store(verdict as u32, Relaxed);
    }
    let (least, most) = step.range();
    let (number, name) = (number as u32 + 1, step.name());
    if verdict == Verdict::Passed {
        defmt::info!(
            "{=u32} {=str}: passed, {=i32} in {=i32}..={=i32}",
            number,
            name,
            measured,
            least,
            most
        );
    } else {
        defmt::error!(
            "{=u32} {=str}: FAILED, {=i32} not in {=i32}..={=i32}",
            number,
            name,
            measured,
            least,
            most
        );
    }
}

/// No step follows.
pub fn finish(is_complete: bool) {
    if is_complete {
        defmt::info!("all steps passed: the motor may be connected, with the supply off");
    } else {
        defmt::error!("do not connect a motor");
    }
    BRING_UP_STEP.store(ENDED, Relaxed);
}
