//! Detailed model of motor, gear train and load.
//!
//! ```text
//! bridge ── winding (R, L, back-EMF) ── gear train (friction, backlash, flexibility) ── load
//! ```
//!
//! # The Futaba S3305
//!
//! The catalogue, as commonly quoted, states 8.9 kg cm and 0.20 s/60 deg at 6 V (7.1 kg cm and 0.25
//! s/60 deg at 4.8 V), and no data of the motor. The defaults are estimates that agree with the
//! stall torque and with equation (2) of the paper as this project reads it, `2.836/(1 + 0.1318 s)`
//! (deg/s)/%: 283.6 deg/s = 4.950 rad/s at full duty. All values are referred to the output shaft:
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
//! Gear losses are modelled as friction, not as an efficiency, so the stall current of 0.78 A is
//! rather low.

pub mod electrical;
pub mod friction;
pub mod gear_train;
pub mod lanes;
pub mod load;
mod pwm;
pub mod stepped;

use core::f64::consts::PI;

use self::electrical::{ElectricalParameters, Terminal, Winding};
use self::friction::{Friction, FrictionParameters};
use self::gear_train::{
    GearTrain, GearTrainParameters, Motion, SHORTEST_STEP_S, STEP_SHARE, TrainState,
};
use self::load::{Load, LoadParameters};
use super::PlantState;
use crate::limits::within;
use crate::parameter::{Parameter, ParameterError, Parameters};
use crate::time::TICK_S;

/// Rate, rad/s, and current, A, below which a body, or a winding, is at rest. What decays further
/// becomes a subnormal number, with which a PC computes ten times slower.
const AT_REST: f64 = 1e-150;

/// A rate or a current, or 0 at rest.
#[inline(always)]
fn or_rest(value: f64) -> f64 {
    if value.abs() < AT_REST { 0.0 } else { value }
}

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
    /// Names the first parameter outside its range, a rotor inertia so small that the back-EMF
    /// would stop the rotor faster than the shortest step resolves, or a destabilising hinge moment
    /// above the stiffness of the shaft, since no stop limits the load.
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

/// Checks a value against a range whose lower limit may be raised by other parameters.
fn check_from<P: Parameters>(name: &str, least: f64, value: f64) -> Result<(), ParameterError> {
    for row in P::TABLE.iter().filter(|row| row.name == name) {
        let min = row.min.max(least);
        Parameter { min, ..*row }.check(value)?;
    }
    Ok(())
}

/// State and signals of the drivetrain at an instant.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Reading {
    /// The output shaft, measured by the encoder.
    pub output: PlantState,
    /// The motor shaft, before the gear ratio.
    pub motor: PlantState,
    /// The load after the output shaft.
    pub load: PlantState,
    /// Current of the winding, A.
    pub current_a: f64,
    /// Back-EMF, V.
    pub back_emf_v: f64,
    /// Terminal voltage of the winding, V.
    pub terminal_v: f64,
    /// Motor torque at the output, Nm.
    pub motor_torque_nm: f64,
    /// Total friction torque at the output, positive if it opposes positive motion, Nm.
    pub friction_torque_nm: f64,
    /// External torque at the load, Nm.
    pub load_torque_nm: f64,
}

/// The drivetrain, driven at the terminals of the winding.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Drivetrain {
    winding: Winding,
    train: GearTrain,
    load: Load,
    terminal: Terminal,
    supply_v: f64,
    gear_ratio: f64,
    /// Back-EMF per output rate, equal to output torque per current.
    constant_nm_a: f64,
    longest_step_s: f64,
    /// The longest step that resolves the decay of the rotor's rate.
    decay_step_s: f64,
    steps_of_tick: Steps,
}

/// What changes in a [`Drivetrain`] that keeps its supply and is not jammed.
#[derive(Debug, Clone, Copy, PartialEq)]
struct DrivetrainState {
    current_a: f64,
    train: TrainState,
    recorded_nm: f64,
    terminal: Terminal,
}

/// A time in equal steps.
#[derive(Debug, Clone, Copy)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Steps {
    count: u32,
    step_s: f64,
    electrical: electrical::Step,
}

impl Steps {
    /// The fewest steps of at most the longest one, for a time above 0 and up to
    /// [`LONGEST_ADVANCE_S`].
    fn new(dt_s: f64, longest_step_s: f64, winding: &Winding) -> Self {
        let count = Self::count(dt_s, longest_step_s);
        let step_s = dt_s / f64::from(count);
        Self {
            count,
            step_s,
            electrical: winding.step(step_s),
        }
    }

    /// At most 1 s / 0.78 us = 1.3 million, at least 1.
    fn count(dt_s: f64, longest_step_s: f64) -> u32 {
        libm::ceil(dt_s / longest_step_s) as u32
    }
}

/// Maximum time that one call simulates, s, which limits the work of a call.
const LONGEST_ADVANCE_S: f64 = 1.0;

/// Maximum recorded torque. With the smallest load inertia, 1e-8 kg m^2, it gives 1e14 rad/s^2,
/// which overflows no number in any practical time.
const GREATEST_TORQUE_NM: f64 = 1e6;

