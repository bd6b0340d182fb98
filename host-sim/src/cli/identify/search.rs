//! Options that say what is looked for and how.

use std::sync::Arc;

use clap::Args;
use indicatif::ProgressBar;

use super::Loaded;
use crate::{
    cli::{output, parameters::setting},
    error::Error,
    identify::{
        Experiment, IdentifyError, Model, Options, Problem, Progress, Scope,
        assessment::Assessment, engine::fit,
    },
    scenario::Setting,
};

#[derive(Debug, Args)]
pub struct SearchOptions {
    /// Holds a parameter at a value; as often as needed
    #[arg(long, value_name = "NAME=VALUE", value_parser = setting)]
    fix: Vec<Setting>,
    /// Looks for a parameter that is held as a rule, such as position_limit_deg; as often as needed
    #[arg(long, value_name = "NAME")]
    free: Vec<String>,
    /// Keeps a parameter within bounds; as often as needed
    #[arg(long, value_name = "NAME=LOW:HIGH", value_parser = bound)]
    bound: Vec<Bounded>,
    /// Begins the search for a parameter at a value; as often as needed
    #[arg(long, value_name = "NAME=VALUE", value_parser = setting)]
    start: Vec<Setting>,
    /// Gives each recording its own value of a parameter; as often as needed
    #[arg(long, value_name = "NAME")]
    own: Vec<String>,
    /// Gives all recordings one value of a parameter; as often as needed
    #[arg(long, value_name = "NAME")]
    share: Vec<String>,
    /// How many starts to search from
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = clap::value_parser!(u16).range(1..=1000))]
    starts: u16,
    /// Seed of the starts
    #[arg(long, default_value_t = 0)]
    seed: u64,
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

impl SearchOptions {
    /// How to search.
    pub fn options(&self) -> Options {
        Options {
            starts: self.starts.into(),
            seed: self.seed,
            ..Options::default()
        }
    }

    /// Fits these models to the recordings, and predicts those that were left out.
    pub fn fit(
        &self,
        models: Vec<Arc<dyn Model>>,
        loaded: &Loaded,
    ) -> Result<Vec<Assessment>, Error> {
        self.check(&models)?;
        let one = |model: Arc<dyn Model>| {
            let bar = output::progress(self.starts.into(), model.name());
            let problem = self.problem(model, &loaded.fitted)?;
            let fitted = fit(&problem, &self.options(), &Bar(&bar))?;
            bar.finish_and_clear();
            let name = fitted.model;
            Assessment::of(name, &problem, fitted, &loaded.held_out)
        };
        let fitted: Result<Vec<_>, IdentifyError> = models.into_iter().map(one).collect();
        Ok(fitted?)
    }

    /// A parameter that is named must be one of a model at least; of several models it applies to
    /// those that have it.
    fn check(&self, models: &[Arc<dyn Model>]) -> Result<(), Error> {
        let parameters = || models.iter().flat_map(|m| m.parameters());
        let fixed = self.fix.iter().chain(&self.start).map(|s| &s.name);
        let named = fixed
            .chain(self.bound.iter().map(|b| &b.name))
            .chain(self.free.iter().chain(&self.own).chain(&self.share));
        for name in named {
            if !parameters().any(|p| p.is_called(name)) {
                let mut known: Vec<&str> = parameters().map(|p| p.name).collect();
                known.sort_unstable();
                known.dedup();
                let expected = known.join(", ");
                return Err(Error::unknown("parameter", name, known, expected));
            }
        }
        Ok(())
    }

    fn problem(
        &self,
        model: Arc<dyn Model>,
        experiments: &[Experiment],
    ) -> Result<Problem, IdentifyError> {
        let parameters = model.parameters().to_vec();
        let has = |name: &str| parameters.iter().any(|p| p.is_called(name));
        let mut problem = Problem::try_new(model, experiments.to_vec())?;
        for b in self.bound.iter().filter(|b| has(&b.name)) {
            problem.bound(&b.name, b.low, b.high)?;
        }
        for name in self.free.iter().filter(|name| has(name)) {
            problem.free(name)?;
        }
        for s in self.start.iter().filter(|s| has(&s.name)) {
            problem.start(&s.name, s.value)?;
        }
        for s in self.fix.iter().filter(|s| has(&s.name)) {
            problem.fix(&s.name, s.value)?;
        }
        for (names, scope) in [(&self.own, Scope::Own), (&self.share, Scope::Shared)] {
            for name in names.iter().filter(|name| has(name)) {
                problem.scope(name, scope)?;
            }
        }
        Ok(problem)
    }
}

/// A bar that the search moves.
struct Bar<'a>(&'a ProgressBar);

impl Progress for Bar<'_> {
    fn done(&self, done: usize, of: usize, _best_cost: f64) {
        self.0.set_length(of as u64);
        self.0.set_position(done as u64);
    }
}
