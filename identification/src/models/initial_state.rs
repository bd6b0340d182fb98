//! The initial state of a run, which most models share.

model_core::parameters! {
    /// The state of a model at the first sample of a run.
    pub struct InitialState {
        /// Angle at the first sample.
        initial_angle_deg [""]: 0.0, "deg", -1e5, 1e5, "the run";
        /// Rate at the first sample.
        initial_rate_deg_s [""]: 0.0, "deg/s", -1e5, 1e5, "the run";
    }
}
