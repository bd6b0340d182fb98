//! Responses and equivalent systems against known systems.

use super::*;
use crate::{
    recording::{Hold, Recording},
    statistics::tests::white,
};

const STEP_S: f64 = 0.004;
const POLE_RAD_S: f64 = 30.0;

/// A binary command through `delay` samples of delay, `lags` equal lags of 30 rad/s, exact for a
/// held command, and noise.
fn run(samples: usize, delay: usize, lags: usize, noise_deg: f64, seed: u64) -> Recording {
    let flips = white(samples / 5 + 1, seed);
    let command: Vec<f64> = (0..samples).map(|i| 5.0 * flips[i / 5].signum()).collect();
    let noise = white(samples, seed + 1);
    // Small steps between the samples: the input of the second lag is not held.
    let fine = 20;
    let decay = (-POLE_RAD_S * STEP_S / fine as f64).exp();
    let mut states = vec![0.0; lags];
    let mut angle = Vec::new();
    for i in 0..samples {
        angle.push(states[lags - 1] + noise_deg * noise[i]);
        for _ in 0..fine {
            let mut input = if i >= delay { command[i - delay] } else { 0.0 };
            for state in &mut states {
                let before = *state;
                *state = input + (*state - input) * decay;
                input = 0.5 * (before + *state);
            }
        }
    }
    Recording {
        time_s: (0..samples).map(|i| i as f64 * STEP_S).collect(),
        command_deg: command,
        angle_deg: angle,
        hold: Hold::Zero,
        ..Recording::default()
    }
}

#[test]
fn a_lag_and_its_delay_are_recovered() {
    let run = run(10_000, 4, 1, 0.05, 1);
    let response = FrequencyResponse::of(&[&run]).expect("it moves");
    let Equivalent {
        shape,
        gain,
        delay_s,
        cost,
        ..
    } = Equivalent::first_order(&response).expect("it is coherent");
    let Shape::First { pole_rad_s } = shape else {
        panic!("of first order")
    };
    // Aliasing adds 3 % to the gain at a third of the Nyquist frequency.
    assert!((pole_rad_s / POLE_RAD_S - 1.0).abs() < 0.05, "{pole_rad_s}");
    assert!((delay_s - 0.016).abs() < 0.001, "{delay_s}");
    assert!((gain - 1.0).abs() < 0.02, "{gain}");
    assert!(cost < 5.0, "{cost}");
}

#[test]
fn two_lags_are_distinguished_from_one() {
    let run = run(10_000, 0, 2, 0.02, 3);
    let response = FrequencyResponse::of(&[&run]).expect("it moves");
    let first = Equivalent::first_order(&response).expect("it is coherent");
    let second = Equivalent::second_order(&response).expect("it is coherent");
    let Shape::Second {
        natural_frequency_rad_s,
        damping,
    } = second.shape
    else {
        panic!("of second order")
    };
    assert!((natural_frequency_rad_s / POLE_RAD_S - 1.0).abs() < 0.05);
    assert!((damping - 1.0).abs() < 0.08, "{damping}");
    assert!(second.cost < 10.0 && first.cost > 3.0 * second.cost);
}

#[test]
fn the_interval_contains_the_true_gain_as_often_as_stated() {
    let truth = Equivalent {
        shape: Shape::First {
            pole_rad_s: POLE_RAD_S,
        },
        gain: 1.0,
        delay_s: 0.0,
        cost: 0.0,
        from_hz: 0.0,
        to_hz: 0.0,
    };
    let (mut inside, mut all) = (0, 0);
    for seed in 0..20 {
        let run = run(4000, 0, 1, 1.0, 100 + 2 * seed);
        let response = FrequencyResponse::of(&[&run]).expect("it moves");
        let band = response.frequency_hz.iter().zip(&response.gain_db);
        for ((f, gain_db), error_db) in band.zip(&response.gain_error_db).step_by(5) {
            if *f > 1.0 && *f < 15.0 {
                let true_db = crate::frequency::decibel(truth.at(*f).norm());
                inside += usize::from((gain_db - true_db).abs() < *error_db);
                all += 1;
            }
        }
    }
    let share = f64::from(inside as u32) / f64::from(all as u32);
    // Seven windows estimate their own spread coarsely: 0.95 is the limit of many.
    assert!((0.88..0.99).contains(&share), "{share} of {all}");
}

#[test]
fn uneven_samples_with_a_gap_give_the_same_answer() {
    let even = run(10_000, 4, 1, 0.05, 1);
    let kept = |i: &usize| i % 7 != 3 && !(4000..4400).contains(i);
    let kept: Vec<usize> = (0..10_000).filter(kept).collect();
    let take = |column: &[f64]| kept.iter().map(|&i| column[i]).collect::<Vec<f64>>();
    let uneven = Recording {
        time_s: take(&even.time_s),
        command_deg: take(&even.command_deg),
        angle_deg: take(&even.angle_deg),
        ..even
    };
    let response = FrequencyResponse::of(&[&uneven]).expect("it moves");
    let found = Equivalent::first_order(&response).expect("it is coherent");
    assert!((found.delay_s - 0.016).abs() < 0.002, "{found:?}");
}

#[test]
fn a_recording_without_information_has_no_response() {
    assert_eq!(FrequencyResponse::of(&[]), None);
    assert_eq!(FrequencyResponse::of(&[&Recording::default()]), None);
    let mut rest = run(1000, 0, 1, 0.1, 1);
    rest.command_deg.fill(3.0);
    assert_eq!(FrequencyResponse::of(&[&rest]), None);
    let mut unrelated = run(1000, 0, 1, 0.1, 1);
    unrelated.angle_deg = white(1000, 77);
    let response = FrequencyResponse::of(&[&unrelated]).expect("it moves");
    let mean = response.coherence.iter().sum::<f64>() / response.coherence.len() as f64;
    // The expected coherence of noise over seven windows is one seventh.
    assert!(mean < 0.25, "{mean}");
}
