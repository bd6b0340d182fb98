//! The claims of the paper, compared with the runs.

mod dynamics;
mod identified;

use crate::{Failure, study::Study, trace_measures::Traces};

/// Result of the comparison of a claim.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// The results confirm it.
    Reproduced,
    /// The results neither confirm nor contradict it.
    NotReproduced,
    /// The results contradict it, or it is inconsistent.
    Contradicted,
}

impl Verdict {
    /// Verdict of a test whose failure contradicts the claim.
    pub fn contradicted_unless(holds: bool) -> Self {
        if holds {
            Self::Reproduced
        } else {
            Self::Contradicted
        }
    }

    /// Verdict of a test whose failure does not contradict the claim.
    pub fn not_reproduced_unless(holds: bool) -> Self {
        if holds {
            Self::Reproduced
        } else {
            Self::NotReproduced
        }
    }

    /// Name in the table.
    pub fn name(self) -> &'static str {
        match self {
            Self::Reproduced => "reproduced",
            Self::NotReproduced => "not reproduced",
            Self::Contradicted => "contradicted",
        }
    }
}

/// A claim with its verdict.
#[derive(Debug, Clone, PartialEq)]
pub struct Claim {
    /// The paper's statement.
    pub text: &'static str,
    /// Section of the paper.
    pub section: &'static str,
    /// Result of the comparison.
    pub verdict: Verdict,
    /// The numbers of the comparison.
    pub evidence: String,
    /// File of the figure that shows it; empty without a figure.
    pub figure: String,
}

/// Indices of the conditions in [`crate::runs::CONDITIONS`].
pub(crate) const PRINTED: usize = 0;
pub(crate) const MAIN: usize = 1;
pub(crate) const LOADED: usize = 2;

/// Data for the evaluation of the claims.
pub(crate) struct Case<'a> {
    pub study: &'a Study,
    pub pulse: Traces,
    pub variable_step: Traces,
}

/// All claims.
///
/// # Errors
/// Those of the simulator, and [`Failure::Incomplete`] of a study that lacks a run.
pub fn all(study: &Study) -> Result<Vec<Claim>, Failure> {
    let traces = |input| Traces::of(study, MAIN, input)?.ok_or(Failure::Incomplete);
    let case = Case {
        study,
        pulse: traces("pulse")?,
        variable_step: traces("variable-step")?,
    };
    let judged = identified::CLAIMS.iter().chain(dynamics::CLAIMS);
    judged
        .map(|judge| judge(&case).ok_or(Failure::Incomplete))
        .collect()
}

/// Evaluates a claim; `None` if the study lacks the runs for it.
type Evaluate = fn(&Case<'_>) -> Option<Claim>;
