//! The control step against its equations in `f64`, and against inputs that no bench would give.

use proptest::prelude::*;

use super::{
    arithmetic::{Coefficient, Gain},
    cascade::{CascadeState, Coefficients},
    encoder_word::{COUNT_DEG, EncoderCount, EncoderError, EncoderWord, Magnet},
    parameters::ControlParameters,
    units::{Angle, Percent, Quantity, angle, percent, rate},
};
use crate::{
    control::pwm_timer::{Modulator, PWM_COUNTS},
    parameter::Parameters,
    time::CONTROL_PERIOD_S,
};

/// The equations of the module's documentation in `f64`, without slew limit.
#[derive(Default)]
struct Referee {
    counts: Option<i32>,
    rate: f64,
    integrator: f64,
}

impl Referee {
    fn duty(&mut self, p: &ControlParameters, counts: i32, command: f64) -> f64 {
        let travelled = counts - self.counts.unwrap_or(counts);
        self.counts = Some(counts);
        let raw = travelled as f64 * COUNT_DEG / CONTROL_PERIOD_S;
        self.rate += p.rate_filter * (raw - self.rate);
        let r = (p.position_gain * (command - counts as f64 * COUNT_DEG))
            .max(-p.rate_command_limit_down_deg_s)
            .min(p.rate_command_limit_up_deg_s);
        let e = r - self.rate;
        let v = p.proportional_gain * e + self.integrator + p.feed_forward_gain * r;
        let u = v.max(-p.duty_limit_pct).min(p.duty_limit_pct);
        self.integrator += CONTROL_PERIOD_S * (p.integral_gain * e + p.anti_windup_gain * (u - v));
        u
    }
}

fn healthy(counts: i32) -> EncoderWord {
    EncoderWord::of(EncoderCount::new(counts as u16), Magnet::Steady)
}

/// The count of a valid word.
fn valid(counts: i32) -> Option<EncoderCount> {
    Some(EncoderCount::new(counts as u16))
}

fn coefficients(parameters: &ControlParameters) -> Coefficients {
    Coefficients::try_new(parameters).expect("parameters within their ranges")
}

/// Any parameters that the constructor takes.
fn parameters() -> impl Strategy<Value = ControlParameters> {
    let table = ControlParameters::TABLE;
    proptest::collection::vec(0.0..=1.0, table.len()).prop_map(move |shares| {
        let mut p = ControlParameters::default();
        for (i, (row, share)) in table.iter().zip(shares).enumerate() {
            let max = row.max.min(1e6);
            *p.get_mut(i).unwrap() = row.min + share * (max - row.min);
        }
        p.encoder_direction = if p.encoder_direction < 0.0 { -1.0 } else { 1.0 };
        if p.position_min_deg > p.position_max_deg {
            core::mem::swap(&mut p.position_min_deg, &mut p.position_max_deg);
        }
        p
    })
}

#[test]
fn the_duty_is_that_of_the_equations_in_double_precision() {
    let p = ControlParameters {
        feed_forward_gain: 0.1,
        rate_command_limit_up_deg_s: 240.0,
        rate_command_limit_down_deg_s: 350.0,
        ..Default::default()
    };
    let gains = coefficients(&p);
    let (mut state, mut referee) = (CascadeState::default(), Referee::default());
    let mut counts = 0;
    for k in 0..20_000 {
        // A shaft that runs to and fro over several turns while the command steps.
        counts += [3, -7, 12, -2, 40, -46][k / 700 % 6];
        let command = [0.0, 90.0, -33.25, 170.5, 1.0][k / 250 % 5];
        let word = valid(counts);
        state.observe(&gains, word);
        let duty = state.regulate(&gains, angle(command)).duty.to_f64();
        let expected = referee.duty(&p, counts, command);
        // The coefficients are off by 2^-31 of them. Errors up to 1,400 deg/s pass through Kp, and
        // the integrator loses by its anti-windup, Ki/Kaw = Kp: 2 * 1.32 * 1,400 * 2^-31.
        assert!(
            (duty - expected).abs() < 2e-6,
            "step {k}: {duty} is not {expected}"
        );
    }
}

#[test]
fn every_single_bit_error_of_a_valid_word_is_seen() {
    for count in 0..4096 {
        for bit in 0..18 {
            let broken = EncoderWord::new(healthy(count).bits() ^ 1 << bit);
            assert_eq!(broken.read(), Err(EncoderError::Parity));
        }
    }
}

#[test]
fn a_line_stuck_at_either_level_is_never_an_angle() {
    assert_eq!(EncoderWord::new(0).read(), Err(EncoderError::NotReady));
    assert_eq!(
        EncoderWord::new(u32::MAX).read(),
        Err(EncoderError::CordicOverflow)
    );
}

