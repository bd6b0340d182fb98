//! Homing: the motion that finds the home position, and its parameters.

use super::Parameters;
use super::controlword::START_HOMING;
use super::window::HoldTimer;

/// Direction of a search.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Direction {
    /// Toward smaller positions.
    Negative = -1,
    /// Toward greater positions.
    Positive = 1,
}

impl Direction {
    /// The other one.
    #[must_use]
    pub const fn reversed(self) -> Self {
        match self {
            Self::Negative => Self::Positive,
            Self::Positive => Self::Negative,
        }
    }
}

/// Homing method 6098h.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum HomingMethod {
    /// 0: nothing is to be found.
    None,
    /// 35 and 37: the home position is the present one.
    Here,
    /// 33 and 34: the next index of the encoder.
    Index(Direction),
    /// -4 and -3: where the motor's current shows a hard stop.
    Stop(Direction),
    /// -2 and -1: the next index of the encoder behind a hard stop.
    IndexBehindStop(Direction),
}

impl HomingMethod {
    /// The method of a code of 6098h; `None` if it is not supported, as those with switches.
    ///
    /// ```
    /// use canopen::cia402::{Direction, HomingMethod};
    /// assert_eq!(HomingMethod::from_code(33), Some(HomingMethod::Index(Direction::Negative)));
    /// assert_eq!(HomingMethod::from_code(-3), Some(HomingMethod::Stop(Direction::Positive)));
    /// assert_eq!(HomingMethod::from_code(17), None);
    /// ```
    #[must_use]
    pub const fn from_code(code: i8) -> Option<Self> {
        use Direction::{Negative, Positive};
        Some(match code {
            0 => Self::None,
            35 | 37 => Self::Here,
            33 => Self::Index(Negative),
            34 => Self::Index(Positive),
            -4 => Self::Stop(Negative),
            -3 => Self::Stop(Positive),
            -2 => Self::IndexBehindStop(Negative),
            -1 => Self::IndexBehindStop(Positive),
            _ => return None,
        })
    }

    /// The same in the opposite direction.
    #[must_use]
    pub const fn reversed(self) -> Self {
        match self {
            Self::None | Self::Here => self,
            Self::Index(direction) => Self::Index(direction.reversed()),
            Self::Stop(direction) => Self::Stop(direction.reversed()),
            Self::IndexBehindStop(direction) => Self::IndexBehindStop(direction.reversed()),
        }
    }
}

/// Parameters of homing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct HomingParameters {
    /// Homing method 6098h.
    pub method: HomingMethod,
    /// Home offset 607Ch: the position that the home position has afterwards.
    pub offset: i32,
    /// Velocity toward a hard stop, 6099h:1.
    pub stop_velocity: u32,
    /// Velocity toward an index, 6099h:2.
    pub index_velocity: u32,
    /// Acceleration 609Ah, also of the deceleration.
    pub acceleration: u32,
    /// Distance of two indices of the encoder.
    pub index_distance: i32,
    /// Motor current, in the unit of [`super::Input::current_actual`], of a motor that stands at a
    /// hard stop.
    pub stop_current: u32,
    /// Way within which the motor stands.
    pub stop_way: u32,
    /// Time in milliseconds for which it stands there.
    pub stop_time_ms: u16,
}

impl Default for HomingParameters {
    /// No method; for a small servo in thousandths of a degree and milliamperes.
    fn default() -> Self {
        Self {
            method: HomingMethod::None,
            offset: 0,
            stop_velocity: 20_000,
            index_velocity: 10_000,
            acceleration: 200_000,
            index_distance: 360_000,
            stop_current: 250,
            stop_way: 200,
            stop_time_ms: 100,
        }
    }
}

/// Progress of homing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Phase {
    /// Not started since the mode began.
    #[default]
    Idle,
    /// On the way.
    Searching(Search),
    /// The home position is found.
    Attained,
    /// A stop, or the falling edge of bit 4.
    Interrupted,
    /// There is no hard stop, or one before the index.
    Failed,
}

