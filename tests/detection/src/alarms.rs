//! Alarms of intact drives.

use std::f64::consts::PI;

use firmware::health::JAM_LEVEL_DEG_S;
use host_sim::input::flight_like;
use model_core::control::units::angle;
use model_core::plant::board::BoardPlantOptions;
use model_core::sensors::noise::Noise;

use crate::drive::{Drive, PERIOD_S};
use crate::jam::JamWarning;

/// Control periods in which a gust changes the load, as a half of 1 - cos (CS-VLA 333): 12.5 mean
/// chords of 0.2 m at 25 m/s are 0.1 s.
const GUST_PERIODS: f64 = 25.0;

/// Moment of inertia of a control surface of 50 mm chord and 20 g about its hinge, m c^2/3, kg m^2.
const SURFACE_KG_M2: f64 = 0.02 * 0.05 * 0.05 / 3.0;

/// Levels of the warning of a jam, deg/s: the recommended one, and lower ones, which show how
/// false warnings grow.
pub const JAM_LEVELS: [u16; 6] = [JAM_LEVEL_DEG_S, 34, 30, 28, 26, 24];

/// What an hour of an intact drive shows.
#[derive(Debug, Clone, Copy, Default)]
pub struct Alarms {
    /// Faults.
    pub faults: u64,
    /// Warnings of a jam at each of the levels.
    pub jams: [u64; JAM_LEVELS.len()],
}

impl std::ops::Add for Alarms {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            faults: self.faults + other.faults,
            jams: std::array::from_fn(|level| self.jams[level] + other.jams[level]),
        }
    }
}

/// Faults and warnings of an hour of an intact drive in flight-like motion, with the worst
/// parameters: constant, resistance and inductance of the motor each off by 30 %, in all eight
/// combinations, a degree of play in the gears, and loads of up to a third of the stall torque of
/// that motor, another one every 0.1 to 1 s.
pub fn alarms(hour: u32) -> Alarms {
    let mut chance = Noise::new(u64::from(hour), 77);
    let mut uniform = || (chance.gaussian(1.0) / 3.0).clamp(-1.0, 1.0);
    let mut options = BoardPlantOptions::realistic(u64::from(hour));
    let [constant, resistance, inductance] =
        [1, 2, 4].map(|bit| if hour & bit == 0 { 0.7 } else { 1.3 });
    let motor = &mut options.drivetrain.electrical;
    motor.torque_constant_nm_a *= constant;
    motor.winding_resistance_ohm *= resistance;
    motor.winding_inductance_h *= inductance;
    // The linkage is stiff, so that the integration has steps of the gears only.
    let gears = &mut options.drivetrain.gear_train;
    gears.backlash_deg = 1.0;
    gears.shaft_stiffness_nm_deg = f64::INFINITY;
    gears.load_inertia_kg_m2 = SURFACE_KG_M2;
    let greatest_nm = 0.3 * constant / resistance;
    let mut command_deg = flight_like(hour.into());
    let mut drive = Drive::enabled(&options);
    let mut found = Alarms::default();
    let mut jams = JAM_LEVELS.map(JamWarning::at);
    let (mut period, mut before_nm) = (0_u32, 0.0);
    while f64::from(period) * PERIOD_S < 3600.0 {
        let load_nm = greatest_nm * uniform();
        let lasts = GUST_PERIODS + 225.0 * uniform().abs();
        for since in 0..lasts as u32 {
            let gust = (f64::from(since + 1) / GUST_PERIODS).min(1.0);
            let share = (1.0 - (PI * gust).cos()) / 2.0;
            drive.defects().torque_nm = before_nm + share * (load_nm - before_nm);
            let command = angle(command_deg(f64::from(period) * PERIOD_S));
            period += 1;
            let faults = drive.follow(command);
            let counts = jams.iter_mut().zip(&mut found.jams);
            for (level, (jam, count)) in JAM_LEVELS.into_iter().zip(counts) {
                let begins = jam.begins(&drive.outputs);
                *count += u64::from(begins);
                if begins && level >= JAM_LEVEL_DEG_S {
                    println!("hour {hour}: a jam at {level} deg/s after {period} periods");
                }
            }
            if !faults.is_empty() {
                let names: Vec<_> = faults.iter().map(|fault| format!("{fault:?}")).collect();
                println!("hour {hour}: {} after {period} periods", names.join(", "));
                found.faults += 1;
                drive = Drive::enabled(&options);
            }
        }
        before_nm = load_nm;
    }
    found
}