#[test]
fn the_angle_counts_turns_and_knows_direction_and_zero() {
    let p = ControlParameters {
        encoder_zero_deg: 90.0,
        encoder_direction: -1.0,
        ..Default::default()
    };
    let gains = coefficients(&p);
    let mut state = CascadeState::default();
    for turn in 0..10 {
        for quarter in 0..4 {
            state.observe(&gains, valid(1024 - 1024 * quarter));
            let expected = f64::from(turn * 4 + quarter) * 90.0;
            assert_eq!(state.angle().to_f64(), expected);
        }
    }
}

#[test]
fn lost_samples_leave_no_jump_in_the_rate() {
    let gains = coefficients(&ControlParameters::default());
    let mut state = CascadeState::default();
    for k in 0..200 {
        // Eight counts a period are 175.78125 deg/s; of four words two in a row are broken.
        let is_lost = k % 4 == 1 || k % 4 == 2;
        state.observe(&gains, valid(8 * k).filter(|_| !is_lost));
        if k > 100 {
            let error = state.rate().to_f64() - 175.781_25;
            assert!(error.abs() < 1e-3, "period {k}: off by {error}");
        }
    }
}

#[test]
fn a_duty_of_half_the_supply_is_half_the_pwm_period() {
    let gains = coefficients(&ControlParameters {
        proportional_gain: 1.0,
        position_gain: 1.0,
        ..Default::default()
    });
    let mut state = CascadeState::default();
    state.observe(&gains, valid(0));
    let duty = state.regulate(&gains, angle(50.0)).duty;
    assert_eq!(Modulator::default().next(duty).get(), PWM_COUNTS / 2);
}

#[test]
fn a_reversal_of_the_command_moves_the_duty_by_its_slew_and_the_integrator_is_corrected() {
    let p = ControlParameters {
        duty_slew_pct_s: 2500.0,
        ..Default::default()
    };
    let gains = coefficients(&p);
    let mut state = CascadeState::default();
    state.observe(&gains, valid(0));
    for _ in 0..250 {
        state.regulate(&gains, angle(90.0));
    }
    // From 100 % to -100 % at 10 % a period.
    for k in 1..=20 {
        let step = state.regulate(&gains, angle(-90.0));
        assert_eq!(step.duty, percent(100.0 - 10.0 * f64::from(k)));
        assert_eq!(step.limits.slew, k < 20);
    }
    // An integrator that had wound up for a second would hold the duty at its end.
    assert!(state.regulate(&gains, angle(0.0)).duty > percent(-100.0));
}

#[test]
fn beyond_the_position_limits_the_command_is_held_at_them() {
    let gains = coefficients(&ControlParameters {
        position_min_deg: -10.0,
        position_max_deg: 20.0,
        ..Default::default()
    });
    let mut state = CascadeState::default();
    state.observe(&gains, valid(0));
    for (command_deg, rate_deg_s, limited) in [
        (15.0, 120.0, false),
        (20.0, 160.0, false),
        (90.0, 160.0, true),
        (-90.0, -80.0, true),
    ] {
        let step = state.regulate(&gains, angle(command_deg));
        assert_eq!(step.rate_command, rate(rate_deg_s));
        assert_eq!(step.limits.position, limited, "{command_deg}");
    }
}

#[test]
fn a_narrower_duty_limit_acts_at_once_whatever_the_slew() {
    let with_limit = |duty_limit_pct| {
        coefficients(&ControlParameters {
            duty_limit_pct,
            duty_slew_pct_s: 250.0,
            ..Default::default()
        })
    };
    let (wide, narrow) = (with_limit(100.0), with_limit(40.0));
    let mut state = CascadeState::default();
    state.observe(&wide, valid(0));
    for _ in 0..250 {
        state.regulate(&wide, angle(90.0));
    }
    state.retune(&wide, &narrow);
    assert_eq!(state.regulate(&narrow, angle(90.0)).duty, percent(40.0));
}

#[test]
fn the_zero_is_the_nearest_count_and_the_angle_ends_after_91_turns() {
    // 0.05 deg are 0.57 counts.
    let gains = coefficients(&ControlParameters {
        encoder_zero_deg: 0.05,
        ..Default::default()
    });
    let mut state = CascadeState::default();
    state.observe(&gains, valid(1));
    assert_eq!(state.angle(), Angle::ZERO);
    for quarter in 1..400 {
        state.observe(&gains, valid(1 + 1024 * quarter));
        let turned_deg = f64::from(quarter) * 90.0;
        assert_eq!(state.angle().to_f64(), turned_deg.min(32_768.0));
    }
}

#[test]
fn with_anti_windup_at_the_inverse_integral_time_the_integrator_stays_within_the_duty() {
    let gains = coefficients(&ControlParameters::default());
    let mut state = CascadeState::default();
    state.observe(&gains, valid(0));
    for _ in 0..100_000 {
        state.regulate(&gains, angle(170.0));
    }
    // The error vanishes: what is left is the integrator.
    let rest = state.regulate(&gains, angle(0.0)).duty;
    assert!(rest <= percent(100.0) && rest > percent(99.0), "{rest}");
}

