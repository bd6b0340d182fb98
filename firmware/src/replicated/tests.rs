//! The shutdown under flipped bits, and the comparison of the copies.

extern crate std;
use std::vec::Vec;

use super::{shutdown::Shutdown, *};
use crate::{
    application::{Samples, Start},
    control_loop::{Commands, ExcitationRequest, LoopParameters},
    drive::StoredParameters,
    faults::Fault,
    interface::Bridge,
};
use model_core::{control::encoder_word::EncoderWord, time::CONTROL_RATE_HZ};

/// This shutdown with each bit of its flags flipped in turn.
fn flipped(shutdown: &Shutdown) -> impl Iterator<Item = Shutdown> {
    (0..3 * u8::BITS).map(|bit| {
        let mut other = shutdown.clone();
        let flag = match bit / u8::BITS {
            0 => &mut other.has_begun,
            1 => &mut other.brakes,
            _ => &mut other.is_of_program,
        };
        flag.0 ^= 1 << (bit % u8::BITS);
        other
    })
}

fn brakes_for_a_second(mut shutdown: Shutdown) -> bool {
    let mut next = || shutdown.step(&Outputs::default());
    let brakes = |_| next().is_some_and(|it| it.bridge == Bridge::Brake);
    (0..CONTROL_RATE_HZ).all(brakes) && next().is_none()
}

#[test]
fn a_flipped_bit_begins_a_shutdown_that_brakes_for_a_second_and_reports_corrupt_data() {
    let begun: Vec<_> = flipped(&Shutdown::default())
        .filter(Shutdown::has_begun)
        .collect();
    assert_eq!(begun.len(), 8);
    for shutdown in begun {
        let outputs = shutdown.clone().step(&Outputs::default()).expect("a step");
        assert_eq!(outputs.fault, Some(Fault::DataCorrupt));
        assert!(outputs.telemetry.latched.contains(Fault::DataCorrupt));
        assert!(brakes_for_a_second(shutdown));
    }
}

#[test]
fn a_flipped_bit_in_a_shutdown_that_brakes_does_not_release_the_motor() {
    let mut shutdown = Shutdown::default();
    shutdown.begin(Fault::DataCorrupt, true);
    for flipped in flipped(&shutdown) {
        assert!(flipped.has_begun());
        assert!(brakes_for_a_second(flipped));
    }
}

#[test]
fn the_first_fault_decides() {
    let mut shutdown = Shutdown::default();
    shutdown.begin(Fault::ProgramCorrupt, false);
    shutdown.begin(Fault::DataCorrupt, true);
    let outputs = shutdown.step(&Outputs::default()).expect("a step");
    assert_eq!(outputs.bridge, Bridge::Coast);
    assert_eq!(outputs.fault, Some(Fault::ProgramCorrupt));
}

#[test]
fn a_shutdown_reports_no_counter_of_the_protections() {
    let mut shutdown = Shutdown::default();
    shutdown.begin(Fault::DataCorrupt, true);
    let mut last = Outputs::default();
    last.telemetry.counter = 3;
    let outputs = shutdown.step(&last).expect("a step");
    assert_eq!(outputs.telemetry.counter, 0);
}

/// Whether both copies agree in a control period in which the second one reads these inputs.
fn agrees(samples: &Samples, commands: &Commands) -> bool {
    let (parameters, excitation) = (
        LoopParameters::of(&StoredParameters::DEFAULT),
        ExcitationRequest::NONE,
    );
    let mailboxes = (&Commands::new(), &parameters, &excitation);
    let mut replicated = Replicated::new(Loop::new(mailboxes, Start::default()));
    let first = Samples::at_rest(EncoderWord::new(0));
    let inputs = Inputs {
        samples: &first,
        was_late: false,
        commands: &Commands::new(),
        parameters: &parameters,
        excitation: &excitation,
    };
    replicated.step(&inputs);
    let again = Inputs {
        samples,
        commands,
        ..inputs
    };
    replicated.repeat(&again)
}

#[test]
fn another_sample_or_another_command_of_the_second_copy_is_a_difference() {
    let (same, commands) = (Samples::at_rest(EncoderWord::new(0)), Commands::new());
    assert!(agrees(&same, &commands));
    let mut other = same;
    other.current = None;
    assert!(!agrees(&other, &commands));
    let (mut command, mut other) = (*commands.newest(), commands);
    command.set_position(1);
    assert!(other.set(&command, false, 0));
    assert!(!agrees(&same, &other));
}
