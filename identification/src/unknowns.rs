//! The unknowns of a problem, and how the parameters of each experiment follow from them.

use super::problem::{IdentifyError, Problem, Role, Scope};

/// The fewest samples for each unknown: with fewer, the scatter of the residuals, from which the
/// standard errors follow, is hardly determined.
const SAMPLES_PER_UNKNOWN: usize = 5;

/// One unknown.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unknown {
    /// The index of its parameter in the model.
    pub parameter: usize,
    /// The experiment that has it; `None` where all share it.
    pub experiment: Option<usize>,
    /// Its starting value.
    pub start: f64,
    /// Its lower bound.
    pub low: f64,
    /// Its upper bound.
    pub high: f64,
    /// Whether the search uses its logarithm.
    pub is_log_scaled: bool,
}

/// All unknowns, and the mapping from them to the parameters of each experiment.
#[derive(Debug, Clone)]
pub struct Unknowns {
    /// The unknowns.
    pub list: Vec<Unknown>,
    /// One for each experiment.
    pub runs: Vec<Run>,
}

/// The parameters of one experiment.
#[derive(Debug, Clone)]
pub struct Run {
    /// Values of all parameters, of which those of the fixed ones are used.
    template: Vec<f64>,
    /// The free parameters of the model.
    pub free: Vec<usize>,
    /// The index of the unknown of each free parameter.
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
    /// [`IdentifyError::NothingFree`], [`IdentifyError::Start`] and
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
        let expected = SAMPLES_PER_UNKNOWN * parameters;
        if samples < expected {
            return Err(IdentifyError::TooFewSamples {
                parameters,
                samples,
                expected,
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
                // False for NaN and infinity.
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
                    is_log_scaled: spec.is_log_scaled(),
                });
            }
            run.free.push(parameter);
            run.columns.push(column);
        }
        Ok(run)
    }

    /// Its starting value.
    pub fn start(&self) -> Vec<f64> {
        self.list.iter().map(|u| u.start).collect()
    }
}
