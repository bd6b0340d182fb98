//! The frequency response of an actuator, measured by running it.
//!
//! The command is a sum of sines at multiples of one frequency, the inverse of its period. The
//! actuator settles for one period; in the next one the angle at the control steps is correlated
//! with each sine.
//!
//! At the multiples without a sine a linear actuator has no motion: what is found there is
//! quantization, limit cycles and distortion. It limits what can be measured. A point is valid
//! where the motion at its sine is [`LEAST_RATIO`] times the largest motion within an octave of it
//! that no sine causes; its gain and phase are NaN otherwise. A motion of the same size at the
//! frequency of the sine changes the phase of a valid point by at most asin(1/3) = 19.5 deg and
//! its gain by at most -3.5 or +2.5 dB. The random error is smaller: the largest of ten motions of
//! one power has about three times their mean power, so that the coherence is above 0.96 and the
//! standard deviation of the phase below 8 deg (Bendat and Piersol, Random Data, 4th ed., section
//! 9.2.4).

use core::f64::consts::TAU;

use crate::actuator::Actuator;
use crate::time::{CONTROL_PERIOD_TICKS, TICKS_PER_SECOND};

/// Gain that defines the bandwidth: half the power, -3.0103 dB.
pub const HALF_POWER_DB: f64 = -3.010_299_956_639_812;

/// How many times larger a motion is than those around it that no sine causes, for a valid point.
pub const LEAST_RATIO: f64 = 3.0;

/// Multiples at which the motion is evaluated; at least an octave above the highest sine.
const MULTIPLES: usize = 200;

/// The multiples of the lowest sines reach up to here, so that one without a sine is among them.
const FEWEST_MULTIPLES: usize = 8;

/// A sine of the command.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sine {
    /// Periods of this sine in a period of the command: at least 1, at most 100.
    pub multiple: u16,
    /// Amplitude, deg.
    pub amplitude_deg: f64,
}

/// A periodic command: a sum of sines with the quadratic phases of Schroeder, which keep its peak
/// low.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Multisine<const N: usize> {
    /// Its period, in control periods.
    pub control_periods: u32,
    /// The sines, in the order of their frequencies.
    pub sines: [Sine; N],
}

/// One point of a response. Gain and phase are NaN where the point is not valid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// Its frequency, Hz.
    pub frequency_hz: f64,
    /// Gain from the command to the angle, dB.
    pub gain_db: f64,
    /// Phase, deg, without jumps by 360 deg; the transport delay is included.
    pub phase_deg: f64,
}

/// A measured frequency response.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrequencyResponse<const N: usize> {
    /// One point for each sine.
    pub points: [Point; N],
    /// Fraction of the power of the motion at the frequencies of the sines, 0 to 1; NaN without
    /// motion.
    pub linear_share: f64,
}

impl<const N: usize> Multisine<N> {
    /// The commands of one period, tick by tick.
    pub fn commands(&self) -> impl Iterator<Item = f64> {
        let mut phasors = [Phasor::default(); N];
        for (k, (phasor, sine)) in phasors.iter_mut().zip(&self.sines).enumerate() {
            let turns = f64::from(sine.multiple) / self.ticks() as f64;
            *phasor = Phasor::new(self.start_turns(k), turns);
        }
        let sines = self.sines;
        (0..self.ticks()).map(move |_| {
            let of = |(phasor, sine): (&mut Phasor, &Sine)| sine.amplitude_deg * phasor.next().1;
            phasors.iter_mut().zip(&sines).map(of).sum()
        })
    }

