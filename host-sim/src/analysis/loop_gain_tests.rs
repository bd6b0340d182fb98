use super::super::linear_models::{Motor, Timing};
use super::super::polynomial::Polynomial;
use super::super::referee::Board;
use super::*;
use model_core::control::parameters::ControlParameters;
use std::f64::consts::TAU;

fn board(duty_delay_s: f64, gain: f64) -> Loop {
    let motor = Motor {
        motor_gain: 2.836 * gain,
        ..Motor::default()
    };
    let timing = Timing {
        duty_delay_s,
        ..Timing::default()
    };
    Loop::sampled(&motor, &ControlParameters::default(), &timing).unwrap()
}

fn assert_margins(duty_delay_s: f64, phase_deg: f64, gain_db: f64) {
    let margins = Margins::of(&board(duty_delay_s, 1.0));
    assert!(margins.stable);
    assert!(
        (margins.phase_deg.unwrap().value - phase_deg).abs() < 0.05,
        "{margins:?}"
    );
    assert!(
        (margins.gain_db.unwrap().value - gain_db).abs() < 0.005,
        "{margins:?}"
    );
}

#[test]
fn the_default_loop_has_57_deg_and_20_6_db_at_1_ms_delay_and_52_deg_and_15_db_at_4_ms() {
    // The second decimals are from a dense scan of the same loop in powers of z by an independent
    // program.
    assert_margins(0.001, 57.11, 20.647);
    assert_margins(0.004, 51.98, 15.107);
}

#[test]
fn the_loop_is_stable_up_to_its_gain_margin() {
    for duty_delay_s in [0.001, 0.004] {
        let margin = Margins::of(&board(duty_delay_s, 1.0))
            .gain_db
            .unwrap()
            .value;
        let limit = 10.0_f64.powf(margin / 20.0);
        let timing = Timing {
            duty_delay_s,
            ..Timing::default()
        };
        for (factor, settles) in [(0.99, true), (1.01, false)] {
            let stable = board(duty_delay_s, limit * factor).closed.is_stable();
            assert_eq!(stable, settles, "poles at {factor} of the limit");
            let gain = limit * factor;
            let simulated = Board {
                timing,
                linear: true,
                gain,
                ..Board::default()
            };
            assert_eq!(
                simulated.settles(10.0),
                settles,
                "time at {factor} of the limit"
            );
        }
    }
}

#[test]
fn the_loop_is_stable_up_to_its_delay_margin() {
    // Four times the gain, so that the total delay is within the permitted range.
    let delay_s = Margins::of(&board(0.001, 4.0)).delay_s.unwrap();
    let stable = |share: f64| board(0.001 + share * delay_s, 4.0).closed.is_stable();
    // The delay of the duty is a delay of the loop, except for the images of the signal above the
    // Nyquist frequency, for which the tolerance is two per cent.
    assert!(stable(0.98) && !stable(1.02), "{delay_s}");
}

#[test]
fn the_continuous_grey_box_has_the_phase_margin_of_its_closed_form_and_no_gain_margin() {
    let grey = Loop::continuous(&Motor::default(), &ControlParameters::default()).unwrap();
    let margins = Margins::of(&grey);
    // L = w (s + P)/s^2: |L| = 1 at c^4 = w^2 (c^2 + P^2), phase margin atan(c/P).
    let (w, p) = (28.36_f64, 8.0_f64);
    let c = (0.5 * w * (w + (w * w + 4.0 * p * p).sqrt())).sqrt();
    let phase = margins.phase_deg.unwrap();
    assert!(margins.stable);
    assert!((phase.value - (c / p).atan().to_degrees()).abs() < 1e-9);
    assert!((phase.frequency_hz - c / TAU).abs() < 1e-9);
    assert_eq!(margins.gain_db, None);
}

#[test]
fn the_smallest_margin_of_several_crossings_is_given() {
    // L = k (s + 1)^2/s^3: stable for k > 1/2 only. At k = 1 the gain can fall by 6.02 dB.
    let (k, zeros) = (1.0, Polynomial::new([1.0, 2.0, 1.0]));
    let cubed = || Polynomial::new([0.0, 0.0, 0.0, 1.0]);
    let open = TransferFunction::continuous(&Polynomial::new([k]) * &zeros, cubed());
    let closed = TransferFunction::closing(&open, zeros);
    let margins = Margins::of(&Loop { open, closed });
    assert!(margins.stable);
    let gain = margins.gain_db.unwrap();
    assert!((gain.value + 6.0206).abs() < 1e-4, "{gain:?}");
    assert!((gain.frequency_hz * TAU - 1.0).abs() < 1e-9);
}

#[test]
fn the_margin_at_the_nyquist_frequency_is_included() {
    // L = k/(z - 1) is real and negative only at z = -1: stable below k = 2, 6.02 dB above 1.
    let one = || Polynomial::new([1.0]);
    let integrator = TransferFunction::sampled(one(), Polynomial::new([0.0, 1.0]), 1.0);
    let closed = TransferFunction::closing(&integrator, one());
    let margins = Margins::of(&Loop {
        open: integrator,
        closed,
    });
    let gain = margins.gain_db.unwrap();
    assert!((gain.value - 6.0206).abs() < 1e-4, "{gain:?}");
    assert_eq!(gain.frequency_hz, 0.5);
}
