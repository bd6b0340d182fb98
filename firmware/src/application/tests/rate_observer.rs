//! The observer of the rate, on the plant whose current pulses.

use model_core::{control::units::angle, plant::board::BoardPlantOptions};

use super::{winding::Loop, *};
use crate::native;

/// A drive with the observer and twice the gains, or with the loop of the paper.
fn drive(seed: u64, observes_rate: bool) -> Loop {
    let mut board = Loop::with(&BoardPlantOptions::realistic(seed));
    if observes_rate {
        let gains = ControlParameters::DEFAULT;
        board.application.parameters = with_gains(ControlParameters {
            position_gain: 2.0 * gains.position_gain,
            proportional_gain: 2.0 * gains.proportional_gain,
            integral_gain: 4.0 * gains.integral_gain,
            anti_windup_gain: 2.0 * gains.anti_windup_gain,
            ..gains
        });
    }
    board.application.observes_rate = observes_rate;
    board
}

/// 20 deg to and fro in 2 s.
fn command(period: u32) -> Angle {
    angle(20.0 * (f64::from(period) * 0.004 * core::f64::consts::PI).sin())
}

/// Rms difference of the rate of the control law from that of the shaft in 4 s, deg/s.
fn error_deg_s(seed: u64, observes_rate: bool) -> f64 {
    let mut board = drive(seed, observes_rate);
    let mut square = 0.0;
    for period in 0..1000 {
        let rate_deg_s = board.plant.plant.reading().output.rate_deg_s;
        let outputs = board.follow(command(period), 1);
        assert_eq!(outputs.fault, None);
        square += (outputs.telemetry.rate.to_f64() - rate_deg_s).powi(2);
    }
    (square / 1000.0).sqrt()
}

#[test]
fn the_observed_rate_has_a_third_of_the_error() {
    for seed in 0..10 {
        let (observed, filtered) = (error_deg_s(seed, true), error_deg_s(seed, false));
        std::println!("{observed:.2} {filtered:.2}");
        assert!(3.0 * observed < filtered, "{observed} and {filtered} deg/s");
    }
}

/// Greatest way of the shaft from the command until the fault that a hand in the samples causes,
/// deg, or within 4 s, and whether there was one.
fn off_deg(moves: bool, mut hand: impl FnMut(&mut Samples)) -> (f64, bool) {
    let mut board = drive(1, true);
    let target = |period| if moves { command(period) } else { Angle::ZERO };
    for period in 0..500 {
        board.follow(target(period), 1);
    }
    let mut off_deg = 0.0_f64;
    for period in 500..1500 {
        let _ = (board.application).request(Request::Command(target(period).into()));
        let mut samples = native::samples(&board.plant.sampled());
        hand(&mut samples);
        let outputs = board.application.control_period(&samples);
        (board.plant).tick(native::bridge(outputs.bridge), &mut |_, _| {});
        if outputs.fault.is_some() {
            return (off_deg, true);
        }
        let angle_deg = board.plant.plant.reading().output.angle_deg;
        off_deg = off_deg.max((angle_deg - target(period).to_f64()).abs());
    }
    (off_deg, false)
}

/// Sum of the travels by which encoder and motor differ at the fault, deg.
const LIMIT_DEG: f64 = 2.2;

#[test]
fn a_leg_that_sticks_or_is_exchanged_is_reported_before_the_shaft_is_far_off() {
    for moves in [false, true] {
        let (sound_deg, is_reported) = off_deg(moves, |_| ());
        assert!(!is_reported);
        for code in [0, 500, 1000, 1241, 1500, 2000] {
            let stuck = |samples: &mut Samples| scan(samples).leg_a = AdcCode::new(code);
            let (off, is_reported) = off_deg(moves, stuck);
            // Half of the supply is what the leg of a motor at rest shows.
            let is_seen = moves || code != 1241;
            std::println!("{code}: {off} deg, {sound_deg} deg without");
            assert_eq!(is_reported, is_seen, "{code}");
            assert!(
                off < sound_deg + LIMIT_DEG,
                "{code}: {off} deg, {sound_deg} without"
            );
        }
        let (off, is_reported) = off_deg(moves, |samples| {
            let scan = scan(samples);
            core::mem::swap(&mut scan.leg_a, &mut scan.leg_b);
        });
        std::println!("exchanged: {off} deg, {sound_deg} deg without");
        assert!(is_reported && off < sound_deg + LIMIT_DEG, "{off} deg");
    }
}
