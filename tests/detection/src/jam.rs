//! When the board reports a gear train that jams, by the rate at which it turned.
//!
//! The command begins at rest and turns at this rate on and on, so the error of the angle grows
//! from the jam on.

use firmware::application::Outputs;
use firmware::health::{Health, Warning};
use firmware::parameters::{HealthSettings, ModelSettings, ObjectValues};
use host_sim::plot::{Figure, Panel, Scale, Series};
use indicatif::ParallelProgressIterator;
use model_core::control::units::angle;
use model_core::plant::board::BoardPlantOptions;
use rayon::iter::{IntoParallelIterator, IntoParallelRefIterator, ParallelIterator};

use crate::drive::{Drive, PERIOD_S};

/// The warning of the health.
#[derive(Debug)]
pub struct JamWarning {
    settings: HealthSettings,
    health: Health,
    is_active: bool,
}

impl JamWarning {
    /// That at a level, deg/s.
    pub fn at(level: u16) -> Self {
        Self {
            settings: HealthSettings {
                jam_level: level,
                ..ObjectValues::DEFAULT.health
            },
            health: Health::default(),
            is_active: false,
        }
    }

    /// Takes a control period; returns whether the warning begins.
    pub fn begins(&mut self, outputs: &Outputs) -> bool {
        self.health
            .observe(&self.settings, &ModelSettings::DEFAULT, outputs);
        let is_active = self.health.warnings() & Warning::Jam.bit() != 0;
        let was_active = std::mem::replace(&mut self.is_active, is_active);
        is_active && !was_active
    }
}

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

/// Times from the jam to the warning and to the fault, ms, and how far the shaft is behind then,
/// deg; NaN without a report. The warning is that at a level, deg/s.
fn run(level: u16, rate_deg_s: f64, torque_nm: f64, seed: u64) -> [f64; 3] {
    let mut drive = Drive::enabled(&BoardPlantOptions::realistic(seed));
    drive.defects().torque_nm = torque_nm;
    let from = ((JAM_DEG + seed as f64) / rate_deg_s / PERIOD_S) as u32;
    let until = from + (LONGEST_S / PERIOD_S) as u32;
    let (mut warning, mut warned_ms) = (JamWarning::at(level), f64::NAN);
    for period in 0..until {
        drive.defects().is_jammed = period >= from;
        let command_deg = rate_deg_s * f64::from(period) * PERIOD_S;
        let is_fault = !drive.follow(angle(command_deg)).is_empty();
        let is_warned = warning.begins(&drive.outputs);
        assert!(period >= from || !is_fault && !is_warned, "before the jam");
        let since_ms = (f64::from(period + 1) - f64::from(from)) * PERIOD_S * 1e3;
        if is_warned {
            warned_ms = since_ms;
        }
        if is_fault {
            return [warned_ms, since_ms, command_deg - drive.angle_deg()];
        }
    }
    [warned_ms, f64::NAN, f64::NAN]
}

/// The greatest of each; NaN if one is.
fn worst(results: &[[f64; 3]]) -> [f64; 3] {
    let greater = |a: f64, b: f64| if b.is_nan() || b > a { b } else { a };
    let column = |at: usize| results.iter().map(|row| row[at]).fold(0.0, greater);
    [0, 1, 2].map(column)
}

/// The latest warning and fault, and how far a shaft was behind, by the rate of the command.
pub fn figure(seeds: u64, level: u16) -> Figure {
    let title = "The gear train jams in motion";
    let mut panels = [
        "warned after (ms)",
        "fault after (ms)",
        "shaft behind (deg)",
    ]
    .map(Panel::new);
    for (colour, (load, torque_nm)) in LOADS.into_iter().enumerate() {
        let worst: Vec<[f64; 3]> = RATES_DEG_S
            .par_iter()
            .progress()
            .map(|&rate_deg_s| {
                let seeds = (0..seeds).into_par_iter();
                let results: Vec<_> = seeds
                    .map(|seed| run(level, rate_deg_s, torque_nm, seed))
                    .collect();
                worst(&results)
            })
            .collect();
        for (rate_deg_s, [warned_ms, fault_ms, deg]) in RATES_DEG_S.iter().zip(&worst) {
            println!(
                "{title}; {load}; {rate_deg_s}; {warned_ms:.0}; {fault_ms:.0} ms; {deg:.1} deg"
            );
        }
        let mut at = 0;
        panels = panels.map(|panel| {
            let values: Vec<f64> = worst.iter().map(|row| row[at]).collect();
            at += 1;
            panel.series(Series::new(load, colour, &RATES_DEG_S, &values))
        });
    }
    let [warned, fault, behind] = panels;
    let mut figure = Figure::new(title, "rate of the command (deg/s)")
        .panel(warned)
        .panel(fault)
        .panel(behind);
    figure.x_scale = Scale::Log;
    figure
}
