//! Draws when the board detects sensors that lie, by the size of the fault, and counts alarms of
//! intact drives: the application of the board in a closed loop with the plant of the emulated
//! board, natively.
//!
//! A fault begins 3 s after the drive was enabled. A run ends with the first fault that is
//! latched, or after 10 s. How far the shaft is off is the difference from a run with the same
//! numbers and without the fault.

mod drive;
mod fault;

use std::f64::consts::PI;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use clap::Parser;
use host_sim::input::flight_like;
use host_sim::plot::{Figure, Panel, Series, svg};
use indicatif::ParallelProgressIterator;
use model_core::control::units::angle;
use model_core::plant::board::BoardPlantOptions;
use model_core::sensors::noise::Noise;
use rayon::iter::{IntoParallelIterator, IntoParallelRefIterator, ParallelIterator};

use drive::{Drive, PERIOD_S, Task};
use fault::Kind;

/// Draws when the board detects sensors that lie, and counts its false alarms
#[derive(Debug, Parser)]
struct Options {
    /// Drives for each point of a figure, each with its noise, friction and magnet
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u64).range(1..))]
    seeds: u64,
    /// Hours of intact drives in which alarms are counted
    #[arg(long, value_name = "H", default_value_t = 0)]
    hours: u32,
    /// Folder of the figures
    #[arg(long, value_name = "DIR", default_value = "docs/detection")]
    out: PathBuf,
}

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

fn figure(kind: Kind, seeds: u64) -> Figure {
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

/// Control periods in which a gust changes the load, as a half of 1 - cos (CS-VLA 333): 12.5 mean
/// chords of 0.2 m at 25 m/s are 0.1 s.
const GUST_PERIODS: f64 = 25.0;

/// Moment of inertia of a control surface of 50 mm chord and 20 g about its hinge, m c^2/3, kg m^2.
const SURFACE_KG_M2: f64 = 0.02 * 0.05 * 0.05 / 3.0;

/// Faults of an hour of an intact drive in flight-like motion, with the worst parameters: constant,
/// resistance and inductance of the motor each off by 30 %, in all eight combinations, a degree of
/// play in the gears, and loads of up to a third of the stall torque of that motor, another one
/// every 0.1 to 1 s.
fn alarms(hour: u32) -> u64 {
    let mut chance = Noise::new(u64::from(hour), 77);
    let mut uniform = || (chance.gaussian(1.0) / 3.0).clamp(-1.0, 1.0);
    let mut options = BoardPlantOptions::realistic(u64::from(hour));
    let [constant, resistance, inductance] =
        [1, 2, 4].map(|bit| if hour & bit == 0 { 0.7 } else { 1.3 });
    let motor = &mut options.drivetrain.electrical;
    motor.torque_constant_nm_a *= constant;
    motor.winding_resistance_ohm *= resistance;
    motor.winding_inductance_h *= inductance;
    // The linkage is stiff, so that the integration has steps of the gears only.
    let gears = &mut options.drivetrain.gear_train;
    gears.backlash_deg = 1.0;
    gears.shaft_stiffness_nm_deg = f64::INFINITY;
    gears.load_inertia_kg_m2 = SURFACE_KG_M2;
    let greatest_nm = 0.3 * constant / resistance;
    let mut command_deg = flight_like(hour.into());
    let mut drive = Drive::enabled(&options);
    let (mut found, mut period, mut before_nm) = (0, 0_u32, 0.0);
    while f64::from(period) * PERIOD_S < 3600.0 {
        let load_nm = greatest_nm * uniform();
        let lasts = GUST_PERIODS + 225.0 * uniform().abs();
        for since in 0..lasts as u32 {
            let gust = (f64::from(since + 1) / GUST_PERIODS).min(1.0);
            let share = (1.0 - (PI * gust).cos()) / 2.0;
            drive.defects().torque_nm = before_nm + share * (load_nm - before_nm);
            let command = angle(command_deg(f64::from(period) * PERIOD_S));
            period += 1;
            let faults = drive.follow(command);
            if !faults.is_empty() {
                let names: Vec<_> = faults.iter().map(|fault| format!("{fault:?}")).collect();
                println!("hour {hour}: {} after {period} periods", names.join(", "));
                found += 1;
                drive = Drive::enabled(&options);
            }
        }
        before_nm = load_nm;
    }
    found
}

fn write(folder: &Path, name: &str, figure: &Figure) -> std::io::Result<()> {
    fs::create_dir_all(folder)?;
    fs::write(folder.join(name).with_extension("svg"), svg::render(figure))
}

fn main() -> std::io::Result<()> {
    let options = Options::parse();
    for kind in Kind::ALL {
        write(&options.out, kind.name(), &figure(kind, options.seeds))?;
    }
    if options.hours > 0 {
        let found = AtomicU64::new(0);
        (0..options.hours)
            .into_par_iter()
            .progress()
            .for_each(|hour| {
                found.fetch_add(alarms(hour), Ordering::Relaxed);
            });
        let found = found.into_inner();
        println!("{found} alarms in {} h of intact drives", options.hours);
    }
    Ok(())
}
