//! Requests to the application between two control periods.

use model_core::control::{
    cascade::CascadeStep, encoder_correction::EncoderCorrection, units::Rate,
};

use super::{
    Application, BoardState, POSITION_WRONG, Refused, Request, back_emf_brake, stopping::Stopping,
};
use crate::{
    command::excitation::{Run, Sample},
    faults::{Fault, PERMANENT},
    parameters::BoardParameters,
};

/// Whether parameters may change to others in a state: while the loop is closed only gains and
/// limits of the control step, not the mounting of the encoder; nothing during a stop.
///
/// # Errors
/// As [`Application::retune`].
pub(crate) fn may_retune(
    state: BoardState,
    present: &BoardParameters,
    other: &BoardParameters,
) -> Result<(), Refused> {
    other.check().map_err(Refused::Parameter)?;
    let may_change = match state {
        // With another zero or direction of the encoder the angle would jump.
        BoardState::Enabled => {
            other.differs_in_control_only(present)
                && other.control.has_mounting_of(&present.control)
        }
        BoardState::QuickStop | BoardState::FaultReaction | BoardState::FaultHold => false,
        _ => true,
    };
    may_change.then_some(()).ok_or(Refused::NotWhileDriving)
}

impl Application {
    /// Checks other parameters than the present ones, and adjusts the state to them; the duty does
    /// not jump, unless its limit becomes narrower.
    ///
    /// # Errors
    /// [`Refused::Parameter`] names the first invalid one; [`Refused::NotWhileDriving`] if more
    /// than gains and limits of the control step would change, or anything during a stop.
    pub fn retune(
        &mut self,
        present: &BoardParameters,
        other: &BoardParameters,
    ) -> Result<(), Refused> {
        may_retune(self.state, present, other)?;
        self.control.retune(&present.control, &other.control);
        // Without a valid count the last duty stays in force.
        let duty = self.last_step.duty.limited(other.control.duty_limit());
        if duty != self.last_step.duty {
            self.apply(CascadeStep {
                duty,
                ..self.last_step
            });
        }
        Ok(())
    }

    /// Corrects another error of the encoder from now on: the angle changes, the shaft does not
    /// move.
    pub(crate) fn correct_encoder(&mut self, correction: &EncoderCorrection) {
        self.control.correct(correction);
        self.velocity.reset();
        self.outputs.telemetry.angle = self.control.angle();
    }

    /// Executes a request.
    ///
    /// # Errors
    /// The reason of the refusal; nothing has changed then.
    pub fn request(&mut self, request: Request) -> Result<(), Refused> {
        match request {
            Request::Enable => return self.enable(),
            Request::Disable => self.disable(),
            Request::QuickStop => match self.state {
                BoardState::Enabled => self.stop(BoardState::QuickStop),
                BoardState::QuickStop | BoardState::FaultReaction | BoardState::FaultHold => {}
                state => return Err(Refused::State(state)),
            },
            Request::Acknowledge => match self.state {
                BoardState::Fault | BoardState::FaultHold => self.acknowledge(),
                state => return Err(Refused::State(state)),
            },
            Request::Command(setpoint) => {
                if !self.setpoints.take(setpoint) {
                    return Err(Refused::Source(self.setpoints.source()));
                }
            }
            Request::Torque(torque) => {
                if !self.setpoints.take_torque(torque) {
                    return Err(Refused::Source(self.setpoints.source()));
                }
            }
            Request::Source(source) => {
                if !self.setpoints.switch(source) {
                    return Err(Refused::Source(source));
                }
            }
            Request::StopExcitation => self.setpoints.stop(),
        }
        Ok(())
    }

    /// Adds this input to the present command, from its tick 0 to its end.
    ///
    /// # Errors
    /// [`Refused::State`] if the loop is not closed.
    pub fn start_excitation(&mut self, run: Run) -> Result<(), Refused> {
        if self.state != BoardState::Enabled {
            return Err(Refused::State(self.state));
        }
        self.setpoints.start(run);
        Ok(())
    }

    /// The tick of the excitation whose sample the next control period needs. A caller that
    /// computes samples in another task with [`Run::sample`] reads it after each control period.
    pub fn sample_due(&mut self) -> Option<u64> {
        self.setpoints.running()?.due()
    }

    /// Takes the sample of the running excitation that is due; any other one has no effect. Without
    /// it the control period computes it itself: the command is the same.
    ///
    /// ```
    /// use firmware::application::{Application, Start};
    /// use firmware::{command::excitation::Sample, parameters::BoardParameters};
    /// let mut application = Application::new(&BoardParameters::DEFAULT, Start::default());
    /// // No excitation runs.
    /// assert_eq!(application.sample_due(), None);
    /// application.take_sample(Sample { tick: 80, angle: Default::default() });
    /// ```
    pub fn take_sample(&mut self, sample: Sample) {
        if self.sample_due() == Some(sample.tick)
            && let Some(running) = self.setpoints.running()
        {
            running.offer(sample);
        }
    }

    fn enable(&mut self) -> Result<(), Refused> {
        match self.state {
            BoardState::Enabled => return Ok(()),
            BoardState::Disabled => {}
            BoardState::QuickStop => {}
            state => return Err(Refused::State(state)),
        }
        if let Some(fault) = self.outputs.telemetry.present.first() {
            return Err(Refused::Blocked(fault));
        }
        if !self.control.shaft().is_known() {
            return Err(Refused::Blocked(Fault::EncoderInvalid));
        }
        if !self.setpoints.may_start() {
            return Err(Refused::Blocked(Fault::CommandTimeout));
        }
        self.setpoints.hold(self.control.angle());
        self.protection.restart();
        self.state = BoardState::Enabled;
        Ok(())
    }

    fn disable(&mut self) {
        self.back_emf_stop = None;
        self.state = match self.state {
            BoardState::Enabled | BoardState::QuickStop => BoardState::Disabled,
            BoardState::FaultReaction | BoardState::FaultHold => BoardState::Fault,
            state => state,
        };
    }

    /// Starts to decelerate the shaft, with the duty of its back-EMF: no current flows.
    pub(super) fn stop(&mut self, state: BoardState) {
        // A stalled shaft stands, whatever is commanded and whatever a count that flickers at its
        // edge makes of its rate: the duty that holds the load stays.
        let is_stalled = self.latched.all().contains(Fault::Stall);
        self.stopping = match is_stalled {
            true => Stopping::from(Rate::ZERO, Rate::ZERO),
            false => Stopping::from(self.control.rate(), self.last_step.rate_command),
        };
        let t = &self.outputs.telemetry;
        if self.stopping.began_in_motion() {
            self.control
                .start_from(back_emf_brake::duty_of(t.back_emf_mv, t.supply_mv));
        }
        self.setpoints.stop();
        self.state = state;
    }

    fn acknowledge(&mut self) {
        if !self.latched.all().and(POSITION_WRONG).is_empty() {
            self.control.reset_position();
        }
        self.latched.acknowledge();
        self.start = self.start.and(PERMANENT);
        self.state = BoardState::Disabled;
    }
}
