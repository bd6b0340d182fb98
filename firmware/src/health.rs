//! The actuator's health: slow means of its measurements in motion, and their change from a
//! baseline.

mod jam;
mod motions;
mod play;
mod statistics;
mod supply;

use canopen::cia402::Mode;
use model_core::{control::encoder_word::Magnet, time::CONTROL_RATE_HZ};

use self::{
    jam::Jam,
    motions::{LENGTH, Motions},
    play::Play,
    supply::Supply,
};
pub use self::{jam::LEVEL_DEG_S as JAM_LEVEL_DEG_S, motions::Results};
use crate::{
    application::{BoardState, Outputs},
    parameters::{HealthSettings, ModelSettings},
};

/// Least rate of a motion, deg/s: two counts of the encoder in 4 ms.
const LEAST_DEG_S: f32 = 40.0;

/// The motor hardly turns below this share of the least rate: 5 deg/s.
const REST_SHARE: i32 = 8;

/// Back-EMF at the least rate, mV, by the motor parameters 2011h. Not inlined: its constants would
/// lie behind the reset that ends its caller, where the bound of the stack expects instructions.
#[inline(never)]
fn least_mv(model: &ModelSettings) -> i32 {
    let v_s_rad = model.torque_constant_nm_a * model.gear_ratio;
    (v_s_rad * LEAST_DEG_S.to_radians() * 1e3) as i32
}

/// Fractional bits of a mean.
const FRACTION: u32 = 13;

/// Greatest value of a mean, the greatest supply and more: a difference of two is 2^28 at most.
const GREATEST: i32 = 1 << 14;

/// A mean over the last values, of all if they are few.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
struct Mean(i32);

impl Mean {
    /// Takes a value, as one of `count`.
    fn take(&mut self, value: i32, count: u16) {
        let value = value.clamp(-GREATEST, GREATEST) << FRACTION;
        // The count is not 0.
        self.0 += (value - self.0) / i32::from(count.max(1));
    }

    /// In whole units.
    fn whole(self) -> i32 {
        self.0 >> FRACTION
    }

    /// In tenths; a mean is 2^27 at most.
    fn in_tenths(self) -> i32 {
        (self.0 * 10) >> FRACTION
    }
}

/// The means, and their results at the end of the last motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Health {
    motions: Motions,
    /// Control periods in which the actuator is enabled without a fault, at most [`LENGTH`].
    readings: u16,
    /// Share of them with a weak magnet, thousandths.
    weak: Mean,
    /// Back-EMF of the control period before, mV.
    last_mv: i32,
    supply: Supply,
    play: Play,
    jam: Jam,
    warnings: u8,
    /// The baseline of friction and constant with which the means have begun.
    baseline: (u16, u32),
}

/// Bits of the warnings: a quantity that is beyond its level, or differs from its baseline by more.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Warning {
    /// Friction.
    Friction = 0,
    /// Constant of the back-EMF.
    Constant = 1,
    /// A load from outside.
    Load = 2,
    /// A weak magnet.
    Magnet = 3,
    /// Resistance of the supply.
    Supply = 4,
    /// Play between motor and shaft.
    Play = 5,
    /// A shaft that is jammed.
    Jam = 6,
}

impl Warning {
    /// All of them.
    pub const ALL: [Self; 7] = [
        Self::Friction,
        Self::Constant,
        Self::Load,
        Self::Magnet,
        Self::Supply,
        Self::Play,
        Self::Jam,
    ];

    /// Its bit.
    pub fn bit(self) -> u8 {
        1 << self as u8
    }
}

impl Health {
    /// Takes the outputs of a control period.
    pub fn observe(&mut self, settings: &HealthSettings, model: &ModelSettings, outputs: &Outputs) {
        let t = &outputs.telemetry;
        // Means that begin with their baseline have no motion of before it.
        let baseline = (settings.friction, settings.constant);
        if self.baseline != baseline {
            *self = Self {
                baseline,
                play: self.play.anew(),
                ..Self::default()
            };
        }
        if t.tick.is_multiple_of(CONTROL_RATE_HZ) {
            self.warnings = self.compare(settings);
        }
        let is_measured = outputs.state != BoardState::Initialising;
        if is_measured && t.present.is_empty() {
            self.supply.observe(t);
        }
        // A torque ends a motion at any rate.
        let is_torque = matches!(
            outputs.motion.mode,
            Mode::ProfileTorque | Mode::CyclicTorque
        );
        if outputs.state != BoardState::Enabled || !t.present.is_empty() || is_torque {
            self.motions.interrupt();
            self.play.interrupt();
            self.jam = Jam::default();
            if outputs.state == BoardState::Disabled {
                self.play.idle(t.back_emf_mv, least_mv(model) / REST_SHARE);
            }
            return;
        }
        self.readings = self.readings.saturating_add(1).min(LENGTH);
        let is_weak = t.magnet == Magnet::Marginal;
        self.weak.take(i32::from(is_weak) * 1000, self.readings);
        let before_mv = core::mem::replace(&mut self.last_mv, t.back_emf_mv);
        let mean_mv = (t.back_emf_mv + before_mv) / 2;
        let least_mv = least_mv(model);
        let level = settings.jam_level;
        if level > 0 {
            // Where a diode conducts the last value remains, which would be that of a motor that
            // has turned.
            let turns_mv = match t.back_emf_mv == before_mv {
                true => 0,
                false => t.back_emf_mv - self.play.offset_mv(),
            };
            if self.jam.observe(t, turns_mv, least_mv, level) {
                self.warnings |= Warning::Jam.bit();
            }
        }
        self.play.observe(mean_mv, t.angle);
        self.motions.observe(t, mean_mv, least_mv);
    }

