//! Assigns samples of any spacing to slots of equal length, for correlations.
//!
//! Each sample is assigned to the nearest slot; slots without a sample are missing. Even samples
//! are unchanged. For uneven ones this is the slotting technique of W. T. Mayo (1974) of laser
//! anemometry: the correlation at a lag is the mean over all pairs of slots that are present.

use std::iter::zip;

use realfft::{RealFftPlanner, num_complex::Complex64};

/// The values of several signals in the same slots of equal length.
#[derive(Debug, Clone, PartialEq)]
pub struct Slots {
    /// Length of a slot, s.
    pub step_s: f64,
    /// One column for each signal; NaN is missing.
    pub columns: Vec<Vec<f64>>,
    /// Longest valid lag, in slots: longer gaps were shortened to it.
    pub longest_lag: usize,
}

/// The median step from sample to sample, s; `None` for fewer than two samples.
pub fn median_step_s(time_s: &[f64]) -> Option<f64> {
    let mut steps: Vec<f64> = time_s.windows(2).map(|t| t[1] - t[0]).collect();
    if steps.is_empty() {
        return None;
    }
    let middle = steps.len() / 2;
    let (_, median, _) = steps.select_nth_unstable_by(middle, f64::total_cmp);
    Some(*median).filter(|step| step.is_finite() && *step > 0.0)
}

/// The median step of the samples at which a signal is present, s: where each message of a log is a
/// sample, those of the others are not its own.
pub fn median_step_of_s(time_s: &[f64], signal: &[f64]) -> Option<f64> {
    if signal.iter().all(|value| value.is_finite()) {
        return median_step_s(time_s);
    }
    let present = time_s.iter().zip(signal).filter(|(_, v)| v.is_finite());
    median_step_s(&present.map(|(t, _)| *t).collect::<Vec<_>>())
}

impl Slots {
    /// Sorts signals over one increasing time into slots, as long as the median step of the one
    /// that is sampled most often. Gaps longer than `longest_lag_s` are shortened to that, which
    /// leaves every shorter lag as it is; `None` of fewer than two samples.
    pub fn new(time_s: &[f64], signals: &[&[f64]], longest_lag_s: f64) -> Option<Self> {
        let steps = signals
            .iter()
            .map(|signal| median_step_of_s(time_s, signal));
        let step_s = steps.flatten().min_by(f64::total_cmp)?;
        // Bounded, because a step may be much shorter than the longest lag.
        let longest_lag = (longest_lag_s / step_s)
            .round()
            .clamp(1.0, time_s.len() as f64) as usize;
        let mut places = Vec::with_capacity(time_s.len());
        let (mut place, mut anchor_s, mut anchor) = (0usize, *time_s.first()?, 0usize);
        let mut before_s = anchor_s;
        for &t in time_s {
            if t - before_s > longest_lag as f64 * step_s {
                (anchor_s, anchor) = (t, place + longest_lag + 1);
            }
            place = place.max(anchor + ((t - anchor_s) / step_s).round() as usize);
            places.push(place);
            before_s = t;
        }
        let column = |signal: &&[f64]| {
            let mut column = vec![f64::NAN; place + 1];
            for (&place, &value) in places.iter().zip(signal.iter()) {
                if value.is_finite() {
                    column[place] = value;
                }
            }
            column
        };
        Some(Self {
            step_s,
            columns: signals.iter().map(column).collect(),
            longest_lag,
        })
    }

    /// Fills the missing slots of a signal with its previous value, as of a held command.
    pub fn held(&mut self, signal: usize) {
        let Some(column) = self.columns.get_mut(signal) else {
            return;
        };
        let mut last = f64::NAN;
        for value in column {
            if value.is_nan() {
                *value = last;
            }
            last = *value;
        }
    }
}

/// Sums of products at lags, with their numbers of pairs.
#[derive(Debug, Clone, PartialEq)]
pub struct LaggedProducts {
    /// The sum of `a[i + lag] b[i]` for lag 0, 1 ...
    pub sums: Vec<f64>,
    /// The number of its terms.
    pub pairs: Vec<f64>,
}

/// Number of lags up to which the plain sum is faster than the transforms.
const FEW_LAGS: usize = 8;

