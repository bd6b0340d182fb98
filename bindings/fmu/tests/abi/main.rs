//! The C interface, called as a host calls it.
#![allow(missing_docs, reason = "a test")]
#![allow(unsafe_code, reason = "the interface is one of C")]

mod exchange;
mod host;
mod misuse;
mod states;
mod tuned;
mod version_3;

use actuator_fmu::abi::Status;
use host::Host;
use model_core::actuator::{Actuator, Settings};
use model_core::scenario;

/// A command that changes at every communication point.
pub fn command_deg(step: u32) -> f64 {
    f64::from(step * 7919 % 101) - 50.0
}

/// Runs for 0.4 s with steps of this many ticks; calls `each` after each step.
pub fn run(host: &Host, ticks: u32, mut each: impl FnMut(u32)) {
    let step_s = f64::from(ticks) * 50e-6;
    let mut point_s = 0.0;
    for step in 0..8000 / ticks {
        // The command of 10 ms: every step size then commands the same.
        host.set("command_deg", command_deg(step * ticks / 200));
        assert_eq!(
            host.step(point_s, step_s),
            Status::Ok,
            "{}",
            host.last_message()
        );
        point_s += step_s;
        each((step + 1) * ticks);
    }
}

fn outputs(actuator: &Actuator) -> [u64; 5] {
    let r = actuator.reading();
    let all = [
        r.angle_deg,
        r.rate_deg_s,
        r.duty_pct,
        r.angle_meas_deg,
        r.rate_meas_deg_s,
    ];
    all.map(f64::to_bits)
}

fn follows_the_actuator(settings: &Settings, ticks: u32) {
    let host = Host::initialized(settings);
    let mut actuator = Actuator::try_new(settings).unwrap();
    let mut done = 0;
    run(&host, ticks, |tick| {
        for tick in done..tick {
            actuator
                .advance(command_deg(tick / ticks * ticks / 200), 1)
                .unwrap();
        }
        done = tick;
        assert_eq!(host.outputs(), outputs(&actuator), "tick {tick}");
    });
}

#[test]
fn steps_of_1_and_4_and_10_ms_and_odd_ones_follow_the_actuator_to_the_last_bit() {
    for settings in scenario::choices() {
        for ticks in [20, 80, 200, 7] {
            follows_the_actuator(&settings, ticks);
        }
    }
}

#[test]
fn steps_that_are_no_whole_number_of_ticks_do_not_drift() {
    let settings = scenario::choices().last().unwrap();
    let odd = Host::initialized(&settings);
    odd.set("command_deg", 60.0);
    // A third of a millisecond: 6.67 ticks.
    let step_s = 1e-3 / 3.0;
    let mut point_s = 0.0;
    for _ in 0..3000 {
        assert_eq!(odd.step(point_s, step_s), Status::Ok);
        point_s += step_s;
    }
    let at_once = Host::initialized(&settings);
    at_once.set("command_deg", 60.0);
    at_once.step(0.0, 1.0);
    assert_eq!(odd.outputs(), at_once.outputs());
}

#[test]
fn the_start_time_shifts_time_and_nothing_else() {
    for settings in scenario::choices() {
        let (from_0, from_1e5) = (Host::new(&settings), Host::new(&settings));
        for (host, start_s) in [(&from_0, 0.0), (&from_1e5, 1e5)] {
            host.initialize(start_s);
            host.set("command_deg", 10.0);
            let mut point_s = start_s;
            for _ in 0..100 {
                assert_eq!(host.step(point_s, 0.003), Status::Ok);
                point_s += 0.003;
            }
        }
        assert_eq!(from_0.outputs(), from_1e5.outputs());
    }
}

#[test]
fn eight_threads_with_an_instance_each_do_not_disturb_each_other() {
    let settings: Vec<_> = scenario::choices().collect();
    std::thread::scope(|scope| {
        for i in 0..8 {
            let settings = settings[i % settings.len()];
            scope.spawn(move || follows_the_actuator(&settings, 80));
        }
    });
}

#[test]
fn a_parameter_that_was_set_acts_and_a_reset_takes_it_back() {
    let settings = scenario::choices().next().unwrap();
    let host = Host::new(&settings);
    let angle_after_the_delay = || {
        host.initialize(0.0);
        host.set("command_deg", 90.0);
        host.step(0.0, 0.1);
        host.get("angle_deg")
    };
    host.set("rate_limit_up_deg_s", 100.0);
    // The rate limit for 0.1 s: the first command is assumed to have been applied before.
    assert!((angle_after_the_delay() - 10.0).abs() < 1e-9);
    // SAFETY: a component in use by this thread alone.
    assert_eq!(unsafe { actuator_fmu::abi::fmi2Reset(host.c) }, Status::Ok);
    assert!((angle_after_the_delay() - 24.0).abs() < 1e-9);
}

#[test]
fn the_torque_of_the_load_is_the_parameter_until_the_input_is_set() {
    let mut settings = scenario::choices().last().unwrap();
    settings.set("load_torque_nm", -0.05).unwrap();
    let mut actuator = Actuator::try_new(&settings).unwrap();
    actuator.advance(20.0, 4000).unwrap();
    let unloaded = Host::initialized(&scenario::choices().last().unwrap());
    unloaded.set("load_torque_nm", -0.05);
    unloaded.set("command_deg", 20.0);
    unloaded.step(0.0, 0.2);
    assert_eq!(unloaded.outputs(), outputs(&actuator));
}

#[test]
fn an_inertia_at_the_input_moves_with_the_load_as_that_of_the_parameter_does() {
    let bench = scenario::choices().last().unwrap();
    let mut settings = bench;
    let horn = settings.drivetrain.gear_train.load_inertia_kg_m2;
    settings.set("load_inertia_kg_m2", horn + 0.004).unwrap();
    let mut actuator = Actuator::try_new(&settings).unwrap();
    actuator.advance(20.0, 4000).unwrap();
    let host = Host::initialized(&bench);
    host.set("added_inertia_kg_m2", 0.004);
    host.set("command_deg", 20.0);
    host.step(0.0, 0.2);
    assert_eq!(host.outputs(), outputs(&actuator));
}
