//! Warnings about a fit, in words.

use model_core::parameter::Shown;

use super::{Assessed, Assessment, instants};
use crate::{
    consistency::Part,
    fit::{Bound, Combination, Estimate},
    levenberg::Termination,
    loss::Loss,
    misfit::Misfit,
    screening::suspicion,
    statistics::distributions::{COVERED, two_sided},
};

/// Correlation above which two estimates can hardly be distinguished.
const STRONG_CORRELATION: f64 = 0.98;
/// Residuals in those of the noise from which the model does not describe the recordings: of the
/// models of the evaluation that do, with white noise, they are 0.9 to 1.1.
const UNEXPLAINED: f64 = 1.5;
/// The same for the worst of some stretches, in which they are up to 1.4. A backlash of ten times
/// the noise has 2.2 to 2.8, and a gain that is off by ten standard errors.
const UNEXPLAINED_STRETCH: f64 = 2.0;
/// Standard errors beyond a bound from which the bound is wrong: by chance once in 30,000 cases.
const BEYOND: f64 = 4.0;
/// RMS error below which data are simulated without noise, deg.
const EXACT_DEG: f64 = 1e-6;
/// Theil's coefficient above which the agreement is called poor.
const POOR_INEQUALITY: f64 = 0.3;
/// Share of the bias in the mean square error above which it is reported.
const LARGE_BIAS: f64 = 0.1;
/// Share of outliers above which they may be the rule.
const MANY_OUTLIERS: f64 = 0.1;
/// Share of starts that end in the optimum below which a warning is due.
const FEW_STARTS: f64 = 0.25;

/// All warnings.
pub fn all(assessment: &Assessment) -> Vec<String> {
    let mut warnings = Vec::new();
    let is_explained = is_explained(&assessment.fit.misfit);
    search(assessment, is_explained, &mut warnings);
    outliers(assessment, &mut warnings);
    for experiment in &assessment.experiments {
        units(assessment, experiment, &mut warnings);
    }
    for estimate in assessment.fit.estimates.iter().filter(|e| !e.fixed) {
        warnings.extend(parameter(assessment, estimate));
    }
    combinations(assessment, &mut warnings);
    correlated(assessment, &mut warnings);
    for experiment in &assessment.experiments {
        limits(experiment, &mut warnings);
        residuals(experiment, is_explained, &mut warnings);
    }
    // The doubt says it of a model that does not explain the data.
    if is_explained {
        coloured_residuals(assessment, &mut warnings);
    }
    warnings.extend_from_slice(&assessment.doubts);
    warnings
}

/// Why the intervals may not cover the true values, in words; nothing where they can be relied on.
pub fn doubts(assessment: &Assessment) -> Vec<String> {
    let mut doubts = Vec::new();
    let fit = &assessment.fit;
    let interval = 100.0 * COVERED;
    for difference in &fit.consistency.differences {
        let place = match difference.part {
            Part::FirstHalf => "the first half of the recording and the second".into(),
            Part::Recording(index) => format!("{} and the others", fit.experiments[index].name),
        };
        let digits = |(value, error): (f64, f64)| format!("{value:.4} +- {error:.4}");
        doubts.push(format!(
            "{} differs between {place}, about {} against {} {}: by {:.1} standard errors, so that \
             no {interval:.0} % interval of it holds for both",
            difference.name,
            digits(difference.there),
            digits(difference.elsewhere),
            difference.unit,
            difference.z.abs()
        ));
    }
    if let Some(drift) = fit.consistency.drift {
        doubts.push(format!(
            "the clock of the angle differs from that of the command by {:.2} +- {:.2} %, or the \
             delay changes by as much of the time: the estimates are those of neither",
            100.0 * drift.share,
            100.0 * drift.standard_error,
        ));
    }
    if let Loss::Student { .. } = fit.loss {
        let outliers: usize = fit.experiments.iter().map(|e| e.outliers.len()).sum();
        let share = outliers as f64 / fit.samples as f64;
        if share > MANY_OUTLIERS {
            doubts.push(format!(
                "{:.0} % of the samples are outliers: no loss identifies the correct ones",
                100.0 * share
            ));
        }
    }
    for run in &assessment.experiments {
        doubts.extend(instants::error_s(run).map(|error_s| {
            format!(
                "the instants of the samples of {} have an error of about {:.1} ms rms: its residuals \
                 grow with the rate, and the estimates depend on that error; record the instant of \
                 each sample",
                run.recording.name,
                1e3 * error_s
            )
        }));
    }
    misfit(assessment, &mut doubts);
    for estimate in fit.estimates.iter().filter(|e| e.beyond > BEYOND) {
        doubts.push(format!(
            "{} would be beyond its bound of {} by {:.0} standard errors: the other estimates are \
             those for that bound; the option `bound` sets another",
            label(assessment, estimate),
            with_unit(estimate.value, estimate.unit),
            estimate.beyond
        ));
    }
    if fit.termination != Termination::Converged {
        doubts.push("the search has not converged: the errors are not those of an optimum".into());
    }
    doubts
}

