//! What the object of the health shows of gears that wear, and when it warns.
//!
//! The baseline is that of the same drive before, with other noise.

use host_sim::can::client::ClientError;
use host_sim::plot::{Figure, Panel, Series, Style};
use indicatif::ParallelProgressIterator;
use model_core::plant::board::BoardPlantOptions;
use rayon::iter::{IntoParallelIterator, IntoParallelRefIterator, ParallelIterator};

use crate::bench;

/// What has changed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Wear {
    /// Play of the gears.
    Play,
    /// Friction of motor, gears and bearing.
    Friction,
}

/// What 2052h shows of it.
struct Objects {
    /// The mean, its baseline, the change from that, and the level of the warning.
    mean: &'static str,
    baseline: &'static str,
    change: &'static str,
    level: &'static str,
    /// Bit of the warning in 2052h:8.
    warning: u8,
    /// A unit of the change in that of the figure.
    unit: f64,
}

impl Wear {
    /// Name of its file.
    pub fn name(self) -> &'static str {
        match self {
            Self::Play => "gear-play",
            Self::Friction => "friction",
        }
    }

    fn objects(self) -> Objects {
        match self {
            Self::Play => Objects {
                mean: "2052:10",
                baseline: "2053:10",
                change: "2054:6",
                level: "2053:8",
                warning: 1 << 5,
                unit: 1e-3,
            },
            Self::Friction => Objects {
                mean: "2052:1",
                baseline: "2053:1",
                change: "2052:6",
                level: "2053:3",
                warning: 1 << 0,
                unit: 0.1,
            },
        }
    }

    /// The level: 10 % of change, or 0.1 deg of play beyond the baseline.
    fn level(self, baseline: i64) -> i64 {
        match self {
            Self::Play => baseline + 100,
            Self::Friction => 100,
        }
    }

    /// Title, abscissa and first ordinate of its figure.
    fn labels(self) -> [&'static str; 3] {
        match self {
            Self::Play => [
                "Play of the gears, with a warning at 0.1 deg more",
                "additional play (deg)",
                "found (deg)",
            ],
            Self::Friction => [
                "Friction, with a warning at 10 % of change",
                "change of the friction (%)",
                "found (%)",
            ],
        }
    }

    fn sizes(self) -> &'static [f64] {
        match self {
            Self::Play => &[0.0, 0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.6, 0.8, 1.0, 1.5, 2.0],
            Self::Friction => &[-20.0, -10.0, 0.0, 10.0, 20.0, 30.0, 40.0, 60.0, 80.0, 100.0],
        }
    }

    /// Wears a drive by this size.
    fn apply(self, size: f64, options: &mut BoardPlantOptions) {
        let train = &mut options.drivetrain.gear_train;
        match self {
            Self::Play => train.backlash_deg += size,
            Self::Friction => {
                let share = 1.0 + size / 100.0;
                let friction = &mut options.drivetrain.friction;
                friction.coulomb_friction_nm *= share;
                friction.viscous_friction_nm_s_deg *= share;
                train.bearing_friction_nm *= share;
            }
        }
    }
}

/// Motions of a drive, a second each.
const MOTIONS: u32 = 40;

/// Noise of a worn drive: that of another seed.
const OTHER_NOISE: u64 = 1_000;

/// The baseline of a drive.
fn baseline(wear: Wear, seed: u64) -> Result<i64, ClientError> {
    let mut client = bench::client(&BoardPlantOptions::realistic(seed))?;
    bench::enable(&mut client)?;
    for motion in 0..MOTIONS {
        bench::turn(&mut client, motion)?;
    }
    let mean = client.integer(wear.objects().mean)?;
    assert!(mean > 0, "drive {seed}: no mean after {MOTIONS} motions");
    Ok(mean)
}

/// What a drive shows.
struct Shown {
    /// Change in the unit of the figure.
    change: f64,
    /// Motions until the warning; NaN without one.
    warned: f64,
}

fn shown(wear: Wear, size: f64, seed: u64, baseline: i64) -> Result<Shown, ClientError> {
    let objects = wear.objects();
    let mut options = BoardPlantOptions::realistic(seed);
    options.seed += OTHER_NOISE;
    wear.apply(size, &mut options);
    let mut client = bench::client(&options)?;
    client.write(objects.baseline, &baseline.to_string())?;
    client.write(objects.level, &wear.level(baseline).to_string())?;
    bench::enable(&mut client)?;
    let mut warned = f64::NAN;
    for motion in 0..MOTIONS {
        bench::turn(&mut client, motion)?;
        let warnings = client.integer("2052:8")?;
        if warned.is_nan() && warnings & i64::from(objects.warning) != 0 {
            warned = f64::from(motion + 1);
        }
    }
    let change = client.integer(objects.change)? as f64 * objects.unit;
    Ok(Shown { change, warned })
}

/// What the drives of a point show together.
struct Point {
    least: f64,
    greatest: f64,
    /// Those that warn, %.
    warn: f64,
    /// Motions until the last warning; NaN if one does not warn.
    latest: f64,
}

impl Point {
    fn of(drives: &[Shown]) -> Self {
        let changes = drives.iter().map(|it| it.change);
        let warned = drives.iter().filter(|it| !it.warned.is_nan()).count();
        let later = |latest: f64, it: &Shown| {
            if it.warned > latest {
                it.warned
            } else {
                latest
            }
        };
        Self {
            least: changes.clone().fold(f64::INFINITY, f64::min),
            greatest: changes.fold(f64::NEG_INFINITY, f64::max),
            warn: 100.0 * warned as f64 / drives.len() as f64,
            latest: if warned == drives.len() {
                drives.iter().fold(0.0, later)
            } else {
                f64::NAN
            },
        }
    }
}

/// The change that is found, and the warnings, by the size of the wear.
///
/// # Panics
/// If a request to a simulated actuator fails.
pub fn figure(wear: Wear, seeds: u64) -> Figure {
    let [title, x_label, found_label] = wear.labels();
    let sizes = wear.sizes();
    let baselines: Vec<i64> = (0..seeds)
        .into_par_iter()
        .map(|seed| baseline(wear, seed).expect("an actuator"))
        .collect();
    let points: Vec<Point> = sizes
        .par_iter()
        .progress()
        .map(|&size| {
            let drives: Vec<Shown> = (0..seeds)
                .zip(&baselines)
                .map(|(seed, &baseline)| shown(wear, size, seed, baseline).expect("an actuator"))
                .collect();
            Point::of(&drives)
        })
        .collect();
    for (size, it) in sizes.iter().zip(&points) {
        println!(
            "{title}; {size}; {:.3} to {:.3}; {:.0} % warn; after {} motions",
            it.least, it.greatest, it.warn, it.latest
        );
    }
    let series = |label: &str, colour, value: fn(&Point) -> f64| {
        let values: Vec<f64> = points.iter().map(value).collect();
        Series::new(label, colour, sizes, &values)
    };
    let found = Panel::new(found_label)
        .series(Series::new("true", 0, sizes, sizes).style(Style::Dashed))
        .series(series("least", 1, |it| it.least))
        .series(series("greatest", 2, |it| it.greatest));
    let warn = Panel::new("drives that warn (%)").series(series("warn", 3, |it| it.warn));
    let latest = Panel::new("all warn after (motions)");
    let latest = latest.series(series("latest warning", 4, |it| it.latest));
    Figure::new(title, x_label)
        .panel(found)
        .panel(warn)
        .panel(latest)
}
