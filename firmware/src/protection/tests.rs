//! The protections alone, and measurements and conditions for the tests in their modules.

extern crate std;

use std::vec;

use super::*;
use crate::parameters::{
    EncoderLimits, StallLimits, SupplyLimits, TemperatureLimits, TimingLimits,
};
use crate::{measure::Ripple, parameters::BoardParameters};

/// No measurement at all.
pub(super) const UNMEASURED: Measured = Measured {
    count: None,
    travelled: None,
    magnet: None,
    sampled_ma: None,
    current: None,
    back_emf_mv: None,
    is_blind: true,
    is_back_emf_held: false,
    rate_change_mdeg_s: None,
    supply_mv: None,
    temperature_mdeg_c: None,
};

/// A current that is constant within the PWM period.
pub(super) fn smooth(mean_ma: i32) -> Option<PeriodCurrent> {
    Some(PeriodCurrent {
        mean_ma,
        stall_ma: mean_ma,
        standing_ma: mean_ma,
        square_ma2: mean_ma * mean_ma,
    })
}

/// A driven motor at rest with these measurements.
pub(super) fn driven(measured: &Measured) -> Conditions<'_> {
    Conditions {
        measured,
        is_driving: true,
        is_following: true,
        angle: Angle::ZERO,
        rate: Rate::ZERO,
        setpoint: Angle::ZERO.into(),
        rate_command: Rate::ZERO,
        duty: Percent::ZERO,
        is_stale: false,
        is_bus_lost: false,
        is_tripped: false,
        missed_periods: 0,
    }
}

/// Control periods until a check reports a fault, of at most 200.
fn periods_until(mut is_present: impl FnMut() -> bool) -> Option<u32> {
    (1..=200).find(|_| is_present())
}

/// A current whose sample is larger than its mean by this pulse, where 300 mA are expected without
/// a back-EMF.
#[derive(Clone, Copy)]
struct Pulsed {
    sampled_ma: i32,
    pulse_ma: i32,
    back_emf_mv: i32,
}

/// A current without a pulse, with this back-EMF.
fn constant(mean_ma: i32, back_emf_mv: i32) -> Pulsed {
    Pulsed {
        sampled_ma: mean_ma,
        pulse_ma: 0,
        back_emf_mv,
    }
}

/// Periods until the current of a motor is implausible, with these currents in turn, in both
/// directions.
fn until_implausible(currents: &[Pulsed]) -> Option<u32> {
    let [forward, backward] = [1, -1].map(|sign| until_implausible_towards(sign, currents));
    assert_eq!(forward, backward);
    forward
}

fn until_implausible_towards(sign: i32, currents: &[Pulsed]) -> Option<u32> {
    let ripple = Ripple::of(10.0, 1e-3);
    let mut guard = PlausibilityGuard::default();
    let mut currents = currents.iter().cycle();
    periods_until(|| {
        let it = *currents.next().expect("a period");
        let current = PeriodCurrent {
            mean_ma: sign * (it.sampled_ma - it.pulse_ma),
            stall_ma: sign * 300,
            ..PeriodCurrent::default()
        };
        let measured = Measured {
            sampled_ma: Some(sign * it.sampled_ma),
            current: Some(current),
            back_emf_mv: Some(sign * it.back_emf_mv),
            ..UNMEASURED
        };
        let present = guard.check(&EncoderLimits::DEFAULT, &ripple, true, &driven(&measured));
        present.contains(Fault::CurrentImplausible)
    })
}

#[test]
fn less_than_a_third_of_the_expected_current_is_implausible_after_60_ms() {
    let until = |mean_ma, back_emf_mv| until_implausible(&[constant(mean_ma, back_emf_mv)]);
    assert_eq!(until(99, 0), Some(15));
    assert_eq!(until(100, 0), None);
    assert_eq!(until(-200, 0), Some(15), "against the voltage");
    // 1 V at 10 ohm are 100 mA less; below 100 mA nothing is compared.
    assert_eq!(until(66, 1000), Some(15));
    assert_eq!(until(67, 1000), None);
    assert_eq!(until(0, 2000), Some(15));
    assert_eq!(until(0, 2010), None);
}

