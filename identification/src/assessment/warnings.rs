//! What speaks against a fit, in words.

use super::{Assessed, Assessment};
use crate::{
    fit::{Bound, Estimate, Termination},
    statistics::distributions::{COVERED, two_sided},
};

/// Two estimates this much correlated can hardly be told apart.
const STRONG_CORRELATION: f64 = 0.98;
/// An error as small as this comes from no sensor, deg.
const EXACT_DEG: f64 = 1e-6;
/// Theil's coefficient above which the agreement is called poor.
const POOR_INEQUALITY: f64 = 0.3;
/// Share of the error that a bias may have.
const LARGE_BIAS: f64 = 0.1;
/// Fewer starts than this share that end in the optimum are few.
const FEW_STARTS: f64 = 0.25;

/// All of them.
pub fn all(assessment: &Assessment) -> Vec<String> {
    let mut warnings = Vec::new();
    search(assessment, &mut warnings);
    for estimate in assessment.fit.estimates.iter().filter(|e| !e.fixed) {
        warnings.extend(parameter(assessment, estimate));
    }
    correlated(assessment, &mut warnings);
    for experiment in &assessment.experiments {
        limits(experiment, &mut warnings);
        residuals(experiment, &mut warnings);
    }
    colour(assessment, &mut warnings);
    warnings
}

fn search(assessment: &Assessment, warnings: &mut Vec<String>) {
    let fit = &assessment.fit;
    match fit.termination {
        Termination::Converged => {}
        Termination::IterationLimit => {
            warnings.push("the search ended at its most iterations, not at an optimum".into());
        }
        Termination::Stalled => {
            warnings.push("the search came to a halt where the cost still slopes".into());
        }
        Termination::Interrupted => {
            warnings.push("the search was interrupted: this is its best until then".into());
        }
    }
    if fit.reading.is_held {
        warnings.push(
            "the command is taken to keep its value from sample to sample: that fits better than a smooth one; \
             --hold smooth says otherwise"
                .into(),
        );
    }
    if fit.is_hold_open {
        warnings.push(format!(
            "the recordings do not tell whether the command is smooth, as is taken here, or held from sample \
             to sample: held, the delay would be {:.4} s less; --hold zero or --hold smooth says which",
            0.5 * usual_step_s(assessment)
        ));
    }
    if fit.reading.begins_at_rest {
        warnings.push(
            "the first command is taken to have come at the first sample, to an actuator at rest: that fits \
             better than one that had been there for long"
                .into(),
        );
    }
    if let Some(case) = fit.no_better_than {
        warnings.push(format!(
            "it fits no better than {case} but by chance: it stays where {case} fits best, and what it has \
             beyond that one is not identifiable from these experiments"
        ));
    }
    let (tried, ended_here) = fit.starts;
    if tried > 1 && (ended_here as f64) < FEW_STARTS * tried as f64 {
        warnings.push(format!(
            "only {ended_here} of {tried} starts end in this optimum: there are others; --starts \
             tries more"
        ));
    }
}

/// From sample to sample of the first recording, s.
fn usual_step_s(assessment: &Assessment) -> f64 {
    let time_s = assessment
        .experiments
        .first()
        .map(|e| e.recording.time_s.as_slice());
    match time_s {
        Some([first, .., last]) => (last - first) / (time_s.map_or(1, <[f64]>::len) - 1) as f64,
        _ => f64::NAN,
    }
}

/// The name of an estimate, with its experiment where it belongs to one.
fn called(assessment: &Assessment, estimate: &Estimate) -> String {
    let experiments = &assessment.fit.experiments;
    match estimate.experiment.and_then(|index| experiments.get(index)) {
        Some(experiment) => format!("{} of {}", estimate.name, experiment.name),
        None => estimate.name.to_owned(),
    }
}

fn parameter(assessment: &Assessment, estimate: &Estimate) -> Option<String> {
    let (name, unit) = (called(assessment, estimate), estimate.unit);
    let limit = match estimate.at_bound {
        Some(Bound::Low) => Some(("lower", estimate.bounds.0)),
        Some(Bound::High) => Some(("upper", estimate.bounds.1)),
        None => None,
    };
    match limit {
        Some((which, bound)) if estimate.identifiable => Some(format!(
            "{name} stands at its {which} bound of {bound} {unit}"
        )),
        Some((which, bound)) => Some(format!(
            "{name} runs into its {which} bound of {bound} {unit}: it is not identifiable from \
             these experiments"
        )),
        None if !estimate.identifiable => Some(format!(
            "{name} is not identifiable from these experiments: they leave it open, or cannot tell \
             it from others"
        )),
        None => None,
    }
}