    /// Measures the response of an actuator whose command is delayed by `delay_s`.
    ///
    /// ```
    /// use model_core::actuator::{Actuator, ModelKind, PlantKind, Settings};
    /// use model_core::evaluation::frequency_response::{Multisine, Sine};
    ///
    /// let settings = Settings::new(ModelKind::BlackBox1, PlantKind::FirstOrder);
    /// let actuator = Actuator::try_new(&settings).unwrap();
    /// // 4.775 Hz: 30 rad/s.
    /// let sine = Sine { multiple: 1, amplitude_deg: 1.0 };
    /// let multisine = Multisine { control_periods: 250, sines: [Sine { multiple: 5, ..sine }] };
    /// let point = multisine.measure(actuator, settings.setup.delay_s).points[0];
    /// assert!((point.gain_db + 3.2).abs() < 0.1);
    /// ```
    pub fn measure(&self, mut actuator: Actuator, delay_s: f64) -> FrequencyResponse<N> {
        // A command that is not finite, of such an amplitude, moves nothing: no point is valid.
        let advance = |actuator: &mut Actuator, command_deg| {
            let _ = actuator.advance(command_deg, 1);
        };
        for command_deg in self.commands() {
            advance(&mut actuator, command_deg);
        }
        let mut motion = Motion::new(self.control_periods);
        for (tick, command_deg) in self.commands().enumerate() {
            if (tick as u64).is_multiple_of(CONTROL_PERIOD_TICKS) {
                motion.add(actuator.reading().angle_deg);
            }
            advance(&mut actuator, command_deg);
        }
        self.evaluate(&motion, delay_s)
    }

    fn ticks(&self) -> u64 {
        u64::from(self.control_periods) * CONTROL_PERIOD_TICKS
    }

    /// Phase of a sine at the start of the period, turns.
    fn start_turns(&self, k: usize) -> f64 {
        -((k * k) as f64) / (2 * N) as f64
    }

    fn evaluate(&self, motion: &Motion, delay_s: f64) -> FrequencyResponse<N> {
        let base_hz = TICKS_PER_SECOND as f64 / self.ticks() as f64;
        let mut power = 0.0;
        let mut phases_deg = [f64::NAN; N];
        let mut points = self.sines.map(|sine| Point {
            frequency_hz: f64::from(sine.multiple) * base_hz,
            gain_db: f64::NAN,
            phase_deg: f64::NAN,
        });
        for (k, sine) in self.sines.iter().enumerate() {
            let (amplitude_deg, turns) = motion.at(usize::from(sine.multiple));
            power += amplitude_deg * amplitude_deg / 2.0;
            if amplitude_deg > 0.0 && amplitude_deg >= LEAST_RATIO * self.unexcited(motion, sine) {
                points[k].gain_db = decibel(amplitude_deg / sine.amplitude_deg);
                // The known delay is removed while the phase is unwrapped: without it the phases of
                // neighbouring points differ by less than half a turn.
                let late = points[k].frequency_hz * delay_s;
                phases_deg[k] = 360.0 * (turns - self.start_turns(k) + late);
            }
        }
        // The first phase is within half a turn of zero.
        let first = phases_deg.iter_mut().find(|phase| !phase.is_nan());
        first
            .into_iter()
            .for_each(|phase| unwrap_deg(&mut [0.0, *phase]));
        unwrap_deg(&mut phases_deg);
        for (point, phase_deg) in points.iter_mut().zip(phases_deg) {
            point.phase_deg = phase_deg - 360.0 * point.frequency_hz * delay_s;
        }
        FrequencyResponse {
            points,
            linear_share: power / motion.power(),
        }
    }

    /// The largest amplitude within an octave of a sine at a multiple that has none, deg.
    fn unexcited(&self, motion: &Motion, sine: &Sine) -> f64 {
        let multiple = usize::from(sine.multiple);
        let from = multiple.div_ceil(2);
        let to = (2 * multiple).clamp(FEWEST_MULTIPLES, MULTIPLES);
        let is_free = |m: &usize| {
            self.sines
                .iter()
                .all(|sine| usize::from(sine.multiple) != *m)
        };
        let amplitudes = (from..=to).filter(is_free).map(|m| motion.at(m).0);
        amplitudes.fold(0.0, f64::max)
    }
}

