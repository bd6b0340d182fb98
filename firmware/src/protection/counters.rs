//! The leaky counters of the protections, by name.
//!
//! The outputs of the control loop have room for one of them, and report another one in each
//! control period; all of them take 13 control periods, 52 ms.

use super::Protection;

/// A leaky counter: the control periods in which a condition held, less those in which it did not.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Counter {
    /// Lost samples of the encoder: faults 1, 2 and 5.
    LostSamples,
    /// A weak magnet: fault 3.
    MagnetWeak,
    /// Over-current: fault 6.
    OverCurrent,
    /// Stall: fault 9.
    Stall,
    /// A shaft that does not follow: fault 10.
    NotFollowing,
    /// Under-voltage: fault 11.
    UnderVoltage,
    /// Over-voltage: fault 12.
    OverVoltage,
    /// Over-temperature: fault 13.
    OverTemperature,
    /// Missing measurements: fault 14.
    Unmeasured,
    /// A missing back-EMF: fault 14.
    NoBackEmf,
    /// Missed control periods: fault 16.
    Overruns,
    /// An implausible current: fault 20.
    CurrentImplausible,
    /// An encoder that turns against the motor: fault 21.
    MotorPolarity,
}

impl Counter {
    /// All counters in the order of the sub-indices of object 2051h.
    pub const ALL: [Self; 13] = [
        Self::LostSamples,
        Self::MagnetWeak,
        Self::OverCurrent,
        Self::Stall,
        Self::NotFollowing,
        Self::UnderVoltage,
        Self::OverVoltage,
        Self::OverTemperature,
        Self::Unmeasured,
        Self::NoBackEmf,
        Self::Overruns,
        Self::CurrentImplausible,
        Self::MotorPolarity,
    ];

    /// The counter that is reported in the control period of this number.
    ///
    /// ```
    /// use firmware::protection::Counter;
    /// assert_eq!(Counter::of_tick(0), Counter::LostSamples);
    /// assert_eq!(Counter::of_tick(14), Counter::MagnetWeak);
    /// ```
    pub fn of_tick(tick: u32) -> Self {
        let position = tick as usize % Self::ALL.len();
        // The remainder is less than the length.
        Self::ALL
            .get(position)
            .copied()
            .unwrap_or(Self::LostSamples)
    }
}

