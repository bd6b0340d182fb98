//! Measures how well the shaft follows commands: the control loop of the board with the plant of
//! the emulated board, natively, with the loop of the paper and with what object 2013h adds to it.
//! Noise, friction, magnet and supply of each drive follow from its seed.

mod bench;
mod command;
mod drive;
mod fitted;
mod margin;
mod page;
mod rest;

use core::f64::consts::{PI, TAU};
use std::fs;
use std::path::PathBuf;

use clap::Parser;
use firmware::control_loop::LoopParameters;
use firmware::parameters::{BoardParameters, ObjectValues};
use firmware::timing::periods;
use host_sim::input::flight_like;
use host_sim::plot::{Figure, Panel, Series, svg};
use model_core::control::cascade::Coefficients;
use model_core::control::parameters::ControlParameters;
use model_core::plant::board::BoardPlantOptions;
use model_core::plant::drivetrain::DrivetrainParameters;
use model_core::time::{CONTROL_PERIOD_S as PERIOD_S, CONTROL_RATE_HZ};
use rayon::iter::{IntoParallelIterator, ParallelIterator};

use bench::Bench;
use command::{sine, standard};
use drive::Drive;
use margin::Margins;
use rest::{Rest, holding_loss_w, loaded, rest};

/// Measures how well the shaft follows commands, with and without feed-forward
#[derive(Debug, Parser)]
struct Options {
    /// Folder of the page and its figure
    #[arg(long, value_name = "DIR", default_value = "docs")]
    out: PathBuf,
}

/// Voltage of the source where no other is named, V.
const SOURCE_V: f64 = 6.0;

/// Drives of each figure.
const SEEDS: u64 = 10;

/// A motion lasts so many control periods, 30 s.
const PERIODS: u32 = 30 * CONTROL_RATE_HZ;

/// Intervals of targets, ms, and their rates.
const INTERVALS: [(i32, &str); 2] = [(4, "250 Hz"), (20, "50 Hz")];

/// A loop: its name, the shares of feed-forward in thousandths, the dead band, mdeg, the factor of
/// the gains, and whether the rate is observed by the back-EMF.
struct Setup {
    name: &'static str,
    forward_permille: u16,
    dead_band_mdeg: u16,
    gains: f64,
    observes: bool,
}

const SETUPS: [Setup; 3] = [
    Setup {
        name: "paper's loop",
        forward_permille: 0,
        dead_band_mdeg: 0,
        gains: 1.0,
        observes: false,
    },
    // Half a count is the quantisation, and a count is noise that changes it.
    Setup {
        name: "with 2013h:1-3 and 2014h",
        forward_permille: 1000,
        dead_band_mdeg: 132,
        gains: 1.0,
        observes: false,
    },
    Setup {
        name: "and 2013h:4, gains x 2",
        forward_permille: 1000,
        dead_band_mdeg: 132,
        gains: 2.0,
        observes: true,
    },
];

impl Setup {
    /// A drive whose targets come so many ms apart.
    fn drive(&self, seed: u64, interval_ms: i32) -> Drive {
        self.drive_on(&BoardPlantOptions::realistic(seed), interval_ms)
    }

    /// The same on this plant.
    fn drive_on(&self, plant: &BoardPlantOptions, interval_ms: i32) -> Drive {
        let (board, values) = (BoardParameters::DEFAULT, ObjectValues::DEFAULT);
        self.drive_with(plant, interval_ms, (board, values), 1.0)
    }

