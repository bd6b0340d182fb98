//! The encoder: its error once and twice a turn. In runs over the range at constant rate the
//! integral of the back-EMF is the angle of the motor, from which that of the encoder deviates.
//! Angles are those of the encoder: from its count 0, in its direction.

use std::f64::consts::TAU;

use model_core::control::encoder_correction::GREATEST_HARMONIC_MDEG;
use model_core::control::encoder_word::COUNT_DEG;

use super::regression::{Regression, regression};
use super::runs::{arrive, constant_rate, flux_v_s};
use super::samples::{Board, SIGNALS, Sample, real};
use super::write::write_range;
use super::{CommissionError, Estimate, Limits, PERIOD_S, record};
use crate::can::client::{Client, ClientError};

/// Cosine and sine once, and cosine and sine twice a turn.
pub const HARMONICS: usize = 4;

/// The objects of the error.
pub const OBJECTS: [&str; HARMONICS] = ["2014:1", "2014:2", "2014:3", "2014:4"];

/// Shortest travel of a run: with it the standard error is that of half a count. On less of a turn
/// the error once a turn cannot be separated from that of the torque constant.
const LEAST_SPAN_MDEG: i32 = 270_000;

/// Longest travel of a run: each angle of a turn, in both directions.
const LONGEST_SPAN_MDEG: i32 = 400_000;

/// Pairs of runs, upward and downward.
const PAIRS: usize = 4;

/// By how much a pair is slower than the one before it, as a share of the greatest rate. The
/// back-EMF of a rate is between the same two codes of the converter for many degrees. A code is
/// 4.8 mV of back-EMF: half of it is 0.12 % of 2 V, which is 0.07 deg in a radian. At another rate
/// it is another part of a code.
const SLOWER: f64 = 0.07;

/// Largest standard error of what is stored: half a count, the quantisation of the encoder; deg.
const LARGEST_DEG: f64 = 0.5 * COUNT_DEG;

/// What all runs share, deg: an angle is truncated to mdeg, which is 0.6 mdeg once a turn; and of
/// the codes of the converter, 20 of which are between the least and the greatest back-EMF with a
/// magnet at its tolerance, 2 mdeg are left.
const COMMON_DEG: f64 = 0.003;

/// Points of the picture.
const POINTS: usize = 72;

/// The error of the encoder by the angle of the shaft.
#[derive(Debug, Clone, Default, serde::Serialize)]
pub struct EncoderError {
    /// Its harmonics; `None` if they are not known.
    pub harmonics: Option<Harmonics>,
    /// Means of the measured error at equal distances over the turn, against the mean of a turn.
    pub points: Vec<ErrorPoint>,
    /// Why it is not known, if runs do not show it.
    pub without_error: Option<String>,
}

/// The error once and twice a turn, deg.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Harmonics {
    /// Cosine once a turn.
    pub once_cosine_deg: Estimate,
    /// Sine once a turn.
    pub once_sine_deg: Estimate,
    /// Cosine twice a turn.
    pub twice_cosine_deg: Estimate,
    /// Sine twice a turn.
    pub twice_sine_deg: Estimate,
}

impl Harmonics {
    /// All of them, in the order of their objects.
    pub fn all(&self) -> [Estimate; HARMONICS] {
        [
            self.once_cosine_deg,
            self.once_sine_deg,
            self.twice_cosine_deg,
            self.twice_sine_deg,
        ]
    }
}

/// The measured error at an angle.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct ErrorPoint {
    /// Angle, deg.
    pub angle_deg: f64,
    /// Error, deg.
    pub error_deg: f64,
}

impl EncoderError {
    fn unknown(why: String) -> Self {
        Self {
            without_error: Some(why),
            ..Self::default()
        }
    }

    /// The objects that are stored, and their values in mdeg.
    pub fn objects(&self) -> Vec<(&'static str, f64)> {
        let harmonics = self.harmonics.iter().flat_map(Harmonics::all);
        let mdeg = harmonics.map(|harmonic| (harmonic.value * 1e3).round());
        OBJECTS.into_iter().zip(mdeg).collect()
    }

    /// The error at an angle of the shaft, against the mean of a turn; deg.
    pub fn at_deg(&self, angle_deg: f64) -> f64 {
        let harmonics = self.harmonics.iter().flat_map(Harmonics::all);
        let harmonics = harmonics.zip(waves(angle_deg));
        harmonics
            .map(|(harmonic, wave)| harmonic.value * wave)
            .sum()
    }
}

/// Cosine and sine once and twice a turn.
fn waves(angle_deg: f64) -> [f64; HARMONICS] {
    let x = angle_deg / 360.0 * TAU;
    [x.cos(), x.sin(), (2.0 * x).cos(), (2.0 * x).sin()]
}

/// The span of the runs within a range.
fn span_mdeg((low, high): (i32, i32)) -> i32 {
    ((high - low) / 10 * 9).min(LONGEST_SPAN_MDEG)
}

