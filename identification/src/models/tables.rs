//! Parameters of the models, with the names that the simulator gives them and the bounds within
//! which a search makes sense.

use model_core::models::SetupParameters;
use model_core::parameter::{Parameter, Parameters};

model_core::parameters! {
    /// The state of a model at the first sample of a run.
    pub struct InitialState {
        /// Angle at the first sample.
        initial_angle_deg [""]: 0.0, "deg", -1e5, 1e5, "the run";
        /// Rate at the first sample.
        initial_rate_deg_s [""]: 0.0, "deg/s", -1e5, 1e5, "the run";
    }
}

/// The parameter of this name in a table.
///
/// # Panics
/// If there is none: an error of this program.
pub fn row<P: Parameters>(name: &str) -> Parameter {
    let found = P::TABLE.iter().find(|row| row.name == name);
    *found.unwrap_or_else(|| panic!("no parameter {name} in its table"))
}

/// The same within narrower bounds.
pub fn bounded<P: Parameters>(name: &str, min: f64, max: f64) -> Parameter {
    let row = row::<P>(name);
    Parameter {
        min: row.min.max(min),
        max: row.max.min(max),
        ..row
    }
}

/// The transport delay.
pub fn delay() -> Parameter {
    row::<SetupParameters>("delay_s")
}

/// A limit of the rate: from what no encoder sees to what no servo reaches.
pub fn rate_limit<P: Parameters>(name: &str) -> Parameter {
    bounded::<P>(name, 0.1, 1e5)
}
