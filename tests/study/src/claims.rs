//! Each claim of the paper, held against the runs.

mod dynamics;
mod identified;

use crate::{Failure, measures::Traces, study::Study};

/// What became of a claim.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// It holds here too.
    Reproduced,
    /// It does not show here, which says nothing against it.
    NotReproduced,
    /// Here the opposite holds, or it contradicts itself.
    Contradicted,
}

impl Verdict {
    /// The verdict of a test: what fails it is contradicted.
    pub fn contradicted_unless(holds: bool) -> Self {
        if holds {
            Self::Reproduced
        } else {
            Self::Contradicted
        }
    }

    /// The same where failing says nothing against the claim.
    pub fn not_reproduced_unless(holds: bool) -> Self {
        if holds {
            Self::Reproduced
        } else {
            Self::NotReproduced
        }
    }

    /// In words.
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
    /// What the paper says.
    pub text: &'static str,
    /// Where it says so.
    pub section: &'static str,
    /// What became of it.
    pub verdict: Verdict,
    /// The numbers that show it.
    pub evidence: String,
    /// The file of the figure that shows it; empty where none does.
    pub figure: String,
}

/// The conditions by their places in [`crate::runs::CONDITIONS`].
pub(crate) const PRINTED: usize = 0;
pub(crate) const MAIN: usize = 1;
pub(crate) const LOADED: usize = 2;

/// What the claims are judged by.
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

/// Judges a claim; `None` of a study that lacks the runs for it.
type Judge = fn(&Case<'_>) -> Option<Claim>;