proptest! {
    #[test]
    fn no_input_makes_the_step_overflow_or_leave_its_limits(
        p in parameters(),
        inputs in proptest::collection::vec((any::<u32>(), any::<i64>(), any::<bool>()), 1..200),
    ) {
        let gains = coefficients(&p);
        let mut state = CascadeState::default();
        let mut modulator = Modulator::default();
        let limit = percent(p.duty_limit_pct);
        for (word, command, is_valid) in inputs {
            let count = EncoderWord::new(word).read().ok().map(|reading| reading.count);
            state.observe(&gains, if is_valid { valid(word as i32) } else { count });
            let step = state.regulate(&gains, Angle::from_bits(command));
            prop_assert!(step.duty.abs() <= limit);
            prop_assert!(modulator.next(step.duty).get().abs() <= PWM_COUNTS);
        }
    }

    #[test]
    fn any_number_in_any_parameter_is_taken_within_its_range_and_refused_outside(
        index in 0..ControlParameters::TABLE.len(), value: f64
    ) {
        let mut p = ControlParameters::default();
        *p.get_mut(index).unwrap() = value;
        let row = ControlParameters::TABLE[index];
        let fits = row.check(value).is_ok();
        // Two rules look beyond the range of one parameter.
        let is_alone = !matches!(row.name, "encoder_direction" | "position_min_deg" | "position_max_deg");
        let taken = Coefficients::try_new(&p).is_ok();
        prop_assert!(taken == fits || (fits && !is_alone), "{} = {value}", row.name);
    }

    #[test]
    fn a_change_of_gains_does_not_move_the_duty(
        old in parameters(),
        new in parameters(),
        counts in proptest::collection::vec(-50i32..50, 1..50),
    ) {
        // Position and encoder settings stay: they change what the angle means. Limits are wide,
        // as narrower limits have to act at once.
        let wide = |p: ControlParameters| ControlParameters {
            position_min_deg: -32768.0,
            position_max_deg: 32767.0,
            encoder_zero_deg: 0.0,
            encoder_direction: 1.0,
            duty_limit_pct: 100.0,
            duty_slew_pct_s: f64::INFINITY,
            ..p
        };
        let (old, new) = (coefficients(&wide(old)), coefficients(&wide(new)));
        let mut state = CascadeState::default();
        for count in counts {
            state.observe(&old, valid(count));
            state.regulate(&old, angle(1.0));
        }
        let mut retuned = state;
        retuned.retune(&old, &new);
        let kept = state.regulate(&old, angle(1.0)).duty;
        prop_assert_eq!(retuned.regulate(&new, angle(1.0)).duty, kept);
    }
}

#[test]
fn a_product_of_simple_fractions_is_exact() {
    let half = Coefficient::new(0.5);
    let half: Gain<Percent, Percent> = Gain::of(half);
    assert_eq!(half.times(percent(-3.0)), percent(-1.5));
}

proptest! {
    #[test]
    fn a_product_is_the_nearest_step_to_the_true_one(value in -1e3..1e3, exponent in -20..1, signal: i64) {
        let k = Coefficient::new(value * libm::exp2(f64::from(exponent)));
        let signal = Percent::from_bits(signal >> 10);
        let exact = k.exactly() * i128::from(signal.to_bits());
        // Halves go up.
        prop_assert_eq!(i128::from(k.times(signal.raw()).to_bits()), (exact + (1 << 61)) >> 62);
    }
}

#[test]
fn the_magnet_stands_in_its_own_bits_and_a_lost_one_is_an_alarm() {
    let word = |magnet| EncoderWord::of(EncoderCount::new(0), magnet);
    assert_eq!(word(Magnet::Steady).bits(), 0b10_0001);
    assert_eq!(word(Magnet::Receding).bits(), 0b10_0010);
    assert_eq!(word(Magnet::Approaching).bits(), 0b10_0100);
    assert_eq!(word(Magnet::Marginal).bits(), 0b10_0111);
    assert_eq!(word(Magnet::Lost).bits(), 0b10_1110);
    for magnet in [
        Magnet::Steady,
        Magnet::Receding,
        Magnet::Approaching,
        Magnet::Marginal,
    ] {
        assert_eq!(word(magnet).read().unwrap().magnet, magnet);
    }
    assert_eq!(word(Magnet::Lost).read(), Err(EncoderError::Linearity));
}

#[test]
fn another_zero_of_the_encoder_counts_from_the_next_word_on() {
    let at = |encoder_zero_deg| {
        coefficients(&ControlParameters {
            encoder_zero_deg,
            ..Default::default()
        })
    };
    let (old, new) = (at(0.0), at(90.0));
    let mut state = CascadeState::default();
    state.observe(&old, valid(1024));
    state.regulate(&old, angle(90.0));
    state.retune(&old, &new);
    assert!(!state.shaft().is_known());
    state.observe(&new, valid(1024));
    assert_eq!(state.angle(), Angle::ZERO);
}