#[test]
fn the_pulse_of_a_slow_motor_shows_a_dead_current_sense() {
    // Of 2.73 V 27 mA are expected, and 100 mA of the sample.
    let until = |sampled_ma, pulse_ma, back_emf_mv| {
        until_implausible(&[Pulsed {
            sampled_ma,
            pulse_ma,
            back_emf_mv,
        }])
    };
    assert_eq!(until(0, 73, 2730), Some(15));
    assert_eq!(until(33, 73, 2730), Some(15));
    assert_eq!(until(34, 73, 2730), None);
    // A brake: 25 mA against a pulse that is six times as large; 26 mA.
    assert_eq!(until(41, 150, 3250), Some(15));
    assert_eq!(until(42, 150, 3250), None);
    assert_eq!(until(0, 155, 3260), None);
}

#[test]
fn periods_in_which_little_current_is_expected_neither_count_nor_clear() {
    // With 2.01 V of back-EMF 99 mA are expected: the 15th of the others is the 43rd period.
    let [dead, sound, little] = [constant(0, 0), constant(300, 0), constant(0, 2010)];
    assert_eq!(until_implausible(&[dead, little, little]), Some(43));
    assert_eq!(until_implausible(&[dead, sound, little]), None);
}

/// Periods until the motor's polarity is wrong, of a shaft with this rate and back-EMF.
fn until_wrong_polarity(rate_deg_s: i32, back_emf_mv: i32) -> Option<u32> {
    until_wrong_polarity_beyond_play(rate_deg_s, back_emf_mv, true)
}

fn until_wrong_polarity_beyond_play(
    rate_deg_s: i32,
    back_emf_mv: i32,
    is_beyond_play: bool,
) -> Option<u32> {
    let measured = Measured {
        travelled: Some(rate_deg_s.signum()),
        back_emf_mv: Some(back_emf_mv),
        ..UNMEASURED
    };
    let conditions = Conditions {
        rate: Rate::from_int(rate_deg_s),
        ..driven(&measured)
    };
    let limits = EncoderLimits {
        stuck_back_emf_mv: 800,
        ..EncoderLimits::DEFAULT
    };
    let ripple = Ripple::of(10.0, 1e-3);
    let mut guard = PlausibilityGuard::default();
    periods_until(|| {
        let present = guard.check(&limits, &ripple, is_beyond_play, &conditions);
        present.contains(Fault::MotorPolarity)
    })
}

#[test]
fn an_encoder_that_turns_against_the_back_emf_is_noticed_after_12_ms() {
    for sign in [1, -1] {
        assert_eq!(until_wrong_polarity(-100 * sign, 800 * sign), Some(3));
        assert_eq!(until_wrong_polarity(-100 * sign, 799 * sign), None);
        assert_eq!(until_wrong_polarity(100 * sign, 800 * sign), None);
        // The play of the gears, in which a load turns the shaft slowly.
        assert_eq!(until_wrong_polarity(-20 * sign, 800 * sign), None);
        assert_eq!(until_wrong_polarity(-21 * sign, 800 * sign), Some(3));
        // The motor takes it up against the shaft.
        let within_play = until_wrong_polarity_beyond_play(-100 * sign, 800 * sign, false);
        assert_eq!(within_play, None);
    }
}

/// Whether a shaft that pulls and travels a count in each `every` control periods is stalled.
fn is_stalled(every: i32, direction: i32) -> bool {
    let mut guard = StallGuard::default();
    (0..2000).any(|period| {
        let measured = Measured {
            travelled: Some(if period % every == 0 { direction } else { 0 }),
            current: smooth(StallLimits::DEFAULT.stall_current_ma),
            ..UNMEASURED
        };
        guard.check(&StallLimits::DEFAULT, &driven(&measured))
    })
}

#[test]
fn a_slow_shaft_that_pulls_is_not_stalled() {
    for direction in [1, -1] {
        // 22 to 3.7 deg/s: within the way for most of the time.
        for every in 1..=6 {
            assert!(!is_stalled(every, direction), "{every}");
        }
        // Three counts in 84 ms.
        assert!(is_stalled(7, direction));
    }
}

