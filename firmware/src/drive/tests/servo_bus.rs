//! The actuator as a servo on a serial bus, on the motor. The makers' libraries judge the
//! protocols: `servo-bus/tests/clients/`.

mod line;
mod objects;

use ::servo_bus::{Field, Order, dynamixel, feetech, tables::sts, tables::x};
use std::vec;

use super::*;
use crate::{
    application::{BoardState, BusState},
    drive::servo_bus::Elapsed,
};

/// A servo with the ID 1.
struct Servo {
    bench: Bench,
    bus: ServoBus,
    model: ServoModel,
}

impl Servo {
    fn new(model: ServoModel) -> Self {
        Self::with(StoredParameters::DEFAULT.with_servo_bus(model, 1), model)
    }

    fn with(set: StoredParameters, model: ServoModel) -> Self {
        let mut servo = Self {
            bench: Bench::with(set),
            bus: ServoBus::new(&set).expect("a servo"),
            model,
        };
        servo.steps(100);
        servo
    }

    fn step(&mut self) {
        self.step_with(|_| {});
    }

    fn step_with(&mut self, hand: impl FnOnce(&mut Samples)) {
        self.bench.step_with(hand);
        self.exchange();
        // The second communication cycle of the control period.
        self.exchange();
    }

    fn exchange(&mut self) {
        self.bus.exchange(&mut self.bench.actuator.device.drive);
    }

    fn steps(&mut self, periods: u32) {
        (0..periods).for_each(|_| self.step());
    }

    /// The answer to bytes, without its delay.
    fn answer(&mut self, bytes: &[u8]) -> Vec<u8> {
        answer(&mut self.bus, bytes)
    }

    /// Writes a register; returns the status, or error, of the answer.
    fn write(&mut self, field: Field, value: i32) -> u8 {
        let data = field.encode(value, Order::Little);
        let data = &data[..usize::from(field.size)];
        let address = field.address.to_le_bytes();
        match self.model.maker() {
            ServoMaker::Feetech => {
                let bytes = feetech::encode(1, 3, &[&address[..1], data].concat());
                self.answer(&bytes)[4]
            }
            ServoMaker::Robotis => {
                let bytes = dynamixel::encode(1, 3, &[&address, data]);
                self.answer(&bytes)[8]
            }
        }
    }

    fn read(&mut self, field: Field) -> i32 {
        let (address, size) = (field.address.to_le_bytes(), field.size);
        let (bytes, from) = match self.model.maker() {
            ServoMaker::Feetech => (feetech::encode(1, 2, &[address[0], size]), 5),
            ServoMaker::Robotis => (dynamixel::encode(1, 2, &[&address, &[size, 0]]), 9),
        };
        let answer = self.answer(&bytes);
        field.decode(&answer[from..][..usize::from(size)], Order::Little)
    }

    fn state(&self) -> BoardState {
        self.bench.actuator.device.drive.outputs().state
    }

    fn shaft_mdeg(&mut self) -> i32 {
        self.bench.angle_mdeg()
    }
}

fn answer(bus: &mut ServoBus, bytes: &[u8]) -> Vec<u8> {
    let mut buffer = vec![0; 1024];
    if bus.receive(bytes).is_none() || bus.elapsed() != Elapsed::Transmit {
        return Vec::new();
    }
    let length = bus.take_answer(&mut buffer);
    buffer.truncate(length);
    buffer
}

/// Steps of the encoder, 0.088 deg, around the middle of a turn.
fn steps(mdeg: i32) -> i32 {
    2048 + (f64::from(mdeg) * 4096.0 / 360_000.0).floor() as i32
}

#[test]
fn a_goal_is_reached_and_held_without_further_packets() {
    let mut servo = Servo::new(ServoModel::Sts3215);
    assert_eq!(servo.read(sts::PRESENT_POSITION), 2048);
    assert_eq!(servo.write(sts::GOAL_POSITION, steps(30_000)), 0);
    servo.steps(20);
    assert_eq!(servo.read(sts::MOVING), 1);
    servo.steps(400);
    // Two counts of the encoder.
    assert!(
        servo.shaft_mdeg().abs_diff(30_000) <= 176,
        "{}",
        servo.shaft_mdeg()
    );
    let position = servo.read(sts::PRESENT_POSITION);
    assert!(position.abs_diff(steps(30_000)) <= 2, "{position}");
    assert_eq!(
        (servo.read(sts::MOVING), servo.read(sts::TORQUE_ENABLE)),
        (0, 1)
    );
    // Longer than the time-out of commands: the table holds its goal.
    servo.steps(1000);
    assert_eq!(servo.state(), BoardState::Enabled);

    let mut servo = Servo::new(ServoModel::Xl330M288);
    assert_eq!(servo.write(x::TORQUE_ENABLE, 1), 0);
    assert_eq!(servo.write(x::GOAL_POSITION, steps(-20_000)), 0);
    servo.steps(400);
    assert!(
        servo.shaft_mdeg().abs_diff(-20_000) <= 176,
        "{}",
        servo.shaft_mdeg()
    );
}

