//! The results of an identification as JSON.

use nalgebra::DMatrix;
use serde_json::{Map, Value, json};

use super::{
    assessment::{Assessed, Assessment, Limited, NonparametricAnalysis, overall},
    data::Note,
    fit::{Bound, Combination, Estimate, Fit},
    levenberg::Termination,
    loss::Loss,
    model::ActiveLimit,
    statistics::Correlations,
};

/// The text of [`document`], with the ranking of a comparison where there is one.
pub fn text(
    assessments: &[Assessment],
    order: Option<&super::compare::Ranking>,
    nonparametric: &NonparametricAnalysis,
    notes: &[Note],
) -> String {
    let mut document = document(assessments, nonparametric, notes);
    if let Some(order) = order {
        document.insert("ranking".into(), ranking(order, assessments));
    }
    format!("{:#}\n", Value::Object(document))
}

/// The document of an identification: its models, the nonparametric analysis, and the notes about
/// the files. Numbers that are not finite are null.
pub fn document(
    assessments: &[Assessment],
    nonparametric: &NonparametricAnalysis,
    notes: &[Note],
) -> Map<String, Value> {
    let models: Vec<Value> = assessments.iter().map(model).collect();
    let notes: Vec<Value> = notes
        .iter()
        .map(|note| json!({ "file": note.path, "line": note.line, "text": note.text }))
        .collect();
    let entries = [
        ("program", json!("actuator")),
        ("version", json!(env!("CARGO_PKG_VERSION"))),
        ("models", json!(models)),
        ("second_opinion", nonparametric_analysis(nonparametric)),
        ("notes", json!(notes)),
    ];
    entries
        .into_iter()
        .map(|(k, v)| (k.to_owned(), v))
        .collect()
}

/// One model.
fn model(assessment: &Assessment) -> Value {
    let fit = &assessment.fit;
    let names = fit.rows.iter().map(|row| fit.estimates[*row].name);
    let parameters: Vec<Value> = fit
        .estimates
        .iter()
        .map(|e| estimate(assessment, e))
        .collect();
    let assessed = |all: &[Assessed]| all.iter().map(experiment).collect::<Vec<_>>();
    json!({
        "name": assessment.name,
        "model": fit.model,
        "fit_percent": fit.fit_percent,
        "parameters": parameters,
        "quality": overall(&assessment.experiments),
        "noise_deg": fit.noise_deg,
        "misfit": {
            "noise_deg": fit.misfit.noise_deg,
            "ratio": fit.misfit.ratio,
            "worst_ratio": fit.misfit.worst,
        },
        "cost_deg2": fit.cost,
        "loss": match fit.loss {
            Loss::Squares => json!({ "name": "squares" }),
            Loss::Student { scale_deg } => json!({ "name": "student", "scale_deg": scale_deg }),
        },
        "samples": fit.samples,
        "effective_samples": assessment.effective_samples,
        "free_parameters": assessment.unknowns(),
        "aic": assessment.criteria.aic,
        "bic": assessment.criteria.bic,
        "command_is_held": fit.assumptions.is_held,
        "command_may_be_held": fit.is_hold_undetermined,
        "begins_at_rest": fit.assumptions.begins_at_rest,
        "combinations": fit.combinations.iter().map(|c| combination(fit, c)).collect::<Vec<_>>(),
        "correlation": {
            "parameters": names.collect::<Vec<_>>(),
            "matrix": matrix(&fit.correlation),
        },
        "covariance": matrix(&fit.covariance),
        "covariance_coloured": matrix(&fit.covariance_coloured),
        "search": {
            "termination": termination(fit.termination),
            "iterations": fit.iterations,
            "starts": fit.starts.0,
            "starts_that_ended_here": fit.starts.1,
            "no_better_than": fit.no_better_than,
        },
        "experiments": assessed(&assessment.experiments),
        "validation": assessed(&assessment.validation),
        "validation_quality": overall(&assessment.validation),
        "warnings": assessment.warnings,
        "intervals_hold": assessment.doubts.is_empty(),
        "doubts": assessment.doubts,
    })
}

fn termination(termination: Termination) -> &'static str {
    match termination {
        Termination::Converged => "converged",
        Termination::IterationLimit => "iteration limit",
        Termination::Stalled => "stalled",
        Termination::Interrupted => "interrupted",
    }
}

