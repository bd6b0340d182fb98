//! Options for the parameters to estimate and for the search.

use std::sync::Arc;

use clap::{
    Args,
    builder::{PossibleValuesParser, TypedValueParser},
};
use indicatif::ProgressBar;

use super::Loaded;
use crate::error::Error;
use crate::{output, parameters::setting};
use host_sim::scenario::Setting;
use identification::{
    Model, Options, Progress,
    assessment::{Assessment, point_to_better},
    loss::LossChoice,
    request::Request,
};

#[derive(Debug, Args)]
pub struct SearchOptions {
    /// Holds a parameter at a value; repeatable
    #[arg(long, value_name = "NAME=VALUE", value_parser = setting)]
    fix: Vec<Setting>,
    /// Estimates a parameter that is held by default, such as position_limit_deg; repeatable
    #[arg(long, value_name = "NAME")]
    free: Vec<String>,
    /// Keeps a parameter within bounds; repeatable
    #[arg(long, value_name = "NAME=LOW:HIGH", value_parser = bound)]
    bound: Vec<Bounded>,
    /// Starts the search for a parameter at a value; repeatable
    #[arg(long, value_name = "NAME=VALUE", value_parser = setting)]
    start: Vec<Setting>,
    /// Gives each recording its own value of a parameter; repeatable
    #[arg(long, value_name = "NAME")]
    own: Vec<String>,
    /// Gives all recordings one value of a parameter; repeatable
    #[arg(long, value_name = "NAME")]
    share: Vec<String>,
    /// How residuals count: squares; robust, by Student's distribution; auto, squares unless
    /// isolated residuals decide the fit
    #[arg(long, value_name = "NAME", default_value = LossChoice::NAMES[0], value_parser = loss_names())]
    loss: LossChoice,
    /// Number of starting points of the search
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = clap::value_parser!(u16).range(1..=1000))]
    starts: u16,
    /// Seed of the starting points
    #[arg(long, default_value_t = 0)]
    seed: u64,
}

/// The values of `--loss`.
pub fn loss_names() -> impl TypedValueParser<Value = LossChoice> {
    PossibleValuesParser::new(LossChoice::NAMES)
        .map(|name| LossChoice::named(&name).unwrap_or_default())
}

/// The value of `--bound`.
#[derive(Debug, Clone)]
struct Bounded {
    name: String,
    low: f64,
    high: f64,
}

fn bound(text: &str) -> Result<Bounded, String> {
    let expected = "expected NAME=LOW:HIGH";
    let (name, ends) = text.split_once('=').ok_or(expected)?;
    let (low, high) = ends.split_once(':').ok_or(expected)?;
    let number = |text: &str| {
        let number: Result<f64, _> = text.trim().parse();
        number.map_err(|_| format!("`{text}` is not a number"))
    };
    Ok(Bounded {
        name: name.trim().to_owned(),
        low: number(low)?,
        high: number(high)?,
    })
}

fn pairs(settings: &[Setting]) -> Vec<(String, f64)> {
    let pair = |s: &Setting| (s.name.clone(), s.value);
    settings.iter().map(pair).collect()
}

impl SearchOptions {
    fn request(&self) -> Request {
        let bound = self.bound.iter();
        Request {
            fix: pairs(&self.fix),
            free: self.free.clone(),
            bound: bound.map(|b| (b.name.clone(), b.low, b.high)).collect(),
            start: pairs(&self.start),
            own: self.own.clone(),
            share: self.share.clone(),
            options: Options {
                starts: self.starts.into(),
                seed: self.seed,
                loss: self.loss,
                ..Options::default()
            },
        }
    }

    /// Checks that the parameters exist in one of these models and the options do not conflict.
    pub fn check(&self, models: &[Arc<dyn Model>]) -> Result<(), Error> {
        Ok(self.request().check(models)?)
    }

    /// Fits these models to the recordings, and predicts those for validation.
    pub fn fit(
        &self,
        models: Vec<Arc<dyn Model>>,
        loaded: &Loaded,
    ) -> Result<Vec<Assessment>, Error> {
        let request = self.request();
        let runs = (&loaded.fitted[..], &loaded.held_out[..]);
        let mut assessments = Vec::new();
        for model in models {
            let bar = output::progress(self.starts.into(), model.name());
            let assessed = request.assess(model, runs, &assessments, &Bar(&bar));
            bar.finish_and_clear();
            assessments.push(assessed?);
        }
        point_to_better(&mut assessments);
        Ok(assessments)
    }
}

/// Shows the progress of the search.
struct Bar<'a>(&'a ProgressBar);

impl Progress for Bar<'_> {
    fn done(&self, done: usize, of: usize, _best_cost: f64) {
        self.0.set_length(of as u64);
        self.0.set_position(done as u64);
    }
}
