//! The tuned gains and loops as code for control engineers.

use model_core::control::parameters::ControlParameters;
use model_core::parameter::Parameters;

use super::{TuneError, TuneRequest, Tuning};
use crate::analysis::linear_models::Loop;

/// The language.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Language {
    /// A script of MATLAB or Octave.
    Matlab,
    /// A script for python-control.
    Python,
}

/// Number of gains at the beginning of the table that are those of the loops.
const GAINS: usize = 4;

/// Gains, and the sampled loops as transfer functions in `z`.
///
/// # Errors
/// [`TuneError::Parameter`] for a parameter that is out of range.
pub fn code(
    request: &TuneRequest,
    tuning: &Tuning,
    language: Language,
) -> Result<String, TuneError> {
    let servo = Loop::sampled(&request.motor, &tuning.control, &request.timing)?;
    let (mark, end) = match language {
        Language::Matlab => ("%", ";"),
        Language::Python => ("#", ""),
    };
    let mut text = format!(
        "{mark} The tuned loops of the board, by actuator {}; angles in deg, duty in %.\n",
        env!("CARGO_PKG_VERSION")
    );
    if language == Language::Python {
        text += "import control\n\n";
    }
    let gains = ControlParameters::TABLE[..GAINS].iter().enumerate();
    for (index, gain) in gains {
        let value = tuning.control.get(index).unwrap_or(f64::NAN);
        text += &format!("{} = {value:?}{end}  {mark} {}\n", gain.name, gain.unit);
    }
    let period_s = request.timing.control_period_s;
    text += &format!("period_s = {period_s:?}{end}\n");
    let loops = [
        ("open_loop", "opened at the duty", &servo.open),
        (
            "closed_loop",
            "from position command to angle",
            &servo.closed,
        ),
    ];
    for (name, meaning, system) in loops {
        let (numerator, denominator) = system.in_z();
        let tf = if language == Language::Python {
            "control.tf"
        } else {
            "tf"
        };
        text += &format!(
            "{mark} {meaning}\n{name} = {tf}({numerator:?}, {denominator:?}, period_s){end}\n"
        );
    }
    Ok(text)
}
