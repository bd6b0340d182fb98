//! The frequency response of recordings, with coherence and confidence.

use std::f64::consts::{PI, TAU};

use realfft::{RealFftPlanner, RealToComplex, num_complex::Complex64};
use std::sync::Arc;

use super::decibel;
use super::grid::{Stretch, common_step_s, is_held, stretches};
use crate::{
    recording::Recording,
    statistics::distributions::{COVERED, two_sided},
};

/// Number of windows without overlap; with the overlap there are seven.
const WINDOWS_PER_RECORD: usize = 4;
/// The shortest useful window, samples.
const SHORTEST_WINDOW: usize = 32;
/// The longest window, samples: more frequencies are not needed.
const LONGEST_WINDOW: usize = 1 << 15;
/// Share of the largest input power below which a line is rounding and leakage.
const LEAST_POWER: f64 = 1e-7;
/// Correlation of two Hann windows that overlap by half (F. J. Harris, Proc. IEEE 66, 1978).
const OVERLAP_CORRELATION: f64 = 1.0 / 6.0;
/// Coherence below which a phase is not used for unwrapping.
const TRUSTED_COHERENCE: f64 = 0.5;

/// A frequency response from command to angle, with one value for each frequency.
///
/// P. D. Welch, IEEE Trans. Audio Electroacoustics 15 (1967): Hann windows that overlap by half.
/// The estimate is `Sxy/Sxx`, unbiased for noise on the angle; the errors are those of J. S. Bendat
/// and A. G. Piersol, Random Data, 4th ed. (2010), section 9.2.
#[derive(Debug, Clone, PartialEq, Default, serde::Serialize)]
pub struct FrequencyResponse {
    /// Frequencies, Hz.
    pub frequency_hz: Vec<f64>,
    /// Gains, dB.
    pub gain_db: Vec<f64>,
    /// Phases, deg, without jumps by whole turns.
    pub phase_deg: Vec<f64>,
    /// Coherence, 0 to 1: the share of the angle's power that the command explains.
    pub coherence: Vec<f64>,
    /// Half of the 95 % interval of the gain, dB.
    pub gain_error_db: Vec<f64>,
    /// Half of the 95 % interval of the phase, deg.
    pub phase_error_deg: Vec<f64>,
    /// The number of independent windows that were averaged.
    pub averages: f64,
    /// Half the frequency of the samples, Hz.
    #[serde(skip)]
    pub nyquist_hz: f64,
}

impl FrequencyResponse {
    /// The response of all recordings together. `None` where they are too short, or the command is
    /// constant.
    ///
    /// The lag of half a sample of a zero-order hold is removed, so that the response is that of
    /// the actuator alone.
    pub fn of(recordings: &[&Recording]) -> Option<Self> {
        let step_s = common_step_s(recordings)?;
        let all: Vec<Vec<Stretch>> = recordings.iter().map(|r| stretches(r, step_s)).collect();
        let all: Vec<&Stretch> = all.iter().flatten().collect();
        let samples: usize = all.iter().map(|s| s.angle_deg.len()).sum();
        let longest = all.iter().map(|s| s.angle_deg.len()).max()?;
        let window = (samples / WINDOWS_PER_RECORD).clamp(SHORTEST_WINDOW, LONGEST_WINDOW);
        // An even number that fits into the longest segment.
        let window = window.min(longest) / 2 * 2;
        if window < SHORTEST_WINDOW {
            return None;
        }
        let mut spectra = Spectra::new(window);
        all.iter().for_each(|stretch| spectra.add(stretch));
        let held = recordings.iter().filter(|r| is_held(r)).count() * 2 > recordings.len();
        spectra.response(step_s, held)
    }

    /// The indices of the coherent frequencies from the lowest on, up to the first two adjacent
    /// ones with less coherence.
    pub fn coherent(&self, least_coherence: f64) -> Vec<usize> {
        let good = |i: usize| self.coherence[i] >= least_coherence;
        let n = self.frequency_hz.len();
        let Some(first) = (0..n).find(|&i| good(i)) else {
            return Vec::new();
        };
        let end = (first..n).find(|&i| !good(i) && (i + 1 >= n || !good(i + 1)));
        (first..end.unwrap_or(n)).filter(|&i| good(i)).collect()
    }
}

/// Sums of spectra over windows.
struct Spectra {
    transform: Arc<dyn RealToComplex<f64>>,
    shape: Vec<f64>,
    xx: Vec<f64>,
    yy: Vec<f64>,
    xy: Vec<Complex64>,
    windows: usize,
}

