//! Ranks fitted models, and selects the simplest of those that are not worse than the best.

use std::cmp::Ordering;

use crate::{
    assessment::{Assessed, Assessment, overall},
    statistics::{
        LossDifference,
        criteria::{bic, evidence},
        loss::Residuals,
    },
};

/// A difference of the BIC below which models are not distinguished.
const SMALL_BIC: f64 = 2.0;

/// The rank of a model, with the reason.
#[derive(Debug, Clone, PartialEq)]
pub struct Rank {
    /// The index of the assessment.
    pub index: usize,
    /// The criterion: the root mean square error on held-out recordings, deg, or the BIC with the
    /// number of independent residuals of the model that fits best, because the residuals of the
    /// others are also coloured by the dynamics that they lack.
    pub score: f64,
    /// Whether the data distinguish it from the best.
    pub is_distinguishable: bool,
    /// The reason for its rank.
    pub reason: String,
}

/// All models from the best to the worst.
#[derive(Debug, Clone, PartialEq)]
pub struct Ranking {
    /// The criterion, in words.
    pub criterion: &'static str,
    /// The models, best first.
    pub ranks: Vec<Rank>,
    /// The index of the sufficient assessment: of those that cannot be distinguished from the best,
    /// the one with the fewest parameters.
    pub enough: usize,
    /// The reason, in words.
    pub verdict: String,
}

impl Ranking {
    /// Ranks models that were fitted to the same recordings, by their predictions of held-out ones
    /// where there are any, otherwise by the BIC.
    pub fn of(assessments: &[Assessment]) -> Self {
        let held_out = assessments.iter().any(|a| !a.validation.is_empty());
        let by_cost = |a: &&Assessment, b: &&Assessment| a.fit.cost.total_cmp(&b.fit.cost);
        let closest = assessments.iter().min_by(by_cost);
        let independent = closest.map_or(1.0, |a| a.effective_samples);
        let score = |a: &Assessment| match held_out {
            true => overall(&a.validation).map_or(f64::INFINITY, |q| q.rms_deg),
            false => {
                let mean_square = 2.0 * a.fit.cost / a.fit.samples as f64;
                bic(independent, mean_square, a.unknowns())
            }
        };
        let mut order: Vec<usize> = (0..assessments.len()).collect();
        let by_score = |a: &usize, b: &usize| -> Ordering {
            score(&assessments[*a]).total_cmp(&score(&assessments[*b]))
        };
        order.sort_by(by_score);
        let Some(best) = order.first().map(|&index| &assessments[index]) else {
            return Self::of_nothing();
        };
        let rank = |&index: &usize| {
            let this = &assessments[index];
            let (is_distinguishable, reason) = match held_out {
                _ if std::ptr::eq(this, best) => (false, String::from("the best")),
                true => by_held_out(best, this),
                false => by_bic(best, this, score(this) - score(best)),
            };
            let score = score(this);
            Rank {
                index,
                score,
                is_distinguishable,
                reason,
            }
        };
        let ranks: Vec<Rank> = order.iter().map(rank).collect();
        let equals = ranks.iter().filter(|rank| !rank.is_distinguishable);
        let fewest = equals.min_by_key(|rank| assessments[rank.index].unknowns());
        let enough = fewest.map_or(order[0], |rank| rank.index);
        Self {
            criterion: match held_out {
                true => "root mean square error on the recordings left out of the fit (deg)",
                false => {
                    "BIC with the samples that are independent in the residuals of the best fit"
                }
            },
            verdict: verdict(assessments, &ranks, enough),
            ranks,
            enough,
        }
    }

    fn of_nothing() -> Self {
        Self {
            criterion: "",
            ranks: Vec::new(),
            enough: 0,
            verdict: "nothing was compared".into(),
        }
    }
}

/// By the residuals on held-out recordings: the test of Diebold and Mariano.
fn by_held_out(best: &Assessment, other: &Assessment) -> (bool, String) {
    let pairs = other.validation.iter().zip(&best.validation);
    let residuals = pairs.map(|(other, best): (&Assessed, &Assessed)| Residuals {
        time_s: &best.recording.time_s,
        first_deg: &other.fit.residual_deg,
        second_deg: &best.fit.residual_deg,
    });
    let Some(difference) = LossDifference::of(residuals) else {
        return (false, "not distinguishable: nothing was compared".into());
    };
    let errors = [other, best].map(|a| overall(&a.validation).map_or(f64::NAN, |q| q.rms_deg));
    let error = relative(errors[0] / errors[1]);
    let z = difference.z();
    match difference.is_by_chance() {
        true => (
            false,
            format!(
                "not distinguishable from the best: {error} on held-out data, within chance (z = {z:.1})"
            ),
        ),
        false => (
            true,
            format!("{error} on held-out data, beyond chance (z = {z:.1})"),
        ),
    }
}

/// A ratio of errors, in words.
fn relative(ratio: f64) -> String {
    match 100.0 * (ratio - 1.0) {
        more if more > 200.0 => format!("{ratio:.0} times the error"),
        more if more >= 0.0 => format!("{more:.1} % more error"),
        more => format!("{:.1} % less error", -more),
    }
}

fn by_bic(best: &Assessment, other: &Assessment, difference: f64) -> (bool, String) {
    let parameters = other.unknowns() as i64 - best.unknowns() as i64;
    let errors = [other, best].map(|a| a.fit.cost.sqrt());
    let error = relative(errors[0] / errors[1]);
    let costs = match parameters {
        0 => "with as many parameters".to_owned(),
        1 => "with one parameter more".to_owned(),
        -1 => "with one parameter less".to_owned(),
        n if n > 0 => format!("with {n} parameters more"),
        n => format!("with {} parameters less", -n),
    };
    if difference.is_nan() || difference < SMALL_BIC {
        let text = format!(
            "not distinguishable from the best: {error} {costs}, a BIC greater by {difference:.1}"
        );
        return (false, text);
    }
    let text = format!(
        "{error} {costs}: a BIC greater by {difference:.1}, {} evidence against it",
        evidence(difference)
    );
    (true, text)
}

fn verdict(assessments: &[Assessment], ranks: &[Rank], enough: usize) -> String {
    let (name, unknowns) = (&assessments[enough].name, assessments[enough].unknowns());
    let best = &assessments[ranks[0].index].name;
    let equals = ranks.iter().filter(|rank| !rank.is_distinguishable).count();
    match equals {
        _ if ranks.len() == 1 => format!("{name} is the only model"),
        0 | 1 => {
            let next = &ranks[1];
            let other = &assessments[next.index].name;
            format!(
                "{name} is enough: the data distinguish it from all others, of which {other} comes next ({})",
                next.reason
            )
        }
        _ if name == best => format!(
            "{name} is enough: it is the best and, of the {equals} that the data do not distinguish, \
             the simplest with {unknowns} free parameters"
        ),
        _ => format!(
            "{name} is enough: the data do not distinguish it from {best}, and of the {equals} such models \
             it is the simplest with {unknowns} free parameters"
        ),
    }
}