#[test]
fn a_profile_takes_the_time_of_its_trapezoid() {
    let mut servo = Servo::new(ServoModel::Sts3215);
    servo.write(sts::ACCELERATION, 10);
    servo.write(sts::GOAL_VELOCITY, 500);
    servo.write(sts::GOAL_POSITION, 2548);
    // 500 steps at 500 steps/s and 1000 steps/s^2: 1.5 s. The loop lags by 1/8 s.
    servo.steps(200);
    assert!(servo.read(sts::PRESENT_POSITION).abs_diff(2048 + 275 - 62) < 30);
    servo.steps(225);
    assert!(servo.read(sts::PRESENT_POSITION).abs_diff(2548) <= 4);

    let mut servo = Servo::new(ServoModel::Xl330M288);
    servo.write(x::DRIVE_MODE, 4);
    servo.write(x::TORQUE_ENABLE, 1);
    servo.write(x::PROFILE_VELOCITY, 1000);
    servo.write(x::PROFILE_ACCELERATION, 250);
    servo.write(x::GOAL_POSITION, 2548);
    for (ms, position) in [(250, 2132), (250, 2298), (250, 2465), (250, 2548)] {
        servo.steps(ms / 4);
        let trajectory = servo.read(x::POSITION_TRAJECTORY);
        // A control period at 667 steps/s, from which it begins and to which it is rounded.
        assert!(
            trajectory.abs_diff(position) <= 6,
            "{trajectory} {position}"
        );
    }
}

#[test]
fn turning_the_torque_on_moves_nothing_and_turning_it_off_ends_the_power_at_once() {
    let mut servo = Servo::new(ServoModel::Sts3215);
    servo.write(sts::GOAL_POSITION, 2500);
    servo.steps(20);
    servo.write(sts::TORQUE_ENABLE, 0);
    servo.steps(3);
    assert_eq!(servo.state(), BoardState::Disabled);
    servo.steps(200);
    let rest = servo.shaft_mdeg();
    assert!(rest < 35_000, "on the way to 39.7 deg: {rest}");
    servo.write(sts::TORQUE_ENABLE, 1);
    servo.steps(100);
    assert_eq!(servo.state(), BoardState::Enabled);
    assert!(
        servo.shaft_mdeg().abs_diff(rest) <= 264,
        "{}",
        servo.shaft_mdeg()
    );
}

#[test]
fn wheel_velocity_and_current_modes_turn_the_shaft() {
    let mut servo = Servo::new(ServoModel::Sts3215);
    servo.write(sts::OPERATING_MODE, 1);
    servo.write(sts::TORQUE_ENABLE, 1);
    servo.write(sts::GOAL_VELOCITY, -300);
    servo.steps(150);
    let speed = servo.read(sts::PRESENT_VELOCITY);
    assert!((speed + 300).abs() < 30, "{speed} steps/s");

    let mut servo = Servo::new(ServoModel::Xl330M288);
    servo.write(x::OPERATING_MODE, 1);
    servo.write(x::TORQUE_ENABLE, 1);
    servo.write(x::GOAL_VELOCITY, 20);
    servo.steps(150);
    let velocity = servo.read(x::PRESENT_VELOCITY);
    assert!((velocity - 20).abs() <= 2, "{velocity}");

    let mut servo = Servo::new(ServoModel::Xl330M288);
    servo.write(x::OPERATING_MODE, 0);
    servo.write(x::TORQUE_ENABLE, 1);
    servo.write(x::GOAL_CURRENT, 150);
    servo.steps(50);
    assert!(servo.shaft_mdeg() > 1_000, "{}", servo.shaft_mdeg());
}

