//! The tables of an identification, for the page and for the terminal.

use crate::table::{Cell, Table};
use identification::{
    assessment::{Assessed, Assessment, NonparametricAnalysis, overall},
    compare::Ranking,
    frequency::Shape,
};

/// All parameters of a model.
pub fn parameters(assessment: &Assessment) -> Table {
    let columns = [
        ("parameter", ""),
        ("unit", ""),
        ("estimate", ""),
        ("standard error", ""),
        ("coloured", ""),
        ("share", "%"),
        ("remark", ""),
    ];
    let fit = &assessment.fit;
    let caption = format!(
        "{}: fit {:.2} %, noise {:.4} deg",
        assessment.name, fit.fit_percent, fit.noise_deg
    );
    let mut table = Table::new(caption, &columns);
    for e in &fit.estimates {
        let experiment = e.experiment.and_then(|i| fit.experiments.get(i));
        let name = match experiment {
            Some(experiment) => format!("{} ({})", e.name, experiment.name),
            None => e.name.to_owned(),
        };
        // An angle may be zero: a relative error has no meaning.
        let size = if e.unit == "deg" {
            f64::NAN
        } else {
            e.value.abs()
        };
        let share = 100.0 * e.standard_error.max(e.standard_error_coloured) / size;
        table.push([
            name.into(),
            e.unit.into(),
            Cell::significant(e.value),
            Cell::significant(e.standard_error),
            Cell::significant(e.standard_error_coloured),
            Cell::Number(share, 2),
            assessment.remark(e).into(),
        ]);
    }
    table
}

/// The correlation of the estimates. The columns have the numbers of the rows: names would make
/// them wider than a page.
pub fn correlation(assessment: &Assessment) -> Table {
    let fit = &assessment.fit;
    let numbers: Vec<String> = (1..=fit.rows.len()).map(|n| n.to_string()).collect();
    let columns = ["", ""]
        .into_iter()
        .chain(numbers.iter().map(String::as_str));
    let caption = format!("{}: correlation of the estimates", assessment.name);
    let mut table = Table::new(caption, &columns.map(|name| (name, "")).collect::<Vec<_>>());
    for (i, (number, row)) in numbers.iter().zip(&fit.rows).enumerate() {
        let names = [number.as_str(), fit.estimates[*row].name].map(Cell::from);
        let values = (0..fit.rows.len()).map(|j| Cell::Number(fit.correlation[(i, j)], 3));
        table.push(names.into_iter().chain(values));
    }
    table
}

/// The columns of [`quality`]. The last three require validation recordings.
const QUALITY: [(&str, &str); 11] = [
    ("model", ""),
    ("free parameters", ""),
    ("fit", "%"),
    ("VAF", "%"),
    ("rms error", "deg"),
    ("Theil", ""),
    ("AIC", ""),
    ("BIC", ""),
    ("held-out fit", "%"),
    ("held-out rms", "deg"),
    ("held-out mean absolute", "deg"),
];

/// The quality of the models over all recordings.
pub fn quality(assessments: &[Assessment]) -> Table {
    let is_validated = assessments.iter().any(|a| !a.validation.is_empty());
    let width = if is_validated { 11 } else { 8 };
    let caption = "Figures of merit over all recordings. A Theil inequality coefficient below 0.25 \
        is good. AIC and BIC assume white residuals; only their differences are meaningful.";
    let mut table = Table::new(caption, &QUALITY[..width]);
    for a in assessments {
        let (fitted, held_out) = (overall(&a.experiments), overall(&a.validation));
        let row = [
            a.name.as_str().into(),
            Cell::Number(a.unknowns() as f64, 0),
            Cell::Number(a.fit.fit_percent, 2),
            Cell::optional(fitted.map(|q| q.vaf_percent), 2),
            Cell::optional(fitted.map(|q| q.rms_deg), 4),
            Cell::optional(fitted.map(|q| q.theil.inequality), 4),
            Cell::Number(a.criteria.aic, 1),
            Cell::Number(a.criteria.bic, 1),
            Cell::optional(held_out.map(|q| q.fit_percent), 2),
            Cell::optional(held_out.map(|q| q.rms_deg), 4),
            Cell::optional(held_out.map(|q| q.mean_absolute_deg), 4),
        ];
        table.push(row.into_iter().take(width));
    }
    table
}

