//! The measurement of each step.

use drivers::bridge::{Bridge as _, Command, PwmTimer as _};
use firmware::bring_up::{DUTY, NOT_MEASURED, PATIENCE_MS, REPETITIONS, Step, Way};
use model_core::control::{pwm_timer::Modulator, units::Percent};

use super::{
    bench::{Bench, PERIODS_PER_MS, Sample, Scan},
    bus,
};

/// Samples whose mean is taken.
const SAMPLES: i32 = 16;

/// Update periods for which nothing may trip the bridge.
const QUIET_PERIODS: i32 = 20;

/// Measures a step.
pub fn measure(step: Step, bench: &mut Bench) -> i32 {
    match step {
        // The caller tests it.
        Step::Watchdog => NOT_MEASURED,
        Step::Supply => {
            // From here on the watchdog supervises the bring-up.
            bench.start_watchdog();
            mean(bench, |sample| Some(sample.supply_mv))
        }
        Step::Temperature => mean(bench, |sample| sample.temperature_mdeg_c),
        Step::CurrentAtRest => mean(bench, |sample| Some(sample.current_ma)),
        Step::LegAAtRest => mean(bench, |sample| Some(sample.legs[0])),
        Step::LegBAtRest => mean(bench, |sample| Some(sample.legs[1])),
        Step::Encoder => (0..REPETITIONS).filter(|_| bench.angle().is_some()).count() as i32,
        Step::EncoderAtRest => spread(bench),
        Step::BreakReleased => trips(bench),
        Step::Forward => driven(bench, DUTY),
        Step::Backward => driven(bench, -DUTY),
        Step::NoMotor => bench.greatest_ma,
        Step::Break => tripped(bench),
        Step::CanController => bus::looped_back(bench),
        Step::CanBus => bus::acknowledged(bench),
        Step::ShaftByHand => turned(bench),
        Step::BrownOut => bench.brown_out_level,
    }
}

/// The mean of a quantity with open switches.
fn mean(bench: &mut Bench, of: impl Fn(&Sample) -> Option<i32>) -> i32 {
    let mut sum = 0;
    for _ in 0..SAMPLES {
        match bench.sample(Scan::Open).as_ref().and_then(&of) {
            // At most 16 times 160,000.
            Some(value) => sum += value,
            None => return NOT_MEASURED,
        }
    }
    sum / SAMPLES
}

/// Counts between the extreme readings of a shaft at rest, across zero too.
fn spread(bench: &mut Bench) -> i32 {
    let (mut way, mut greatest) = (Way::default(), 0);
    for _ in 0..REPETITIONS {
        let reading = bench.angle();
        match reading.and_then(|reading| way.add(reading.count.get())) {
            Some(distance) => greatest = distance,
            None => return NOT_MEASURED,
        }
    }
    greatest
}

/// Trips while nothing trips the bridge.
fn trips(bench: &mut Bench) -> i32 {
    bench.bridge.take_trip();
    (0..QUIET_PERIODS)
        .filter(|_| {
            bench.next_period();
            bench.bridge.take_trip()
        })
        .count() as i32
}

fn command(duty: Percent) -> Command {
    Command::Driven(Modulator::default().next(duty))
}

/// Leg A less leg B in the on time at this duty.
fn driven(bench: &mut Bench, duty: Percent) -> i32 {
    bench.drive(command(duty));
    // The duty takes effect, and the legs settle.
    bench.next_period();
    let mut sum = 0;
    for _ in 0..SAMPLES {
        let Some(sample) = bench.sample(Scan::Driven) else {
            return NOT_MEASURED;
        };
        if bench.bridge.take_trip() {
            return NOT_MEASURED;
        }
        bench.greatest_ma = bench.greatest_ma.max(sample.current_ma.abs());
        let [leg_a, leg_b] = sample.legs;
        sum += leg_a - leg_b;
    }
    sum / SAMPLES
}

/// Waits for a trip while the bridge is driven; 1 if the hardware has opened the switches then.
fn tripped(bench: &mut Bench) -> i32 {
    bench.drive(command(DUTY));
    bench.next_period();
    for _ in 0..PATIENCE_MS * PERIODS_PER_MS {
        bench.wait_for_edge();
        let timer = bench.bridge.timer();
        if timer.has_tripped() {
            let is_off = !timer.are_outputs_on();
            bench.switch_off();
            return if is_released(bench) {
                i32::from(is_off)
            } else {
                NOT_MEASURED
            };
        }
        bench.begin_period();
    }
    0
}

/// Waits until the break input is high again.
fn is_released(bench: &mut Bench) -> bool {
    (0..PATIENCE_MS * PERIODS_PER_MS).any(|_| {
        bench.next_period();
        !bench.bridge.take_trip()
    })
}

/// Waits until the shaft has been turned by hand.
fn turned(bench: &mut Bench) -> i32 {
    let (least, _) = Step::ShaftByHand.range();
    let (mut way, mut greatest) = (Way::default(), 0);
    for _ in 0..PATIENCE_MS * PERIODS_PER_MS {
        let Some(reading) = bench.angle() else {
            return NOT_MEASURED;
        };
        match way.add(reading.count.get()) {
            Some(distance) => greatest = distance,
            None => return NOT_MEASURED,
        }
        if greatest >= least {
            break;
        }
    }
    greatest
}