#[test]
fn a_fault_is_in_the_status_ends_the_torque_and_is_acknowledged_by_the_table() {
    let lose = |servo: &mut Servo| {
        for _ in 0..50 {
            servo.step_with(|samples| samples.encoder = None);
        }
        servo.steps(150);
        assert_eq!(servo.state(), BoardState::Fault);
    };
    let mut servo = Servo::new(ServoModel::Sts3215);
    servo.write(sts::TORQUE_ENABLE, 1);
    servo.steps(20);
    lose(&mut servo);
    assert_eq!(servo.read(sts::STATUS), feetech::status::ENCODER);
    assert_eq!(servo.read(sts::TORQUE_ENABLE), 0);
    servo.write(sts::TORQUE_ENABLE, 1);
    servo.steps(20);
    assert_eq!(
        (servo.state(), servo.read(sts::STATUS)),
        (BoardState::Enabled, 0)
    );

    let mut servo = Servo::new(ServoModel::Xl330M288);
    servo.write(x::TORQUE_ENABLE, 1);
    servo.steps(20);
    servo.write(x::SHUTDOWN, 0x3F);
    lose(&mut servo);
    assert_eq!(
        servo.read(x::HARDWARE_ERROR_STATUS),
        dynamixel::error::ENCODER
    );
    assert_eq!(servo.read(x::TORQUE_ENABLE), 0);
    // A reboot.
    servo.answer(&dynamixel::encode(1, 8, &[]));
    servo.steps(20);
    assert_eq!(servo.read(x::HARDWARE_ERROR_STATUS), 0);
    servo.write(x::TORQUE_ENABLE, 1);
    servo.steps(20);
    assert_eq!(servo.state(), BoardState::Enabled);
}

#[test]
fn an_acknowledgement_during_the_reaction_to_a_fault_acts_at_its_end() {
    let mut servo = Servo::new(ServoModel::Sts3215);
    servo.write(sts::OPERATING_MODE, 1);
    servo.write(sts::TORQUE_ENABLE, 1);
    servo.write(sts::GOAL_VELOCITY, 300);
    servo.steps(100);
    while servo.state() == BoardState::Enabled {
        servo.step_with(|samples| samples.bus = BusState::Off);
    }
    assert_eq!(servo.state(), BoardState::FaultReaction);
    servo.write(sts::TORQUE_ENABLE, 1);
    servo.steps(200);
    assert_eq!(
        (servo.state(), servo.read(sts::STATUS)),
        (BoardState::Disabled, 0)
    );
}

#[test]
fn the_limit_of_the_table_limits_the_torque_and_is_not_stored() {
    let limit = |servo: &mut Servo| {
        servo.steps(1);
        let parameters = servo.bench.actuator.device.drive.messages.parameters;
        parameters.unverified().axis.max_torque
    };
    let mut servo = Servo::new(ServoModel::Sts3215);
    servo.write(sts::TORQUE_LIMIT, 250);
    // A quarter of 6073h, 3200, also behind 1010h.
    assert_eq!(limit(&mut servo), 800);
    servo.bench.set(0x1010, 1, 0x6576_6173, 4);
    assert_eq!(
        (limit(&mut servo), servo.bench.get(0x6072, 0)),
        (800, 65_535)
    );
    servo.write(sts::TORQUE_LIMIT, 1000);
    assert_eq!(limit(&mut servo), 3200);

    // 100 times 1 mA and 2.69 mA.
    for (model, ma) in [(ServoModel::Xl330M288, 100), (ServoModel::Xm430W350, 269)] {
        let mut servo = Servo::new(model);
        servo.write(x::OPERATING_MODE, 5);
        servo.write(x::GOAL_CURRENT, 100);
        let rated_ma = servo.bench.get(0x6075, 0);
        assert_eq!(u32::from(limit(&mut servo)), ma * 1000 / rated_ma);
    }
}

#[test]
fn a_grip_with_a_limited_current_is_no_fault() {
    let mut servo = Servo::new(ServoModel::Xl330M288);
    servo.bench.motor = Motor::between_stops(10.0);
    servo.write(x::OPERATING_MODE, 5);
    servo.write(x::GOAL_CURRENT, 200);
    servo.write(x::TORQUE_ENABLE, 1);
    servo.write(x::GOAL_POSITION, steps(50_000));
    // Five times the time of a following error.
    servo.steps(400);
    assert_eq!(servo.state(), BoardState::Enabled);
    assert_eq!(servo.read(x::HARDWARE_ERROR_STATUS), 0);
    assert!(servo.shaft_mdeg() > 9_500, "{}", servo.shaft_mdeg());
    // The goal is left at once.
    servo.write(x::GOAL_POSITION, 2048);
    servo.steps(200);
    assert!(servo.shaft_mdeg().abs() < 300, "{}", servo.shaft_mdeg());
}

