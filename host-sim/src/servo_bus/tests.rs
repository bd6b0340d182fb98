//! Servos against their catalogues and manuals.

mod pendulum;

use servo_bus::tables::{sts, x};
use servo_bus::{BROADCAST, Field, dynamixel, feetech};

use super::bus::Sent;
use super::{Bus, Fault, NAMES, OfServo, model};

/// A servo, written to as by the bus.
struct Bench {
    bus: Bus,
    is_sts: bool,
}

impl Bench {
    fn new(name: &str) -> Self {
        let model = model(name).expect("a model");
        Self {
            bus: Bus::new(&model, 1, 0.0).expect("its parameters are in their ranges"),
            is_sts: name.starts_with("sts"),
        }
    }

    fn answer(&mut self, bytes: &[u8]) -> Vec<u8> {
        let mut sent = Sent::default();
        self.bus.receive(bytes, &mut sent);
        sent.bytes
    }

    /// Writes a register; returns the status, or error, of the answer.
    fn write(&mut self, field: Field, value: i32) -> u8 {
        let data = field.encode(value, servo_bus::Order::Little);
        let data = &data[..usize::from(field.size)];
        let (bytes, error) = if self.is_sts {
            let parameters = [&[field.address as u8], data].concat();
            (feetech::encode(1, 3, &parameters), 4)
        } else {
            let address = field.address.to_le_bytes();
            (dynamixel::encode(1, 3, &[&address, data]), 8)
        };
        self.answer(&bytes)[error]
    }

    /// Reads a register, as the bus does.
    fn read(&mut self, field: Field) -> i32 {
        let (bytes, data) = if self.is_sts {
            let parameters = [field.address as u8, field.size];
            (feetech::encode(1, 2, &parameters), 5)
        } else {
            let address = field.address.to_le_bytes();
            let length = u16::from(field.size).to_le_bytes();
            (dynamixel::encode(1, 2, &[&address, &length]), 9)
        };
        let answer = self.answer(&bytes);
        let data = &answer[data..data + usize::from(field.size)];
        field.decode(data, servo_bus::Order::Little)
    }

    fn get(&mut self, field: Field) -> i32 {
        self.bus.servos()[0].memory().get(field)
    }

    fn apply(&mut self, fault: OfServo) {
        self.bus.apply(Fault::Of(1, fault));
    }

    fn load(&mut self, torque_nm: f64) {
        self.apply(OfServo::Load(torque_nm));
    }

    fn jam(&mut self, is_jammed: bool) {
        self.apply(OfServo::Jam(is_jammed));
    }

    fn run(&mut self, ms: u32) {
        (0..ms).for_each(|_| self.bus.step());
    }

    /// Drives with the whole supply.
    fn full_duty(&mut self) {
        if self.is_sts {
            self.write(sts::OPERATING_MODE, 2);
            self.write(sts::GOAL_TIME, 1000);
            self.write(sts::TORQUE_ENABLE, 1);
        } else {
            self.write(x::OPERATING_MODE, 16);
            self.write(x::TORQUE_ENABLE, 1);
            self.write(x::GOAL_PWM, 885);
        }
    }

    fn rate(&mut self) -> f64 {
        self.bus.servos()[0].sensed().rate
    }
}

/// Rate without a load, rad/s, and torque at stall, Nm: the catalogue, but for the STS3215 and the
/// torque of the XL330, for which the equations of friction give them: 0.955 tm = 0.0533 + 0.0282
/// w, tm = 0.4632 (7.4 - 1.2753 w), and 0.955 tm = 0.0533 + 1.386 t at rest.
const CATALOGUE: [(&str, f64, f64); 4] = [
    ("sts3215", 5.44, 2.32),
    ("sts3250", 7.87, 4.9),
    ("xl330-m288", 10.79, 0.38),
    ("xm430-w350", 4.817, 4.1),
];

#[test]
fn each_motor_has_the_rate_and_the_torque_of_its_source() {
    assert_eq!(CATALOGUE.map(|(name, ..)| name), NAMES);
    for (name, rate_rad_s, stall_nm) in CATALOGUE {
        let mut bench = Bench::new(name);
        bench.full_duty();
        bench.run(500);
        let rate = bench.rate() * std::f64::consts::TAU / 4096.0;
        assert!(
            (rate / rate_rad_s - 1.0).abs() < 0.06,
            "{name}: {rate} rad/s"
        );
        // A load of 7 % less is lifted, one of 7 % more is not.
        for (share, moves) in [(0.93, true), (1.07, false)] {
            let mut bench = Bench::new(name);
            bench.load(-share * stall_nm);
            bench.full_duty();
            bench.run(400);
            assert_eq!(
                bench.rate() > 5.0,
                moves,
                "{name}: {share} of {stall_nm} Nm, {}",
                bench.rate()
            );
        }
    }
}

