//! The low-order equivalent system: gain, pole or poles, and delay.
//!
//! M. B. Tischler and R. K. Remple, Aircraft and Rotorcraft System Identification, 2nd ed. (2012),
//! sections 11.2 and 11.3; MIL-STD-1797. The cost is
//!
//! ```text
//! J = 20/n sum W ((gain difference in dB)^2 + 0.01745 (phase difference in deg)^2)
//! W = (1.58 (1 - exp(-coherence)))^2
//! ```
//!
//! with `n` frequencies that are evenly spaced on a logarithmic axis, so that 1 dB weighs as much
//! as 7.57 deg. Gain in dB and delay are linear: for given poles they are a least-squares solution,
//! and only the poles are searched, on a grid that is refined repeatedly.

use num_complex::Complex64;

use super::response::FrequencyResponse;
use crate::frequency::{decibel, logarithmic_grid, unwrap_deg};

/// Number of frequencies of a fit, as is usual.
const POINTS: usize = 20;
/// Weight of a squared degree against a squared decibel.
const PHASE_WEIGHT: f64 = 0.017_45;
/// The least coherence of a frequency that is used.
pub const LEAST_COHERENCE: f64 = 0.6;
/// Share of the Nyquist frequency up to which frequencies are used: above, aliasing adds some per
/// cent to the gain of a lag.
const NYQUIST_SHARE: f64 = 1.0 / 3.0;
/// The cost up to which a fit is acceptable (Tischler and Remple, section 11.3).
pub const ACCEPTABLE_COST: f64 = 100.0;
/// Range of a pole, rad/s.
const POLES_RAD_S: (f64, f64) = (0.1, 2000.0);
/// Range of a damping ratio.
const DAMPINGS: (f64, f64) = (0.02, 20.0);
/// Intervals of the first grid, on each axis: its points are 1.8 apart in a pole.
const FIRST_STEPS: usize = 16;
/// Intervals of each later grid, on each axis.
const STEPS: usize = 4;
/// Number of grids. The first one covers the whole range, the second one two of its intervals, and
/// each further one half of its predecessor: the last one resolves a pole to 1e-7.
const ROUNDS: usize = 26;

/// The form of an equivalent system.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
#[serde(untagged)]
pub enum Shape {
    /// `p/(s + p)`.
    First {
        /// The pole, rad/s.
        pole_rad_s: f64,
    },
    /// `w^2/(s^2 + 2 d w s + w^2)`.
    Second {
        /// The natural frequency, rad/s.
        natural_frequency_rad_s: f64,
        /// The damping.
        damping: f64,
    },
}

impl Shape {
    fn at(&self, s: Complex64) -> Complex64 {
        match *self {
            Self::First { pole_rad_s } => pole_rad_s / (s + pole_rad_s),
            Self::Second {
                natural_frequency_rad_s: w,
                damping,
            } => w * w / (s * s + 2.0 * damping * w * s + w * w),
        }
    }
}

/// An equivalent system of low order.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Equivalent {
    /// Its poles.
    #[serde(rename = "poles")]
    pub shape: Shape,
    /// Its steady gain.
    pub gain: f64,
    /// Its delay, s; not negative.
    pub delay_s: f64,
    /// The cost: a fit up to 100 is acceptable, one up to 50 can hardly be distinguished from the
    /// data.
    pub cost: f64,
    /// The lowest frequency of the fit, Hz.
    pub from_hz: f64,
    /// The highest frequency of the fit, Hz.
    pub to_hz: f64,
}

impl Equivalent {
    /// The first-order system nearest to a response. `None` where fewer than eight frequencies are
    /// coherent.
    pub fn first_order(response: &FrequencyResponse) -> Option<Self> {
        Self::nearest(response, [POLES_RAD_S, (1.0, 1.0)], |[pole_rad_s, _]| {
            Shape::First { pole_rad_s }
        })
    }

    /// The second-order system nearest to a response. `None` where fewer than ten frequencies are
    /// coherent.
    pub fn second_order(response: &FrequencyResponse) -> Option<Self> {
        Self::nearest(response, [POLES_RAD_S, DAMPINGS], |[w, damping]| {
            Shape::Second {
                natural_frequency_rad_s: w,
                damping,
            }
        })
    }

    /// Its value at a frequency.
    pub fn at(&self, frequency_hz: f64) -> Complex64 {
        let s = Complex64::new(0.0, std::f64::consts::TAU * frequency_hz);
        self.gain * self.shape.at(s) * (-s * self.delay_s).exp()
    }