/// Whether the noise explains the residuals.
fn is_explained(misfit: &Misfit) -> bool {
    misfit.ratio < UNEXPLAINED && misfit.worst < UNEXPLAINED_STRETCH
}

/// Residuals that the noise does not explain.
fn misfit(assessment: &Assessment, doubts: &mut Vec<String>) {
    let fit = &assessment.fit;
    let Misfit {
        noise_deg,
        ratio,
        worst,
    } = fit.misfit;
    if is_explained(&fit.misfit) {
        return;
    }
    let of_range = |f: fn(f64, f64) -> f64, first: f64, column: fn(&Assessed) -> &Vec<f64>| {
        let values = assessment.experiments.iter().flat_map(column);
        values
            .filter(|value| !value.is_nan())
            .fold(first, |a, b| f(a, *b))
    };
    let (low, high) = (
        of_range(f64::min, f64::INFINITY, |e| &e.recording.angle_deg),
        of_range(f64::max, f64::NEG_INFINITY, |e| &e.recording.angle_deg),
    );
    let has_stop = |name: &str| {
        fit.estimate(name)
            .is_some_and(|e| e.fixed && e.value.is_infinite())
    };
    let stop = ["position_limit_deg", "hard_stop_deg"]
        .into_iter()
        .find(|name| has_stop(name));
    let stop = stop.map_or(String::new(), |name| {
        format!("a stop by the option `free` with {name}, ")
    });
    let all = || {
        assessment
            .experiments
            .iter()
            .filter_map(|e| e.correlations.as_ref())
    };
    let white = match all().all(|c| c.whiteness.is_white()) {
        true => "",
        false => "not white, ",
    };
    let follows = all().filter(|c| c.is_correlated_with_input());
    let follows = follows.map(|c| c.cross_ratio).fold(f64::NAN, f64::max);
    let follows = match follows.is_nan() {
        true => String::new(),
        false => format!(
            ", and correlated with the command ({follows:.1} times its 95 % band), so that it lacks \
             dynamics"
        ),
    };
    doubts.push(format!(
        "the model does not explain the data: its residuals are {white}{ratio:.1} times the noise of \
         {noise_deg:.3} deg, in one stretch {worst:.1} times{follows}; the estimates hold for inputs \
         like these only (angles from {low:.1} to {high:.1} deg), and no interval of them is known; \
         try {stop}another model, the option `window`, more `starts`, and check the column and unit \
         of the command",
    ));
}

