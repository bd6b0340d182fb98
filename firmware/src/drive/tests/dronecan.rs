//! The actuator as a DroneCAN node on the motor. An independent client judges the protocol:
//! `dronecan/tests/clients/`.

use ::dronecan::{Application, Opcode, Target, Value};
use canopen::cia402::Cia402State;
use core::task::Poll;
use embedded_can::ExtendedId;

use super::*;
use crate::{
    application::{BoardState, Bridge},
    dictionary::DriveCommand,
};

/// The actuator of the bench.
const ACTUATOR: u8 = 5;

fn bench() -> Bench {
    let mut bench = Bench::with(StoredParameters::DEFAULT.with_dronecan(ACTUATOR));
    // The initialisation.
    bench.steps(100);
    bench
}

impl Bench {
    fn drive(&mut self) -> &mut Drive<'static> {
        &mut self.actuator.device.drive
    }

    /// Commands a target at 50 Hz for these control periods.
    fn command(&mut self, target: Target, periods: u32) {
        for period in 0..periods {
            if period % 5 == 0 {
                self.drive().command(ACTUATOR, target);
            }
            self.step();
        }
    }

    fn state(&mut self) -> BoardState {
        self.drive().outputs().state
    }

    fn axis(&mut self) -> Cia402State {
        self.drive().outputs().motion.state
    }

    fn shaft_mdeg(&mut self) -> i32 {
        crate::timing::thousandths(self.drive().outputs().telemetry.angle)
    }

    fn parameter(&mut self, name: &str, value: i64) {
        let index = self.drive().find(name.as_bytes()).expect("a parameter");
        self.drive().set(index, Value::Integer(value));
        let set = self.drive().parameter(index).expect("a parameter").value;
        assert_eq!(set, Value::Integer(value), "{name}");
        self.steps(2);
    }
}

#[test]
fn each_kind_of_command_moves_the_shaft_to_its_angle() {
    for (target, mdeg) in [
        (Target::Unitless(0.5), 30_000),
        (Target::Position(-0.5), -28_648),
        (Target::PulseWidth(1750.0), 30_000),
        // Beyond the travel, and the limits of position.
        (Target::Unitless(-3.0), -60_000),
    ] {
        let mut bench = bench();
        bench.command(target, 300);
        assert_eq!(bench.state(), BoardState::Enabled);
        // Two counts of the encoder.
        let angle = bench.shaft_mdeg();
        assert!((angle - mdeg).abs() <= 176, "{target:?}: {angle}");
    }
    let mut bench = bench();
    bench.command(Target::Speed(0.5), 100);
    let rate = bench.drive().outputs().telemetry.velocity_mdeg_s;
    // 0.5 rad/s are 28.6 deg/s.
    assert!((rate - 28_648).abs() < 2_000, "{rate}");
}

#[test]
fn positions_count_from_the_origin_as_commanded_and_as_reported() {
    // At 10 deg of the encoder.
    let (mut homed, _) = super::homing::homed(37, 30_000);
    homed.set(0x1010, 1, u32::from_le_bytes(*b"save"), 4);
    let stored = *homed.actuator.device.drive.store.stored();
    let mut bench = Bench::with(stored.with_dronecan(ACTUATOR));
    bench.steps(100);
    // 34.4 deg from the origin.
    bench.command(Target::Position(0.6), 300);
    let reported_rad = bench.drive().telemetry().position_rad;
    // Two counts of the encoder.
    assert!((reported_rad - 0.6).abs() <= 0.0031, "{reported_rad}");
    // The homing rested within two counts of 10 deg.
    let angle = bench.shaft_mdeg();
    assert!((angle - 14_377).abs() <= 2 * 176, "{angle}");
}