/// The products of two signals in slots at the lags `0..=longest`, their means taken off before.
pub fn lagged_products(a: &[f64], b: &[f64], longest: usize) -> LaggedProducts {
    let pairs = if a.iter().chain(b).all(|v| v.is_finite()) {
        let pairs = |lag| a.len().saturating_sub(lag).min(b.len()) as f64;
        (0..=longest).map(pairs).collect()
    } else {
        let pairs = sums(presence(a), presence(b), longest);
        pairs.iter().map(|pairs| pairs.round()).collect()
    };
    LaggedProducts {
        sums: sums(centred(a), centred(b), longest),
        pairs,
    }
}

/// The sums of `a[i + lag] b[i]` for the lags `0..=longest`.
fn sums(a: Vec<f64>, b: Vec<f64>, longest: usize) -> Vec<f64> {
    if longest < FEW_LAGS {
        let sum = |lag| zip(a.iter().skip(lag), &b).map(|(a, b)| a * b).sum();
        (0..=longest).map(sum).collect()
    } else {
        sums_by_transform(a, b, longest)
    }
}

fn sums_by_transform(a: Vec<f64>, b: Vec<f64>, longest: usize) -> Vec<f64> {
    let length = (a.len().max(b.len()) + longest + 1).next_power_of_two();
    let mut planner = RealFftPlanner::<f64>::new();
    let forward = planner.plan_fft_forward(length);
    let inverse = planner.plan_fft_inverse(length);
    let spectrum = |mut padded: Vec<f64>| {
        padded.resize(length, 0.0);
        let mut spectrum = forward.make_output_vec();
        // It fails only for other lengths.
        let _ = forward.process(&mut padded, &mut spectrum);
        spectrum
    };
    let (a, b) = (spectrum(a), spectrum(b));
    let mut product: Vec<Complex64> = a.iter().zip(&b).map(|(a, b)| a * b.conj()).collect();
    // They are real for a real signal, except for rounding.
    for end in [0, product.len() - 1] {
        product[end].im = 0.0;
    }
    let mut lags = inverse.make_output_vec();
    let _ = inverse.process(&mut product, &mut lags);
    lags.truncate(longest + 1);
    lags.iter().map(|v| v / length as f64).collect()
}

/// With its mean subtracted, and zero where it is missing.
fn centred(signal: &[f64]) -> Vec<f64> {
    let present = || signal.iter().filter(|v| v.is_finite());
    let mean = present().sum::<f64>() / present().count().max(1) as f64;
    let centred = |v: &f64| if v.is_finite() { v - mean } else { 0.0 };
    signal.iter().map(centred).collect()
}

fn presence(signal: &[f64]) -> Vec<f64> {
    let presence = |v: &f64| f64::from(u8::from(v.is_finite()));
    signal.iter().map(presence).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn even_samples_keep_their_places_and_a_missing_one_leaves_its_slot_empty() {
        let time = [0.0, 0.1, 0.2, 0.4, 0.5];
        let slots = Slots::new(&time, &[&[1.0, 2.0, 3.0, 4.0, 5.0]], 1.0).expect("samples");
        assert!((slots.step_s - 0.1).abs() < 1e-12);
        assert_eq!(slots.columns[0].len(), 6);
        assert!(slots.columns[0][3].is_nan() && slots.columns[0][4] == 4.0);
    }

    #[test]
    fn a_gap_of_a_day_costs_no_memory() {
        let time: Vec<f64> = (0..200)
            .map(|i| f64::from(i) * 1e-3 + if i < 100 { 0.0 } else { 86_400.0 })
            .collect();
        let slots = Slots::new(&time, &[&time], 0.05).expect("samples");
        assert_eq!(slots.longest_lag, 50);
        assert_eq!(slots.columns[0].len(), 200 + 50);
    }

    #[test]
    fn products_are_those_of_the_plain_sum_with_missing_pairs_left_out() {
        let a: Vec<f64> = (0..40).map(|i| f64::from((i * 7) % 11)).collect();
        let whole: Vec<f64> = (0..43).map(|i| f64::from((i * 5) % 13)).collect();
        let mut missing = whole.clone();
        missing[7] = f64::NAN;
        for (b, longest) in [(&whole, 5), (&whole, 20), (&missing, 5), (&missing, 20)] {
            let (ca, cb) = (centred(&a), centred(b));
            let products = lagged_products(&a, b, longest);
            assert_eq!(products.sums.len(), longest + 1);
            for lag in 0..=longest {
                let pairs = (0..40 - lag).filter(|i| b[*i].is_finite());
                let plain: f64 = pairs.clone().map(|i| ca[i + lag] * cb[i]).sum();
                assert!((products.sums[lag] - plain).abs() < 1e-9);
                assert_eq!(products.pairs[lag], pairs.count() as f64);
            }
        }
    }
}
