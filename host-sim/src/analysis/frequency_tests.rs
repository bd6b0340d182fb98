use super::super::linear_models::{Loop, Motor, Timing, black_box_1, black_box_2};
use super::super::referee::Board;
use super::*;
use model_core::control::parameters::ControlParameters;
use model_core::evaluation::frequency_response::sine;
use num_complex::Complex64;
use std::f64::consts::TAU;

/// Delay of the paper's test set-up, s.
const DELAY_S: f64 = 0.0175;

/// Half a tick: the reference holds the command of its continuous models during each tick.
const HELD_S: f64 = 25e-6;

fn board() -> Loop {
    Loop::sampled(
        &Motor::default(),
        &ControlParameters::default(),
        &Timing::default(),
    )
    .unwrap()
}

fn grey() -> Loop {
    Loop::continuous(&Motor::default(), &ControlParameters::default()).unwrap()
}

/// Compares with a row of the reference's table: frequency of -3.000 dB, the phase there, and gain
/// and phase at 30 rad/s.
fn assert_row(system: TransferFunction, row: [f64; 4], tolerance: [f64; 4]) {
    let at = falls_to_hz(&system, -3.0).unwrap();
    let response = Response::of(&system, &[0.01, 0.1, at, 30.0 / TAU]);
    let found = [
        at,
        response.phase_deg[2],
        response.gain_db[3],
        response.phase_deg[3],
    ];
    for i in 0..4 {
        let error = (found[i] - row[i]).abs();
        assert!(error < tolerance[i], "{found:?} is not {row:?}");
    }
}

/// Half of the last printed digit.
const PRINTED: [f64; 4] = [5e-4, 0.05, 5e-3, 0.05];

#[test]
fn black_box_1_has_the_bandwidth_and_the_phase_of_the_reference() {
    assert_row(
        black_box_1(30.0).delayed(DELAY_S + HELD_S),
        [4.763, -75.0, -3.01, -75.1],
        PRINTED,
    );
}

#[test]
fn black_box_2_has_the_bandwidth_and_the_phase_of_the_reference() {
    assert_row(
        black_box_2(900.0, 54.0).delayed(DELAY_S + HELD_S),
        [3.556, -94.1, -5.11, -120.1],
        PRINTED,
    );
}

#[test]
fn the_grey_box_has_the_bandwidth_and_the_phase_of_the_reference() {
    assert_row(
        grey().closed.delayed(DELAY_S + HELD_S),
        [1.677, -79.4, -13.59, -158.5],
        PRINTED,
    );
}

#[test]
fn the_board_has_the_measured_bandwidth_and_phase_of_the_reference() {
    // The reference's board quantises its angle to 0.088 deg: some 0.3 % of an amplitude of 5 deg,
    // 0.03 dB and 0.2 deg. Around 1.64 Hz the gain falls by 0.01 dB in 0.0008 Hz.
    let measured = [0.0025, 0.2, 0.035, 0.2];
    assert_row(
        board().closed.delayed(DELAY_S),
        [1.644, -73.8, -11.71, -154.1],
        measured,
    );
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
