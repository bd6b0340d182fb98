//! Draws when the board detects sensors that lie, a jam, and gears that wear, by the size of the
//! fault, and counts alarms of intact drives: the firmware in a closed loop with the plant of the
//! emulated board, natively.

mod alarms;
mod bench;
mod drive;
mod fault;
mod jam;
mod sensors;
mod wear;

use std::fs;
use std::ops::Add;
use std::path::PathBuf;

use clap::Parser;
use clap::builder::PossibleValuesParser;
use host_sim::plot::{Figure, svg};
use indicatif::ParallelProgressIterator;
use rayon::iter::{IntoParallelIterator, ParallelIterator};

use alarms::{Alarms, JAM_LEVELS, alarms};
use fault::Kind;
use firmware::health::JAM_LEVEL_DEG_S;
use wear::Wear;

/// Draws when the board detects faults, by their size, and counts its false alarms
#[derive(Debug, Parser)]
struct Options {
    /// Drives for each point of a figure, each with its noise, friction and magnet
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u64).range(1..))]
    seeds: u64,
    /// Hours of intact drives in which alarms are counted
    #[arg(long, value_name = "H", default_value_t = 0)]
    hours: u32,
    /// The first of these hours: each is another drive
    #[arg(long, value_name = "H", default_value_t = 0)]
    first: u32,
    /// Level of the warning of a jam in its figure, deg/s
    #[arg(long, value_name = "DEG_S", default_value_t = JAM_LEVEL_DEG_S)]
    level: u16,
    /// Folder of the figures
    #[arg(long, value_name = "DIR", default_value = "docs/detection")]
    out: PathBuf,
    /// Figures that are drawn, instead of all
    #[arg(value_name = "FIGURE", value_parser = PossibleValuesParser::new(CURVES.map(Curve::name)))]
    figures: Vec<String>,
}

/// A figure.
#[derive(Debug, Clone, Copy)]
enum Curve {
    /// A sensor that lies.
    Sensor(Kind),
    /// A gear train that jams.
    Jam,
    /// Gears that wear.
    Wear(Wear),
}

/// All figures.
const CURVES: [Curve; 8] = [
    Curve::Sensor(Kind::Drift),
    Curve::Sensor(Kind::Slip),
    Curve::Sensor(Kind::Scale),
    Curve::Sensor(Kind::Play),
    Curve::Sensor(Kind::CurrentGain),
    Curve::Jam,
    Curve::Wear(Wear::Play),
    Curve::Wear(Wear::Friction),
];

impl Curve {
    /// Name of its file.
    fn name(self) -> &'static str {
        match self {
            Self::Sensor(kind) => kind.name(),
            Self::Jam => "jam",
            Self::Wear(wear) => wear.name(),
        }
    }

    fn figure(self, seeds: u64, level: u16) -> Figure {
        match self {
            Self::Sensor(kind) => sensors::figure(kind, seeds),
            Self::Jam => jam::figure(seeds, level),
            Self::Wear(wear) => wear::figure(wear, seeds),
        }
    }
}

fn main() -> std::io::Result<()> {
    let options = Options::parse();
    fs::create_dir_all(&options.out)?;
    for curve in CURVES {
        let name = curve.name();
        if options.figures.is_empty() || options.figures.iter().any(|it| it == name) {
            let figure = svg::render(&curve.figure(options.seeds, options.level));
            fs::write(options.out.join(name).with_extension("svg"), figure)?;
        }
    }
    if options.hours > 0 {
        let hours = options.first..options.first.saturating_add(options.hours);
        let hours = hours.into_par_iter().progress();
        let found = hours.map(alarms).reduce(Alarms::default, Alarms::add);
        let hours = options.hours;
        println!("{} alarms in {hours} h of intact drives", found.faults);
        for (level, count) in JAM_LEVELS.iter().zip(found.jams) {
            println!("{count} warnings of a jam at {level} deg/s in {hours} h of intact drives");
        }
    }
    Ok(())
}
