//! The bring-up program: a sound board passes every step, and each defect is found by the step that
//! is there for it, before a motor may be connected.

use std::{fs, path::Path, sync::OnceLock};

use board_tests::program::run_program;
use cross_build::bring_up_elf;
use firmware::bring_up::{NOT_MEASURED, Step, Verdict};
use virtual_board::{
    can::WireFault,
    faults::{Fault, Planned},
    plant::{Bridge, EncoderWire, PERIOD_CYCLES, Stuck},
    run::{Finished, Firmware, Flow, Options, Script, View},
};

use crate::log;

fn program() -> &'static Firmware {
    static PROGRAM: OnceLock<Firmware> = OnceLock::new();
    PROGRAM.get_or_init(|| Firmware::read(bring_up_elf()).expect("an ELF file"))
}

/// `BRING_UP_STEP` after the last step.
const ENDED: u32 = 255;

/// `BDTR` of TIM1, and its bit `MOE`.
const BDTR: u64 = 0x4001_0044;
const MOE: u32 = 1 << 15;

/// Longest run, ms: two steps wait 30 s for a person.
const LONGEST_MS: u64 = 70_000;

/// A person at the bench, and what was seen.
#[derive(Default)]
struct Person {
    /// Whether they pull the break input low and turn the shaft.
    acts: bool,
    /// Period in which the present step began, and its number.
    since: (u64, u32),
    periods: u64,
    /// Longest on time, cycles of 168 MHz, with the step in which it was.
    longest: (u32, u32),
    verdicts: Vec<u32>,
    measured: Vec<i32>,
    /// The content of the log's buffer, which is never emptied.
    log: Vec<u8>,
    has_ended: bool,
    is_off: bool,
}

impl Person {
    fn watch(&mut self, view: &mut View<'_>, step: u32) {
        let on = match view.row.bridge {
            Bridge::Driven { on_cycles, .. } => on_cycles,
            Bridge::Coast | Bridge::Brake => 0,
        };
        if on > self.longest.0 {
            self.longest = (on, step);
        }
    }

    fn act(&mut self, view: &mut View<'_>, step: u32) {
        let elapsed = self.periods - self.since.0;
        if step == Step::Break as u32 + 1 && elapsed == 50 {
            let soon_ns = view.now_ns() + 1_000_000;
            view.plan(Planned::at_ns(soon_ns, Fault::BridgeTrip).for_ms(20));
        }
        let turns = step == Step::ShaftByHand as u32 + 1 && elapsed > 50;
        view.plant.defects.torque_nm = if turns { 0.5 } else { 0.0 };
    }

    fn read(&mut self, view: &mut View<'_>) {
        let mut words = |name| {
            let address = program().address(name).expect("a symbol");
            let steps = Step::ALL.len() as u64;
            (0..steps)
                .map(|n| view.word(address + 4 * n).expect("memory"))
                .collect::<Vec<_>>()
        };
        self.verdicts = words("BRING_UP_VERDICTS");
        let measured = words("BRING_UP_MEASURED");
        self.measured = measured.into_iter().map(|word| word as i32).collect();
    }
}

impl Script for Person {
    fn at_edge(&mut self, view: &mut View<'_>) -> Flow {
        self.periods += 1;
        let address = program().address("BRING_UP_STEP").expect("a symbol");
        let step = view.word(address).expect("memory");
        if step != self.since.1 {
            self.since = (self.periods, step);
        }
        self.watch(view, step);
        if self.acts {
            self.act(view, step);
        }
        if step != ENDED {
            return Flow::Continue;
        }
        // The off state lasts.
        self.has_ended = true;
        self.is_off = view.register(BDTR) & MOE == 0;
        self.read(view);
        self.log = log::buffer(view, program());
        if self.periods - self.since.0 < 20 {
            return Flow::Continue;
        }
        Flow::End
    }
}

/// Runs the program on a board with these defects.
fn bring_up(acts: bool, defects: &[Fault]) -> Finished<Person> {
    let mut options = Options::for_ms(LONGEST_MS);
    options.keeps_trace = false;
    options.faults = defects
        .iter()
        .map(|fault| Planned::at_ms(0, fault.clone()))
        .collect();
    let person = Person {
        acts,
        ..Person::default()
    };
    run_program(program(), options, person)
}

/// Runs a board without a motor and with a defect: this step, and no other, fails.
fn fails_at(step: Step, acts: bool, defects: &[Fault]) -> i32 {
    let defects = [&[Fault::MotorOpen], defects].concat();
    judged(&bring_up(acts, &defects).script, Some(step))
}