    fn nearest(
        response: &FrequencyResponse,
        ranges: [(f64, f64); 2],
        shape: impl Fn([f64; 2]) -> Shape,
    ) -> Option<Self> {
        let points = points(response)?;
        let unknowns = 2 + ranges.iter().filter(|(low, high)| low < high).count();
        if points.len() < 2 * unknowns + 2 {
            return None;
        }
        let fit = |at: [f64; 2]| fitted(&points, shape(at));
        let logs = ranges.map(|(low, high)| (low.ln(), high.ln()));
        let mut best = ([0.0; 2], fit(ranges.map(|(low, high)| (low * high).sqrt())));
        let mut reach = logs.map(|(low, high)| high - low);
        let mut middle = logs.map(|(low, high)| 0.5 * (low + high));
        for round in 0..ROUNDS {
            let steps = if round == 0 { FIRST_STEPS } else { STEPS };
            for at in grid(middle, reach, logs, steps) {
                let found = fit(at.map(f64::exp));
                if found.cost < best.1.cost {
                    best = (at, found);
                    middle = at;
                }
            }
            let factor = if round == 0 {
                2.0 / FIRST_STEPS as f64
            } else {
                0.5
            };
            reach = reach.map(|reach| factor * reach);
        }
        Some(best.1)
    }
}

/// Points around a centre and within limits; one point where the limits coincide.
fn grid(
    middle: [f64; 2],
    reach: [f64; 2],
    limits: [(f64, f64); 2],
    steps: usize,
) -> impl Iterator<Item = [f64; 2]> {
    let line = move |axis: usize| {
        let (low, high) = limits[axis];
        let steps = if low < high { steps } else { 0 };
        (0..=steps).map(move |i| {
            let offset = if steps > 0 {
                i as f64 / steps as f64 - 0.5
            } else {
                0.0
            };
            (middle[axis] + offset * reach[axis]).max(low).min(high)
        })
    };
    line(0).flat_map(move |x| line(1).map(move |y| [x, y]))
}

/// A frequency of the fit.
struct Point {
    frequency_hz: f64,
    gain_db: f64,
    phase_deg: f64,
    weight: f64,
}

/// The coherent frequencies, thinned to even spacing on a logarithmic axis.
fn points(response: &FrequencyResponse) -> Option<Vec<Point>> {
    let highest_hz = NYQUIST_SHARE * response.nyquist_hz;
    let mut coherent = response.coherent(LEAST_COHERENCE);
    coherent.retain(|&i| response.frequency_hz[i] <= highest_hz);
    let (first, last) = (*coherent.first()?, *coherent.last()?);
    let ends = [first, last].map(|i| response.frequency_hz[i]);
    let per_decade = (POINTS as f64 / (ends[1] / ends[0]).log10().max(0.1)).ceil() as usize;
    let mut chosen: Vec<usize> = logarithmic_grid(ends[0], ends[1], per_decade)
        .into_iter()
        .filter_map(|f| {
            let distance = |i: &usize| (response.frequency_hz[*i] / f).ln().abs();
            coherent
                .iter()
                .copied()
                .min_by(|a, b| distance(a).total_cmp(&distance(b)))
        })
        .collect();
    chosen.dedup();
    let point = |i: usize| Point {
        frequency_hz: response.frequency_hz[i],
        gain_db: response.gain_db[i],
        phase_deg: response.phase_deg[i],
        weight: (1.58 * (1.0 - (-response.coherence[i]).exp())).powi(2),
    };
    Some(chosen.into_iter().map(point).collect())
}

/// The system of this shape with the best gain and delay.
fn fitted(points: &[Point], shape: Shape) -> Equivalent {
    let at = |p: &Point| shape.at(Complex64::new(0.0, std::f64::consts::TAU * p.frequency_hz));
    let values: Vec<Complex64> = points.iter().map(at).collect();
    let mut phases: Vec<f64> = values
        .iter()
        .map(|value| value.arg().to_degrees())
        .collect();
    unwrap_deg(&mut phases);
    let weights: f64 = points.iter().map(|p| p.weight).sum();
    let differences = points.iter().zip(&values);
    let differences: Vec<f64> = differences
        .map(|(p, value)| p.gain_db - decibel(value.norm()))
        .collect();
    let gains = points.iter().zip(&differences);
    let gain_db = gains.map(|(p, gain)| p.weight * gain).sum::<f64>() / weights;
    // The phase of a delay is -360 f delay: a line through the origin.
    let (mut above, mut below) = (0.0, 0.0);
    for (p, phase) in points.iter().zip(&phases) {
        above += p.weight * p.frequency_hz * (phase - p.phase_deg);
        below += p.weight * p.frequency_hz * p.frequency_hz;
    }
    let delay_s = (above / below / 360.0).max(0.0);
    let squares = points.iter().zip(differences.iter().zip(&phases));
    let squares = squares.map(|(p, (difference, phase))| {
        let gain = difference - gain_db;
        let phase = p.phase_deg - phase + 360.0 * p.frequency_hz * delay_s;
        p.weight * (gain * gain + PHASE_WEIGHT * phase * phase)
    });
    let ends = [points.first(), points.last()].map(|p| p.map_or(f64::NAN, |p| p.frequency_hz));
    Equivalent {
        shape,
        gain: 10_f64.powf(gain_db / 20.0),
        delay_s,
        cost: 20.0 / points.len() as f64 * squares.sum::<f64>(),
        from_hz: ends[0],
        to_hz: ends[1],
    }
}
