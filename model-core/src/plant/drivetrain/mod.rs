//! A motor, a gear train and a load, to stand in for the drivetrain.
//!
//! ```text
//! bridge ── winding (R, L, back-EMF) ── gear train (friction, backlash, flexibility) ── load
//! ```
//!
//! # The Futaba S3305
//!
//! Its catalogue, as commonly quoted, gives 8.9 kg cm and 0.20 s/60 deg at 6 V (7.1 kg cm and
//! 0.25 s/60 deg at 4.8 V), and nothing of the motor within. The defaults are estimates, made to agree with the stall
//! torque and with equation (2) of the paper as this project reads it, `2.836/(1 + 0.1318 s)`
//! (deg/s)/%: 283.6 deg/s = 4.950 rad/s at full duty. All at the output shaft:
//!
//! | quantity | value |
//! |---|---|
//! | friction, 3 % of the stall torque | 0.028 + 0.002 = 0.030 Nm |
//! | torque before friction at stall: 8.9 kg cm + friction = `n k V/R` | 0.873 + 0.030 = 0.903 Nm |
//! | slope of torque over rate: 0.873 Nm/4.950 rad/s | 0.1763 Nm s/rad |
//! | of it viscous, 1 % | 0.0020 Nm s/rad |
//! | of it back-EMF: `(n k)^2/R` | 0.1743 Nm s/rad |
//! | hence `n k` = 0.1743 x 6 V/0.903 Nm, `R` = `n k` x 6 V/0.903 Nm | 1.158 Vs/rad, 7.7 ohm |
//! | gear ratio for 15,100 rpm of the motor: `n`, hence `k` | 320, 3.62 mNm/A |
//! | inertia: 0.1318 s x 0.1763 Nm s/rad, over `n^2` for the rotor | 0.0232 kg m^2, 2.27e-7 kg m^2 |
//!
//! Losses of the gears appear as friction, not as an efficiency, so the stall current of 0.78 A is
//! on the low side.

pub mod electrical;
pub mod friction;
pub mod gear_train;
pub mod load;
pub mod pwm;

use core::f64::consts::PI;

use self::electrical::{ElectricalParameters, Terminal, Winding};
use self::friction::{Friction, FrictionParameters};
use self::gear_train::{GearTrain, GearTrainParameters, Motion, SHORTEST_STEP_S, STEP_SHARE};
use self::load::{Load, LoadParameters};
use super::PlantState;
use crate::limits::within;
use crate::parameter::{Parameter, ParameterError, Parameters};

/// All parameters of the drivetrain.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct DrivetrainParameters {
    /// The motor and its supply.
    pub electrical: ElectricalParameters,
    /// Gears, shafts, inertias and stops.
    pub gear_train: GearTrainParameters,
    /// The friction of the gear train.
    pub friction: FrictionParameters,
    /// The external load.
    pub load: LoadParameters,
}

impl DrivetrainParameters {
    /// Checks every value against its range.
    ///
    /// # Errors
    /// That of the first parameter outside its range, that of a rotor so light that the back-EMF
    /// would stop it faster than the shortest step resolves, and that of a hinge moment that drives
    /// the load away more strongly than its shaft holds it: no stop stands behind the shaft.
    fn check(&self) -> Result<(), ParameterError> {
        self.electrical.check()?;
        self.gear_train.check()?;
        self.friction.check()?;
        self.load.check()?;
        let (motor, gears) = (&self.electrical, &self.gear_train);
        let lightest = motor.torque_constant_nm_a * motor.torque_constant_nm_a
            / motor.winding_resistance_ohm
            * (SHORTEST_STEP_S / STEP_SHARE);
        check_from::<GearTrainParameters>(
            "motor_inertia_kg_m2",
            lightest,
            gears.motor_inertia_kg_m2,
        )?;
        check_from::<LoadParameters>(
            "hinge_moment_nm_deg",
            -gears.shaft_stiffness_nm_deg,
            self.load.hinge_moment_nm_deg,
        )
    }
}

