//! Two copies of the control loop, compared in every control period.
//!
//! The output of the first copy acts in the next update period. Then the second copy computes the
//! same control period from inputs that are read again, and outputs and states of both are
//! compared. A bit that has flipped in a register, in the memory of a copy or in the path of an
//! input, and an instruction that was not executed, make a difference, and the [`Shutdown`] begins
//! in the same control period.
//!
//! Both copies see the same mailboxes; a message is protected by its check value
//! ([`crate::check_value`]). Both execute the same program, whose flash has a CRC
//! ([`crate::integrity`]).

mod shutdown;
#[cfg(test)]
mod tests;

pub use self::shutdown::{BRAKING_PERIODS, RESTART_MARK, Shutdown};

use crate::{
    control_loop::{Inputs, Loop},
    faults::FaultSet,
    interface::Outputs,
};

/// The loop, twice.
///
/// ```
/// use firmware::application::{Samples, Start};
/// use firmware::control_loop::{Commands, ExcitationRequest, Inputs, Loop, LoopParameters};
/// use firmware::{drive::StoredParameters, replicated::Replicated};
/// use model_core::control::encoder_word::EncoderWord;
///
/// let parameters = LoopParameters::of(&StoredParameters::DEFAULT);
/// let (commands, excitation) = (Commands::new(), ExcitationRequest::NONE);
/// let control_loop = Loop::new((&commands, &parameters, &excitation), Start::default());
/// let mut replicated = Replicated::new(control_loop);
/// let samples = Samples::at_rest(EncoderWord::new(0));
/// let inputs = Inputs {
///     samples: &samples,
///     was_late: false,
///     commands: &commands,
///     parameters: &parameters,
///     excitation: &excitation,
/// };
/// replicated.step(&inputs);
/// assert!(replicated.repeat(&inputs));
/// ```
#[derive(Debug)]
pub struct Replicated {
    first: Loop,
    second: Loop,
}

impl Replicated {
    /// Two copies of a loop.
    pub fn new(control_loop: Loop) -> Self {
        Self {
            second: control_loop.clone(),
            first: control_loop,
        }
    }

    /// One control period of the first copy, whose outputs act.
    pub fn step(&mut self, inputs: &Inputs<'_>) -> &Outputs {
        self.first.step(inputs)
    }

    /// The same control period of the second copy; returns whether both have the same outputs and
    /// the same state. Their parameters are not compared: a parameter that differs makes another
    /// state or other outputs in the period in which it counts.
    #[must_use]
    pub fn repeat(&mut self, inputs: &Inputs<'_>) -> bool {
        self.second.step(inputs);
        self.first.state() == self.second.state()
    }

    /// The first copy.
    pub fn first(&self) -> &Loop {
        &self.first
    }

    /// The faults after which the motor brakes, by either copy: at most one of them is wrong.
    pub fn braking_faults(&self) -> FaultSet {
        let of = |copy: &Loop| copy.parameters().board.braking_faults();
        of(&self.first).or(of(&self.second))
    }
}
