//! The reaction to the loss of the master.
//!
//! In the cyclic modes the master sends targets periodically: from the first target of the mode
//! after the transition to Operation enabled, the change to a cyclic mode, or a halt, a pause of
//! more than 2040h:1 is a loss of the master. Targets of other modes do not count. In every mode
//! a missing heartbeat is a loss, and so is the NMT state Stopped.
//! 2040h:2 selects the reaction:
//!
//! | 2040h:2 | reaction |
//! |---|---|
//! | 0 | halt as configured in 605Dh, then hold |
//! | 1 | a fault, with the reaction configured in 605Eh |
//! | 2 | the shaft moves to 2040h:3 at the rate of 2040h:4, and holds there |
//! | 3 | none |
//! | 4 | the power is removed, as by the controlword |
//! | 5 | a quick stop, as by the controlword |
//!
//! 6007h shows it by the codes of CiA 402.

use super::{LoopParameters, PERIOD_US, State};
use crate::{
    application::{CommandSource, Request},
    timing::periods,
};
use canopen::cia402::{Cia402State, controlword};

/// 2040h:2: a quick stop.
const QUICK_STOP: u8 = 5;

/// State of the supervision of the master.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Failsafe {
    /// Control periods since the last target of the cyclic mode, and one more; 0 before the first.
    silent: u16,
    /// The network reports a loss: heartbeat, or the NMT state Stopped.
    lost: bool,
    /// Present target of the motion to the failsafe position, mdeg.
    retreat_mdeg: Option<i32>,
}

impl Failsafe {
    /// Registers a target of the cyclic mode.
    pub fn commanded(&mut self) {
        self.silent = 1;
    }

    /// Registers whether the network reports a loss.
    pub fn network(&mut self, lost: bool) {
        self.lost = lost;
    }

    /// Whether the shaft moves to the failsafe position, or is there.
    pub fn retreats(&self) -> bool {
        self.retreat_mdeg.is_some()
    }

    /// Clears the state at a fault reset. The sender of the reset is a present master; an earlier
    /// loss of the heartbeat or of the NMT state Operational no longer applies.
    pub fn begin_anew(&mut self) {
        *self = Self::default();
    }
}

/// Reaction that the axis carries out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Reaction {
    /// Nothing.
    None,
    /// Follow this controlword.
    Control(u16),
    /// Enter a fault.
    Fail,
    /// Follow this target angle, mdeg.
    Go(i32),
}

impl State {
    /// Supervises the master for one control period.
    pub(super) fn fail_safe(&mut self, parameters: &LoopParameters) -> Reaction {
        let action = parameters.failsafe.failsafe_action;
        // A quick stop that ends in its own state lasts until the master is back.
        let stays = action == QUICK_STOP && self.axis.state() == Cia402State::QuickStopActive;
        let is_enabled = stays || self.axis.state() == Cia402State::OperationEnabled;
        let is_cyclic = self.command.mode.is_cyclic();
        let is_bus = self.application.selected_source() == CommandSource::Bus;
        // After a halt the axis waits for a target, as after enabling.
        let is_halted = self.command.control & controlword::HALT != 0;
        if !is_cyclic || !is_enabled || !is_bus || is_halted {
            self.failsafe.silent = 0;
        }
        if !is_enabled || !is_bus {
            self.failsafe.retreat_mdeg = None;
            return Reaction::None;
        }
        let timeout_ms = parameters.board.command.command_timeout_ms;
        // An excitation needs no commands; after it the timeout starts again.
        let is_exciting = !self.is_commanded();
        self.failsafe.silent = match self.failsafe.silent {
            0 => 0,
            _ if is_exciting => 1,
            silent => silent.saturating_add(1),
        };
        let is_silent = timeout_ms > 0 && self.failsafe.silent > periods(timeout_ms) + 1;
        if !self.failsafe.lost && !is_silent {
            self.failsafe.retreat_mdeg = None;
            return Reaction::None;
        }
        if is_exciting {
            // The excitation ends with each reaction; the request is refused if it has already
            // ended.
            let _ = self.application.request(Request::StopExcitation);
        }
        let word = self.command.control;
        match action {
            1 => Reaction::Fail,
            2 => Reaction::Go(self.retreat(parameters)),
            3 => Reaction::None,
            4 => Reaction::Control(word & !controlword::ENABLE_VOLTAGE),
            QUICK_STOP => Reaction::Control(word & !controlword::QUICK_STOP),
            _ => Reaction::Control(word | controlword::HALT),
        }
    }

    /// The next target angle of the motion to the failsafe position, mdeg.
    fn retreat(&mut self, parameters: &LoopParameters) -> i32 {
        let wanted = parameters.failsafe.failsafe_position_mdeg;
        let rate = parameters.board.command.approach_rate_deg_s;
        // mdeg per control period: at most 2000 times 4.
        let step = rate.saturating_mul(PERIOD_US as i32 / 1000);
        let from = self
            .failsafe
            .retreat_mdeg
            .unwrap_or(self.application.outputs().motion.position_mdeg);
        let next = from.saturating_add(wanted.saturating_sub(from).max(-step).min(step));
        self.failsafe.retreat_mdeg = Some(next);
        next
    }
}
