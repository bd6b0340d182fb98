//! What changes the memory that the control step works with.

use super::*;

/// That memory, with the number of changes.
fn control(bench: &Bench) -> (u32, std::string::String) {
    let control = bench.device.drive.control();
    (control.changes(), std::format!("{:?}", **control))
}

/// A device in cyclic synchronous position mode that moves, in the middle of a control period.
fn moving() -> Bench {
    let mut bench = Bench::enabled(8);
    bench.cyclic = Some((15, 20_000));
    bench.steps(20);
    bench
}

#[test]
fn process_data_and_due_events_change_nothing_that_the_control_step_works_with() {
    let mut bench = moving();
    let before = control(&bench);
    bench.send(0x201, &[15, 0, 0x10, 0x27, 0, 0]);
    bench.send(0x80, &[]);
    for _ in 0..100 {
        bench.now_us += 2_000;
        bench.device.communicate(bench.now_us);
        bench.listen();
    }
    assert_eq!(control(&bench), before);
    bench.steps(1);
    assert_ne!(control(&bench).0, before.0, "the control step does");
}

#[test]
fn a_write_of_a_profile_velocity_and_a_running_excitation_are_changes_that_are_counted() {
    let mut bench = moving();
    let before = control(&bench);
    bench.set(0x6081, 0, 90_000, 4);
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
