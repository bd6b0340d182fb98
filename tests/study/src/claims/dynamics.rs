//! Claims about the figures.

use super::{Case, Claim, Evaluate, MAIN, Verdict};
use crate::{
    figures::file,
    host::{sample_at, seconds},
    runs::SampleRate::{Hz50, Hz250},
    trace_measures::{
        Ahead, VISIBLE_DEG, ahead, largest_difference, max_standard_deviation_deg, overshoot_deg,
        rms_deg,
    },
};

/// The claims of this module.
pub(super) const CLAIMS: &[Evaluate] = &[
    accurate,
    inflection,
    rate_limited,
    too_large,
    ahead_of_it,
    second_worse,
    grey_rise,
    grey_peak,
    grey_variable,
    enough,
];

fn accurate(case: &Case<'_>) -> Option<Claim> {
    let fitted = case.study.fit(MAIN, Hz250, "pulse", 0)?;
    let spread_deg = max_standard_deviation_deg(&case.pulse.runs_deg);
    let percent = fitted.quality.fit_percent;
    Some(Claim {
        text: "Black box 1 is very accurate for the constant pulse.",
        section: "IV, figure 9",
        verdict: Verdict::contradicted_unless(percent > 90.0),
        evidence: format!(
            "The fit is {percent:.1} % with an error of {:.2} deg rms and {:.1} deg at most; the \
             standard deviation of the five runs is up to {spread_deg:.1} deg.",
            fitted.quality.rms_deg, fitted.quality.largest_deg
        ),
        figure: file(9, MAIN),
    })
}

fn inflection(case: &Case<'_>) -> Option<Claim> {
    let pulse = &case.pulse;
    let (at_s, deg) = largest_difference(&pulse.fitted_deg[0], &pulse.mean_deg, 3.0, 4.0);
    let duty_pct = *pulse.duty_pct.get(sample_at(at_s))?;
    let saturated = duty_pct.abs() > 99.0;
    Some(Claim {
        text: "The inflection at about 3.2 s comes from the custom control algorithm.",
        section: "IV, figure 9",
        verdict: Verdict::contradicted_unless(!saturated),
        evidence: format!(
            "After 3 s the largest difference of the runs and black box 1 is {deg:.1} deg, at \
             {at_s:.2} s. The duty is {duty_pct:.0} % there: {}",
            if saturated {
                "the controller has no effect, and the inflection is the acceleration of the \
                 motor."
            } else {
                "the controller is not saturated."
            }
        ),
        figure: file(9, MAIN),
    })
}

fn rate_limited(case: &Case<'_>) -> Option<Claim> {
    let fitted = case.study.fit(MAIN, Hz250, "pulse", 0)?;
    let runs = fitted.fit.experiments.iter();
    let limited_s = runs.map(|e| e.rate_limited_s).sum::<f64>() / 5.0;
    let saturated = case.pulse.duty_pct.iter().filter(|duty| duty.abs() > 99.0);
    let saturated_s = seconds(saturated.count());
    Some(Claim {
        text: "The actuator is rate-limit driven: nearly linear to the step and away from it.",
        section: "IV",
        verdict: Verdict::contradicted_unless(limited_s > 0.4),
        evidence: format!(
            "Black box 1 is at its limits for {limited_s:.2} s of a pulse, and the board's duty \
             is at 100 % for {saturated_s:.2} s."
        ),
        figure: file(9, MAIN),
    })
}

fn too_large(case: &Case<'_>) -> Option<Claim> {
    let traces = &case.variable_step;
    let steps = crate::trace_measures::steps(&traces.command_deg);
    let missed = steps.iter().filter(|(range, _)| {
        let last = range.end - 1;
        (traces.command_deg[last] - traces.mean_deg[last]).abs() > 5.0
    });
    let missed = missed.count();
    Some(Claim {
        text: "Some of the variable steps are too large to follow.",
        section: "IV, figure 13",
        verdict: Verdict::contradicted_unless(missed > 0),
        evidence: format!(
            "{missed} of {} steps end more than 5 deg from their level. Amplitudes and times are \
             choices of this study: the paper states none.",
            steps.len()
        ),
        figure: file(13, MAIN),
    })
}

/// Lead of a model on the variable step, with the paper's numbers and as fitted.
fn both(case: &Case<'_>, model: usize) -> (Ahead, Ahead) {
    let traces = &case.variable_step;
    let of = |answers: &[Vec<f64>]| ahead(&traces.command_deg, &traces.mean_deg, &answers[model]);
    (of(&traces.printed_deg), of(&traces.fitted_deg))
}

fn in_words((paper, fitted): (Ahead, Ahead)) -> String {
    format!(
        "in {} of {} steps, by up to {:.1} deg (as fitted: {}, {:.1} deg)",
        paper.steps, paper.of, paper.largest_deg, fitted.steps, fitted.largest_deg
    )
}

