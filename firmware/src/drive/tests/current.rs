//! Limits of current, and a shaft that is held after a fault, as a master sees them.

use super::*;
use crate::{
    application::{BoardState, Bridge, BusState, tests::turn},
    faults::Fault,
};
use model_core::{
    control::encoder_word::{EncoderCount, EncoderWord, Magnet},
    sensors::adc::AdcCode,
};

/// A motor that draws no more than 6073h permits turns more slowly, and bit 11 says why.
#[test]
fn bit_11_is_set_while_6073h_limits_the_current_and_6072h_is_as_good() {
    for index in [0x6072, 0x6073] {
        let mut bench = Bench::new();
        bench.set(0x2040, 1, 0, 4);
        bench.enable();
        assert_eq!(bench.status() & statusword::INTERNAL_LIMIT, 0);
        // 100 mA.
        bench.set(index, 0, 200, 2);
        bench.set(0x607A, 0, 50_000, 4);
        bench.steps(5);
        assert_ne!(bench.status() & statusword::INTERNAL_LIMIT, 0, "{index:x}");
        let current = bench.get(0x6078, 0) as i16;
        assert!(current <= 230, "{index:x}: {current} of 1000");
        bench.until(1000, |bench| bench.angle_mdeg() > 49_500);
    }
}

#[test]
fn bit_7_warns_while_the_heat_of_the_winding_reduces_the_current() {
    let mut bench = Bench::new();
    // 45 deg C: the current decreases from 30 on. With the time constant of a second the winding
    // reaches that in the first motion.
    bench.set(0x2100, 11, 45_000, 4);
    bench.set_real(0x2011, 11, 1.0);
    bench.set(0x2040, 1, 0, 4);
    bench.enable();
    assert_eq!(bench.status() & statusword::WARNING, 0);
    let cold = bench.get(0x2009, 0);
    assert!((240..260).contains(&cold), "{cold}");
    let mut target = 50_000_i32;
    for _ in 0..10 {
        bench.set(0x607A, 0, target as u32, 4);
        bench.steps(100);
        target = -target;
    }
    bench.until(100, |bench| bench.status() & statusword::WARNING != 0);
    assert!((300..450).contains(&bench.get(0x2009, 0)));
    // A reset of the node keeps the temperature.
    let before = bench.get(0x2009, 0);
    bench.send(0, &[0x81, 1]);
    bench.steps(200);
    let after = bench.get(0x2009, 0);
    assert!(
        after > cold + 10 && after <= before + 10,
        "{before} {after}"
    );
}

#[test]
fn a_reset_of_the_node_keeps_what_the_brake_has_learned() {
    for has_moved in [false, true] {
        let mut bench = Bench::new();
        bench.set(0x2040, 1, 0, 4);
        bench.enable();
        for target in [50_000_i32, 0].into_iter().filter(|_| has_moved) {
            bench.set(0x607A, 0, target as u32, 4);
            bench.steps(150);
        }
        bench.send(0, &[0x81, 1]);
        bench.steps(100);
        bench.send(0, &[1, 1]);
        bench.set(0x2040, 1, 0, 4);
        bench.enable();
        // The encoder is lost, and a load turns the shaft.
        let turning = |samples: &mut Samples| {
            samples.encoder = None;
            turn(samples, 100.0);
        };
        let bridges: Vec<_> = (0..20).map(|_| bench.step_with(turning).bridge).collect();
        let opposes = matches!(bridges.last(), Some(Bridge::Driven(duty)) if duty.get() < 0);
        assert_eq!(opposes, has_moved, "{bridges:?}");
    }
}

/// A torque constant that is a third greater in 2011h than the one with which its error was learned
/// lets the encoder go a third further than the motor.
#[test]
fn another_torque_constant_is_no_fault_of_the_encoder() {
    let mut bench = Bench::new();
    bench.set(0x2040, 1, 0, 4);
    for constant in [0.00362, 0.0048] {
        bench.set_real(0x2011, 2, constant);
        bench.enable();
        for target in [50_000_i32, -50_000, 0] {
            bench.set(0x607A, 0, target as u32, 4);
            bench.steps(150);
        }
        assert_eq!(bench.status() & 0x6F, 0x27, "{constant}");
        bench.control(0);
        bench.steps(50);
    }
}

/// The samples of a shaft that stands at zero, with the current of a stall.
fn stalled(samples: &mut Samples) {
    let word = EncoderWord::of(EncoderCount::new(0), Magnet::Steady);
    *samples = Samples::at_rest(word);
    samples.current = Some(AdcCode::from_pin_v(1.65 + 0.5 * 0.78));
}

/// A device whose shaft is held after a stall.
fn held() -> Bench {
    let mut bench = Bench::new();
    bench.set(0x2040, 1, 0, 4);
    bench.enable();
    bench.set(0x607A, 0, 9_000, 4);
    let mut state = BoardState::Enabled;
    for _ in 0..200 {
        state = bench.step_with(stalled).state;
    }
    assert_eq!(state, BoardState::FaultHold);
    bench
}

#[test]
fn a_shaft_that_is_held_after_a_stall_is_in_the_state_fault_and_resets_as_any_fault() {
    let mut bench = held();
    let outputs = bench.outputs.expect("outputs");
    assert_eq!(outputs.fault, Some(Fault::Stall));
    assert_eq!(outputs.motion.status & 0x4F, 0x08, "fault");
    bench.send(0x201, &[0x80, 0]);
    assert_eq!(bench.step_with(stalled).state, BoardState::Disabled);
}

#[test]
fn a_lost_bus_does_not_end_the_hold_and_a_reset_of_the_node_does() {
    let mut bench = held();
    for _ in 0..50 {
        let outputs = bench.step_with(|samples| {
            stalled(samples);
            samples.bus = BusState::Off;
        });
        assert_eq!(outputs.state, BoardState::FaultHold);
    }
    bench.send(0, &[0x81, 1]);
    // The loop restarts, and initialises: the shaft is at rest.
    let states: Vec<_> = (0..20).map(|_| bench.step_with(stalled).state).collect();
    assert_eq!(states.last(), Some(&BoardState::Disabled), "{states:?}");
}
