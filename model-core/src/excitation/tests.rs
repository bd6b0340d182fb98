//! The inputs that the referee lacks against their formulas, and all inputs against invalid
//! parameters.

use super::Excitation;
use super::catalogue::Input;
use super::chirp::{Chirp, Sweep};
use super::multisine::Multisine;
use super::multistep::Multistep;
use super::phase::{Exponential, Quadratic};
use super::prbs::Prbs;
use super::ramp::Ramp;
use super::recorded::Recorded;
use super::variable_step::VariableStep;
use crate::control::units::Angle;
use crate::parameter::ParameterError;
use crate::time::seconds;
use core::f64::consts::PI;
use core::num::{NonZeroU8, NonZeroU64};
use proptest::prelude::*;
use std::vec::Vec;

/// Tolerance: the error of the sine, 1.5e-9, times the largest amplitude of 20 deg, and that of the
/// phases.
const ALLOWED_DEG: f64 = 1e-7;

fn standard(name: &str) -> Excitation<'static> {
    Input::named(name).unwrap().excitation().unwrap()
}

fn assert_follows(name: &str, formula: impl Fn(u64) -> f64) {
    let input = standard(name);
    let ticks = Input::named(name).unwrap().duration_ticks().unwrap();
    for tick in 0..ticks + 20_000 {
        let error = (input.command(tick).to_f64() - formula(tick)).abs();
        assert!(error < ALLOWED_DEG, "{name} at tick {tick}: {error}");
    }
}

#[test]
fn the_logarithmic_chirp_follows_its_formula() {
    assert_follows("log-chirp", |i| {
        let grown = libm::exp(libm::log(100.0) * seconds(i) / 20.0) - 1.0;
        let turns = 0.1 * 20.0 / libm::log(100.0) * grown;
        if i < 400_000 {
            5.0 * libm::sin(2.0 * PI * turns)
        } else {
            0.0
        }
    });
}

#[test]
fn the_doublet_follows_its_formula() {
    assert_follows("doublet", |i| match i {
        20_000..26_000 => 20.0,
        26_000..32_000 => -20.0,
        _ => 0.0,
    });
}

#[test]
fn every_name_selects_an_input_with_a_summary_and_defaults_in_range() {
    assert_eq!(Input::NAMES.len(), 10);
    for name in Input::NAMES {
        let input = Input::named(name).unwrap();
        assert_eq!(input.name(), *name);
        assert!(input.summary().ends_with('.') && !input.summary().contains('\n'));
        for (index, parameter) in input.table().iter().enumerate() {
            assert_eq!(input.get(index), Some(parameter.default), "{name}");
        }
        assert!(input.excitation().is_ok());
    }
    assert_eq!(Input::named("varstep"), Input::named("variable-step"));
    assert_eq!(Input::named("3211"), Input::named("3-2-1-1"));
    assert_eq!(Input::named("Pulse"), None);
}

#[test]
fn an_unknown_or_out_of_range_parameter_is_refused() {
    let mut sine = Input::named("sine").unwrap();
    assert_eq!(sine.set("frequency", 1.0), Err(ParameterError::Unknown));
    for value in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(
            sine.set("f", value),
            Err(ParameterError::OutOfRange { .. })
        ));
    }
    assert_eq!(sine, Input::named("sine").unwrap());
}

/// Any standard input with each parameter anywhere in its range or at a limit.
fn any_input() -> impl Strategy<Value = Input> {
    let shares = prop::collection::vec(prop_oneof![Just(0.0), Just(1.0), Just(1e-9), 0.0..1.0], 8);
    (prop::sample::select(Input::NAMES), shares).prop_map(|(name, shares)| {
        let mut input = Input::named(name).unwrap();
        for (parameter, share) in input.table().iter().zip(shares) {
            let mut value = parameter.min + share * (parameter.max - parameter.min);
            if parameter.is_choice() {
                value = libm::floor(value);
            }
            input.set(parameter.name, value).unwrap();
        }
        input
    })
}