/// Asserts that a bring-up has ended at this step, or has passed; returns the last measurement.
fn judged(person: &Person, failed: Option<Step>) -> i32 {
    println!("{:?} {:?}", person.verdicts, person.measured);
    assert!(person.has_ended, "in step {}", person.since.1);
    assert!(person.is_off, "the switches are open at the end");
    let count = failed.map_or(Step::ALL.len(), |step| step as usize);
    let (before, after) = person.verdicts.split_at(count);
    assert!(
        before
            .iter()
            .all(|verdict| *verdict == Verdict::Passed as u32)
    );
    if failed.is_some() {
        assert_eq!(after[0], Verdict::Failed as u32);
        assert!(
            after[1..]
                .iter()
                .all(|verdict| *verdict == Verdict::Open as u32)
        );
        assert!(
            person.measured[count + 1..]
                .iter()
                .all(|value| *value == NOT_MEASURED)
        );
    }
    // Nothing is driven before the measurements have passed, and never more than a tenth.
    let (cycles, step) = person.longest;
    assert!(
        cycles <= PERIOD_CYCLES / 10,
        "{cycles} cycles in step {step}"
    );
    if count <= Step::BreakReleased as usize {
        assert_eq!(cycles, 0, "driven in step {step}");
    }
    person.measured.get(count).copied().unwrap_or_default()
}

#[test]
fn a_sound_board_passes_every_step_and_ends_with_open_switches() {
    let finished = bring_up(true, &[Fault::MotorOpen]);
    judged(&finished.script, None);
    // One reset by the watchdog, in its step.
    assert_eq!(finished.resets.len(), 1);
    // A tenth of the period less the dead time of 1 us.
    assert_eq!(finished.script.longest.0, PERIOD_CYCLES / 10 - 168);
}

#[test]
fn a_dead_watchdog_is_found_by_its_step() {
    assert_eq!(fails_at(Step::Watchdog, true, &[Fault::WatchdogDead]), 100);
}

#[test]
fn a_wrong_supply_is_found_by_its_step() {
    for (volts, mv) in [(4.2, 4_200), (8.0, 8_000)] {
        let measured = fails_at(Step::Supply, true, &[Fault::Supply { volts }]);
        assert!((measured - mv).abs() < 20, "{measured}");
    }
}

#[test]
fn a_wrong_temperature_is_found_by_its_step() {
    let fault = Fault::Temperature { deg_c: 90.0 };
    fails_at(Step::Temperature, true, &[fault]);
}

#[test]
fn an_open_current_sense_is_found_by_its_step() {
    for code in [0, 4095] {
        fails_at(Step::CurrentAtRest, true, &[Fault::CurrentSense { code }]);
    }
}

#[test]
fn swapped_and_open_wires_of_the_encoder_are_found_by_its_step() {
    for (line, stuck) in [
        (EncoderWire::Data, Stuck::Low),
        (EncoderWire::Data, Stuck::High),
        (EncoderWire::Clock, Stuck::High),
        (EncoderWire::Select, Stuck::High),
        (EncoderWire::Select, Stuck::Low),
    ] {
        let fault = Fault::EncoderWire { line, stuck };
        assert_eq!(fails_at(Step::Encoder, true, &[fault]), 0);
    }
}

#[test]
fn an_encoder_that_repeats_its_angle_is_found_when_the_shaft_is_turned() {
    assert_eq!(
        fails_at(Step::ShaftByHand, true, &[Fault::EncoderFrozen]),
        0
    );
}

#[test]
fn a_break_input_that_stays_low_is_found_before_the_bridge_is_driven() {
    let fault = Fault::BridgeTrip;
    assert!(fails_at(Step::BreakReleased, true, &[fault]) > 0);
}

#[test]
fn a_dead_break_input_is_found_by_its_step() {
    // Nothing that a person does arrives.
    assert_eq!(fails_at(Step::Break, false, &[]), 0);
}

#[test]
fn a_motor_is_found_before_anybody_puts_a_hand_to_the_shaft() {
    let finished = bring_up(true, &[]);
    assert!(judged(&finished.script, Some(Step::NoMotor)) > 100);
}

#[test]
fn a_silent_transceiver_is_found_by_the_bus_and_not_by_the_controller() {
    let wire = WireFault::Open;
    assert_eq!(fails_at(Step::CanBus, true, &[Fault::Can { wire }]), 0);
}

#[test]
fn the_log_states_measurement_range_and_verdict() {
    let finished = bring_up(true, &[Fault::MotorOpen, Fault::Supply { volts: 4.2 }]);
    let lines = log::lines(bring_up_elf(), &finished.script.log);
    assert_eq!(
        lines,
        [
            "1 watchdog (ms): passed, 25 in 16..=48",
            "2 supply (mV): FAILED, 4202 not in 4560..=7600",
            "do not connect a motor",
        ]
    );
}

#[test]
fn the_steps_are_those_of_the_hardware_page() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/hardware.md");
    let page = fs::read_to_string(path).expect("the page");
    for step in Step::ALL {
        let (least, most) = step.range();
        let row = format!(
            "| {} | {} | {least} to {most} |",
            step as usize + 1,
            step.name()
        );
        assert!(page.contains(&row), "{row}");
    }
}