#[test]
fn nothing_that_was_written_before_the_angle_is_known_moves_the_shaft() {
    for model in ServoModel::ALL {
        let set = StoredParameters::DEFAULT.with_servo_bus(model, 1);
        let mut servo = Servo {
            bench: Bench::with(set),
            bus: ServoBus::new(&set).expect("a servo"),
            model,
        };
        let (goal, enable) = match model.maker() {
            ServoMaker::Feetech => (sts::GOAL_POSITION, sts::TORQUE_ENABLE),
            ServoMaker::Robotis => (x::GOAL_POSITION, x::TORQUE_ENABLE),
        };
        servo.write(enable, 1);
        servo.write(goal, 2500);
        servo.steps(100);
        // A packet for another servo.
        let ping = match model.maker() {
            ServoMaker::Feetech => feetech::encode(9, 1, &[]),
            ServoMaker::Robotis => dynamixel::encode(9, 1, &[]),
        };
        servo.answer(&ping);
        servo.steps(100);
        assert_eq!(servo.state(), BoardState::Disabled, "{model:?}");
        assert_eq!((servo.read(enable), servo.shaft_mdeg()), (0, 0));
    }
}

#[test]
fn the_bus_watchdog_ends_the_motion() {
    let mut servo = Servo::new(ServoModel::Xl330M288);
    servo.write(x::OPERATING_MODE, 1);
    servo.write(x::TORQUE_ENABLE, 1);
    servo.write(x::GOAL_VELOCITY, 20);
    servo.write(x::BUS_WATCHDOG, 10);
    servo.steps(45);
    assert!(servo.bench.get(0x606C, 0) as i32 > 10_000);
    servo.steps(60);
    assert!((servo.bench.get(0x606C, 0) as i32).abs() < 1_000);
    assert_eq!(servo.read(x::BUS_WATCHDOG), -1);
}

#[test]
fn canopen_may_end_the_motion_and_nothing_else() {
    let mut servo = Servo::new(ServoModel::Sts3215);
    servo.write(sts::TORQUE_ENABLE, 1);
    servo.steps(20);
    let local = Err(0x0800_0021);
    for (index, value, size) in [
        (0x6040, 0x06, 2),
        (0x6040, 0x1F, 2),
        (0x6060, 1, 1),
        (0x607A, 10_000, 4),
        (0x60FF, 10_000, 4),
        (0x6071, 100, 2),
    ] {
        assert_eq!(
            servo.bench.try_set(index, 0, value, size),
            local,
            "{index:x}"
        );
    }
    servo.steps(20);
    assert_eq!(servo.state(), BoardState::Enabled);
    // A goal in the same communication cycle, and later ones, do not end the stop.
    assert_eq!(servo.bench.try_set(0x6040, 0, 0, 2), Ok(()));
    for _ in 0..10 {
        servo.write(sts::GOAL_POSITION, 2500);
        servo.steps(3);
        assert_eq!(servo.state(), BoardState::Disabled);
        assert_eq!(servo.read(sts::TORQUE_ENABLE), 0);
    }
    servo.write(sts::TORQUE_ENABLE, 1);
    servo.steps(10);
    assert_eq!(servo.state(), BoardState::Enabled);
}

#[test]
fn dronecan_may_end_the_motion_and_nothing_else() {
    use ::dronecan::{Application, Target};
    let model = ServoModel::Sts3215;
    let set = StoredParameters::DEFAULT
        .with_dronecan(1)
        .with_servo_bus(model, 1);
    let mut servo = Servo::with(set, model);
    for _ in 0..20 {
        servo
            .bench
            .actuator
            .device
            .drive
            .command(1, Target::Position(0.5));
        servo.step();
        assert_eq!(servo.state(), BoardState::Disabled);
    }
    servo.write(sts::TORQUE_ENABLE, 1);
    servo.steps(20);
    assert_eq!(servo.state(), BoardState::Enabled);
    let release = Target::Position(f32::NAN);
    servo.bench.actuator.device.drive.command(1, release);
    servo.steps(20);
    assert_eq!(servo.state(), BoardState::Disabled);
}

#[test]
fn what_the_table_keeps_without_power_is_stored_once_it_has_settled() {
    let mut servo = Servo::new(ServoModel::Sts3215);
    servo.write(sts::LOCK, 0);
    servo.write(sts::ID, 7);
    servo.steps(20);
    assert!(servo.bench.writing.is_none());
    servo.steps(100);
    let stored = *servo.bench.actuator.device.drive.store.stored();
    let mut other = ServoBus::new(&stored).expect("a servo");
    let ping = feetech::encode(7, 1, &[]);
    assert_eq!(answer(&mut other, &ping), feetech::encode(7, 0, &[])[..]);
    // Another model has its own registers, those of a new one.
    let mut set = stored;
    set.values.servo_bus.servo_bus_model = ServoModel::Xl330M288 as u8;
    let mut other = ServoBus::new(&set).expect("a servo");
    let ping = dynamixel::encode(1, 1, &[]);
    assert!(!answer(&mut other, &ping).is_empty());
}