    /// Control periods of the means, of the way that has fewer.
    pub fn samples(&self) -> u16 {
        self.motions.samples()
    }

    /// The results; `None` before there are enough values.
    pub fn results(&self) -> Option<Results> {
        self.motions.results()
    }

    /// Share of the control periods in which the magnet is weak, thousandths.
    pub fn weak(&self) -> i32 {
        self.weak.whole()
    }

    /// Resistance of the supply, mohm; `None` before there are enough values.
    pub fn supply(&self) -> Option<i32> {
        self.supply.resistance()
    }

    /// Play between motor and shaft, mdeg; `None` before there are enough motions.
    pub fn play(&self) -> Option<i32> {
        self.play.mdeg()
    }

    /// Change of the friction from its baseline, thousandths; `None` without one.
    pub fn friction_change(&self, settings: &HealthSettings) -> Option<i32> {
        change_permille(self.results()?.friction, settings.friction.into())
    }

    /// Change of the constant from its baseline, thousandths; `None` without one.
    pub fn constant_change(&self, settings: &HealthSettings) -> Option<i32> {
        // At most 10,000,000.
        change_permille(self.results()?.constant, settings.constant as i32)
    }

    /// Standard error of friction and load, 0.1 mA; `None` while it is not known.
    pub fn friction_error(&self) -> Option<i32> {
        self.motions.friction_error()
    }

    /// That of the constant, uV s/deg.
    pub fn constant_error(&self) -> Option<i32> {
        self.motions.constant_error()
    }

    /// That of the resistance of the supply, mohm.
    pub fn supply_error(&self) -> Option<i32> {
        self.supply.standard_error()
    }

    /// That of the play, mdeg.
    pub fn play_error(&self) -> Option<i32> {
        self.play.standard_error()
    }

    /// Change of the resistance of the supply from its baseline, mohm; `None` without one.
    pub fn supply_change(&self, settings: &HealthSettings) -> Option<i32> {
        change(self.supply()?, settings.supply)
    }

    /// Change of the play from its baseline, mdeg; `None` without one.
    pub fn play_change(&self, settings: &HealthSettings) -> Option<i32> {
        change(self.play()?, settings.play)
    }

    /// The warnings, a bit each.
    pub fn warnings(&self) -> u8 {
        self.warnings
    }

    /// The warnings. One ends at three quarters of its level.
    fn compare(&self, settings: &HealthSettings) -> u8 {
        let friction = self.friction_change(settings);
        let constant = self.constant_change(settings);
        let compared = [
            (Warning::Friction, friction, settings.friction_level),
            (Warning::Constant, constant, settings.constant_level),
            (
                Warning::Load,
                self.results().map(|it| it.load),
                settings.load_level,
            ),
            (Warning::Magnet, Some(self.weak()), settings.magnet_level),
            (Warning::Supply, self.supply(), settings.supply_level),
            (Warning::Play, self.play(), settings.play_level),
        ];
        let mut warnings = 0;
        for (warning, difference, level) in compared {
            let bit = warning.bit();
            let level = i32::from(level);
            let ends_at = if self.warnings & bit == 0 {
                level
            } else {
                level - level / 4
            };
            if level > 0 && difference.is_some_and(|it| it.abs() > ends_at) {
                warnings |= bit;
            }
        }
        warnings
    }
}

/// Change from a baseline; `None` without one.
fn change(value: i32, baseline: u16) -> Option<i32> {
    (baseline > 0).then(|| value - i32::from(baseline))
}