#[test]
fn a_goal_is_reached_with_the_gains_of_the_table() {
    for name in NAMES {
        let mut bench = Bench::new(name);
        let (goal, enable, present) = if bench.is_sts {
            (
                sts::GOAL_POSITION,
                sts::TORQUE_ENABLE,
                sts::PRESENT_POSITION,
            )
        } else {
            (x::GOAL_POSITION, x::TORQUE_ENABLE, x::PRESENT_POSITION)
        };
        bench.write(enable, 1);
        assert_eq!(bench.write(goal, 3000), 0);
        bench.run(50);
        let early = bench.get(present);
        assert!(early < 2600, "{name}: {early} after 50 ms is a jump");
        bench.run(1500);
        let end = bench.get(present);
        assert!(end.abs_diff(3000) < 40, "{name}: {end}");
    }
}

#[test]
fn the_profile_of_an_sts_takes_the_time_of_its_trapezoid() {
    let mut bench = Bench::new("sts3215");
    bench.write(sts::ACCELERATION, 20);
    bench.write(sts::GOAL_VELOCITY, 1000);
    bench.write(sts::GOAL_POSITION, 3048);
    // 1000 steps at 1000 steps/s and 2000 steps/s^2: 1 s, and 0.5 s for both ramps.
    bench.run(750);
    assert!(
        bench.get(sts::PRESENT_POSITION).abs_diff(2548) < 60,
        "{}",
        bench.get(sts::PRESENT_POSITION)
    );
    assert!(bench.rate() > 900.0 && bench.get(sts::MOVING) == 1);
    bench.run(800);
    assert!(bench.get(sts::PRESENT_POSITION).abs_diff(3048) < 20 && bench.get(sts::MOVING) == 0);
}

#[test]
fn the_modes_of_an_sts_turn_step_and_drive() {
    let mut bench = Bench::new("sts3215");
    bench.write(sts::OPERATING_MODE, 1);
    bench.write(sts::GOAL_VELOCITY, -1000);
    bench.write(sts::TORQUE_ENABLE, 1);
    bench.run(1500);
    let rate = bench.get(sts::PRESENT_VELOCITY);
    assert!((rate + 1000).abs() < 30, "{rate} steps/s");
    // The position stays within a turn.
    assert!((0..4096).contains(&bench.get(sts::PRESENT_POSITION)));
    let mut bench = Bench::new("sts3215");
    bench.write(sts::OPERATING_MODE, 3);
    for _ in 0..3 {
        bench.write(sts::GOAL_POSITION, -2000);
        bench.run(1500);
    }
    let turned = bench.bus.servos()[0].sensed().position - 2048;
    assert!((turned + 6000).abs() < 40, "{turned}");
    assert!(bench.get(sts::PRESENT_POSITION).abs() < 40);
}

#[test]
fn torque_128_makes_the_position_the_middle_and_the_seam_lacks_one_step() {
    for turn in [700, -1500, -2047] {
        let mut bench = Bench::new("sts3215");
        bench.write(sts::OPERATING_MODE, 3);
        bench.write(sts::GOAL_POSITION, turn);
        bench.run(1500);
        bench.write(sts::TORQUE_ENABLE, 0);
        bench.write(sts::OPERATING_MODE, 0);
        bench.run(10);
        bench.write(sts::TORQUE_ENABLE, 128);
        bench.run(10);
        let position = bench.get(sts::PRESENT_POSITION);
        assert!(position.abs_diff(2048) <= 2, "{turn}: {position}");
        assert!(bench.get(sts::HOMING_OFFSET).abs() <= 2047);
        assert_eq!(bench.get(sts::TORQUE_ENABLE), 0);
    }
}