/// Maximum added inertia: that of a tonne at a metre.
const GREATEST_INERTIA_KG_M2: f64 = 1e3;

impl Drivetrain {
    /// A drivetrain at rest at zero, without current.
    ///
    /// # Errors
    /// Names the first parameter outside its range; the range of the motor inertia starts where its
    /// mechanical time constant, `R J/k^2`, is five of the shortest steps, 4 us.
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
        Ok(Self::of_checked(parameters))
    }

    /// The same of parameters that were checked.
    fn of_checked(parameters: &DrivetrainParameters) -> Self {
        let load = Load::new(&parameters.load);
        let friction = Friction::new(parameters.friction);
        let train = GearTrain::new(&parameters.gear_train, friction, &load);
        let motor = &parameters.electrical;
        let gear_ratio = parameters.gear_train.gear_ratio;
        // The back-EMF decelerates the rotor with the rate k^2/(R J), a decay like the others.
        let decay_s = motor.winding_resistance_ohm * parameters.gear_train.motor_inertia_kg_m2
            / (motor.torque_constant_nm_a * motor.torque_constant_nm_a);
        let decay_step_s = STEP_SHARE * decay_s;
        let longest_step_s = train.longest_step_s(&load).min(decay_step_s);
        let winding = Winding::new(motor);
        Self {
            steps_of_tick: Steps::new(TICK_S, longest_step_s, &winding),
            winding,
            train,
            load,
            terminal: Terminal::Coast,
            supply_v: motor.supply_v,
            gear_ratio,
            constant_nm_a: motor.torque_constant_nm_a * gear_ratio,
            longest_step_s,
            decay_step_s,
        }
    }

    /// Advances by `dt_s` with the bridge in this state, in equal steps short enough to be stable.
    ///
    /// Returns the mean current of the winding over that time, A.
    ///
    /// A time that is NaN or not above 0 has no effect; a time above one second is limited to one
    /// second. A voltage of NaN counts as 0.
    #[inline(always)]
    pub fn advance(&mut self, terminal: Terminal, dt_s: f64) -> f64 {
        self.set_terminal(terminal);
        if dt_s.is_nan() || dt_s <= 0.0 {
            return self.winding.current_a;
        }
        let dt_s = dt_s.min(LONGEST_ADVANCE_S);
        let steps = if dt_s == TICK_S {
            self.steps_of_tick
        } else {
            Steps::new(dt_s, self.longest_step_s, &self.winding)
        };
        self.take(steps)
    }

    /// As [`Self::advance`], by this number of ticks, up to 20, with the same result as tick by
    /// tick.
    #[inline(always)]
    fn advance_ticks(&mut self, terminal: Terminal, ticks: u32) {
        self.set_terminal(terminal);
        let mut steps = self.steps_of_tick;
        // 20 x 64 steps at most.
        steps.count *= ticks;
        self.take(steps);
    }

    fn set_terminal(&mut self, terminal: Terminal) {
        self.terminal = match terminal {
            Terminal::Driven(v) if v.is_nan() => Terminal::Driven(0.0),
            Terminal::Driven(v) => Terminal::Driven(within(v, -self.supply_v, self.supply_v)),
            other => other,
        };
    }

    /// Simulates these steps; returns the mean current, A.
    #[inline(always)]
    fn take(&mut self, steps: Steps) -> f64 {
        // What a step changes stays in registers.
        let mut sum_a = 0.0;
        let (mut winding, constant_nm_a) = (self.winding.clone(), self.constant_nm_a);
        let (train, load, step_s) = (&mut self.train, &self.load, steps.step_s);
        let driven_v = match self.terminal {
            Terminal::Driven(v) => Some(v),
            Terminal::Brake => Some(0.0),
            Terminal::Coast => None,
        };
        match driven_v {
            Some(v) => train.advance(steps.count, step_s, load, |rate_rad_s| {
                let back_emf_v = constant_nm_a * rate_rad_s;
                let mean_a = winding.advance_driven(v, back_emf_v, &steps.electrical);
                sum_a += mean_a;
                constant_nm_a * mean_a
            }),
            None => train.advance(steps.count, step_s, load, |rate_rad_s| {
                let back_emf_v = constant_nm_a * rate_rad_s;
                let mean_a = winding.advance(Terminal::Coast, back_emf_v, &steps.electrical);
                sum_a += mean_a;
                constant_nm_a * mean_a
            }),
        }
        self.winding.current_a = winding.current_a;
        sum_a / f64::from(steps.count)
    }

    /// Stops what is at rest; called at least once in a PWM period.
    #[inline]
    pub(in crate::plant) fn settle(&mut self) {
        self.winding.current_a = or_rest(self.winding.current_a);
        self.train.settle();
    }

    #[inline(always)]
    fn state(&self) -> DrivetrainState {
        DrivetrainState {
            current_a: self.winding.current_a,
            train: self.train.state(),
            recorded_nm: self.load.recorded_nm,
            terminal: self.terminal,
        }
    }

    #[inline(always)]
    fn set_state(&mut self, state: &DrivetrainState) {
        self.winding.current_a = state.current_a;
        // The length of the steps derives from the inertia.
        self.set_added_inertia_kg_m2(state.train.added_kg_m2);
        self.train.set_state(&state.train);
        self.load.recorded_nm = state.recorded_nm;
        self.terminal = state.terminal;
    }

    /// Adds a torque to the external load until the next call, Nm, for example a recording or a
    /// gust. It is limited to +-1e6 Nm; NaN counts as 0.
    pub fn set_recorded_torque_nm(&mut self, torque_nm: f64) {
        self.load.recorded_nm = if torque_nm.is_nan() {
            0.0
        } else {
            within(torque_nm, -GREATEST_TORQUE_NM, GREATEST_TORQUE_NM)
        };
    }

    /// Inertia that moves with the load in addition to that of the parameters, kg m^2, until the
    /// next call: that of a joint of another simulation. It is limited to the range from 0 to 1e3;
    /// NaN counts as 0. Motions keep their rates.
    pub fn set_added_inertia_kg_m2(&mut self, inertia_kg_m2: f64) {
        let inertia_kg_m2 = if inertia_kg_m2.is_nan() {
            0.0
        } else {
            within(inertia_kg_m2, 0.0, GREATEST_INERTIA_KG_M2)
        };
        if self.train.set_added_inertia(inertia_kg_m2) {
            self.longest_step_s = self.train.longest_step_s(&self.load).min(self.decay_step_s);
            let steps = Steps::count(TICK_S, self.longest_step_s);
            // The coefficients of a step cost an exponential.
            if steps != self.steps_of_tick.count {
                self.steps_of_tick = Steps::new(TICK_S, self.longest_step_s, &self.winding);
            }
        }
    }

    /// Sets the angle of all bodies, deg; one that is not finite has no effect.
    pub fn place(&mut self, angle_deg: f64) {
        if angle_deg.is_finite() {
            self.train.place(angle_deg * (PI / 180.0));
        }
    }

    /// Moves the load by an angle, deg, and an impulse, Nm s: the effect of something that the
    /// external torque did not contain, such as a contact that another simulation has solved.
    /// Values that are not finite have no effect.
    pub fn push_load(&mut self, angle_deg: f64, impulse_nms: f64) {
        if angle_deg.is_finite() && impulse_nms.is_finite() {
            self.train.push_load(angle_deg * (PI / 180.0), impulse_nms);
        }
    }

    /// Sets the supply of the bridge, V, limited to the range of its parameter; NaN counts as 0.
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

    /// Sets the resistance of the winding, which its temperature changes, ohm; limited to the range
    /// of its parameter. NaN has no effect.
    ///
    /// ```
    /// use model_core::plant::drivetrain::{Drivetrain, DrivetrainParameters, electrical::Terminal};
    ///
    /// let mut drivetrain = Drivetrain::try_new(&DrivetrainParameters::default()).unwrap();
    /// drivetrain.set_jammed(true);
    /// drivetrain.set_winding_resistance_ohm(10.0);
    /// drivetrain.advance(Terminal::Driven(6.0), 0.01);
    /// assert!((drivetrain.reading().current_a - 0.6).abs() < 1e-9);
    /// ```
    pub fn set_winding_resistance_ohm(&mut self, resistance_ohm: f64) {
        if resistance_ohm.is_nan() {
            return;
        }
        self.winding
            .set_resistance(within(resistance_ohm, 0.05, 1000.0));
        self.steps_of_tick = Steps::new(TICK_S, self.longest_step_s, &self.winding);
    }

    /// Time constant of the winding, s.
    pub fn winding_time_constant_s(&self) -> f64 {
        self.winding.time_constant_s()
    }

    /// Jams or frees the gear train; a jammed gear train remains at rest under any torque.
    pub fn set_jammed(&mut self, is_jammed: bool) {
        self.train.is_jammed = is_jammed;
    }

    /// Torque of the shaft on the load, Nm: with a rigid shaft, of the gears on output and load.
    pub fn shaft_torque_nm(&self) -> f64 {
        self.train.shaft_nm()
    }

    /// Motion of the load.
    pub fn load(&self) -> PlantState {
        state(self.train.load())
    }

    /// The present state and signals.
    pub fn reading(&self) -> Reading {
        let (motor_rad, motor_rad_s) = self.train.motor();
        let back_emf_v = self.back_emf_v();
        Reading {
            output: state(self.train.output()),
            motor: state((motor_rad * self.gear_ratio, motor_rad_s * self.gear_ratio)),
            load: self.load(),
            current_a: self.winding.current_a,
            back_emf_v,
            terminal_v: self.winding.terminal_v(self.terminal, back_emf_v),
            motor_torque_nm: self.constant_nm_a * self.winding.current_a,
            friction_torque_nm: self.train.friction_nm,
            load_torque_nm: self.train.load_nm(&self.load),
        }
    }

    /// Turns the motor at the rate of this back-EMF.
    #[cfg(test)]
    pub(crate) fn spin(&mut self, back_emf_v: f64) {
        self.train.spin(back_emf_v / self.constant_nm_a);
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