fn search(assessment: &Assessment, is_explained: bool, warnings: &mut Vec<String>) {
    let fit = &assessment.fit;
    match fit.termination {
        Termination::Converged => {}
        Termination::IterationLimit => {
            warnings.push("the search reached its iteration limit before an optimum".into());
        }
        Termination::Stalled => {
            warnings.push("the search stalled where the gradient of the cost is not zero".into());
        }
        Termination::Interrupted => {
            warnings.push("the search was interrupted: these are its best values so far".into());
        }
    }
    if fit.assumptions.is_held {
        warnings.push(
            "a zero-order hold is assumed for the command: it fits better than a smooth command; \
             the hold `smooth` overrides this"
                .into(),
        );
    }
    if fit.is_hold_undetermined {
        warnings.push(format!(
            "the recordings do not determine whether the command is smooth, as assumed here, or held \
             from sample to sample: with a zero-order hold the delay would be {:.4} s less and other \
             parameters would differ, which the standard errors include; the hold `zero` or `smooth` decides",
            0.5 * mean_interval_s(assessment)
        ));
    }
    if let Some((below, above)) = fit.delay_open_s {
        warnings.push(format!(
            "the command {} up to one sample before the recording shows it: for that reason the delay \
             may be {below:.4} s less or {above:.4} s more, which its standard errors include",
            if below > 0.0 { "changes by a different time for each step," } else { "may have changed" }
        ));
    }
    if fit.assumptions.begins_at_rest {
        warnings.push(
            "the first command is assumed to arrive at the first sample, at an actuator at rest: that \
             fits better than a command that was applied long before"
                .into(),
        );
    }
    if let Some(nested) = fit.no_better_than {
        warnings.push(format!(
            "by a likelihood-ratio test it fits no better than {nested}: it is reported at the optimum \
             of {nested}, and its additional parameters are not identifiable from these experiments"
        ));
    }
    let (tried, ended_here) = fit.starts;
    // The doubt about the model names more starts.
    if is_explained && tried > 1 && (ended_here as f64) < FEW_STARTS * tried as f64 {
        warnings.push(format!(
            "only {ended_here} of {tried} starts end in this optimum: there are other minima, \
             which more starts may find"
        ));
    }
}

/// The robust loss, and the samples that hardly count under it.
fn outliers(assessment: &Assessment, warnings: &mut Vec<String>) {
    let Loss::Student { scale_deg } = assessment.fit.loss else {
        return;
    };
    warnings.push(format!(
        "isolated residuals would decide a fit by least squares: a robust loss is used, that of \
         Student's distribution with a scale of {scale_deg:.4} deg; the loss `squares` overrides this"
    ));
    for experiment in &assessment.experiments {
        let outliers = &experiment.fit.outliers;
        let Some(first) = outliers.first() else {
            continue;
        };
        warnings.push(format!(
            "{}: {} of {} samples have less than a tenth of the weight of the others, the first of \
             them at {:.4} s with a residual of {:.3} deg",
            experiment.recording.name,
            outliers.len(),
            experiment.recording.len(),
            experiment.recording.time_s[*first],
            experiment.fit.residual_deg[*first],
        ));
    }
}

/// Units and signs that look wrong.
fn units(assessment: &Assessment, experiment: &Assessed, warnings: &mut Vec<String>) {
    let gain = assessment.fit.estimate("gain").filter(|gain| !gain.fixed);
    if let Some(text) = suspicion(&experiment.recording, gain.map(|gain| gain.value)) {
        warnings.push(format!("{}: {text}", experiment.recording.name));
    }
}

/// Mean sample interval of the first recording, s.
fn mean_interval_s(assessment: &Assessment) -> f64 {
    let time_s = assessment
        .experiments
        .first()
        .map(|e| e.recording.time_s.as_slice());
    match time_s {
        Some([first, .., last]) => (last - first) / (time_s.map_or(1, <[f64]>::len) - 1) as f64,
        _ => f64::NAN,
    }
}

/// The name of an estimate, with its experiment where it has one.
fn label(assessment: &Assessment, estimate: &Estimate) -> String {
    let experiments = &assessment.fit.experiments;
    match estimate.experiment.and_then(|index| experiments.get(index)) {
        Some(experiment) => format!("{} of {}", estimate.name, experiment.name),
        None => estimate.name.to_owned(),
    }
}