#[test]
fn what_is_no_target_for_this_actuator_closes_no_loop() {
    let mut bench = bench();
    for target in [
        Target::Unitless(f32::NAN),
        Target::PulseWidth(0.0),
        Target::PulseWidth(100.0),
        Target::PulseWidth(1e9),
        Target::Force(1.0),
    ] {
        bench.command(target, 20);
        assert_eq!(bench.state(), BoardState::Disabled, "{target:?}");
    }
    bench.drive().command(ACTUATOR + 1, Target::Unitless(1.0));
    bench.steps(20);
    assert_eq!(bench.state(), BoardState::Disabled);
    // The servo pulse is the source.
    let source = DriveCommand::CommandSource;
    assert_eq!(bench.drive().execute(source, 1), Ok(()));
    bench.steps(2);
    bench.command(Target::Unitless(1.0), 20);
    assert_eq!(bench.state(), BoardState::Disabled);
}

#[test]
fn a_release_stops_the_shaft_and_then_removes_the_power() {
    for release in [Target::Position(f32::NAN), Target::PulseWidth(0.0)] {
        let mut bench = bench();
        bench.command(Target::Speed(2.0), 50);
        let before = bench.shaft_mdeg();
        bench.command(release, 1);
        // The loop lags by 1/8 s behind the ramp, and the stop waits for the shaft.
        let periods = bench.until(150, |bench| bench.state() == BoardState::Disabled);
        let after = bench.shaft_mdeg();
        assert!(periods > 5 && after > before, "{periods} {before} {after}");
        assert_eq!(bench.drive().latched(), FaultSet::EMPTY);
        // And the next command closes the loop again.
        bench.command(Target::Position(0.0), 300);
        assert!(bench.shaft_mdeg().abs() <= 176);
    }
}

#[test]
fn a_command_that_stays_away_is_a_fault_which_a_release_acknowledges() {
    let mut bench = bench();
    bench.command(Target::Unitless(0.2), 100);
    bench.steps(200);
    assert_eq!(bench.axis(), Cia402State::Fault);
    let mut text = [0; 32];
    let (_, length) = bench.drive().take_log(&mut text).expect("a log message");
    assert!(text[..length].starts_with(b"fault "));
    assert_eq!(bench.drive().take_log(&mut text), None);
    bench.command(Target::Unitless(0.2), 50);
    assert_eq!(bench.axis(), Cia402State::Fault, "not by a target");
    bench.command(Target::Unitless(f32::NAN), 10);
    assert_eq!(bench.axis(), Cia402State::SwitchOnDisabled);
    bench.command(Target::Unitless(0.2), 50);
    assert_eq!(bench.state(), BoardState::Enabled);
}

#[test]
fn a_release_that_begins_in_the_reaction_to_a_fault_acknowledges_it_afterwards() {
    let mut bench = bench();
    bench.command(Target::Speed(2.0), 50);
    bench.until(100, |bench| {
        bench.axis() == Cia402State::FaultReactionActive
    });
    bench.command(Target::Unitless(f32::NAN), 1);
    assert_eq!(bench.axis(), Cia402State::FaultReactionActive);
    bench.command(Target::Unitless(f32::NAN), 200);
    assert_eq!(bench.axis(), Cia402State::SwitchOnDisabled);
}

#[test]
fn the_failsafe_position_is_taken_when_commands_stay_away() {
    let mut bench = bench();
    bench.parameter("failsafe_action", 2);
    bench.parameter("failsafe_position_mdeg", -10_000);
    bench.command(Target::Unitless(0.5), 200);
    bench.steps(400);
    assert!((bench.shaft_mdeg() + 10_000).abs() <= 176);
}