/// Change from a baseline, in thousandths of it; `None` without one.
fn change_permille(value: i32, baseline: i32) -> Option<i32> {
    let difference = i64::from(value) - i64::from(baseline);
    let change = (difference * 1000).checked_div(baseline.into())?;
    Some(change.clamp(i16::MIN.into(), i16::MAX.into()) as i32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::ObjectValues;
    use model_core::control::units::rate;

    const MODEL: ModelSettings = ObjectValues::DEFAULT.model;

    /// An enabled actuator at this rate, deg/s, with this current and back-EMF.
    fn outputs(deg_s: f64, current_ma: i32, back_emf_mv: i32) -> Outputs {
        let mut outputs = Outputs {
            state: BoardState::Enabled,
            ..Outputs::default()
        };
        outputs.telemetry.rate = rate(deg_s);
        outputs.telemetry.current_ma = current_ma;
        outputs.telemetry.back_emf_mv = back_emf_mv;
        outputs
    }

    /// Motions of 200 control periods each way: 30 mA of friction, 10 mA of load, 5 mA and 40 mV of
    /// offset, 20 mV s/deg, and 300 mA that accelerate and decelerate.
    fn moved(settings: &HealthSettings) -> Health {
        let mut health = Health::default();
        for motion in 0..40 {
            let sign = if motion % 2 == 0 { 1 } else { -1 };
            for period in 0..200 {
                let inertia_ma = if period < 100 { 300 } else { -300 };
                let current_ma = sign * (30 + inertia_ma) + 10 + 5;
                let out = outputs(100.0 * f64::from(sign), current_ma, sign * 2000 + 40);
                health.observe(settings, &MODEL, &out);
            }
            // The mean over the first period at rest is above that of the least rate still.
            for _ in 0..2 {
                health.observe(settings, &MODEL, &outputs(0.0, 0, 40));
            }
        }
        health
    }

    #[test]
    fn inertia_and_offsets_cancel() {
        let health = moved(&HealthSettings::DEFAULT);
        let Results {
            friction,
            load,
            constant,
        } = health.results().unwrap();
        // In tenths; the last motion weighs 2.5 % more at its end: 300 mA times 100/4096 at most.
        assert!((friction - 300).abs() <= 10, "{friction}");
        // The offset of the current counts as a load.
        assert!((load - 150).abs() <= 75, "{load}");
        // Steps of a mean are cut off below 4096/2^13, 0.5 of 100 deg/s: the ways differ by less.
        assert!((constant - 20_000).abs() <= 30, "{constant}");
        assert_eq!(health.warnings(), 0);
    }

    #[test]
    fn a_changed_baseline_begins_the_means_anew() {
        let mut health = moved(&HealthSettings::DEFAULT);
        let changed = HealthSettings {
            friction: 250,
            ..HealthSettings::DEFAULT
        };
        health.observe(&HealthSettings::DEFAULT, &MODEL, &outputs(0.0, 0, 0));
        assert!(health.results().is_some());
        health.observe(&changed, &MODEL, &outputs(0.0, 0, 0));
        assert_eq!((health.results(), health.samples()), (None, 0));
    }

    /// The rate is that of 4 control periods before, and 30 mA accelerate by 1 deg/s in a period.
    #[test]
    fn a_lag_of_the_rate_is_no_friction() {
        let mut health = Health::default();
        let mut rates = [0.0; 5];
        for motion in 0..60 {
            let sign = if motion % 2 == 0 { 1 } else { -1 };
            for period in 0..200 {
                let change = match period {
                    0..80 => 1,
                    120.. => -1,
                    _ => 0,
                };
                rates.rotate_right(1);
                rates[0] = rates[1] + f64::from(sign * change);
                let current_ma = sign * (30 + 30 * change);
                let back_emf_mv = (rates[0] * 20.0) as i32;
                health.observe(
                    &HealthSettings::DEFAULT,
                    &MODEL,
                    &outputs(rates[4], current_ma, back_emf_mv),
                );
            }
        }
        let Results { friction, .. } = health.results().unwrap();
        // A period more of acceleration, 30 mA, in 130.
        assert!((friction - 300).abs() <= 5, "{friction}");
    }

    #[test]
    fn each_level_has_its_warning() {
        let baseline = HealthSettings {
            friction: 250,
            constant: 18_000,
            ..HealthSettings::DEFAULT
        };
        let levels = |friction_level, constant_level, load_level| HealthSettings {
            friction_level,
            constant_level,
            load_level,
            ..baseline
        };
        assert_eq!(moved(&levels(100, 200, 300)).warnings(), 1);
        assert_eq!(moved(&levels(300, 100, 300)).warnings(), 2);
        assert_eq!(moved(&levels(300, 200, 50)).warnings(), 4);
    }

    #[test]
    fn a_warning_ends_at_three_quarters_of_its_level() {
        let settings = HealthSettings {
            magnet_level: 400,
            ..HealthSettings::DEFAULT
        };
        let mut health = Health::default();
        let mut share = |weak: u32, strong: u32| {
            for period in 0..weak + strong {
                let mut out = outputs(0.0, 0, 0);
                if period >= strong {
                    out.telemetry.magnet = Magnet::Marginal;
                }
                health.observe(&settings, &MODEL, &out);
            }
            (health.warnings(), health.weak())
        };
        // Of all control periods 50 %, 33 % and 25 % are weak.
        assert_eq!(share(500, 500).0, 8);
        assert_eq!(share(0, 500).0, 8);
        assert_eq!(share(0, 500).0, 0);
    }
}