fn estimate(assessment: &Assessment, estimate: &Estimate) -> Value {
    let fit = &assessment.fit;
    let experiment = estimate.experiment.and_then(|i| fit.experiments.get(i));
    json!({
        "name": estimate.name,
        "unit": estimate.unit,
        "estimate": estimate.value,
        "standard_error": estimate.standard_error,
        "standard_error_coloured": estimate.standard_error_coloured,
        "at_bound": estimate.at_bound.is_some(),
        "bound": estimate.at_bound.map(|bound| match bound {
            Bound::Low => "low",
            Bound::High => "high",
        }),
        "profile": estimate.profile,
        "beyond_bound": estimate.beyond,
        "bounds": [estimate.bounds.0, estimate.bounds.1],
        "identifiable": estimate.identifiable,
        "fixed": estimate.fixed,
        "remark": assessment.remark(estimate),
        "experiment": experiment.map(|e| e.name.as_str()),
    })
}

fn combination(fit: &Fit, combination: &Combination) -> Value {
    json!({
        "combination": fit.described(combination),
        "value": combination.value,
        "standard_error": combination.standard_error,
        "standard_error_coloured": combination.standard_error_coloured,
    })
}

fn matrix(matrix: &DMatrix<f64>) -> Vec<Vec<f64>> {
    let rows = matrix.row_iter();
    rows.map(|row| row.iter().copied().collect()).collect()
}

fn experiment(assessed: &Assessed) -> Value {
    let time_s = |i: &usize| assessed.recording.time_s[*i];
    json!({
        "name": assessed.recording.name,
        "outliers_s": assessed.fit.outliers.iter().map(time_s).collect::<Vec<_>>(),
        "samples": assessed.recording.len(),
        "quality": assessed.quality,
        "limited": limited(&assessed.limited),
        "residuals": assessed.correlations.as_ref().map(correlations),
    })
}

fn limited(limited: &Limited) -> Value {
    let stretch = |s: &super::assessment::Stretch| {
        let at = match s.state {
            ActiveLimit::RateUp => "rate up",
            ActiveLimit::RateDown => "rate down",
            _ => "duty",
        };
        json!({ "limit": at, "from_s": s.from_s, "to_s": s.to_s })
    };
    json!({
        "duration_s": limited.duration_s,
        "rate_limited_s": limited.rate_limited_s(),
        "rate_up_s": limited.rate_up_s,
        "rate_down_s": limited.rate_down_s,
        "duty_s": limited.duty_s,
        "stop_s": limited.stop_s,
        "stuck_s": limited.stuck_s,
        "stretches": limited.stretches.iter().map(stretch).collect::<Vec<_>>(),
    })
}

fn correlations(c: &Correlations) -> Value {
    json!({
        "is_white": c.whiteness.is_white(),
        "whiteness_statistic": c.whiteness.statistic,
        "whiteness_lags": c.whiteness.lags,
        "whiteness_p_value": c.whiteness.p_value,
        "outside_band": c.whiteness.outside,
        "effective_samples": c.effective_samples,
        "is_correlated_with_command": c.is_correlated_with_input(),
        "largest_cross_ratio": c.cross_ratio,
        "autocorrelation": { "lag_s": c.auto_lag_s, "value": c.auto, "band": c.auto_band },
        "cross_correlation": { "lag_s": c.cross_lag_s, "value": c.cross, "band": c.cross_band },
    })
}

fn nonparametric_analysis(analysis: &NonparametricAnalysis) -> Value {
    let delay = |(name, delay): &(String, Option<super::statistics::delay::DelayEstimate>)| {
        json!({
            "experiment": name,
            "peak_s": delay.map(|d| d.peak_s),
            "onset_s": delay.and_then(|d| d.onset_s),
            "correlation": delay.map(|d| d.correlation),
            "resolution_s": delay.map(|d| d.resolution_s),
        })
    };
    json!({
        "delay": analysis.delays.iter().map(delay).collect::<Vec<_>>(),
        "frequency_response": analysis.response,
        "first_order": analysis.first_order,
        "second_order": analysis.second_order,
    })
}

/// The ranking of a comparison.
pub fn ranking(ranking: &super::compare::Ranking, assessments: &[Assessment]) -> Value {
    let rank = |rank: &super::compare::Rank| {
        json!({
            "name": assessments[rank.index].name,
            "score": rank.score,
            "is_distinguishable_from_best": rank.is_distinguishable,
            "reason": rank.reason,
        })
    };
    json!({
        "criterion": ranking.criterion,
        "ranks": ranking.ranks.iter().map(rank).collect::<Vec<_>>(),
        "enough": assessments[ranking.enough].name,
        "verdict": ranking.verdict,
    })
}