#[test]
fn parameters_are_checked_as_those_of_the_dictionary_and_stored() {
    let mut bench = bench();
    let mut set = |name: &str, value| {
        let drive = bench.drive();
        let index = drive.find(name.as_bytes()).expect("a parameter");
        drive.set(index, value);
        drive.parameter(index).expect("a parameter").value
    };
    // Range, type, relation to another parameter.
    assert_eq!(set("stall_ms", Value::Integer(19)), Value::Integer(500));
    assert_eq!(set("stall_ms", Value::Real(600.0)), Value::Integer(500));
    assert_eq!(set("actuator_id", Value::Integer(256)), Value::Integer(5));
    assert_eq!(
        set("under_voltage_mv", Value::Integer(8_000)),
        Value::Integer(4_000)
    );
    assert_eq!(
        set("min_position_mdeg", Value::Integer(70_000)),
        Value::Integer(-60_000)
    );
    assert_eq!(
        set("position_gain", Value::Real(f32::NAN)),
        Value::Real(8.0)
    );
    assert_eq!(set("position_gain", Value::Real(9.0)), Value::Real(9.0));
    assert_eq!(set("stall_ms", Value::Integer(600)), Value::Integer(600));
    bench.steps(2);
    bench.command(Target::Unitless(0.0), 20);
    // Locked while the loop is closed, unlike gains.
    let index = bench.drive().find(b"stall_ms").expect("a parameter");
    bench.drive().set(index, Value::Integer(700));
    let value = bench.drive().parameter(index).map(|it| it.value);
    assert_eq!(value, Some(Value::Integer(600)));
    bench.command(Target::Unitless(f32::NAN), 50);
    for (opcode, value) in [(Opcode::Save, 600), (Opcode::Erase, 500)] {
        assert_eq!(bench.drive().perform(opcode), Poll::Pending);
        bench.until(5, |bench| {
            bench.drive().perform(opcode) == Poll::Ready(true)
        });
        bench.drive().power_on();
        bench.steps(100);
        let stored = bench.drive().parameter(index).map(|it| it.value);
        assert_eq!(stored, Some(Value::Integer(value)));
        assert_eq!(bench.drive().telemetry().actuator_id, ACTUATOR);
    }
}

/// By xorshift.
struct Random(u64);

impl Random {
    fn below(&mut self, end: u64) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0 % end
    }
}

/// A frame of any content, mostly of a kind that the node receives.
fn any_frame(random: &mut Random, node_id: u8) -> CanFrame {
    let source = random.below(128) as u32;
    let services = [1, 5, 10, 11, 40, 48, 255];
    let id = match random.below(8) {
        0 => random.below(1 << 29) as u32,
        1 => 1 << 8 | source,
        2 => 1010 << 8 | source,
        _ => {
            let service = services[random.below(7) as usize] << 16;
            service | (random.below(2) as u32) << 15 | u32::from(node_id) << 8 | 0x80 | source
        }
    };
    let mut data = [0; 8];
    for byte in &mut data {
        *byte = random.below(256) as u8;
    }
    let length = random.below(9) as usize;
    // The bits that make transfers of frames: often consistent ones.
    if let Some(tail) = data[..length].last_mut() {
        *tail = [*tail, 0xC0, 0x80, 0x20, 0x00, 0x60, 0x40][random.below(7) as usize];
    }
    let id = ExtendedId::new(id).expect("29 bits");
    CanFrame::new(id, &data[..length]).expect("at most 8 bytes")
}

/// Whether a frame is a whole message of commands for the bench: these have no check value beyond
/// that of the frame.
fn is_command(frame: &CanFrame) -> bool {
    let is_for_all = frame.raw_id().0 & 0x00FF_FF80 == 1010 << 8;
    let is_whole = frame.data().last().is_some_and(|tail| tail & 0xE0 == 0xC0);
    is_for_all && is_whole && frame.data().first() == Some(&ACTUATOR)
}

#[test]
fn a_million_frames_of_any_content_move_nothing() {
    let mut bench = bench();
    bench.parameter("dronecan_node_id", 42);
    assert_eq!(bench.drive().perform(Opcode::Save), Poll::Pending);
    bench.until(5, |bench| {
        bench.drive().perform(Opcode::Save) == Poll::Ready(true)
    });
    bench.actuator.device = Device::new(
        *bench.drive().store.stored(),
        Box::leak(Box::new([0; 400])),
        0,
    );
    let mut random = Random(0x5eed_d207_eca1);
    let mut responses = 0;
    for number in 0..1_000_000 {
        let frame = any_frame(&mut random, 42);
        if is_command(&frame) {
            continue;
        }
        bench.actuator.receive(&frame, bench.now_us);
        if number % 20 == 0 {
            let outputs = bench.step();
            assert!(!matches!(outputs.bridge, Bridge::Driven(_)), "{frame:?}");
            responses += bench.received.len();
            bench.received.clear();
        }
    }
    // They are processed: it answers those that are valid requests.
    assert!(responses > 100_000, "{responses}");
}