/// Whether a range has the span that shows the error.
pub fn has_span(range_mdeg: (i32, i32)) -> bool {
    span_mdeg(range_mdeg) >= LEAST_SPAN_MDEG
}

/// Measures the error in runs within this range, mdeg, and writes it, so that the steps behind this
/// one have the angle of the shaft. Without a result 2014h is as before, as within a range that is
/// too small, where nothing moves.
pub fn measure(
    client: &mut Client,
    (low, high): (i32, i32),
    limits: &Limits,
    board: &Board,
) -> Result<EncoderError, CommissionError> {
    if !has_span((low, high)) {
        return Ok(EncoderError::default());
    }
    let span_mdeg = span_mdeg((low, high));
    client.quick_stop()?;
    let mut before = Vec::new();
    for object in OBJECTS {
        before.push((object, client.integer(object)? as f64));
        client.write(object, "0")?;
    }
    write_range(client, (low.into(), high.into()))?;
    let centre = low.midpoint(high);
    let ends = [centre + span_mdeg / 2, centre - span_mdeg / 2];
    let mounting = Mounting::of(client)?;
    client.enable(1)?;
    client.write("6081", &limits.rate_mdeg_s.to_string())?;
    arrive(client, ends[1])?;
    let mut pairs = Vec::new();
    for pair in 0..PAIRS {
        let share = 1.0 - SLOWER * pair as f64;
        let rate_mdeg_s = (f64::from(limits.rate_mdeg_s) * share) as i32;
        client.write("6081", &rate_mdeg_s.to_string())?;
        let mut runs = Vec::new();
        for end in ends {
            let (capture, moved) = record(client, &SIGNALS, |client| arrive(client, end))?;
            moved?;
            let samples = board.samples(&capture);
            let run = constant_rate(&samples, rate_mdeg_s);
            runs.extend(run.map(|samples| Run::of(samples, &mounting)));
        }
        pairs.push(runs);
    }
    client.quick_stop()?;
    let found = of_pairs(&pairs);
    let stored = match found.harmonics {
        Some(_) => found.objects(),
        None => before,
    };
    let mut stored = stored.iter();
    stored.try_for_each(|(object, mdeg)| -> Result<(), ClientError> {
        client.write(object, &mdeg.to_string())
    })?;
    Ok(found)
}

/// How the encoder is mounted: its angle at zero, deg, and its direction, 1 or -1.
struct Mounting {
    zero_deg: f64,
    direction: f64,
}

impl Mounting {
    fn of(client: &mut Client) -> Result<Self, CommissionError> {
        Ok(Self {
            // A whole count.
            zero_deg: (real(client, "2010:3")? / COUNT_DEG).round() * COUNT_DEG,
            direction: real(client, "2010:4")?,
        })
    }
}

/// Integral of the back-EMF, time, and the waves of the error.
const FACTORS: usize = 2 + HARMONICS;

/// Rounds of the fit: the waves are those of the shaft, which is where the last round has found it.
/// Each makes the error of the angle smaller by the slope of the error, 0.04.
const ROUNDS: usize = 4;

/// A run.
struct Run {
    /// Angles by the encoder, deg.
    angles_deg: Vec<f64>,
    /// Integral of the back-EMF to each, V s.
    flux_v_s: Vec<f64>,
}

/// Factors, and an angle by the encoder, deg.
type Row = ([f64; FACTORS], f64);

impl Run {
    fn of(samples: &[Sample], mounting: &Mounting) -> Self {
        let Mounting {
            zero_deg,
            direction,
        } = mounting;
        let angle_deg = |sample: &Sample| zero_deg + direction * sample.angle_deg;
        Self {
            angles_deg: samples.iter().map(angle_deg).collect(),
            flux_v_s: flux_v_s(samples).collect(),
        }
    }

