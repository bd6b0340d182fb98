//! The numbers that are looked for, and how each experiment takes its parameters from them.

use super::problem::{IdentifyError, Problem, Role, Scope};

/// One number that is looked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unknown {
    /// Which parameter of the model.
    pub parameter: usize,
    /// The experiment that it belongs to alone.
    pub experiment: Option<usize>,
    /// Where the search begins.
    pub start: f64,
    /// Its lower bound.
    pub low: f64,
    /// Its upper bound.
    pub high: f64,
    /// Whether the search goes by its logarithm.
    pub is_size: bool,
}

/// All of them, and for each experiment its way from them to the parameters of the model.
#[derive(Debug, Clone)]
pub struct Unknowns {
    /// The numbers.
    pub list: Vec<Unknown>,
    /// One for each experiment.
    pub runs: Vec<Run>,
}

/// The parameters of one experiment.
#[derive(Debug, Clone)]
pub struct Run {
    /// All parameters, of which the fixed ones are used.
    template: Vec<f64>,
    /// The free parameters of the model.
    pub free: Vec<usize>,
    /// The unknown that each of them is.
    pub columns: Vec<usize>,
}

impl Run {
    /// The parameters of the model for these unknowns.
    pub fn values(&self, unknowns: &[f64]) -> Vec<f64> {
        let mut values = self.template.clone();
        for (parameter, column) in self.free.iter().zip(&self.columns) {
            values[*parameter] = unknowns[*column];
        }
        values
    }
}

impl Unknowns {
    /// The unknowns of a problem.
    ///
    /// # Errors
    /// [`IdentifyError::NothingFree`], [`IdentifyError::Start`] for a start value that is none, and
    /// [`IdentifyError::TooFewSamples`].
    pub fn of(problem: &Problem) -> Result<Self, IdentifyError> {
        let mut unknowns = Self {
            list: Vec::new(),
            runs: Vec::new(),
        };
        for experiment in 0..problem.experiments.len() {
            let run = unknowns.run(problem, experiment)?;
            unknowns.runs.push(run);
        }
        let parameters = unknowns.list.len();
        if parameters == 0 {
            return Err(IdentifyError::NothingFree);
        }
        let angles = problem.experiments.iter().map(|e| &e.recording.angle_deg);
        let samples = angles.flatten().filter(|a| !a.is_nan()).count();
        if samples <= parameters {
            return Err(IdentifyError::TooFewSamples {
                parameters,
                samples,
            });
        }
        Ok(unknowns)
    }

    fn run(&mut self, problem: &Problem, experiment: usize) -> Result<Run, IdentifyError> {
        let recording = &problem.experiments[experiment].recording;
        let mut run = Run {
            template: problem.specs.iter().map(|s| s.start).collect(),
            free: Vec::new(),
            columns: Vec::new(),
        };
        for (parameter, spec) in problem.specs.iter().enumerate() {
            let name = spec.parameter.name;
            if let Some(known) = recording.constants.get(name) {
                run.template[parameter] = *known;
                continue;
            }
            if spec.role == Role::Fixed {
                continue;
            }
            let own = (spec.scope == Scope::Own).then_some(experiment);
            let is_it = |u: &Unknown| u.parameter == parameter && u.experiment == own;
            let column = self.list.iter().position(is_it).unwrap_or(self.list.len());
            if column == self.list.len() {
                let mut start = spec.start;
                if own.is_some() && problem.model.parameters()[parameter].is_initial_state {
                    let own = &problem.experiments[experiment..=experiment];
                    start = problem.model.starting_values(own)[parameter];
                }
                // Written so that NaN and infinity fail.
                if !(start >= spec.low && start <= spec.high && start.is_finite()) {
                    return Err(IdentifyError::Start {
                        name,
                        start,
                        low: spec.low,
                        high: spec.high,
                    });
                }
                self.list.push(Unknown {
                    parameter,
                    experiment: own,
                    start,
                    low: spec.low,
                    high: spec.high,
                    is_size: spec.is_size(),
                });
            }
            run.free.push(parameter);
            run.columns.push(column);
        }
        Ok(run)
    }

    /// Where the search begins.
    pub fn start(&self) -> Vec<f64> {
        self.list.iter().map(|u| u.start).collect()
    }
}
