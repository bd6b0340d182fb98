//! Set-point handshake of profile position mode (bits 4, 5 and 6 of the controlword, bit 12 of the
//! statusword).

use super::controlword::{CHANGE_SET_IMMEDIATELY, NEW_SET_POINT, RELATIVE};
use super::{Parameters, RelativeTo};

/// The active target and one buffered set-point.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct SetPoints {
    target: i32,
    buffered: Option<i32>,
    moving: bool,
    /// A set-point was accepted since the start of the mode.
    accepted: bool,
    new_set_point: bool,
    acknowledged: bool,
}

impl SetPoints {
    /// Holds a position without an active set-point. A "new set-point" bit that is already set is
    /// not a new set-point.
    pub fn restart(&mut self, position: i32, word: u16) {
        *self = Self {
            target: position,
            new_set_point: word & NEW_SET_POINT != 0,
            ..Self::default()
        };
    }

    /// Evaluates the controlword and target position 607Ah, with position demand and actual
    /// position; returns the active target.
    pub fn step(
        &mut self,
        word: u16,
        position: i32,
        present: (i32, i32),
        parameters: &Parameters,
    ) -> i32 {
        let new_set_point = word & NEW_SET_POINT != 0;
        let rises = new_set_point && !self.new_set_point;
        self.new_set_point = new_set_point;
        if rises {
            self.accept(word, position, present, parameters);
        }
        if !new_set_point && self.buffered.is_none() {
            self.acknowledged = false;
        }
        self.target
    }

    fn accept(
        &mut self,
        word: u16,
        position: i32,
        (demand, actual): (i32, i32),
        parameters: &Parameters,
    ) {
        let last = match parameters.relative_to {
            RelativeTo::Demand => demand,
            RelativeTo::Actual => actual,
            // Where a set-point beyond the position limits ends.
            RelativeTo::Target if self.accepted => {
                let last = self.buffered.unwrap_or(self.target);
                parameters.within_position_limits(last).0
            }
            RelativeTo::Target => self.target,
        };
        let target = if word & RELATIVE == 0 {
            position
        } else {
            last.saturating_add(position)
        };
        if !self.moving || word & CHANGE_SET_IMMEDIATELY != 0 {
            (self.target, self.buffered, self.moving) = (target, None, true);
        } else if self.buffered.is_none() {
            self.buffered = Some(target);
        } else {
            // The buffer is full: the set-point is not acknowledged.
            return;
        }
        self.acknowledged = true;
        self.accepted = true;
    }

    /// The target is reached: activates the buffered set-point.
    pub fn reached(&mut self) {
        match self.buffered.take() {
            Some(next) => self.target = next,
            None => self.moving = false,
        }
    }

    /// Bit 12 "set-point acknowledge": the set-point is accepted; the bit remains set while the
    /// buffer is full.
    pub const fn acknowledged(&self) -> bool {
        self.acknowledged
    }

    /// Whether no set-point was accepted since the start of the mode.
    pub const fn is_empty(&self) -> bool {
        !self.accepted
    }

    /// Whether a set-point is active.
    pub const fn is_active(&self) -> bool {
        self.moving
    }

    /// Whether a set-point waits for the active one.
    pub const fn has_next(&self) -> bool {
        self.buffered.is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NEW: u16 = 1 << 4;
    const IMMEDIATELY: u16 = 1 << 5;

    /// The active target after a set-point, and whether it was acknowledged.
    fn give(points: &mut SetPoints, bits: u16, position: i32) -> (i32, bool) {
        let target = points.step(NEW | bits, position, (0, 0), &Parameters::default());
        let is_acknowledged = points.acknowledged();
        points.step(0, 0, (0, 0), &Parameters::default());
        (target, is_acknowledged)
    }

    #[test]
    fn one_set_point_is_active_and_one_waits() {
        let mut points = SetPoints::default();
        points.restart(5, 0);
        assert!(!points.moving && points.is_empty());
        assert_eq!(give(&mut points, 0, 10), (10, true));
        assert!(points.moving && !points.acknowledged());
        assert_eq!(give(&mut points, 0, 20), (10, true));
        assert!(points.acknowledged(), "the buffer is full");
        assert_eq!(give(&mut points, 0, 30).0, 10);
        points.reached();
        assert_eq!(points.step(0, 0, (0, 0), &Parameters::default()), 20);
        assert!(points.moving && !points.acknowledged());
        assert_eq!(give(&mut points, IMMEDIATELY, 40), (40, true));
        points.reached();
        assert!(!points.moving);
    }

    #[test]
    fn a_set_point_is_a_rising_edge_after_the_start_of_the_mode() {
        let mut points = SetPoints::default();
        let parameters = Parameters::default();
        points.restart(5, NEW);
        assert_eq!(points.step(NEW, 10, (0, 0), &parameters), 5);
        points.restart(5, 0);
        assert_eq!(points.step(NEW, 10, (0, 0), &parameters), 10);
    }
}