/// The first frequency, Hz, at which the measured power falls to a half. `None` if it does not fall
/// that far.
///
/// The inverse of the power is interpolated over the square of the frequency, by a parabola through
/// the two points around the crossing and the one before them: of a lag of first or second order it
/// is one.
pub fn half_power_hz(points: &[Point]) -> Option<f64> {
    let mut valid = points.iter().filter(|point| !point.gain_db.is_nan());
    let mut before = None;
    let mut last = valid.next()?;
    for next in valid {
        if last.gain_db > HALF_POWER_DB && next.gain_db <= HALF_POWER_DB {
            let [low, high] = [last, next].map(inverse_power);
            let slope = (high.1 - low.1) / (high.0 - low.0);
            let slope_before = before.map(|(x, y)| ((low.1 - y) / (low.0 - x), high.0 - x));
            let curvature = slope_before.map_or(0.0, |(before, width)| (slope - before) / width);
            let at = |x: f64| low.1 + (x - low.0) * (slope + curvature * (x - high.0));
            let (mut from, mut to) = (low.0, high.0);
            // After 60 bisections there is no number between the limits.
            for _ in 0..60 {
                let middle = 0.5 * (from + to);
                if at(middle) < 2.0 {
                    from = middle;
                } else {
                    to = middle;
                }
            }
            return Some(libm::sqrt(from));
        }
        before = Some(inverse_power(last));
        last = next;
    }
    None
}

/// The square of the frequency and the inverse of the power.
fn inverse_power(point: &Point) -> (f64, f64) {
    let frequency_hz = point.frequency_hz;
    (
        frequency_hz * frequency_hz,
        libm::pow(10.0, -point.gain_db / 10.0),
    )
}

/// A gain in dB.
pub fn decibel(gain: f64) -> f64 {
    20.0 * libm::log10(gain)
}

/// Removes the jumps by whole turns from a sequence of angles; the first angle stays. NaN is
/// skipped.
pub fn unwrap_deg(angles_deg: &mut [f64]) {
    let mut last = f64::NAN;
    for angle_deg in angles_deg {
        if !last.is_nan() {
            *angle_deg -= 360.0 * libm::round((*angle_deg - last) / 360.0);
        }
        if !angle_deg.is_nan() {
            last = *angle_deg;
        }
    }
}

/// Cosine and sine of a phase that advances by the same angle each time.
#[derive(Debug, Clone, Copy, Default)]
struct Phasor {
    now: (f64, f64),
    step: (f64, f64),
}

impl Phasor {
    fn new(start_turns: f64, step_turns: f64) -> Self {
        let of = |turns: f64| (libm::cos(TAU * turns), libm::sin(TAU * turns));
        Self {
            now: of(start_turns),
            step: of(step_turns),
        }
    }

    /// The present value; advances. 100,000 rotations add rounding errors of up to 1e-11.
    fn next(&mut self) -> (f64, f64) {
        let ((cos, sin), (step_cos, step_sin)) = (self.now, self.step);
        self.now = (
            cos * step_cos - sin * step_sin,
            cos * step_sin + sin * step_cos,
        );
        (cos, sin)
    }
}

/// Amplitude and phase, deg, of the sine with this number of periods in equally spaced samples. The
/// phase is that at the first sample. A constant and harmonics do not change the result.
///
/// ```
/// use model_core::evaluation::frequency_response::sine;
///
/// let samples = [3.0, 1.0, -1.0, 1.0];
/// let (amplitude, phase_deg) = sine(&samples, 1);
/// assert!((amplitude - 2.0).abs() < 1e-12 && (phase_deg - 90.0).abs() < 1e-12);
/// ```
pub fn sine(samples: &[f64], periods: u32) -> (f64, f64) {
    let mut correlation = Correlation::new(f64::from(periods) / samples.len() as f64);
    samples.iter().for_each(|sample| correlation.add(*sample));
    let (amplitude, turns) = correlation.sine(samples.len() as f64);
    (amplitude, 360.0 * turns)
}

/// The correlation of samples with the cosine and sine of one frequency.
#[derive(Clone, Copy, Default)]
struct Correlation {
    phasor: Phasor,
    sums: (f64, f64),
}