/// Checks a value against a range whose lower end other parameters may raise.
fn check_from<P: Parameters>(name: &str, least: f64, value: f64) -> Result<(), ParameterError> {
    for row in P::TABLE.iter().filter(|row| row.name == name) {
        let min = row.min.max(least);
        Parameter { min, ..*row }.check(value)?;
    }
    Ok(())
}

/// Everything that can be read off the drivetrain at an instant.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Reading {
    /// The output shaft, where the encoder sits.
    pub output: PlantState,
    /// The motor's own shaft; it turns by the gear ratio more.
    pub motor: PlantState,
    /// The load behind the output shaft.
    pub load: PlantState,
    /// Current of the winding, A.
    pub current_a: f64,
    /// Back-EMF, V.
    pub back_emf_v: f64,
    /// Voltage between the ends of the winding, V.
    pub terminal_v: f64,
    /// Torque of the motor, at the output, Nm.
    pub motor_torque_nm: f64,
    /// Torque of all friction, at the output, positive against positive motion, Nm.
    pub friction_torque_nm: f64,
    /// External torque at the load, Nm.
    pub load_torque_nm: f64,
}

/// The drivetrain, driven by whatever stands at the ends of the winding.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Drivetrain {
    winding: Winding,
    train: GearTrain,
    load: Load,
    terminal: Terminal,
    supply_v: f64,
    gear_ratio: f64,
    /// Back-EMF per rate of the output, and torque at the output per current.
    constant_nm_a: f64,
    longest_step_s: f64,
}

/// Longest time that one call simulates, s: it bounds the work of a call.
const LONGEST_ADVANCE_S: f64 = 1.0;

/// Greatest recorded torque. On the lightest load, 1e-8 kg m^2, it makes 1e14 rad/s^2: far from the
/// ends of the numbers after any time that somebody waits for.
const GREATEST_TORQUE_NM: f64 = 1e6;

impl Drivetrain {
    /// A drivetrain at rest at zero, without current.
    ///
    /// # Errors
    /// That of the first parameter outside its range; for the motor's inertia the range starts
    /// where its mechanical time constant, `R J/k^2`, is five of the shortest steps, 4 us.
    ///
    /// ```
    /// use model_core::plant::drivetrain::{Drivetrain, DrivetrainParameters, electrical::Terminal};
    ///
    /// let mut drivetrain = Drivetrain::try_new(&DrivetrainParameters::default()).unwrap();
    /// drivetrain.advance(Terminal::Driven(6.0), 0.5);
    /// // 283.6 deg/s x (1 - exp(-0.5 s/0.1319 s)) = 277.2 deg/s
    /// assert!((drivetrain.reading().output.rate_deg_s - 277.2).abs() < 0.5);
    /// ```
    pub fn try_new(parameters: &DrivetrainParameters) -> Result<Self, ParameterError> {
        parameters.check()?;
        let load = Load::new(&parameters.load);
        let friction = Friction::new(parameters.friction);
        let train = GearTrain::new(&parameters.gear_train, friction, &load);
        let motor = &parameters.electrical;
        let gear_ratio = parameters.gear_train.gear_ratio;
        // The back-EMF acts on the rotor at the rate k^2/(R J), which is a decay like others.
        let decay_s = motor.winding_resistance_ohm * parameters.gear_train.motor_inertia_kg_m2
            / (motor.torque_constant_nm_a * motor.torque_constant_nm_a);
        let longest_step_s = train.longest_step_s(&load).min(STEP_SHARE * decay_s);
        Ok(Self {
            winding: Winding::new(motor),
            train,
            load,
            terminal: Terminal::Coast,
            supply_v: motor.supply_v,
            gear_ratio,
            constant_nm_a: motor.torque_constant_nm_a * gear_ratio,
            longest_step_s,
        })
    }