    /// The same with these parameters of the board, whose rate loop has gains of so many times
    /// those of the paper.
    fn drive_with(
        &self,
        plant: &BoardPlantOptions,
        interval_ms: i32,
        (board, mut values): (BoardParameters, ObjectValues),
        rate_gains: f64,
    ) -> Drive {
        values.tracking.velocity_permille = self.forward_permille;
        values.tracking.model_permille = self.forward_permille;
        values.tracking.dead_band_mdeg = self.dead_band_mdeg;
        if self.forward_permille > 0 {
            // As a commissioning measures it over a turn.
            let pair = |amplitude_deg: f64, phase_deg: f64| {
                let (sin, cos) = phase_deg.to_radians().sin_cos();
                [amplitude_deg * sin, amplitude_deg * cos].map(|deg| (deg * 1e3).round() as i16)
            };
            let (error, magnet) = (&mut values.encoder, &plant.encoder);
            [error.cosine_once_mdeg, error.sine_once_mdeg] = pair(
                magnet.misalignment_first_deg,
                magnet.misalignment_first_phase_deg,
            );
            [error.cosine_twice_mdeg, error.sine_twice_mdeg] = pair(
                magnet.misalignment_second_deg,
                magnet.misalignment_second_phase_deg,
            );
        }
        values.profile.interpolation_time = interval_ms as u8;
        values.tracking.rate_observer = self.observes.into();
        let gains = ControlParameters::DEFAULT;
        let gains = ControlParameters {
            position_gain: gains.position_gain * self.gains,
            proportional_gain: gains.proportional_gain * self.gains * rate_gains,
            integral_gain: gains.integral_gain * self.gains * self.gains * rate_gains,
            anti_windup_gain: gains.anti_windup_gain * self.gains,
            ..gains
        };
        let board = BoardParameters {
            control: Coefficients::try_new(&gains).expect("in range"),
            ..board
        };
        let parameters = LoopParameters::new(&board, &values);
        Drive::enabled(plant, &parameters)
    }
}

/// How a plant differs from the motor of 2011h.
type Differs = fn(&mut BoardPlantOptions);

const DIFFERENCES: [(&str, Differs); 8] = [
    ("torque constant -30 %", |plant| {
        plant.drivetrain.electrical.torque_constant_nm_a *= 0.7;
    }),
    ("torque constant +30 %", |plant| {
        plant.drivetrain.electrical.torque_constant_nm_a *= 1.3;
    }),
    ("resistance -30 %", |plant| {
        plant.drivetrain.electrical.winding_resistance_ohm *= 0.7;
    }),
    ("resistance +30 %", |plant| {
        plant.drivetrain.electrical.winding_resistance_ohm *= 1.3;
    }),
    ("inertia -30 %", |plant| {
        plant.drivetrain.gear_train.motor_inertia_kg_m2 *= 0.7;
    }),
    ("inertia +30 %", |plant| {
        plant.drivetrain.gear_train.motor_inertia_kg_m2 *= 1.3;
    }),
    ("1 deg of play", |plant| {
        plant.drivetrain.gear_train.backlash_deg = 1.0;
    }),
    ("magnet 1.4 deg off", |plant| {
        plant.encoder.misalignment_first_deg = 1.4;
    }),
];

/// A control period: command, angle of the shaft, duty.
#[derive(Debug, Clone, Copy)]
struct Sample {
    command_deg: f64,
    angle_deg: f64,
    duty_pct: f64,
}

/// Follows a command that is sent every `interval_ms`.
fn follow(drive: &mut Drive, interval_ms: i32, mut command: impl FnMut(f64) -> f64) -> Vec<Sample> {
    let spacing = u32::from(periods(interval_ms));
    let period = |number: u32| {
        let command_deg = command(f64::from(number) * PERIOD_S);
        if number.is_multiple_of(spacing) {
            drive.target(command_deg);
        }
        let (duty_pct, angle_deg) = drive.step();
        Sample {
            command_deg,
            angle_deg,
            duty_pct,
        }
    };
    (0..PERIODS).map(period).collect()
}

/// The mean over the seeds.
fn mean(figure: impl Fn(u64) -> f64 + Sync + Send) -> f64 {
    (0..SEEDS).into_par_iter().map(figure).sum::<f64>() / SEEDS as f64
}

/// Rms difference of angle and command, deg.
fn error_deg(samples: &[Sample]) -> f64 {
    let square = |sample: &Sample| (sample.command_deg - sample.angle_deg).powi(2);
    (samples.iter().map(square).sum::<f64>() / samples.len() as f64).sqrt()
}

