//! How far the estimates of a parameter from different inputs to the same actuator are apart: by
//! their value, and in the standard errors of their difference.

use host_sim::table::{Cell, Table};
use identification::Estimate;

use crate::{
    claims::MAIN,
    models::MODELS,
    runs::SampleRate,
    study::{FitKey, Study},
};

/// Standard errors within which 95 % of the pairs agree if the errors hold, and those beyond which
/// one of the two is wrong.
const AGREES: f64 = 2.0;
const WRONG: f64 = 5.0;

/// A row for each parameter of each model, and one for all pairs.
pub fn table(study: &Study) -> Table {
    let columns = [
        "parameter",
        "least",
        "greatest",
        "pairs",
        "within 2 (%)",
        "beyond 5 (%)",
    ];
    let columns: Vec<_> = [&["model"][..], &columns].concat();
    let columns: Vec<_> = columns.iter().map(|name| (*name, "")).collect();
    let mut table = Table::new("", &columns);
    let mut all = Vec::new();
    for (model, model_name) in MODELS.iter().enumerate() {
        for name in parameters(study, model) {
            let found = estimates(study, model, name);
            let main = found
                .iter()
                .filter(|(key, _)| (key.0, key.1) == (MAIN, SampleRate::Hz250));
            let values = || main.clone().map(|(_, estimate)| estimate.value);
            let apart = apart(&found);
            let labels = [
                (*model_name).into(),
                format!("{name} ({})", found[0].1.unit).into(),
                Cell::significant(values().fold(f64::INFINITY, f64::min)),
                Cell::significant(values().fold(f64::NEG_INFINITY, f64::max)),
            ];
            table.push(labels.into_iter().chain(shares(&apart)));
            all.extend(apart);
        }
    }
    if !all.is_empty() {
        let labels = ["all".into(), Cell::None, Cell::None, Cell::None];
        table.push(labels.into_iter().chain(shares(&all)));
    }
    table
}

/// The number of pairs, and the shares that agree and that cannot both hold.
fn shares(apart: &[f64]) -> [Cell; 3] {
    let share = |is_it: &dyn Fn(&&f64) -> bool| {
        let count = apart.iter().filter(is_it).count();
        Cell::Number(100.0 * count as f64 / apart.len() as f64, 0)
    };
    let count = Cell::Number(apart.len() as f64, 0);
    [count, share(&|z| **z <= AGREES), share(&|z| **z > WRONG)]
}

/// The names of the estimated parameters of a model that belong to the actuator and not to a run.
fn parameters(study: &Study, model: usize) -> Vec<&'static str> {
    let mut fits = study.fits.iter().filter(|(key, _)| key.3 == model);
    let estimates = fits.next().map(|(_, fitted)| fitted.fit.estimates.iter());
    let own = estimates
        .into_iter()
        .flatten()
        .filter(|e| !e.fixed && e.experiment.is_none());
    own.map(|e| e.name).collect()
}

/// The estimates of a parameter.
fn estimates<'a>(study: &'a Study, model: usize, name: &str) -> Vec<(&'a FitKey, &'a Estimate)> {
    let fits = study.fits.iter().filter(|(key, _)| key.3 == model);
    fits.filter_map(|(key, fitted)| Some((key, fitted.fit.estimate(name)?)))
        .collect()
}

/// The distances, in standard errors, of the pairs from two inputs to one actuator that both have
/// standard errors.
fn apart(found: &[(&FitKey, &Estimate)]) -> Vec<f64> {
    let known: Vec<_> = found.iter().filter(|(_, e)| error(e) > 0.0).collect();
    let mut apart = Vec::new();
    for (index, (key, a)) in known.iter().enumerate() {
        let others = known[index + 1..]
            .iter()
            .filter(|(of, _)| (of.0, of.1) == (key.0, key.1));
        apart.extend(others.map(|(_, b)| (a.value - b.value).abs() / error(a).hypot(error(b))));
    }
    apart
}

fn error(estimate: &Estimate) -> f64 {
    estimate
        .standard_error
        .max(estimate.standard_error_coloured)
}
