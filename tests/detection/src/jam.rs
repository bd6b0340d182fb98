//! When the board reports a gear train that jams, by the rate at which it turned.
//!
//! The command begins at rest and turns at this rate on and on, so the error of the angle grows
//! from the jam on.

use host_sim::plot::{Figure, Panel, Scale, Series};
use indicatif::ParallelProgressIterator;
use model_core::control::units::angle;
use model_core::plant::board::BoardPlantOptions;
use rayon::iter::{IntoParallelIterator, IntoParallelRefIterator, ParallelIterator};

use crate::drive::{Drive, PERIOD_S};

/// Rates of the command, deg/s.
const RATES_DEG_S: [f64; 10] = [5.0, 7.0, 10.0, 15.0, 20.0, 30.0, 50.0, 70.0, 100.0, 200.0];

/// Loads, N m: a third of the stall torque.
const LOADS: [(&str, f64); 3] = [
    ("no load", 0.0),
    ("against 0.3 N m", -0.3),
    ("with 0.3 N m", 0.3),
];

/// Angle at which the train of the first drive jams, deg; that of each other one is a degree
/// further.
const JAM_DEG: f64 = 50.0;

/// The greatest time to a report, s.
const LONGEST_S: f64 = 10.0;

/// Time from the jam to the report, ms, and how far the shaft is behind then, deg; NaN without a
/// report.
fn run(rate_deg_s: f64, torque_nm: f64, seed: u64) -> (f64, f64) {
    let mut drive = Drive::enabled(&BoardPlantOptions::realistic(seed));
    drive.defects().torque_nm = torque_nm;
    let from = ((JAM_DEG + seed as f64) / rate_deg_s / PERIOD_S) as u32;
    let until = from + (LONGEST_S / PERIOD_S) as u32;
    for period in 0..until {
        drive.defects().is_jammed = period >= from;
        let command_deg = rate_deg_s * f64::from(period) * PERIOD_S;
        if !drive.follow(angle(command_deg)).latched.is_empty() {
            assert!(period >= from, "a report before the jam");
            let reported_s = f64::from(period + 1 - from) * PERIOD_S;
            return (reported_s * 1e3, command_deg - drive.angle_deg());
        }
    }
    (f64::NAN, f64::NAN)
}

/// The greatest of both; NaN if one is.
fn worst(results: &[(f64, f64)]) -> (f64, f64) {
    let greater = |a: f64, b: f64| if b.is_nan() || b > a { b } else { a };
    let both = |(ms, deg), &(other_ms, other_deg)| (greater(ms, other_ms), greater(deg, other_deg));
    results.iter().fold((0.0, 0.0), both)
}

/// The latest report, and how far a shaft was behind, by the rate of the command.
pub fn figure(seeds: u64) -> Figure {
    let title = "The gear train jams in motion";
    let mut time = Panel::new("reported after (ms)");
    let mut behind = Panel::new("shaft behind (deg)");
    for (colour, (load, torque_nm)) in LOADS.into_iter().enumerate() {
        let worst: Vec<(f64, f64)> = RATES_DEG_S
            .par_iter()
            .progress()
            .map(|&rate_deg_s| {
                let seeds = (0..seeds).into_par_iter();
                let results: Vec<_> = seeds.map(|seed| run(rate_deg_s, torque_nm, seed)).collect();
                worst(&results)
            })
            .collect();
        for (rate_deg_s, (ms, deg)) in RATES_DEG_S.iter().zip(&worst) {
            println!("{title}; {load}; {rate_deg_s}; {ms:.0} ms; {deg:.1} deg");
        }
        let (times, angles): (Vec<f64>, Vec<f64>) = worst.into_iter().unzip();
        time = time.series(Series::new(load, colour, &RATES_DEG_S, &times));
        behind = behind.series(Series::new(load, colour, &RATES_DEG_S, &angles));
    }
    let mut figure = Figure::new(title, "rate of the command (deg/s)")
        .panel(time)
        .panel(behind);
    figure.x_scale = Scale::Log;
    figure
}