    /// The rows of the fit with the harmonics that the last one has found, each column less its
    /// mean, so that the angle of the start is not an unknown.
    fn rows(&self, harmonics: &[f64]) -> Vec<Row> {
        let row = |(period, (angle_deg, flux_v_s)): (usize, (&f64, &f64))| {
            let [a, b, c, d] = waves(shaft_deg(*angle_deg, harmonics));
            let factors = [*flux_v_s, period as f64 * PERIOD_S, a, b, c, d];
            (factors, *angle_deg)
        };
        let pairs = self.angles_deg.iter().zip(&self.flux_v_s);
        let mut rows: Vec<Row> = pairs.enumerate().map(row).collect();
        let count = rows.len() as f64;
        for factor in 0..FACTORS {
            let mean = rows.iter().map(|row| row.0[factor]).sum::<f64>() / count;
            rows.iter_mut().for_each(|row| row.0[factor] -= mean);
        }
        let mean = rows.iter().map(|row| row.1).sum::<f64>() / count;
        rows.iter_mut().for_each(|row| row.1 -= mean);
        rows
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// The angle of the shaft from that of the encoder, with these harmonics; deg.
fn shaft_deg(angle_deg: f64, harmonics: &[f64]) -> f64 {
    (0..ROUNDS).fold(angle_deg, |shaft_deg, _| {
        angle_deg - dot(&waves(shaft_deg), harmonics)
    })
}

/// The coefficients of these runs, and their rows.
fn fit<'a>(runs: impl Iterator<Item = &'a Run> + Clone) -> Option<Regression<FACTORS>> {
    let mut harmonics = [0.0; HARMONICS];
    let mut fitted = None;
    for _ in 0..ROUNDS {
        let rows = runs.clone().flat_map(|run| run.rows(&harmonics));
        let found = regression(&rows.collect::<Vec<_>>())?;
        harmonics.copy_from_slice(&found.coefficients[FACTORS - HARMONICS..]);
        fitted = Some(found);
    }
    fitted
}

/// The error by all runs. Its standard error has that by leaving out each pair of runs: residuals
/// in the integral of the back-EMF are not independent of each other.
fn of_pairs(pairs: &[Vec<Run>]) -> EncoderError {
    let without = |left_out: usize| {
        let pairs = pairs.iter().enumerate();
        fit(pairs
            .filter(move |(pair, _)| *pair != left_out)
            .flat_map(|(_, runs)| runs))
    };
    let others: Option<Vec<_>> = (0..pairs.len()).map(without).collect();
    let is_complete = pairs.iter().all(|runs| runs.len() == 2);
    let (Some(whole), Some(others), true) = (fit(pairs.iter().flatten()), others, is_complete)
    else {
        return EncoderError::unknown("no constant rate over the range".into());
    };
    let estimate = |index| harmonic(&whole, &others, FACTORS - HARMONICS + index);
    let harmonics = Harmonics {
        once_cosine_deg: estimate(0),
        once_sine_deg: estimate(1),
        twice_cosine_deg: estimate(2),
        twice_sine_deg: estimate(3),
    };
    let errors = harmonics.all().map(|harmonic| harmonic.standard_error);
    let most = errors.into_iter().fold(0.0, f64::max);
    // Not true for NaN either.
    let is_known = most <= LARGEST_DEG;
    if !is_known {
        return EncoderError::unknown(format!(
            "a standard error of {most:.3} deg, expected {LARGEST_DEG:.3} deg at most"
        ));
    }
    let values = harmonics.all().map(|harmonic| harmonic.value.abs() * 1e3);
    let greatest_mdeg = values.into_iter().fold(0.0, f64::max);
    if greatest_mdeg.round() > f64::from(GREATEST_HARMONIC_MDEG) {
        return EncoderError::unknown(format!(
            "an error of {greatest_mdeg:.0} mdeg, expected {GREATEST_HARMONIC_MDEG} mdeg at most: \
             the magnet is off its axis"
        ));
    }
    EncoderError {
        points: points(pairs.iter().flatten(), &whole),
        harmonics: Some(harmonics),
        without_error: None,
    }
}

/// A coefficient with its standard error by the residuals, and by leaving out each pair
/// (jackknife).
fn harmonic(whole: &Regression<FACTORS>, others: &[Regression<FACTORS>], index: usize) -> Estimate {
    let Estimate {
        value,
        standard_error,
    } = whole.estimate(index);
    let count = others.len() as f64;
    let values = || others.iter().map(|other| other.coefficients[index]);
    let mean = values().sum::<f64>() / count;
    let squares: f64 = values().map(|value| (value - mean).powi(2)).sum();
    Estimate {
        value,
        standard_error: [standard_error, COMMON_DEG]
            .into_iter()
            .fold((squares * (count - 1.0) / count).sqrt(), f64::hypot),
    }
}

/// What the back-EMF leaves of the angles, in means over equal parts of the turn.
fn points<'a>(runs: impl Iterator<Item = &'a Run>, whole: &Regression<FACTORS>) -> Vec<ErrorPoint> {
    let (by_back_emf, harmonics) = whole.coefficients.split_at(FACTORS - HARMONICS);
    let width_deg = 360.0 / POINTS as f64;
    let mut sums = [(0.0, 0.0); POINTS];
    for run in runs {
        let shafts: Vec<f64> = run
            .angles_deg
            .iter()
            .map(|at| shaft_deg(*at, harmonics))
            .collect();
        // The rows are without the mean of the error over the run.
        let errors = shafts.iter().map(|at| dot(&waves(*at), harmonics));
        let mean_deg = errors.sum::<f64>() / shafts.len() as f64;
        for (shaft_deg, (factors, value)) in shafts.iter().zip(run.rows(harmonics)) {
            let part = (shaft_deg.rem_euclid(360.0) / width_deg) as usize % POINTS;
            let (count, sum) = &mut sums[part];
            *count += 1.0;
            *sum += value - dot(&factors, by_back_emf) + mean_deg;
        }
    }
    let parts = sums.iter().enumerate();
    let measured = parts.filter(|(_, (count, _))| *count > 0.0);
    measured
        .map(|(part, (count, sum))| ErrorPoint {
            angle_deg: (part as f64 + 0.5) * width_deg,
            error_deg: sum / count,
        })
        .collect()
}
