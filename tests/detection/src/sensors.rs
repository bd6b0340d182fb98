//! When the board detects sensors that lie, by the size of the fault.
//!
//! A fault begins 3 s after the drive was enabled. A run ends with the first fault that is
//! latched, or after 10 s. How far the shaft is off is the difference from a run with the same
//! numbers and without the fault.

use host_sim::plot::{Figure, Panel, Series};
use indicatif::ParallelProgressIterator;
use model_core::plant::board::BoardPlantOptions;
use rayon::iter::{IntoParallelIterator, IntoParallelRefIterator, ParallelIterator};

use crate::drive::{Drive, PERIOD_S, Task};
use crate::fault::Kind;

/// The fault begins after so many control periods, and a run lasts so long.
const FROM: u32 = 750;
const UNTIL: u32 = FROM + 2_500;

/// The result of a run.
#[derive(Debug, Clone, Copy)]
struct Result {
    /// Time from the fault to the report, s; `None` without one.
    reported_s: Option<f64>,
    /// How far the shaft was off at the most until then, deg.
    off_deg: f64,
}

fn run(kind: Kind, size: f64, task: Task, seed: u64) -> Result {
    let options = BoardPlantOptions::realistic(seed);
    let (mut faulty, mut sound) = (Drive::enabled(&options), Drive::enabled(&options));
    for drive in [&mut faulty, &mut sound] {
        drive.defects().torque_nm = task.torque_nm();
    }
    let mut off_deg = 0.0_f64;
    for period in 0..UNTIL {
        if period >= FROM {
            let since_s = f64::from(period - FROM) * PERIOD_S;
            kind.apply(size, since_s, faulty.defects());
        }
        let latched = faulty.perform(task);
        sound.perform(task);
        if period < FROM {
            continue;
        }
        off_deg = off_deg.max((faulty.angle_deg() - sound.angle_deg()).abs());
        if !latched.is_empty() {
            let reported_s = Some(f64::from(period + 1 - FROM) * PERIOD_S);
            return Result {
                reported_s,
                off_deg,
            };
        }
    }
    Result {
        reported_s: None,
        off_deg,
    }
}

/// The latest report, ms, NaN if a run had none; and the greatest angle by which a shaft was off.
fn worst(kind: Kind, size: f64, task: Task, seeds: u64) -> (f64, f64) {
    let results: Vec<Result> = (0..seeds)
        .into_par_iter()
        .map(|seed| run(kind, size, task, seed))
        .collect();
    let all: Option<Vec<f64>> = results.iter().map(|result| result.reported_s).collect();
    let latest_s = all.map_or(f64::NAN, |times| times.into_iter().fold(0.0, f64::max));
    let off_deg = results.iter().map(|result| result.off_deg);
    (latest_s * 1e3, off_deg.fold(0.0, f64::max))
}

/// When a fault is reported, and how far the shaft was off, by its size.
pub fn figure(kind: Kind, seeds: u64) -> Figure {
    let (title, x_label) = kind.labels();
    let mut time = Panel::new("reported after (ms)");
    let mut off = Panel::new("shaft off (deg)");
    for (colour, task) in Task::ALL.into_iter().enumerate() {
        let sizes = kind.sizes();
        let worst: Vec<(f64, f64)> = sizes
            .par_iter()
            .progress()
            .map(|&size| worst(kind, size, task, seeds))
            .collect();
        for (size, (ms, deg)) in sizes.iter().zip(&worst) {
            println!("{title}; {}; {size}; {ms:.0} ms; {deg:.1} deg", task.name());
        }
        let (times, angles): (Vec<f64>, Vec<f64>) = worst.into_iter().unzip();
        time = time.series(Series::new(task.name(), colour, sizes, &times));
        off = off.series(Series::new(task.name(), colour, sizes, &angles));
    }
    Figure::new(title, x_label).panel(time).panel(off)
}