impl Spectra {
    fn new(window: usize) -> Self {
        let lines = window / 2 + 1;
        let hann = |i| 0.5 - 0.5 * (TAU * i as f64 / window as f64).cos();
        Self {
            transform: RealFftPlanner::new().plan_fft_forward(window),
            shape: (0..window).map(hann).collect(),
            xx: vec![0.0; lines],
            yy: vec![0.0; lines],
            xy: vec![Complex64::ZERO; lines],
            windows: 0,
        }
    }

    fn add(&mut self, stretch: &Stretch) {
        let window = self.shape.len();
        let starts = (0..stretch.angle_deg.len().saturating_sub(window - 1)).step_by(window / 2);
        for start in starts {
            let x = self.spectrum(&stretch.command_deg[start..start + window]);
            let y = self.spectrum(&stretch.angle_deg[start..start + window]);
            for line in 0..self.xx.len() {
                self.xx[line] += x[line].norm_sqr();
                self.yy[line] += y[line].norm_sqr();
                self.xy[line] += x[line].conj() * y[line];
            }
            self.windows += 1;
        }
    }

    fn spectrum(&self, samples: &[f64]) -> Vec<Complex64> {
        let mean = samples.iter().sum::<f64>() / samples.len() as f64;
        let shaped = samples.iter().zip(&self.shape);
        let mut shaped: Vec<f64> = shaped.map(|(v, shape)| (v - mean) * shape).collect();
        let mut spectrum = self.transform.make_output_vec();
        // It fails only for other lengths.
        let _ = self.transform.process(&mut shaped, &mut spectrum);
        spectrum
    }

    fn response(&self, step_s: f64, held: bool) -> Option<FrequencyResponse> {
        let strongest = self.xx.iter().copied().fold(0.0, f64::max);
        // A constant command has no power but rounding.
        if self.windows == 0 || strongest < 1e-18 {
            return None;
        }
        let windows = self.windows as f64;
        let overlap = 2.0 * OVERLAP_CORRELATION.powi(2) * (windows - 1.0) / windows;
        let mut response = FrequencyResponse {
            averages: windows / (1.0 + overlap),
            nyquist_hz: 0.5 / step_s,
            ..FrequencyResponse::default()
        };
        let spacing_hz = 1.0 / (step_s * self.shape.len() as f64);
        // The window spreads the mean over two lines; the Nyquist frequency has no phase.
        for line in 2..self.xx.len() - 1 {
            if self.xx[line] > LEAST_POWER * strongest {
                self.point(&mut response, line, line as f64 * spacing_hz, step_s, held);
            }
        }
        unwrap(&mut response);
        (!response.frequency_hz.is_empty()).then_some(response)
    }

    fn point(
        &self,
        response: &mut FrequencyResponse,
        line: usize,
        frequency_hz: f64,
        step_s: f64,
        held: bool,
    ) {
        let power = self.xx[line] * self.yy[line];
        let coherence = if power > 0.0 {
            self.xy[line].norm_sqr() / power
        } else {
            0.0
        };
        let half_turn = PI * frequency_hz * step_s;
        let hold = match held {
            true => Complex64::from_polar(half_turn.sin() / half_turn, -half_turn),
            false => Complex64::ONE,
        };
        let value = self.xy[line] / self.xx[line] / hold;
        let error = ((1.0 - coherence).max(0.0) / (2.0 * response.averages * coherence)).sqrt();
        let reach = two_sided(COVERED) * error;
        response.frequency_hz.push(frequency_hz);
        response.gain_db.push(decibel(value.norm()));
        response.phase_deg.push(value.arg().to_degrees());
        response.coherence.push(coherence.min(1.0));
        response.gain_error_db.push(decibel(1.0 + reach));
        // Errors above half a turn are not defined.
        response.phase_error_deg.push(if reach < 1.0 {
            reach.asin().to_degrees()
        } else {
            180.0
        });
    }
}

/// Unwraps the phases along the coherent ones.
fn unwrap(response: &mut FrequencyResponse) {
    let mut leading = 0.0;
    for (phase, coherence) in response.phase_deg.iter_mut().zip(&response.coherence) {
        *phase -= 360.0 * ((*phase - leading) / 360.0_f64).round();
        if *coherence >= TRUSTED_COHERENCE {
            leading = *phase;
        }
    }
}
