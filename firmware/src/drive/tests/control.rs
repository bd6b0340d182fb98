//! What changes application, axis and the parameters of the PDOs outside the control step.

use canopen::Counted;

use super::*;

/// A value and the number of accesses to it.
type Accessed = (u32, std::string::String);

fn accessed<T: core::fmt::Debug>(value: &Counted<T>) -> Accessed {
    (value.accesses(), std::format!("{:?}", **value))
}

/// Application and axis.
fn control(bench: &Bench) -> Accessed {
    accessed(bench.device.drive.control())
}

/// The parameters of the PDOs.
fn pdos(bench: &Bench) -> Accessed {
    accessed(bench.device.node().pdo_table())
}

/// A device in cyclic synchronous position mode that moves, in the middle of a control period.
fn moving() -> Bench {
    let mut bench = Bench::enabled(8);
    bench.cyclic = Some((15, 20_000));
    bench.steps(20);
    bench
}

#[test]
fn process_data_and_due_events_access_neither_application_nor_axis_nor_pdo_parameters() {
    let mut bench = moving();
    let (before, target) = (control(&bench), bench.device.command_state());
    let pdos_before = pdos(&bench);
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
    assert_eq!(pdos(&bench), pdos_before);
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

#[test]
fn a_change_of_pdo_parameters_and_a_reset_of_the_communication_are_accesses() {
    let mut bench = moving();
    let before = pdos(&bench);
    bench.set(0x1801, 5, 30, 2);
    let changed = pdos(&bench);
    assert_ne!(changed.0, before.0, "an event time");
    assert_ne!(changed.1, before.1, "an event time");
    bench.send(0, &[0x82, 0]);
    let reset = pdos(&bench);
    assert_ne!(reset.0, changed.0, "a reset");
    assert_eq!(reset.1, before.1, "to the defaults");
}