fn ahead_of_it(case: &Case<'_>) -> Option<Claim> {
    let found = both(case, 0);
    let traces = &case.variable_step;
    let beyond = overshoot_deg(&traces.command_deg, &traces.printed_deg[0]);
    Some(Claim {
        text: "On the variable step black box 1 generally overshoots the actuator.",
        section: "IV, figure 13",
        verdict: Verdict::not_reproduced_unless(2 * found.0.steps > found.0.of),
        evidence: format!(
            "With the paper's numbers it is more than {VISIBLE_DEG} deg ahead of the runs {}. \
             Its overshoot beyond the command is {beyond:.1} deg: a first-order lag cannot \
             overshoot.",
            in_words(found)
        ),
        figure: file(13, MAIN),
    })
}

fn second_worse(case: &Case<'_>) -> Option<Claim> {
    let (first, second) = (both(case, 0), both(case, 1));
    let more = second.0.steps >= first.0.steps && second.0.largest_deg > first.0.largest_deg;
    Some(Claim {
        text: "Black box 2 overshoots the actuator more often and higher than black box 1.",
        section: "IV, figure 13",
        verdict: Verdict::contradicted_unless(more),
        evidence: format!(
            "Black box 1 is ahead {}; black box 2 {}.",
            in_words(first),
            in_words(second)
        ),
        figure: file(13, MAIN),
    })
}

fn grey_rise(case: &Case<'_>) -> Option<Claim> {
    let pulse = &case.pulse;
    let error = |answers: &[Vec<f64>]| rms_deg(&answers[2], &pulse.mean_deg, 1.0, 1.6);
    let (paper, fitted) = (error(&pulse.printed_deg), error(&pulse.fitted_deg));
    Some(Claim {
        text: "The grey box follows the rise of the pulse.",
        section: "IV, figure 12",
        verdict: Verdict::not_reproduced_unless(paper < 9.0),
        evidence: format!(
            "From 1 to 1.6 s the error is {paper:.1} deg rms of 90 deg with the paper's numbers \
             as printed, and {fitted:.2} deg as fitted."
        ),
        figure: file(12, MAIN),
    })
}

fn grey_peak(case: &Case<'_>) -> Option<Claim> {
    let pulse = &case.pulse;
    let beyond = |trace: &[f64]| overshoot_deg(&pulse.command_deg, trace);
    let (paper, fitted) = (beyond(&pulse.printed_deg[2]), beyond(&pulse.fitted_deg[2]));
    let runs = beyond(&pulse.mean_deg);
    Some(Claim {
        text: "The grey box oscillates at the peak and overshoots on its way back to zero.",
        section: "IV, figure 12",
        verdict: Verdict::not_reproduced_unless(paper > 5.0 * runs.max(0.2)),
        evidence: format!(
            "With the numbers as printed and an assumed anti-windup gain the overshoot is \
             {paper:.1} deg; that of the runs is {runs:.1} deg. With the controller of the board \
             and a fitted motor it is {fitted:.1} deg: the numbers cause the overshoot, not the \
             structure."
        ),
        figure: file(12, MAIN),
    })
}

fn grey_variable(case: &Case<'_>) -> Option<Claim> {
    let traces = &case.variable_step;
    let end_s = seconds(traces.mean_deg.len());
    let error =
        |answers: &[Vec<f64>], model: usize| rms_deg(&answers[model], &traces.mean_deg, 0.0, end_s);
    let paper: Vec<f64> = (0..3)
        .map(|model| error(&traces.printed_deg, model))
        .collect();
    let fitted: Vec<f64> = (0..3)
        .map(|model| error(&traces.fitted_deg, model))
        .collect();
    let worst = paper[2] > paper[0] && paper[2] > paper[1];
    Some(Claim {
        text: "On the variable step the grey box is the worst of the three by far.",
        section: "IV, figure 13",
        verdict: Verdict::contradicted_unless(worst && fitted[2] > fitted[0].min(fitted[1])),
        evidence: format!(
            "Black box 1, 2 and grey box: {:.1}, {:.1} and {:.1} deg rms with the paper's \
             numbers; {:.2}, {:.2} and {:.2} deg as fitted: the numbers cause the error, not the \
             structure.",
            paper[0], paper[1], paper[2], fitted[0], fitted[1], fitted[2]
        ),
        figure: file(13, MAIN),
    })
}

fn enough(case: &Case<'_>) -> Option<Claim> {
    let of = |model| {
        let fitted = case.study.fit(MAIN, Hz50, "pulse", model)?;
        let other = fitted
            .predicted
            .get(crate::study::input_index("variable-step"))?;
        Some(other.as_ref()?.fit_percent)
    };
    let (first, second, grey) = (of(0)?, of(1)?, of(2)?);
    Some(Claim {
        text: "Low-cost actuators can be modelled accurately with a variety of techniques.",
        section: "V",
        verdict: Verdict::not_reproduced_unless(first.min(second).min(grey) > 80.0),
        evidence: format!(
            "Fitted to the pulse alone, black box 1, 2 and grey box predict the variable step, \
             which was not used for the fit, to {first:.1}, {second:.1} and {grey:.1} %."
        ),
        figure: file(13, MAIN),
    })
}