#[test]
fn a_stall_is_judged_by_the_current_of_a_motor_that_stands() {
    let limit_ma = StallLimits::DEFAULT.stall_current_ma;
    for (standing_ma, is_stall) in [(limit_ma - 1, false), (limit_ma, true), (-limit_ma, true)] {
        let current = PeriodCurrent {
            standing_ma,
            // A winding of 70 % of the resistance seems to carry more.
            ..smooth(limit_ma * 6 / 5).expect("a current")
        };
        let measured = Measured {
            travelled: Some(0),
            current: Some(current),
            ..UNMEASURED
        };
        let mut guard = StallGuard::default();
        let found = (0..2000).any(|_| guard.check(&StallLimits::DEFAULT, &driven(&measured)));
        assert_eq!(found, is_stall, "{standing_ma} mA");
    }
}

/// Whether a shaft that pulls is stalled that stands for some control periods and turns at 22 deg/s
/// for others, again and again.
fn is_stalled_in_turns(stands: usize, turns: usize) -> bool {
    let mut guard = StallGuard::default();
    let pattern = [vec![0; stands], vec![1; turns]].concat();
    pattern.into_iter().cycle().take(2000).any(|travelled| {
        let measured = Measured {
            travelled: Some(travelled),
            current: smooth(StallLimits::DEFAULT.stall_current_ma),
            ..UNMEASURED
        };
        guard.check(&StallLimits::DEFAULT, &driven(&measured))
    })
}

#[test]
fn a_shaft_that_stands_for_more_than_half_of_the_time_is_stalled() {
    assert!(is_stalled_in_turns(40, 24));
    assert!(!is_stalled_in_turns(24, 40));
}

#[test]
fn a_stalled_motor_travels_at_most_the_limit_from_where_it_began_to_pull() {
    let limits = StallLimits {
        stall_current_ma: 500,
        stall_way_mdeg: 1000,
        stall_ms: 400,
    };
    // Periods of a pull until a stall, whose first one travels these counts.
    let pull = |counts| {
        let mut guard = StallGuard::default();
        let mut check = |mean_ma, travelled| {
            let measured = Measured {
                travelled: Some(travelled),
                current: smooth(mean_ma),
                ..UNMEASURED
            };
            guard.check(&limits, &driven(&measured))
        };
        assert!(!check(499, 100));
        let mut counts = Some(counts);
        periods_until(|| check(500, counts.take().unwrap_or(0)))
    };
    // 11.4 counts.
    for counts in [11, -11] {
        assert_eq!(pull(counts), Some(100), "{counts}");
    }
    // A longer way ends the pull where it ends: its period counts for none.
    for counts in [12, -12] {
        assert_eq!(pull(counts), Some(101), "{counts}");
    }
}

#[test]
fn supply_and_temperature_are_wrong_beyond_their_limits_and_right_at_them() {
    let present = |supply_mv, temperature_mdeg_c| {
        let measured = Measured {
            supply_mv: Some(supply_mv),
            temperature_mdeg_c: Some(temperature_mdeg_c),
            ..UNMEASURED
        };
        let p = BoardParameters {
            supply: SupplyLimits {
                under_voltage_mv: 4000,
                over_voltage_mv: 6300,
                supply_ms: 4,
            },
            temperature: TemperatureLimits {
                over_temperature_mdeg_c: 85_000,
                over_temperature_ms: 4,
            },
            ..BoardParameters::DEFAULT
        };
        let supply = SupplyGuard::default().check(&p.supply, &driven(&measured));
        supply.or(TemperatureGuard::default().check(&p.temperature, &driven(&measured)))
    };
    assert_eq!(present(4000, 85_000), FaultSet::EMPTY);
    assert_eq!(present(6300, 85_000), FaultSet::EMPTY);
    let of = |fault| FaultSet::of(&[fault]);
    assert_eq!(present(3999, 85_000), of(Fault::UnderVoltage));
    assert_eq!(present(6301, 85_000), of(Fault::OverVoltage));
    assert_eq!(present(6300, 85_001), of(Fault::OverTemperature));
}

#[test]
fn as_many_missed_periods_as_are_tolerated_are_no_fault() {
    let limits = TimingLimits {
        overruns: 3,
        ..TimingLimits::DEFAULT
    };
    let mut guard = TimingGuard::default();
    let mut is_overrun = |missed_periods| {
        let conditions = Conditions {
            missed_periods,
            ..driven(&UNMEASURED)
        };
        guard
            .check(&limits, &conditions)
            .contains(Fault::LoopOverrun)
    };
    assert!(!is_overrun(3));
    assert!(is_overrun(1));
}