impl Protection {
    /// The value of a counter.
    pub fn counter(&self, counter: Counter) -> u16 {
        match counter {
            Counter::LostSamples => self.encoder.lost_samples(),
            Counter::MagnetWeak => self.encoder.weak_periods(),
            Counter::OverCurrent => self.over_current.periods(),
            Counter::Stall => self.stall.periods(),
            Counter::NotFollowing => self.following.periods(),
            Counter::UnderVoltage => self.supply.under_periods(),
            Counter::OverVoltage => self.supply.over_periods(),
            Counter::OverTemperature => self.temperature.periods(),
            Counter::Unmeasured => self.timing.unmeasured_periods(),
            Counter::NoBackEmf => self.timing.blind_periods(),
            Counter::Overruns => self.timing.missed_periods(),
            Counter::CurrentImplausible => self.plausibility.current_periods(),
            Counter::MotorPolarity => self.plausibility.polarity_periods(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        application::{DeadBandSettings, MotorLimits},
        interface::{Samples, Settings},
        measure::{MotorConstants, PeriodCurrent},
        parameters::{BoardParameters, LimitSettings, ModelSettings},
        protection::{
            Conditions, Measured,
            tests::{UNMEASURED, driven, smooth},
        },
    };
    use model_core::control::{
        encoder_correction::EncoderCorrection,
        encoder_word::{EncoderWord, Magnet},
        pwm_timer::PwmCompare,
        shaft_tracker::ShaftTracker,
        units::{Angle, Rate},
    };

    /// Everything is measured, of a motor at rest.
    const SOUND: Measured = Measured {
        travelled: Some(0),
        magnet: Some(Magnet::Steady),
        sampled_ma: Some(0),
        current: no_current_at_a_stall_current_of(0),
        back_emf_mv: Some(0),
        is_blind: false,
        is_back_emf_held: false,
        rate_change_mdeg_s: None,
        supply_mv: Some(6_000),
        temperature_mdeg_c: Some(25_000),
        ..UNMEASURED
    };

    const fn no_current_at_a_stall_current_of(stall_ma: i32) -> Option<PeriodCurrent> {
        Some(PeriodCurrent {
            mean_ma: 0,
            stall_ma,
            standing_ma: 0,
            square_ma2: 0,
        })
    }

    /// The counters after one control period with these samples, if any, and conditions.
    fn counted(samples: Option<&Samples>, conditions: &Conditions<'_>) -> [u16; 13] {
        let parameters = BoardParameters::DEFAULT;
        let settings = Settings {
            board: &parameters,
            motor: &MotorConstants::of(&ModelSettings::DEFAULT),
            limits: &MotorLimits::of(
                &LimitSettings::DEFAULT,
                &parameters,
                &ModelSettings::DEFAULT,
            ),
            dead_band: &DeadBandSettings::default(),
            encoder: &EncoderCorrection::NONE,
            observes_rate: false,
        };
        let mut protection = Protection::new();
        if let Some(samples) = samples {
            let (shaft, compare) = (ShaftTracker::default(), PwmCompare::default());
            protection.measure(settings, samples, &shaft, compare);
        }
        protection.check(settings, conditions);
        Counter::ALL.map(|counter| protection.counter(counter))
    }

    #[test]
    fn a_condition_counts_in_its_counter_alone() {
        type Change = fn(&mut Measured);
        let measured = |change: Change| {
            let mut measured = SOUND;
            change(&mut measured);
            measured
        };
        let changes: [(Counter, Change); 10] = [
            (Counter::MagnetWeak, |m| m.magnet = Some(Magnet::Marginal)),
            (Counter::OverCurrent, |m| m.sampled_ma = Some(2_001)),
            (Counter::Stall, |m| m.current = smooth(500)),
            (Counter::UnderVoltage, |m| m.supply_mv = Some(3_999)),
            (Counter::OverVoltage, |m| m.supply_mv = Some(7_601)),
            (Counter::OverTemperature, |m| {
                m.temperature_mdeg_c = Some(85_001)
            }),
            (Counter::Unmeasured, |m| m.current = None),
            (Counter::NoBackEmf, |m| m.is_blind = true),
            (Counter::CurrentImplausible, |m| {
                m.current = no_current_at_a_stall_current_of(300);
            }),
            // It runs freely: 900 mV at 7.7 ohm.
            (Counter::MotorPolarity, |m| {
                (m.travelled, m.back_emf_mv) = (Some(1), Some(-900));
                m.current = no_current_at_a_stall_current_of(-116);
            }),
        ];
        let alone = |counter| Counter::ALL.map(|other| u16::from(other == counter));
        for (counter, change) in changes {
            let measured = measured(change);
            let conditions = Conditions {
                rate: Rate::from_int(if counter == Counter::MotorPolarity {
                    30
                } else {
                    0
                }),
                ..driven(&measured)
            };
            assert_eq!(counted(None, &conditions), alone(counter), "{counter:?}");
        }
        let sound = driven(&SOUND);
        assert_eq!(counted(None, &sound), [0; 13]);
        let far = Conditions {
            setpoint: Angle::from_int(20).into(),
            rate_command: Rate::from_int(40),
            ..sound
        };
        assert_eq!(counted(None, &far), alone(Counter::NotFollowing));
        let missed = Conditions {
            missed_periods: 1,
            ..sound
        };
        assert_eq!(counted(None, &missed), alone(Counter::Overruns));
        let samples = Samples {
            encoder: None,
            ..Samples::at_rest(EncoderWord::new(0))
        };
        assert_eq!(counted(Some(&samples), &sound), alone(Counter::LostSamples));
    }

    #[test]
    fn each_counter_is_reported_once_in_thirteen_control_periods() {
        for start in [0, 1, 250, 4_000_000_000] {
            let mut reported: [u32; 13] = [0; 13];
            for tick in start..start + 13 {
                reported[Counter::of_tick(tick) as usize] += 1;
            }
            assert_eq!(reported, [1; 13]);
        }
    }
}
