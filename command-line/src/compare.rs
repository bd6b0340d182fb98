//! `actuator compare`.

use clap::Args;

use crate::error::Error;

use super::{
    identify::{DataOptions, Found, Outputs, converged, loss_names, model_names},
    output,
};
use identification::{
    Options,
    assessment::NonparametricAnalysis,
    compare::{Candidate, Comparison},
    loss::LossChoice,
    models,
};

/// Fits all models to recordings and selects the simplest that is adequate
///
/// Each model is fitted complete, without delay, without rate limits and without both. They are
/// ranked by their predictions of the recordings of --validate, or with --leave-one-out of each
/// recording by the fit to the others; without these by the BIC with the number of independent
/// samples. Models that the data do not distinguish from the best are marked;
/// the one of them with the fewest parameters is selected.
#[derive(Debug, Args)]
pub struct Compare {
    #[command(flatten)]
    data: DataOptions,
    /// Model to compare; repeatable [default: the paper's models, and the motors too if the
    /// recordings are of a pendulum]
    #[arg(long, value_name = "NAME", value_parser = model_names())]
    model: Vec<String>,
    /// Ranks the models by cross-validation: each recording is predicted by the fit to all others;
    /// estimates are those of the fit to all
    #[arg(long, conflicts_with = "validate")]
    leave_one_out: bool,
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
    #[command(flatten)]
    outputs: Outputs,
}

impl Compare {
    pub(super) fn run(self) -> Result<(), Error> {
        self.outputs.check(None, &self.data)?;
        let known = if self.model.is_empty() && !self.data.are_of_a_pendulum()? {
            models::of_the_paper()
        } else {
            models::all()
        };
        let is_asked = |name: &str| self.model.is_empty() || self.model.iter().any(|m| m == name);
        let chosen: Vec<_> = known.into_iter().filter(|m| is_asked(m.name())).collect();
        self.data.check(&chosen)?;
        if self.leave_one_out && self.data.data.len() < 2 {
            let problem = "--leave-one-out with one recording, expected at least two";
            return Err(Error::Conflict(problem.into()));
        }
        let loaded = self.data.load(&chosen)?;
        let candidates: Vec<Candidate> = chosen.iter().flat_map(Candidate::forms).collect();
        let options = Options {
            starts: self.starts.into(),
            seed: self.seed,
            loss: self.loss,
            ..Options::default()
        };
        let fitted = &loaded.fitted;
        let fits = match self.leave_one_out {
            true => Comparison::leave_one_out_fits(candidates.len(), fitted.len()),
            false => candidates.len(),
        };
        let bar = output::progress(fits as u64, "fits");
        let progress = |done| bar.set_position(done as u64);
        let comparison = match self.leave_one_out {
            true => Comparison::leave_one_out(&candidates, fitted, &options, &progress),
            false => Comparison::of(&candidates, fitted, &loaded.held_out, &options, &progress),
        };
        bar.finish_and_clear();
        let comparison = comparison?;
        for (name, error) in &comparison.refused {
            note!("warning: {name} was not compared: {error}");
        }
        let nonparametric = NonparametricAnalysis::of(&loaded.fitted);
        let found = Found {
            assessments: &comparison.assessments,
            ranking: Some(&comparison.ranking),
            nonparametric: &nonparametric,
            loaded: &loaded,
        };
        self.outputs.write(&found)?;
        converged(&comparison.assessments)
    }
}