impl Correlation {
    fn new(turns_per_sample: f64) -> Self {
        Self {
            phasor: Phasor::new(0.0, turns_per_sample),
            sums: (0.0, 0.0),
        }
    }

    fn add(&mut self, sample: f64) {
        let (cos, sin) = self.phasor.next();
        self.sums.0 += sample * cos;
        self.sums.1 += sample * sin;
    }

    /// Amplitude, and phase in turns.
    fn sine(&self, samples: f64) -> (f64, f64) {
        let (cos, sin) = self.sums;
        let amplitude = 2.0 * libm::hypot(cos, sin) / samples;
        (amplitude, libm::atan2(cos, sin) / TAU)
    }
}

/// The motion of one period at all multiples of its frequency.
struct Motion {
    samples: f64,
    multiples: [Correlation; MULTIPLES],
    sum: f64,
    squares: f64,
}

impl Motion {
    fn new(control_periods: u32) -> Self {
        let samples = f64::from(control_periods);
        Self {
            samples,
            multiples: core::array::from_fn(|i| Correlation::new((i + 1) as f64 / samples)),
            sum: 0.0,
            squares: 0.0,
        }
    }

    fn add(&mut self, angle_deg: f64) {
        self.multiples.iter_mut().for_each(|m| m.add(angle_deg));
        self.sum += angle_deg;
        self.squares += angle_deg * angle_deg;
    }

    /// Amplitude, deg, and phase of the sine at this multiple, turns.
    fn at(&self, multiple: usize) -> (f64, f64) {
        let correlation = self.multiples.get(multiple.wrapping_sub(1));
        correlation.copied().unwrap_or_default().sine(self.samples)
    }