proptest! {
    #[test]
    fn no_parameter_or_tick_makes_an_input_panic(
        input in any_input(), ticks in prop::collection::vec(any::<u64>(), 8)
    ) {
        let excitation = input.excitation().unwrap();
        let end = excitation.duration_ticks();
        let corners = [0, 1, end.saturating_sub(1), end, end.saturating_add(1), u64::MAX];
        for tick in ticks.into_iter().chain(corners) {
            excitation.command(tick);
        }
        input.duration_ticks().unwrap();
    }

    #[test]
    fn no_field_value_makes_an_input_panic(
        amplitude: i64, wide: [u128; 4], narrow: [u64; 2], tick: u64
    ) {
        let ([a, b, c, d], [e, f]) = (wide, narrow);
        let amplitude = Angle::from_bits(amplitude);
        let unit_ticks = NonZeroU64::MIN | e;
        let phase = Quadratic { per_tick: a, per_tick_squared: b };
        let law = Exponential {
            scale: c, octaves_per_tick: d, duration_ticks: e, rising: f % 2 == 0, offset: f,
        };
        let inputs = [
            Excitation::Multistep(Multistep {
                amplitude, start_tick: f, unit_ticks, widths: &[0, 255, 1],
            }),
            Excitation::VariableStep(VariableStep {
                levels: &[Angle::MIN, Angle::MAX], dwell_ticks: unit_ticks, scale: amplitude,
            }),
            // Out of order more often than not.
            Excitation::Ramp(Ramp::through(&[(e, Angle::MIN), (f, Angle::MAX), (tick, amplitude)])),
            Excitation::Chirp(Chirp {
                amplitude, duration_ticks: u64::MAX, sweep: Sweep::Linear(phase),
            }),
            Excitation::Chirp(Chirp {
                amplitude, duration_ticks: u64::MAX, sweep: Sweep::Logarithmic(law),
            }),
            Excitation::Prbs(
                Prbs::new(amplitude, 3 + f as u32 % 14, unit_ticks, u32::MAX).unwrap()
            ),
            Excitation::Multisine(Multisine {
                amplitude, phase, period_ticks: e, first_line: u16::MAX, line_step: u16::MAX,
                lines: NonZeroU8::MAX,
            }),
        ];
        for input in inputs {
            for tick in [tick, 0, e, f, u64::MAX] {
                input.command(tick);
            }
            input.duration_ticks();
        }
    }

    #[test]
    fn the_command_is_independent_of_the_evaluation_order(input in any_input(), tick in 0_u64..400_000) {
        let excitation = input.excitation().unwrap();
        let board: Vec<Angle> = (0..8).map(|k| excitation.command(tick + 80 * k)).collect();
        let desk: Vec<Angle> = (0..640).rev().map(|k| excitation.command(tick + k)).collect();
        for (k, command) in board.iter().enumerate() {
            prop_assert_eq!(*command, desk[639 - 80 * k]);
        }
    }

    #[test]
    fn a_finite_input_keeps_its_final_value(input in any_input(), beyond: u64) {
        let excitation = input.excitation().unwrap();
        let end = excitation.duration_ticks();
        let repeats = matches!(
            excitation,
            Excitation::Sine(_) | Excitation::Prbs(_) | Excitation::Multisine(_)
        );
        if !repeats {
            prop_assert_eq!(
                excitation.command(end.saturating_add(beyond)), excitation.command(end)
            );
        }
    }

    #[test]
    fn a_recording_is_right_continuous(
        mut ticks in prop::collection::vec(any::<u64>(), 1..20), asked: u64
    ) {
        ticks.sort_unstable();
        let commands: Vec<_> =
            (0_i32..).zip(&ticks).map(|(k, &tick)| (tick, Angle::from_bits(k.into()))).collect();
        let recorded = Excitation::Recorded(Recorded::try_new(&commands).unwrap());
        let expected = ticks.iter().rposition(|&tick| tick <= asked).unwrap_or(0);
        prop_assert_eq!(recorded.command(asked).to_bits(), expected as i64);
    }
}
