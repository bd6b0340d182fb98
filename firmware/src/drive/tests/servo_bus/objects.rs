//! The objects that the control tables name: CANopen has the same quantities in them.

use ::servo_bus::{MIDDLE, Register, TURN};
use canopen_generator::DataType;

use super::*;

/// A step of the encoder, deg.
const STEP_DEG: f64 = 360.0 / TURN as f64;

/// A quantity and its resolution, in deg, deg/s, V, degC, mA, or % of the supply.
type Quantity = (f64, f64);

/// Number and name of a unit.
fn unit(text: &str) -> (f64, &str) {
    let (number, name) = text.split_once(' ').unwrap_or(("1", text));
    (number.parse().expect("a number"), name)
}

impl Servo {
    /// What CANopen reads from an object.
    fn object(&mut self, address: (u16, u8)) -> Quantity {
        let rows = canopen_generator::actuator::rows().expect("the dictionary");
        let row = rows.iter().find(|row| row.address() == address);
        let row = row.unwrap_or_else(|| panic!("{address:x?} is not an object"));
        let raw = self.bench.get(address.0, address.1);
        let value = match row.kind {
            DataType::I16 => f64::from(raw as u16 as i16),
            DataType::I32 => f64::from(raw as i32),
            DataType::U32 => f64::from(raw),
            kind => panic!("{address:x?} is {kind:?}, expected a quantity"),
        };
        let size = match unit(&row.unit) {
            (1.0, "mdeg" | "mdeg/s" | "mV") => 1e-3,
            // Of the rated current, mA.
            (0.1, "%") => 1e-3 * f64::from(self.bench.get(0x6075, 0)),
            (number, "degC" | "%") => number,
            _ => panic!(
                "{address:x?} has the unit `{}`, expected a quantity",
                row.unit
            ),
        };
        (value * size, size)
    }

    /// What the bus reads from a register.
    fn register(&mut self, register: &Register) -> Quantity {
        let value = self.read(register.field);
        let size = match unit(register.unit) {
            // A step and the share of the PWM in round numbers.
            (0.088, "deg") => return (f64::from(value - MIDDLE) * STEP_DEG, STEP_DEG),
            (0.113, "%") => 100.0 / f64::from(dynamixel::FULL_PWM),
            (number, "steps/s") => number * STEP_DEG,
            (number, "rev/min") => number * 6.0,
            (number, "V" | "degC" | "mA" | "%") => number,
            _ => panic!("{} is not a quantity, and has an object", register.name),
        };
        (f64::from(value) * size, size)
    }

    /// Compares registers with their objects.
    fn compare(&mut self, names: &[&'static str]) -> Vec<&'static str> {
        let compared = names.iter().map(|name| {
            let register = *self.model.table().register(name).expect("a register");
            let object = register.object.expect("it has an object");
            let (value, step) = self.register(&register);
            let (expected, object_step) = self.object(object);
            assert!(
                (value - expected).abs() <= step + object_step + 0.01 * expected.abs(),
                "{name}: {value}, {object:x?}: {expected}"
            );
            assert!(
                expected.abs() > 3.0 * step,
                "{name}: {expected} shows nothing"
            );
            *name
        });
        compared.collect()
    }
}

/// Compares all registers of an STS servo that have an object.
fn compare_feetech(model: ServoModel) -> Vec<&'static str> {
    let mut compared = Vec::new();
    let mut servo = Servo::new(model);
    servo.write(sts::GOAL_POSITION, steps(30_000));
    servo.steps(500);
    compared.extend(servo.compare(&["goal_position", "present_position"]));
    compared.extend(servo.compare(&["present_voltage", "present_temperature"]));
    let mut servo = Servo::new(model);
    servo.write(sts::OPERATING_MODE, 1);
    servo.write(sts::TORQUE_ENABLE, 1);
    servo.write(sts::GOAL_VELOCITY, -300);
    servo.steps(300);
    compared.extend(servo.compare(&["goal_velocity", "present_velocity"]));
    compared.extend(servo.compare(&["present_load", "present_current"]));
    compared
}

/// The same of a Dynamixel.
fn compare_robotis(model: ServoModel) -> Vec<&'static str> {
    let mut compared = Vec::new();
    let mut servo = Servo::new(model);
    servo.write(x::TORQUE_ENABLE, 1);
    servo.write(x::GOAL_POSITION, steps(30_000));
    servo.steps(500);
    compared.extend(servo.compare(&["goal_position", "position_trajectory"]));
    compared.extend(servo.compare(&["present_position", "present_input_voltage"]));
    compared.extend(servo.compare(&["present_temperature"]));
    let mut servo = Servo::new(model);
    servo.write(x::OPERATING_MODE, 1);
    servo.write(x::TORQUE_ENABLE, 1);
    servo.write(x::GOAL_VELOCITY, 20);
    servo.steps(300);
    compared.extend(servo.compare(&["goal_velocity", "velocity_trajectory"]));
    compared.extend(servo.compare(&["present_velocity", "present_pwm"]));
    let mut servo = Servo::new(model);
    servo.write(x::OPERATING_MODE, 0);
    servo.write(x::TORQUE_ENABLE, 1);
    servo.write(x::GOAL_CURRENT, 150);
    servo.steps(30);
    compared.extend(servo.compare(&["goal_current", "present_current"]));
    compared
}

#[test]
fn the_object_that_a_table_names_for_a_register_has_the_same_quantity() {
    for model in ServoModel::ALL {
        let compared = match model.maker() {
            ServoMaker::Feetech => compare_feetech(model),
            ServoMaker::Robotis => compare_robotis(model),
        };
        let registers = model.table().registers.iter();
        for register in registers.filter(|register| register.object.is_some()) {
            let is_compared = compared.contains(&register.name);
            assert!(is_compared, "{model:?}: {} is not compared", register.name);
        }
    }
}