#[test]
fn an_overload_is_reported_weakens_the_output_and_is_recovered() {
    let mut bench = Bench::new("sts3215");
    bench.write(sts::GOAL_POSITION, 4000);
    bench.run(200);
    bench.jam(true);
    // 2 s by the table.
    bench.run(1950);
    assert_eq!(
        (bench.get(sts::STATUS), bench.get(sts::PRESENT_LOAD)),
        (0, 1000)
    );
    bench.run(100);
    assert_eq!(bench.get(sts::STATUS) & 32, 32);
    let load = bench.get(sts::PRESENT_LOAD).abs();
    assert!(load <= 200, "{load}");
    // The status is in every answer, and the torque can be taken off all the same.
    assert_eq!(bench.write(sts::TORQUE_ENABLE, 0) & 32, 32);
    bench.jam(false);
    bench.run(10);
    assert_eq!(
        (bench.get(sts::TORQUE_ENABLE), bench.get(sts::STATUS) & 32),
        (0, 0)
    );
    bench.write(sts::GOAL_POSITION, 2048);
    bench.run(2500);
    let position = bench.get(sts::PRESENT_POSITION);
    assert!(position.abs_diff(2048) < 40, "{position}");
}

#[test]
fn a_profile_by_time_lasts_its_time_in_the_modes_of_position_and_velocity() {
    let mut bench = Bench::new("xm430-w350");
    bench.write(x::DRIVE_MODE, 4);
    bench.write(x::TORQUE_ENABLE, 1);
    bench.write(x::PROFILE_VELOCITY, 1000);
    bench.write(x::PROFILE_ACCELERATION, 250);
    bench.write(x::GOAL_POSITION, 3048);
    // 1000 steps in 1 s with ramps of 0.25 s: 1333 steps/s, and 167 steps in each ramp.
    for (ms, position) in [(250, 2215), (250, 2548), (250, 2881), (250, 3048)] {
        bench.run(ms);
        let trajectory = bench.get(x::POSITION_TRAJECTORY);
        // Periods of 1.3 steps, and limits rounded up.
        assert!(
            trajectory.abs_diff(position) <= 3,
            "{trajectory}, {position}"
        );
    }
    let mut bench = Bench::new("xm430-w350");
    bench.write(x::DRIVE_MODE, 4);
    bench.write(x::OPERATING_MODE, 1);
    bench.write(x::TORQUE_ENABLE, 1);
    bench.write(x::PROFILE_ACCELERATION, 500);
    bench.write(x::GOAL_VELOCITY, 100);
    for velocity in [50, 100] {
        bench.run(250);
        let trajectory = bench.get(x::VELOCITY_TRAJECTORY);
        assert!(trajectory.abs_diff(velocity) <= 1, "{trajectory}");
    }
}

#[test]
fn the_position_mode_in_reverse_stays_within_a_turn() {
    let mut bench = Bench::new("xl330-m288");
    bench.write(x::DRIVE_MODE, 1);
    bench.run(1);
    assert_eq!(bench.get(x::PRESENT_POSITION), 2048);
    bench.write(x::TORQUE_ENABLE, 1);
    assert_eq!(bench.write(x::GOAL_POSITION, 3000), 0);
    bench.run(1500);
    let position = bench.get(x::PRESENT_POSITION);
    assert!(position.abs_diff(3000) < 40, "{position}");
    // The shaft has turned the other way.
    assert!(bench.bus.servos()[0].sensed().position < 1200);
}

#[test]
fn the_torque_is_on_after_a_start_that_is_configured_so() {
    let mut bench = Bench::new("xl330-m288");
    bench.write(x::STARTUP_CONFIGURATION, 1);
    let reboot = dynamixel::encode(1, 8, &[]);
    bench.bus.receive(&reboot, &mut Sent::default());
    bench.load(0.1);
    bench.run(1000);
    assert_eq!(bench.get(x::TORQUE_ENABLE), 1);
    assert!(bench.rate().abs() < 1.0, "{}", bench.rate());
}

#[test]
fn a_voltage_beyond_the_register_reads_as_its_end() {
    for (name, field, end) in [
        ("sts3215", sts::PRESENT_VOLTAGE, 255),
        ("xl330-m288", x::PRESENT_INPUT_VOLTAGE, 65_535),
    ] {
        let mut bench = Bench::new(name);
        bench.bus.apply(Fault::Supply(7000.0));
        bench.run(1);
        assert_eq!(bench.get(field), end, "{name}");
    }
}

