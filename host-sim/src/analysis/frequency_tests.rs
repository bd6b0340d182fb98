use super::super::linear_models::{Loop, Motor, Timing, black_box_1, black_box_2};
use super::super::referee::Board;
use super::*;
use model_core::control::parameters::ControlParameters;
use model_core::evaluation::frequency_response::sine;
use num_complex::Complex64;
use std::f64::consts::TAU;

/// Delay of the paper's test set-up, s.
const DELAY_S: f64 = 0.0175;

fn board() -> Loop {
    Loop::sampled(
        &Motor::default(),
        &ControlParameters::default(),
        &Timing::default(),
    )
    .unwrap()
}

#[test]
fn the_bandwidth_agrees_with_the_closed_form() {
    let relative = |found: Option<f64>, exact: f64| (found.unwrap() / exact - 1.0).abs();
    for pole in [0.5, 30.0, 400.0] {
        let exact = pole / TAU;
        // The half-power point is found to rounding.
        assert!(relative(bandwidth_hz(&black_box_1(pole)), exact) < 1e-12);
    }
    // |A/(A - w^2 + j B w)|^2 = 1/2
    let (a, b) = (900.0_f64, 54.0_f64);
    let middle = a - b * b / 2.0;
    let exact = (middle + (middle * middle + a * a).sqrt()).sqrt() / TAU;
    assert!(relative(bandwidth_hz(&black_box_2(a, b)), exact) < 1e-12);
}

#[test]
fn the_response_of_the_board_agrees_with_a_simulated_sine() {
    let system = board().closed.delayed(DELAY_S);
    let simulated = Board {
        linear: true,
        gain: 1.0,
        ..Board::default()
    };
    for frequency_hz in [0.25, 1.0, 2.5, 5.0, 12.5, 25.0] {
        let command = |tick: i64| (TAU * frequency_hz * (tick as f64 * 50e-6 - DELAY_S)).sin();
        let (angle, _) = simulated.run(200_000, command);
        // Angles at the control steps, after 6 s in which the transient decays: its slowest pole is
        // -14 1/s, half of the inner bandwidth.
        let samples = || (120_000..200_000).step_by(80);
        let y: Vec<f64> = samples().map(|i| angle[i]).collect();
        let (amplitude, phase_deg) = sine(&y, (4.0 * frequency_hz) as u32);
        let start_deg = 360.0 * 6.0 * frequency_hz;
        let found = Complex64::from_polar(amplitude, (phase_deg - start_deg).to_radians());
        let error = (found / system.at(frequency_hz) - 1.0).norm();
        assert!(error < 1e-8, "{error} at {frequency_hz} Hz");
    }
}

#[test]
fn the_phase_is_continuous_at_minus_180_deg() {
    let grid = logarithmic_grid(0.1, 100.0, 50);
    let response = Response::of(&board().closed.delayed(DELAY_S), &grid);
    assert!(response.phase_deg.last().unwrap() < &-700.0);
    let largest = response
        .phase_deg
        .windows(2)
        .map(|p| (p[1] - p[0]).abs())
        .fold(0.0, f64::max);
    assert!(largest < 60.0, "{largest}");
}

#[test]
fn the_delay_changes_the_phase_and_not_the_gain() {
    let plain = Response::of(&black_box_1(30.0), &[1.0, 40.0]);
    let late = Response::of(&black_box_1(30.0).delayed(DELAY_S), &[1.0, 40.0]);
    assert_eq!(late.gain_db, plain.gain_db);
    assert!((late.phase_deg[1] - plain.phase_deg[1] + 252.0).abs() < 1e-9);
}

#[test]
fn a_gain_that_never_falls_has_no_bandwidth() {
    use super::super::polynomial::Polynomial;
    let one = || Polynomial::new([1.0]);
    assert_eq!(
        bandwidth_hz(&TransferFunction::continuous(one(), one())),
        None
    );
    let integrator = TransferFunction::continuous(one(), Polynomial::new([0.0, 1.0]));
    assert_eq!(bandwidth_hz(&integrator), None);
    assert_eq!(bandwidth_hz(&black_box_1(f64::NAN)), None);
}

#[test]
fn an_invalid_grid_is_empty() {
    assert!(logarithmic_grid(0.0, 1.0, 10).is_empty());
    assert!(logarithmic_grid(1.0, f64::INFINITY, 10).is_empty());
    assert!(logarithmic_grid(f64::NAN, 1.0, 10).is_empty());
    assert!(logarithmic_grid(1.0, 2.0, 0).is_empty());
}