/// Rms difference of the angle and the command of so many control periods before, deg.
fn late_error_deg(samples: &[Sample], periods: usize) -> f64 {
    let late = samples.iter().zip(&samples[periods..]);
    let late = late.map(|(before, now)| Sample {
        command_deg: before.command_deg,
        ..*now
    });
    error_deg(&late.collect::<Vec<_>>())
}

/// Rms error on a flight-like command at 50 Hz against the command of one interval before, deg.
fn late_flight_deg(setup: &Setup) -> f64 {
    mean(|seed| {
        let samples = follow(&mut setup.drive(seed, 20), 20, flight_like(seed));
        late_error_deg(&samples, periods(20).into())
    })
}

/// Rms error on a flight-like command, deg.
fn flight_deg(setup: &Setup, bench: Bench, interval_ms: i32) -> f64 {
    mean(|seed| {
        let mut drive = bench.drive(setup, seed, interval_ms);
        error_deg(&follow(&mut drive, interval_ms, flight_like(seed)))
    })
}

/// Rms error on a flight-like command at 50 Hz with a plant that differs, deg.
fn different_deg(setup: &Setup, differs: Differs) -> f64 {
    mean(|seed| {
        let mut plant = BoardPlantOptions::realistic(seed);
        differs(&mut plant);
        error_deg(&follow(
            &mut setup.drive_on(&plant, 20),
            20,
            flight_like(seed),
        ))
    })
}

/// Rms error on a standard input, deg.
fn standard_deg(setup: &Setup, name: &str) -> f64 {
    mean(|seed| error_deg(&follow(&mut setup.drive(seed, 4), 4, standard(name))))
}

/// Greatest angle beyond a step of the target, deg.
fn overshoot_deg(setup: &Setup, bench: Bench, (interval_ms, step_deg): (i32, f64)) -> f64 {
    let beyond = (0..SEEDS).into_par_iter().map(|seed| {
        let mut drive = bench.drive(setup, seed, interval_ms);
        let samples = follow(&mut drive, interval_ms, |time_s| {
            if time_s < 1.0 { 0.0 } else { step_deg }
        });
        let angles = samples.iter().map(|sample| sample.angle_deg);
        angles.fold(0.0, f64::max) - step_deg
    });
    beyond.reduce(|| 0.0, f64::max)
}

/// Amplitude of the angle over that of a sine.
fn gain(setup: &Setup, bench: Bench, (amplitude_deg, frequency_hz): (f64, f64)) -> f64 {
    mean(|seed| {
        let mut drive = bench.drive(setup, seed, 4);
        let samples = follow(&mut drive, 4, sine(amplitude_deg, frequency_hz));
        // Whole turns of the second half.
        let turn = 1.0 / (frequency_hz * PERIOD_S);
        let turns = (samples.len() as f64 / 2.0 / turn).floor();
        let from = samples.len() - (turns * turn).round() as usize;
        let (mut real, mut imaginary) = (0.0, 0.0);
        for (number, sample) in samples.iter().enumerate().skip(from) {
            let phase = TAU * number as f64 / turn;
            real += sample.angle_deg * phase.cos();
            imaginary += sample.angle_deg * phase.sin();
        }
        2.0 * real.hypot(imaginary) / ((samples.len() - from) as f64 * amplitude_deg)
    })
}

/// The least frequency at which the gain is below -3 dB, Hz, of frequencies 5 % apart.
fn bandwidth_hz(setup: &Setup, bench: Bench, amplitude_deg: f64) -> f64 {
    let frequencies = (0..100).map(|number| 0.5 * 1.05_f64.powi(number));
    let mut above = frequencies.skip_while(|&frequency_hz| {
        gain(setup, bench, (amplitude_deg, frequency_hz)) >= 0.5_f64.sqrt()
    });
    above.next().unwrap_or(f64::NAN)
}