/// The quality of each model for each recording.
pub fn runs(assessments: &[Assessment], of: fn(&Assessment) -> &[Assessed]) -> Table {
    let columns = [
        ("model", ""),
        ("recording", ""),
        ("samples", ""),
        ("fit", "%"),
        ("rms error", "deg"),
        ("Theil", ""),
        ("bias", "%"),
        ("variance", "%"),
        ("covariance", "%"),
        ("rate limited", "s"),
        ("white", ""),
    ];
    let caption = "Each recording. Bias, variance and covariance are Theil's components of the mean \
        square error.";
    let mut table = Table::new(caption, &columns);
    for assessment in assessments {
        for run in of(assessment) {
            let quality = run.quality.as_ref();
            let percent = |part: Option<f64>| Cell::optional(part.map(|p| 100.0 * p), 1);
            let white = run.correlations.as_ref().map(|c| c.whiteness.is_white());
            table.push([
                assessment.name.as_str().into(),
                run.recording.name.as_str().into(),
                Cell::Number(quality.map_or(0.0, |q| q.samples as f64), 0),
                Cell::Number(run.fit.fit_percent, 2),
                Cell::optional(quality.map(|q| q.rms_deg), 4),
                Cell::optional(quality.map(|q| q.theil.inequality), 4),
                percent(quality.map(|q| q.theil.bias)),
                percent(quality.map(|q| q.theil.variance)),
                percent(quality.map(|q| q.theil.covariance)),
                Cell::Number(run.limited.rate_limited_s(), 3),
                white.map_or(Cell::None, |w| if w { "yes" } else { "no" }.into()),
            ]);
        }
    }
    table
}

/// The error of each model on each held-out recording.
pub fn held_out(assessments: &[Assessment]) -> Table {
    let recordings = assessments.first().map_or(&[][..], |a| &a.validation);
    let names = recordings
        .iter()
        .map(|run| (run.recording.name.as_str(), "deg"));
    let columns: Vec<_> = std::iter::once(("model", "")).chain(names).collect();
    let caption = "Root mean square error on each held-out recording.";
    let mut table = Table::new(caption, &columns);
    for assessment in assessments {
        let error = |run: &Assessed| Cell::optional(run.quality.map(|q| q.rms_deg), 4);
        let errors = assessment.validation.iter().map(error);
        table.push(std::iter::once(assessment.name.as_str().into()).chain(errors));
    }
    table
}

/// The models from the best to the worst.
pub fn ranking(ranking: &Ranking, assessments: &[Assessment]) -> Table {
    let columns = [
        ("rank", ""),
        ("model", ""),
        ("free parameters", ""),
        ("score", ""),
        ("why", ""),
    ];
    let mut table = Table::new(format!("By {}", ranking.criterion), &columns);
    for (place, rank) in (1..).zip(&ranking.ranks) {
        let assessment = &assessments[rank.index];
        table.push([
            Cell::Number(f64::from(place), 0),
            assessment.name.as_str().into(),
            Cell::Number(assessment.unknowns() as f64, 0),
            Cell::significant(rank.score),
            rank.reason.as_str().into(),
        ]);
    }
    table
}

/// The equivalent systems in the frequency domain.
pub fn equivalents(opinion: &NonparametricAnalysis) -> Table {
    let columns = [
        ("system", ""),
        ("pole or frequency", "rad/s"),
        ("damping", ""),
        ("gain", ""),
        ("delay", "ms"),
        ("cost", ""),
        ("from", "Hz"),
        ("to", "Hz"),
    ];
    let caption = "Low-order equivalent systems. A cost of up to 100 is acceptable; up to 50 the \
        system is nearly indistinguishable from the data.";
    let mut table = Table::new(caption, &columns);
    let systems = [opinion.first_order, opinion.second_order]
        .into_iter()
        .flatten();
    for system in systems {
        let (name, pole, damping) = match system.shape {
            Shape::First { pole_rad_s } => ("first order", pole_rad_s, Cell::None),
            Shape::Second {
                natural_frequency_rad_s,
                damping,
            } => (
                "second order",
                natural_frequency_rad_s,
                Cell::Number(damping, 3),
            ),
        };
        table.push([
            name.into(),
            Cell::Number(pole, 2),
            damping,
            Cell::Number(system.gain, 4),
            Cell::Number(1e3 * system.delay_s, 2),
            Cell::Number(system.cost, 1),
            Cell::Number(system.from_hz, 2),
            Cell::Number(system.to_hz, 2),
        ]);
    }
    table
}

/// The delays from cross-correlation.
pub fn delays(opinion: &NonparametricAnalysis) -> Table {
    let columns = [
        ("recording", ""),
        ("first response", "ms"),
        ("peak", "ms"),
        ("correlation", ""),
        ("resolution", "ms"),
    ];
    let caption = "Delay from the cross-correlation of the changes of command and angle. The peak \
        includes the lag of the actuator: the transport delay is smaller.";
    let mut table = Table::new(caption, &columns);
    for (name, delay) in &opinion.delays {
        let ms = |value: Option<f64>| Cell::optional(value.map(|s| 1e3 * s), 2);
        table.push([
            name.as_str().into(),
            ms(delay.and_then(|d| d.onset_s)),
            ms(delay.map(|d| d.peak_s)),
            Cell::optional(delay.map(|d| d.correlation), 3),
            ms(delay.map(|d| d.resolution_s)),
        ]);
    }
    table
}