#[test]
fn a_current_limit_of_the_position_mode_limits_the_grip() {
    let mut bench = Bench::new("xm430-w350");
    bench.write(x::OPERATING_MODE, 5);
    bench.write(x::GOAL_CURRENT, 100);
    bench.write(x::TORQUE_ENABLE, 1);
    bench.write(x::GOAL_POSITION, 4000);
    // A spring of 5 Nm/rad from 300 steps on stands for the object.
    for _ in 0..3000 {
        let turned = f64::from(bench.bus.servos()[0].sensed().position - 2348);
        bench.load(if turned > 0.0 {
            -5.0 * turned * std::f64::consts::TAU / 4096.0
        } else {
            0.0
        });
        bench.run(1);
    }
    let current = bench.get(x::PRESENT_CURRENT);
    assert!((current - 100).abs() <= 1, "{current}");
    assert!(bench.get(x::PRESENT_POSITION) < 2700);
    assert_eq!(bench.get(x::HARDWARE_ERROR_STATUS), 0);
}

#[test]
fn a_jam_shuts_a_dynamixel_down_until_it_is_rebooted() {
    let mut bench = Bench::new("xm430-w350");
    bench.write(x::TORQUE_ENABLE, 1);
    bench.write(x::GOAL_POSITION, 3500);
    bench.run(100);
    bench.jam(true);
    bench.run(1500);
    assert_eq!(bench.get(x::HARDWARE_ERROR_STATUS), 32);
    assert_eq!(bench.get(x::TORQUE_ENABLE), 0);
    assert_eq!(bench.write(x::TORQUE_ENABLE, 1), 0x87);
    bench.jam(false);
    let reboot = dynamixel::encode(1, 8, &[]);
    bench.bus.receive(&reboot, &mut Sent::default());
    bench.run(5);
    assert_eq!(bench.write(x::TORQUE_ENABLE, 1), 0);
}

#[test]
fn the_bus_watchdog_stops_a_turning_dynamixel() {
    let mut bench = Bench::new("xl330-m288");
    bench.write(x::OPERATING_MODE, 1);
    bench.write(x::TORQUE_ENABLE, 1);
    bench.write(x::GOAL_VELOCITY, 150);
    bench.write(x::BUS_WATCHDOG, 40);
    bench.run(700);
    assert!(
        (bench.get(x::PRESENT_VELOCITY) - 150).abs() < 15,
        "{}",
        bench.get(x::PRESENT_VELOCITY)
    );
    bench.run(1500);
    assert_eq!(
        (bench.get(x::BUS_WATCHDOG), bench.get(x::PRESENT_VELOCITY)),
        (-1, 0)
    );
}

#[test]
fn a_soft_supply_breaks_down_under_six_servos() {
    let bus = |supply_ohm| {
        let model = model("sts3215").expect("a model");
        let mut bus = Bus::new(&model, 6, supply_ohm).expect("in range");
        let goal = [
            &[42, 2][..],
            &(1..=6).flat_map(|id| [id, 0xE8, 3]).collect::<Vec<u8>>(),
        ]
        .concat();
        bus.receive(
            &feetech::encode(BROADCAST, 0x83, &goal),
            &mut Sent::default(),
        );
        let mut least = f64::INFINITY;
        for _ in 0..300 {
            bus.step();
            least = least.min(bus.servos()[0].sensed().supply_v);
        }
        least
    };
    assert_eq!(bus(0.0), 7.4);
    assert!(bus(0.5) < 5.0, "{}", bus(0.5));
}

#[test]
fn faults_begin_and_end() {
    let mut bench = Bench::new("sts3215");
    let ping = feetech::encode(1, 1, &[]);
    let right = [0xFF, 0xFF, 1, 2, 0, 0xFC];
    bench.apply(OfServo::Absent(true));
    assert!(bench.answer(&ping).is_empty());
    bench.apply(OfServo::Absent(false));
    bench.apply(OfServo::Corrupt(1));
    assert_eq!(bench.answer(&ping), [0xFF, 0xFF, 1, 2, 0, 0xFD]);
    assert_eq!(bench.answer(&ping), right);
    bench.apply(OfServo::Id(9));
    assert!(bench.answer(&ping).is_empty());
    bench.apply(OfServo::Id(1));
    // A supply below the limit of 4 V: the status reports it, while the torque is off.
    bench.bus.apply(Fault::Supply(3.5));
    bench.run(5);
    assert_eq!(
        (bench.get(sts::STATUS), bench.get(sts::PRESENT_VOLTAGE)),
        (1, 35)
    );
    bench.bus.apply(Fault::Of(2, OfServo::Jam(true)));
}