    /// Power of the motion without its mean.
    fn power(&self) -> f64 {
        let mean = self.sum / self.samples;
        self.squares / self.samples - mean * mean
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::actuator::{ModelKind, PlantKind, Settings};
    use proptest::prelude::*;

    const ODD: [u16; 6] = [1, 3, 5, 9, 17, 33];

    fn odd(amplitude_deg: f64) -> Multisine<6> {
        Multisine {
            control_periods: 1000,
            sines: ODD.map(|multiple| Sine {
                multiple,
                amplitude_deg,
            }),
        }
    }

    fn measured(model: ModelKind, amplitude_deg: f64) -> FrequencyResponse<6> {
        let settings = Settings::new(model, PlantKind::FirstOrder);
        let actuator = Actuator::try_new(&settings).unwrap();
        odd(amplitude_deg).measure(actuator, settings.setup.delay_s)
    }

    #[test]
    fn the_first_order_model_has_the_gain_and_phase_of_its_pole_and_delay() {
        let response = measured(ModelKind::BlackBox1, 1.0);
        for point in &response.points {
            let s = point.frequency_hz * TAU / 30.0;
            // The command is held for a tick, which adds half a tick of delay.
            let delay_deg = 360.0 * point.frequency_hz * (0.0175 + 25e-6);
            let gain_db = -decibel(libm::hypot(1.0, s));
            let phase_deg = -libm::atan(s).to_degrees() - delay_deg;
            assert!((point.gain_db - gain_db).abs() < 1e-3, "{point:?}");
            assert!((point.phase_deg - phase_deg).abs() < 0.01, "{point:?}");
        }
        // No limit is active, and the transient has decayed to e^(-30*4).
        assert!((response.linear_share - 1.0).abs() < 1e-6);
    }

    #[test]
    fn a_point_is_valid_where_its_motion_exceeds_what_no_sine_causes_within_an_octave() {
        // A motion of 1 deg at 1, 3, 5, 9, 17 and 33 periods, and one other.
        let valid = |multiple: u16, amplitude_deg: f64| {
            let mut motion = Motion::new(1000);
            for i in 0..1000 {
                let sine =
                    |multiple: u16| libm::sin(TAU * f64::from(multiple) * f64::from(i) / 1e3);
                let excited: f64 = ODD.into_iter().map(sine).sum();
                motion.add(excited + amplitude_deg * sine(multiple));
            }
            let points = odd(1.0).evaluate(&motion, 0.0).points;
            points.map(|point| !point.gain_db.is_nan() && !point.phase_deg.is_nan())
        };
        assert_eq!(valid(12, 0.3), [true; 6]);
        assert_eq!(valid(12, 0.4), [true, true, true, false, false, true]);
        assert_eq!(valid(7, 0.4), [false, false, false, false, true, true]);
        assert_eq!(valid(150, 0.4), [true; 6]);
    }

    proptest! {
        #[test]
        fn a_sine_is_found_beside_a_constant_and_a_harmonic(
            amplitude in 0.01..100.0f64, turns in -0.49..0.49f64, constant in -100.0..100.0f64,
            periods in 1..40u32,
        ) {
            let samples: [f64; 1000] = core::array::from_fn(|i| {
                let x = TAU * f64::from(periods) * i as f64 / 1e3;
                amplitude * libm::sin(x + TAU * turns) + constant + libm::cos(3.0 * x)
            });
            let found = sine(&samples, periods);
            // Rounding of 1e-16 in 1000 sums, relative to the larger of all parts.
            let tolerance = 1e-10 * (amplitude + constant.abs() + 1.0);
            prop_assert!((found.0 - amplitude).abs() < tolerance);
            prop_assert!((found.1 - 360.0 * turns).abs() < 100.0 * tolerance / amplitude);
        }
    }

    #[test]
    fn the_command_is_the_sum_of_its_sines() {
        let multisine = odd(2.0);
        for (tick, command) in multisine.commands().enumerate().step_by(997) {
            let sine = |(k, multiple): (usize, &u16)| {
                let turns = f64::from(*multiple) * tick as f64 / multisine.ticks() as f64;
                2.0 * libm::sin(TAU * (turns + multisine.start_turns(k)))
            };
            let expected: f64 = ODD.iter().enumerate().map(sine).sum();
            assert!((command - expected).abs() < 1e-9, "{tick}");
        }
    }

    #[test]
    fn an_actuator_that_does_not_move_has_no_response_and_no_bandwidth() {
        let mut settings = Settings::new(ModelKind::BlackBox1, PlantKind::FirstOrder);
        settings.black_box_1.pole_rad_s = 0.0;
        let still = odd(1.0).measure(Actuator::try_new(&settings).unwrap(), 0.0);
        assert!(still.linear_share.is_nan());
        assert_eq!(half_power_hz(&still.points), None);
    }

    #[test]
    fn an_amplitude_that_is_not_finite_has_no_response() {
        let response = measured(ModelKind::BlackBox1, f64::NAN);
        assert!(response.points.iter().all(|point| point.gain_db.is_nan()));
    }

    /// Points of `1/((1 - u)^2 + (2 zeta)^2 u)` with `u = (f/1 Hz)^2`, and one that is not valid.
    fn oscillator(zeta: f64) -> [Point; 5] {
        [0.3, 0.5, 0.9, 1.0, 1.7].map(|frequency_hz| {
            let u = frequency_hz * frequency_hz;
            let gain = 1.0 / libm::sqrt((1.0 - u) * (1.0 - u) + 4.0 * zeta * zeta * u);
            Point {
                frequency_hz,
                gain_db: if u == 1.0 { f64::NAN } else { decibel(gain) },
                phase_deg: 0.0,
            }
        })
    }

    #[test]
    fn half_power_of_an_oscillator_is_found_between_valid_points() {
        for zeta in [0.5, 0.7, 0.9] {
            let points = oscillator(zeta);
            let m = 2.0 * zeta * zeta - 1.0;
            let expected = libm::sqrt(libm::sqrt(m * m + 1.0) - m);
            let found = half_power_hz(&points).unwrap();
            assert!((found - expected).abs() < 1e-9, "{zeta}: {found}");
        }
        assert_eq!(half_power_hz(&oscillator(0.5)[..4]), None);
    }
}