fn parameter(assessment: &Assessment, estimate: &Estimate) -> Option<String> {
    let name = label(assessment, estimate);
    let bound = |value| with_unit(value, estimate.unit);
    let limit = match estimate.at_bound {
        Some(Bound::Low) => Some(("lower", bound(estimate.bounds.0))),
        Some(Bound::High) => Some(("upper", bound(estimate.bounds.1))),
        None => None,
    };
    match limit {
        Some((which, bound)) if estimate.identifiable => Some(format!(
            "{name} is at its {which} bound of {bound}{}",
            profile(estimate)
        )),
        Some((which, bound)) => Some(format!(
            "{name} reaches its {which} bound of {bound}: it is not identifiable from \
             these experiments{}",
            profile(estimate)
        )),
        None if !estimate.identifiable => Some(format!(
            "{name} is not identifiable from these experiments: they do not determine it, or only \
             together with others"
        )),
        None => None,
    }
}

/// The interval of an estimate at its bound.
fn profile(estimate: &Estimate) -> String {
    if estimate.profile.is_nan() {
        return String::new();
    }
    format!(
        "; by the profile likelihood its {:.0} % interval extends to {}",
        100.0 * COVERED,
        with_unit(estimate.profile, estimate.unit)
    )
}

/// A value with five significant digits, and its unit.
fn with_unit(value: f64, unit: &str) -> String {
    let rounded = format!("{value:.4e}").parse().unwrap_or(value);
    match unit {
        "" | "1" => Shown(rounded).to_string(),
        unit => format!("{} {unit}", Shown(rounded)),
    }
}

/// What is known of the estimates that are not identifiable alone.
fn combinations(assessment: &Assessment, warnings: &mut Vec<String>) {
    let fit = &assessment.fit;
    let one = |known: &Combination| {
        let error = known.standard_error.max(known.standard_error_coloured);
        format!(
            "{} = {:.4e} +- {error:.1e}",
            fit.described(known),
            known.value
        )
    };
    if !fit.combinations.is_empty() {
        let known: Vec<String> = fit.combinations.iter().map(one).collect();
        warnings.push(format!(
            "these experiments determine only combinations of some parameters, near this optimum: {}; \
             a value of one of them, by the option `fix`, determines the others",
            known.join(", ")
        ));
    }
}

fn correlated(assessment: &Assessment, warnings: &mut Vec<String>) {
    let fit = &assessment.fit;
    for (i, row) in fit.rows.iter().enumerate() {
        for (j, column) in fit.rows.iter().enumerate().take(i) {
            let correlation = fit.correlation[(i, j)];
            if correlation.abs() > STRONG_CORRELATION {
                let [a, b] = [column, row].map(|k| label(assessment, &fit.estimates[*k]));
                warnings.push(format!(
                    "{a} and {b} are correlated by {correlation:.3}: these experiments hardly \
                     distinguish them"
                ));
            }
        }
    }
}

/// Time at rate and duty limits.
fn limits(experiment: &Assessed, warnings: &mut Vec<String>) {
    let (limited, name) = (&experiment.limited, &experiment.recording.name);
    let Some(longest) = limited.longest() else {
        return;
    };
    let total_s = limited.rate_limited_s();
    warnings.push(format!(
        "{name} is rate limited for {total_s:.3} s of {:.3} s ({:.0} %): up {:.3} s, down {:.3} s, \
         duty {:.3} s; the longest stretch is from {:.3} s to {:.3} s; linear methods identify a \
         slower system from such data",
        limited.duration_s,
        100.0 * total_s / limited.duration_s,
        limited.rate_up_s,
        limited.rate_down_s,
        limited.duty_s,
        longest.from_s,
        longest.to_s,
    ));
}

/// Whether the residuals are rounding errors only, which need no warning.
fn is_exact(experiment: &Assessed) -> bool {
    experiment.quality.is_some_and(|q| q.rms_deg < EXACT_DEG)
}

fn residuals(experiment: &Assessed, is_explained: bool, warnings: &mut Vec<String>) {
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
    let correlations = experiment.correlations.as_ref().filter(|_| is_explained);
    if let Some(found) = correlations.filter(|c| c.is_correlated_with_input()) {
        warnings.push(format!(
            "{name}: the residual is correlated with the command ({:.1} times its 95 % band): the \
             model lacks dynamics",
            found.cross_ratio
        ));
    }
}

/// Coloured residuals, and the factor by which the white standard errors are too small.
fn coloured_residuals(assessment: &Assessment, warnings: &mut Vec<String>) {
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
