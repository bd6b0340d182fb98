//! Nonparametric analysis of the recordings, without a model in the time domain.

use crate::{
    experiment::Experiment,
    frequency::{Equivalent, FrequencyResponse},
    recording::Recording,
    statistics::delay::DelayEstimate,
};

/// Delay by cross-correlation, frequency response, and low-order equivalent systems.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct NonparametricAnalysis {
    /// The delay of each recording, with its name; `None` where command and angle are not
    /// correlated.
    pub delays: Vec<(String, Option<DelayEstimate>)>,
    /// The frequency response of all recordings together; `None` where they are too short or at
    /// rest.
    pub response: Option<FrequencyResponse>,
    /// The first-order equivalent system.
    pub first_order: Option<Equivalent>,
    /// The second-order equivalent system.
    pub second_order: Option<Equivalent>,
}

impl NonparametricAnalysis {
    /// The analysis of these experiments.
    pub fn of(experiments: &[Experiment]) -> Self {
        let recordings: Vec<&Recording> = experiments.iter().map(|e| &*e.recording).collect();
        let delay = |r: &&Recording| {
            let delay = DelayEstimate::of(&r.time_s, &r.command_deg, &r.angle_deg);
            (r.name.clone(), delay)
        };
        let response = FrequencyResponse::of(&recordings);
        Self {
            delays: recordings.iter().map(delay).collect(),
            first_order: response.as_ref().and_then(Equivalent::first_order),
            second_order: response.as_ref().and_then(Equivalent::second_order),
            response,
        }
    }
}