/// The highest frequency at which the amplitude of the angle can be -3 dB of that of a sine, Hz:
/// the motor always accelerates with its torque at standstill, a square wave whose fundamental is
/// 4/pi of it. Friction and back-EMF, which are left out, lower it.
fn bound_hz(amplitude_deg: f64) -> f64 {
    let DrivetrainParameters {
        electrical,
        gear_train,
        ..
    } = BoardPlantOptions::realistic(0).drivetrain;
    let ratio = gear_train.gear_ratio;
    let inertia_kg_m2 = gear_train.inertia_kg_m2();
    let current_a = SOURCE_V / electrical.winding_resistance_ohm;
    let torque_nm = electrical.torque_constant_nm_a * ratio * current_a;
    let acceleration_deg_s2 = (torque_nm / inertia_kg_m2).to_degrees();
    let least_deg = amplitude_deg * 0.5_f64.sqrt();
    (4.0 / PI * acceleration_deg_s2 / least_deg).sqrt() / TAU
}

/// Copper loss on the flight-like command, W.
fn flight_loss_w(setup: &Setup) -> f64 {
    mean(|seed| {
        let mut drive = setup.drive(seed, 20);
        follow(&mut drive, 20, flight_like(seed));
        drive.copper_loss_j() / (f64::from(PERIODS) * PERIOD_S)
    })
}

fn figure() -> Figure {
    let shown = 8 * CONTROL_RATE_HZ as usize;
    let runs =
        SETUPS.map(|setup| follow(&mut setup.drive(1, 20), 20, flight_like(1))[..shown].to_vec());
    let time_s: Vec<f64> = (0..shown as u32)
        .map(|number| f64::from(number) * PERIOD_S)
        .collect();
    let commands: Vec<f64> = runs[0].iter().map(|sample| sample.command_deg).collect();
    let mut angle = Panel::new("angle (deg)").series(Series::new("command", 0, &time_s, &commands));
    let mut error = Panel::new("error (deg)");
    for ((colour, setup), run) in (1..).zip(&SETUPS).zip(&runs) {
        let angles: Vec<f64> = run.iter().map(|sample| sample.angle_deg).collect();
        let errors: Vec<f64> = (commands.iter().zip(&angles)).map(|(c, a)| c - a).collect();
        angle = angle.series(Series::new(setup.name, colour, &time_s, &angles));
        error = error.series(Series::new(setup.name, colour, &time_s, &errors));
    }
    Figure::new("Targets at 50 Hz", "time (s)")
        .panel(angle)
        .panel(error)
}

