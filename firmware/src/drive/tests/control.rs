//! What changes application and axis outside the control step.

use super::*;

/// The number of accesses, and application and axis.
fn control(bench: &Bench) -> (u32, std::string::String) {
    let control = bench.device.drive.control();
    (control.accesses(), std::format!("{:?}", **control))
}

/// A device in cyclic synchronous position mode that moves, in the middle of a control period.
fn moving() -> Bench {
    let mut bench = Bench::enabled(8);
    bench.cyclic = Some((15, 20_000));
    bench.steps(20);
    bench
}

#[test]
fn process_data_and_due_events_access_neither_application_nor_axis() {
    let mut bench = moving();
    let (before, target) = (control(&bench), bench.device.command_state());
    bench.received.clear();
    bench.send(0x201, &[15, 0, 0x10, 0x27, 0, 0]);
    bench.send(0x80, &[]);
    for _ in 0..100 {
        bench.now_us += 2_000;
        bench.device.communicate(bench.now_us);
        bench.listen();
    }
    assert_ne!(bench.device.command_state(), target, "the command is taken");
    assert!(!bench.received.is_empty(), "events are due");
    assert_eq!(control(&bench), before);
    bench.steps(1);
    assert_ne!(control(&bench).0, before.0, "the control step does");
}

#[test]
fn a_write_of_a_profile_velocity_and_a_running_excitation_are_accesses() {
    let mut bench = moving();
    let (before, now_us) = (control(&bench), bench.now_us);
    let write = [0x23, 0x81, 0x60, 0, 0x90, 0x5F, 1, 0];
    bench.send(0x601, &write);
    assert_eq!(bench.now_us, now_us, "without a control step");
    assert_ne!(control(&bench).0, before.0, "a velocity");

    let mut bench = Bench::enabled(8);
    for (sub, value) in [(3, 7), (5, 2_000), (12, 1_000)] {
        bench.set(0x2020, sub, value, 4);
    }
    bench.set(0x2020, 1, 1, 1);
    bench.steps(30);
    let before = control(&bench);
    bench.device.communicate(bench.now_us);
    assert_ne!(control(&bench).0, before.0, "a sample of the excitation");
}