/// What is searched for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Goal {
    /// A hard stop.
    Stop(Direction),
    /// An index, at this position.
    Index(i32),
}

/// A search, with the place where the motor stands, and for how long.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Search {
    pub goal: Goal,
    place: i32,
    standing: HoldTimer,
}

/// State of homing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Homing {
    pub phase: Phase,
    /// The home position was found since the start of the axis.
    is_homed: bool,
    bit: bool,
}

/// What a motor meets that does not turn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Resistance {
    /// It turns, or may begin to.
    None,
    /// A hard stop.
    Stop,
    /// Something that draws no current: it does not follow the demand.
    Unknown,
}

impl Homing {
    /// The mode begins; with power, a bit 4 that is set already starts nothing.
    pub fn restart(&mut self, word: u16, with_power: bool) {
        if with_power {
            self.track(word);
        }
        self.phase = match (self.phase, self.is_homed) {
            (Phase::Searching(_), _) => Phase::Interrupted,
            (_, true) => Phase::Attained,
            (_, false) => Phase::Idle,
        };
    }

    /// A stop interrupts.
    pub fn interrupt(&mut self) {
        if matches!(self.phase, Phase::Searching(_)) {
            self.phase = Phase::Interrupted;
        }
    }

    /// Whether bit 4 of the controlword starts; its falling edge interrupts.
    pub fn starts(&mut self, word: u16) -> bool {
        let is_set = word & START_HOMING != 0;
        if !is_set {
            self.interrupt();
        }
        is_set && !self.bit
    }

    /// Keeps bit 4 at the end of a period of any mode and of a halt: a master may release the halt
    /// and set bit 4 at once.
    pub fn track(&mut self, word: u16) {
        self.bit = word & START_HOMING != 0;
    }

    /// Begins a search at this position.
    pub fn search(&mut self, goal: Goal, position: i32) {
        self.phase = Phase::Searching(Search {
            goal,
            place: position,
            standing: HoldTimer::default(),
        });
    }

    pub fn attain(&mut self) {
        (self.phase, self.is_homed) = (Phase::Attained, true);
    }
}

impl Search {
    /// Whether the motor stands against something, by its position, the distance to the demand and
    /// its current.
    pub fn resistance<const PERIOD_US: u32>(
        &mut self,
        position: i32,
        lag: u32,
        current: u32,
        parameters: &Parameters,
    ) -> Resistance {
        let homing = &parameters.homing;
        let is_near = position.abs_diff(self.place) <= homing.stop_way;
        let is_blocked = current >= homing.stop_current;
        let is_behind = lag > parameters.following_error_window;
        if !is_near {
            self.place = position;
        }
        let stands = is_near && (is_blocked || is_behind);
        let lasts = (self.standing).step::<PERIOD_US>(stands, homing.stop_time_ms);
        match (lasts, is_blocked) {
            (false, _) => Resistance::None,
            (true, true) => Resistance::Stop,
            (true, false) => Resistance::Unknown,
        }
    }
}

/// The index of the encoder next to a position, by distances to the position 0 of the encoder.
pub(super) fn next_index(position: i32, direction: Direction, distance: i32) -> i32 {
    let beyond = position.checked_rem_euclid(distance).unwrap_or(0);
    let below = position.saturating_sub(beyond);
    match direction {
        Direction::Positive if beyond > 0 => below.saturating_add(distance),
        _ => below,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_next_index_is_on_the_side_of_its_direction_or_here() {
        use Direction::{Negative, Positive};
        for (position, direction, index) in [
            (10, Negative, 0),
            (10, Positive, 360),
            (-10, Negative, -360),
            (-10, Positive, 0),
            (0, Negative, 0),
            (360, Positive, 360),
        ] {
            assert_eq!(next_index(position, direction, 360), index, "{position}");
        }
        assert_eq!(next_index(7, Positive, 0), 7);
    }
}