/// The lines of the table, each with a figure of each setup.
fn rows() -> Vec<(String, [f64; 3])> {
    type Measure = Box<dyn Fn(&Setup) -> f64>;
    let mut measures: Vec<(String, Measure)> = Vec::new();
    for (interval_ms, rate) in INTERVALS {
        for source_v in [5.0, SOURCE_V, 7.4] {
            measures.push((
                format!("rms error, targets at {rate}, {source_v:.1} V (deg)"),
                Box::new(move |setup| flight_deg(setup, Bench::at(source_v), interval_ms)),
            ));
        }
    }
    measures.push((
        "rms error against the command of 20 ms before, targets at 50 Hz (deg)".to_owned(),
        Box::new(late_flight_deg),
    ));
    // They show what an error of 2011h costs, at either rate.
    let differences = DIFFERENCES.into_iter().filter(|_| page::IS_PAPERS);
    for (difference, differs) in differences {
        measures.push((
            format!("rms error, targets at 50 Hz, {difference} (deg)"),
            Box::new(move |setup| different_deg(setup, differs)),
        ));
    }
    for name in ["chirp", "3-2-1-1"] {
        measures.push((
            format!("rms error, {name} of the paper (deg)"),
            Box::new(move |setup| standard_deg(setup, name)),
        ));
    }
    for (interval_ms, rate) in INTERVALS {
        for step_deg in [5.0, 20.0] {
            measures.push((
                format!("step of {step_deg} deg, targets at {rate}: beyond it (deg)"),
                Box::new(move |setup| overshoot_deg(setup, Bench::USUAL, (interval_ms, step_deg))),
            ));
        }
    }
    for amplitude_deg in [1.0, 5.0] {
        measures.push((
            format!("bandwidth at -3 dB, {amplitude_deg} deg (Hz)"),
            Box::new(move |setup| bandwidth_hz(setup, Bench::USUAL, amplitude_deg)),
        ));
        measures.push((
            format!("its bound by voltage and winding, {amplitude_deg} deg (Hz)"),
            Box::new(move |_| bound_hz(amplitude_deg)),
        ));
    }
    for (load, torque_nm) in [("", 0.0), (" under 0.3 N m", -0.3)] {
        type OfRest = fn(&Rest) -> f64;
        let parts: [(&str, OfRest); 4] = [
            ("changes of the duty's sign (1/s)", |it| it.changes_hz),
            ("greatest motion (deg)", |it| it.motion_deg),
            ("rms error (deg)", |it| it.error_deg),
            ("greatest error (deg)", |it| it.greatest_error_deg),
        ];
        for (name, part) in parts {
            measures.push((
                format!("at rest{load}: {name}"),
                Box::new(move |setup| part(&rest(setup, Bench::USUAL, torque_nm))),
            ));
        }
    }
    measures.push((
        "step of the load to 0.3 N m: greatest motion (deg)".to_owned(),
        Box::new(|setup| loaded(setup, -0.3).0),
    ));
    measures.push((
        "0.3 N m held: rms of the duty about its mean (%)".to_owned(),
        Box::new(|setup| loaded(setup, -0.3).1),
    ));
    measures.push((
        "copper loss, targets at 50 Hz (W)".to_owned(),
        Box::new(flight_loss_w),
    ));
    measures.push((
        "copper loss, 0.3 N m held (W)".to_owned(),
        Box::new(|setup| holding_loss_w(setup, -0.3)),
    ));
    measures.push((
        "rms current, 0.3 N m held (mA)".to_owned(),
        Box::new(|setup| {
            let winding = BoardPlantOptions::realistic(0).drivetrain.electrical;
            let square_a2 = holding_loss_w(setup, -0.3) / winding.winding_resistance_ohm;
            1e3 * square_a2.sqrt()
        }),
    ));
    let measured = measures
        .into_iter()
        .map(|(name, measure)| (name, SETUPS.each_ref().map(measure)));
    let mut rows: Vec<_> = measured.collect();
    rows.extend(margins(Bench::USUAL));
    rows
}

/// The margins of each setup on a bench.
fn margins(bench: Bench) -> [(String, [f64; 3]); 3] {
    let margins = SETUPS.each_ref().map(|setup| margin::margins(setup, bench));
    type Part = fn(Margins) -> f64;
    let parts: [(&str, Part); 3] = [
        ("phase margin (deg)", |it| it.phase_deg),
        ("frequency of the phase margin (Hz)", |it| it.crossing_hz),
        ("gain margin (dB)", |it| it.gain_db),
    ];
    parts.map(|(name, part)| (name.to_owned(), margins.map(part)))
}

/// What is measured of each setup on other benches too.
fn rows_of(bench: Bench) -> Vec<(String, [f64; 3])> {
    let rest = SETUPS.each_ref().map(|setup| rest(setup, bench, 0.0));
    let of_setups = |measure: &dyn Fn(&Setup) -> f64| SETUPS.each_ref().map(measure);
    let rows = [
        (
            "rms error, targets at 50 Hz (deg)",
            of_setups(&|setup| flight_deg(setup, bench, 20)),
        ),
        (
            "step of 5 deg: beyond it (deg)",
            of_setups(&|setup| overshoot_deg(setup, bench, (4, 5.0))),
        ),
        (
            "bandwidth, 1 deg (Hz)",
            of_setups(&|setup| bandwidth_hz(setup, bench, 1.0)),
        ),
        (
            "at rest: changes of sign (1/s)",
            rest.each_ref().map(|it| it.changes_hz),
        ),
        (
            "at rest: greatest error (deg)",
            rest.each_ref().map(|it| it.greatest_error_deg),
        ),
    ];
    let named = rows.map(|(name, values)| (name.to_owned(), values));
    named.into_iter().chain(margins(bench)).collect()
}

fn main() -> std::io::Result<()> {
    let options = Options::parse();
    let path = |extension: &str| options.out.join(page::NAME).with_extension(extension);
    fs::write(path("md"), page::page()?)?;
    fs::write(path("svg"), svg::render(&figure()))
}
