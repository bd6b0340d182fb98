//! What happens when the master falls silent.
//!
//! In the cyclic modes the master commands again and again: a pause of more than 2040h:1, counted
//! from the enabling of operation or the change to a cyclic mode, is its loss. In every mode a lost
//! heartbeat is, and that the node is stopped. What follows says 2040h:2.
//!
//! | 2040h:2 | |
//! |---|---|
//! | 0 | the drive halts as 605Dh says, and holds |
//! | 1 | a fault: the shaft is brought to rest as 605Eh says |
//! | 2 | the shaft goes to 2040h:3 at the rate of 2040h:4, and stays there |

use super::{Drive, limits::PERIOD_US};
use crate::{
    application::{CommandSource, Request},
    timing::periods,
};
use canopen::cia402::Cia402State;

/// What is known of the master.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Failsafe {
    /// Control periods since the last cyclic command, or since operation was enabled in a cyclic
    /// mode.
    silent: u16,
    /// The network says that it is gone.
    lost: bool,
    /// Where a retreat has come to, mdeg.
    retreat_mdeg: Option<i32>,
}

impl Failsafe {
    /// A cyclic command came.
    pub fn commanded(&mut self) {
        self.silent = 0;
    }

    /// The network says that the master is gone, or there again.
    pub fn network(&mut self, lost: bool) {
        self.lost = lost;
    }

    /// Whoever resets the fault is there, and has another try, whatever was known of the master
    /// before: its heartbeat may be watched no longer, and after a reset of the communication it
    /// need not start the node.
    pub fn begin_anew(&mut self) {
        *self = Self::default();
    }
}

/// What the axis is to do of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Reaction {
    /// Nothing.
    None,
    /// Halt.
    Hold,
    /// A fault.
    Fail,
    /// Be at this angle, mdeg.
    Go(i32),
}

impl Drive<'_> {
    /// One control period.
    pub(super) fn fail_safe(&mut self) -> Reaction {
        let is_enabled = self.axis.state() == Cia402State::OperationEnabled;
        let is_cyclic = matches!(self.commands.mode, 8 | 9);
        let is_bus = self.application.selected_source() == CommandSource::Bus;
        if !is_cyclic || !is_enabled || !is_bus {
            self.failsafe.silent = 0;
        }
        if !is_enabled || !is_bus {
            self.failsafe.retreat_mdeg = None;
            return Reaction::None;
        }
        let timeout_ms = self.application.parameters().command.command_timeout_ms;
        // An excitation needs no commands; behind it the silence begins anew.
        let is_exciting = !self.is_commanded();
        self.failsafe.silent = if is_cyclic && !is_exciting {
            self.failsafe.silent.saturating_add(1)
        } else {
            0
        };
        let is_silent = timeout_ms > 0 && self.failsafe.silent > periods(timeout_ms);
        if !self.failsafe.lost && !is_silent {
            self.failsafe.retreat_mdeg = None;
            return Reaction::None;
        }
        if is_exciting {
            // It ends, whatever follows; refused where it has ended by itself.
            let _ = self.application.request(Request::StopExcitation);
        }
        match self.values.failsafe.failsafe_action {
            1 => Reaction::Fail,
            2 => Reaction::Go(self.retreat()),
            _ => Reaction::Hold,
        }
    }

    /// The next angle on the way to the failsafe position.
    fn retreat(&mut self) -> i32 {
        let wanted = self.values.failsafe.failsafe_position_mdeg;
        let rate = self.application.parameters().command.approach_rate_deg_s;
        // mdeg in a control period: at most 2000 times 4.
        let step = rate.saturating_mul(PERIOD_US as i32 / 1000);
        let from = self
            .failsafe
            .retreat_mdeg
            .unwrap_or(self.motion.position_mdeg);
        let next = from.saturating_add(wanted.saturating_sub(from).max(-step).min(step));
        self.failsafe.retreat_mdeg = Some(next);
        next
    }
}