fn correlated(assessment: &Assessment, warnings: &mut Vec<String>) {
    let fit = &assessment.fit;
    for (i, row) in fit.rows.iter().enumerate() {
        for (j, column) in fit.rows.iter().enumerate().take(i) {
            let correlation = fit.correlation[(i, j)];
            if correlation.abs() > STRONG_CORRELATION {
                let [a, b] = [column, row].map(|k| called(assessment, &fit.estimates[*k]));
                warnings.push(format!(
                    "{a} and {b} are correlated by {correlation:.3}: these experiments hardly tell \
                     them apart"
                ));
            }
        }
    }
}

/// That the data were rate limited, and for how long.
fn limits(experiment: &Assessed, warnings: &mut Vec<String>) {
    let (limited, name) = (&experiment.limited, &experiment.recording.name);
    let Some(longest) = limited.longest() else {
        return;
    };
    let total_s = limited.rate_limited_s();
    warnings.push(format!(
        "{name} is rate limited for {total_s:.3} s of {:.3} s ({:.0} %): up {:.3} s, down {:.3} s, \
         duty {:.3} s; the longest stretch is from {:.3} s to {:.3} s; linear tools find a slower \
         system in such data",
        limited.duration_s,
        100.0 * total_s / limited.duration_s,
        limited.rate_up_s,
        limited.rate_down_s,
        limited.duty_s,
        longest.from_s,
        longest.to_s,
    ));
}

/// Whether nothing but rounding is left: there is nothing to be said of it.
fn is_exact(experiment: &Assessed) -> bool {
    experiment.quality.is_some_and(|q| q.rms_deg < EXACT_DEG)
}

fn residuals(experiment: &Assessed, warnings: &mut Vec<String>) {
    if is_exact(experiment) {
        return;
    }
    let name = &experiment.recording.name;
    if let Some(quality) = &experiment.quality {
        let theil = quality.theil;
        if theil.inequality > POOR_INEQUALITY {
            warnings.push(format!(
                "{name}: the agreement is poor, Theil's coefficient is {:.2} (good is below 0.25)",
                theil.inequality
            ));
        }
        if theil.bias > LARGE_BIAS {
            warnings.push(format!(
                "{name}: {:.0} % of the error is an offset of {:.3} deg",
                100.0 * theil.bias,
                quality.bias_deg
            ));
        }
    }
    let correlations = experiment.correlations.as_ref();
    if let Some(found) = correlations.filter(|c| c.is_correlated_with_input()) {
        warnings.push(format!(
            "{name}: the command still shows in the residual ({:.1} times its 95 % band): the \
             actuator does something that the model does not",
            found.cross_ratio
        ));
    }
}

/// That the standard errors for white residuals are too small, and by how much.
fn colour(assessment: &Assessment, warnings: &mut Vec<String>) {
    let inexact = assessment.experiments.iter().filter(|e| !is_exact(e));
    let coloured = inexact.filter(|e| {
        let whiteness = e.correlations.as_ref().map(|c| c.whiteness);
        whiteness.is_some_and(|w| !w.is_white())
    });
    let names: Vec<&str> = coloured.map(|e| e.recording.name.as_str()).collect();
    if names.is_empty() {
        return;
    }
    let ratios = assessment.fit.estimates.iter();
    let ratios = ratios.map(|e| e.standard_error_coloured / e.standard_error);
    let largest = ratios.filter(|r| r.is_finite()).fold(f64::NAN, f64::max);
    let consequence = if largest.is_nan() {
        String::new()
    } else {
        format!(
            "; the standard errors that allow for it are up to {largest:.1} times those for white \
             residuals, and {:.2} of them make a {:.0} % interval",
            two_sided(COVERED),
            100.0 * COVERED
        )
    };
    warnings.push(format!(
        "the residuals of {} are not white{consequence}",
        names.join(", ")
    ));
}