    /// Moves on by `dt_s` with the bridge in this state, in equal steps short enough to be stable.
    ///
    /// A time that is not above 0, or NaN, is no time; of one beyond a second, a second is taken.
    /// A voltage of NaN is 0.
    pub fn advance(&mut self, terminal: Terminal, dt_s: f64) {
        self.terminal = match terminal {
            Terminal::Driven(v) if v.is_nan() => Terminal::Driven(0.0),
            Terminal::Driven(v) => Terminal::Driven(within(v, -self.supply_v, self.supply_v)),
            other => other,
        };
        if dt_s.is_nan() || dt_s <= 0.0 {
            return;
        }
        let dt_s = dt_s.min(LONGEST_ADVANCE_S);
        // At most 1 s / 0.78 us = 1.3 million, at least 1.
        let steps = libm::ceil(dt_s / self.longest_step_s) as u32;
        let step_s = dt_s / f64::from(steps);
        let step = self.winding.step(step_s);
        for _ in 0..steps {
            let back_emf_v = self.back_emf_v();
            let mean_a = self.winding.advance(self.terminal, back_emf_v, &step);
            self.train
                .advance(step_s, self.constant_nm_a * mean_a, &self.load);
        }
    }

    /// Adds a torque to the external load until the next call, Nm: a recording, a gust.
    /// It is held within +-1e6 Nm; NaN is 0.
    pub fn set_recorded_torque_nm(&mut self, torque_nm: f64) {
        self.load.recorded_nm = if torque_nm.is_nan() {
            0.0
        } else {
            within(torque_nm, -GREATEST_TORQUE_NM, GREATEST_TORQUE_NM)
        };
    }

    /// Changes the supply of the bridge, V, held within its parameter's range; NaN is 0.
    ///
    /// ```
    /// use model_core::plant::drivetrain::{Drivetrain, DrivetrainParameters, electrical::Terminal};
    ///
    /// let mut drivetrain = Drivetrain::try_new(&DrivetrainParameters::default()).unwrap();
    /// drivetrain.set_supply_v(3.0);
    /// drivetrain.advance(Terminal::Driven(6.0), 1e-6);
    /// assert_eq!(drivetrain.reading().terminal_v, 3.0);
    /// ```
    pub fn set_supply_v(&mut self, supply_v: f64) {
        let (least, most) = (0.0, electrical::GREATEST_SUPPLY_V);
        self.supply_v = if supply_v.is_nan() {
            0.0
        } else {
            within(supply_v, least, most)
        };
        self.winding.set_supply_v(self.supply_v);
    }

    /// Jams the gear train, or frees it: what is jammed takes every torque and stands still.
    pub fn set_jammed(&mut self, is_jammed: bool) {
        self.train.is_jammed = is_jammed;
    }

    /// Everything that can be read off now.
    pub fn reading(&self) -> Reading {
        let back_emf_v = self.back_emf_v();
        let current_a = self.winding.current_a;
        let (motor_rad, motor_rad_s) = self.train.motor();
        Reading {
            output: state(self.train.output()),
            motor: state((motor_rad * self.gear_ratio, motor_rad_s * self.gear_ratio)),
            load: state(self.train.load()),
            current_a,
            back_emf_v,
            terminal_v: self.winding.terminal_v(self.terminal, back_emf_v),
            motor_torque_nm: self.constant_nm_a * current_a,
            friction_torque_nm: self.train.friction_nm,
            load_torque_nm: self.train.load_nm(&self.load),
        }
    }

    fn back_emf_v(&self) -> f64 {
        self.constant_nm_a * self.train.motor().1
    }
}

fn state((angle_rad, rate_rad_s): Motion) -> PlantState {
    PlantState {
        angle_deg: angle_rad * (180.0 / PI),
        rate_deg_s: rate_rad_s * (180.0 / PI),
    }
}

#[cfg(test)]
mod tests;
