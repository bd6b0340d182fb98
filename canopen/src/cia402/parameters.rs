//! Parameters of an axis, in the units of the object dictionary.

use super::{HomingParameters, Limits, Options};

/// What a relative set-point is added to: bits 0 and 1 of positioning option code 60F2h.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum RelativeTo {
    /// The preceding target.
    Target,
    /// The position demand.
    Demand,
    /// The actual position.
    Actual,
}

/// Positions are in user-defined units, velocities in that unit per second, accelerations in that
/// unit per second squared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Parameters {
    /// Option codes 605Ah to 605Eh.
    pub options: Options,
    /// Software position limits 607Dh, lower and upper; `None` disables them.
    pub position_limits: Option<(i32, i32)>,
    /// Velocity per distance at which a velocity mode may approach a position limit, in units of
    /// 2^-10/s; 0 for no such bound.
    pub approach_gain: u32,
    /// Deceleration that the motor reaches: the approach to a position limit counts on no more of
    /// 6084h than this.
    pub reachable_deceleration: u32,
    /// Max profile velocity 607Fh or max motor speed 6080h, whichever is less.
    pub max_velocity: u32,
    /// Max torque 6072h, thousandths of the rated torque.
    pub max_torque: u16,
    /// Torque slope 6087h, thousandths of the rated torque per second.
    pub torque_slope: u32,
    /// Profile velocity 6081h.
    pub profile_velocity: u32,
    /// Profile acceleration 6083h.
    pub acceleration: u32,
    /// Profile deceleration 6084h.
    pub deceleration: u32,
    /// Control periods over which the demand of a profile position is averaged, which limits its
    /// jerk to the acceleration divided by their time; up to [`Parameters::MOST_SMOOTHING`]. 0 and
    /// 1 do not average.
    pub smoothing: u8,
    /// Positioning option code 60F2h.
    pub relative_to: RelativeTo,
    /// Homing.
    pub homing: HomingParameters,
    /// Quick stop deceleration 6085h.
    pub quick_stop_deceleration: u32,
    /// Time in milliseconds of a stop after which it does not wait for the motor to rest, only for
    /// the end of the deceleration.
    pub stop_time_ms: u16,
    /// Interpolation time period 60C2h in microseconds; 0 applies each target immediately.
    pub interpolation_us: u32,
    /// Following error window 6065h; `u32::MAX` disables monitoring.
    pub following_error_window: u32,
    /// Following error time out 6066h in milliseconds.
    pub following_error_timeout_ms: u16,
    /// Position window 6067h; with `u32::MAX` the target is always reached.
    pub position_window: u32,
    /// Position window time 6068h in milliseconds.
    pub position_window_time_ms: u16,
    /// Velocity window 606Dh.
    pub velocity_window: u32,
    /// Velocity window time 606Eh in milliseconds.
    pub velocity_window_time_ms: u16,
    /// Velocity threshold 606Fh, at or below which bit 12 "speed" indicates zero speed.
    pub velocity_threshold: u32,
    /// Velocity threshold time 6070h in milliseconds.
    pub velocity_threshold_time_ms: u16,
}

impl Default for Parameters {
    /// A small servo in thousandths of a degree with a command period of 20 ms.
    fn default() -> Self {
        Self {
            options: Options::default(),
            position_limits: Some((-60_000, 60_000)),
            approach_gain: 0,
            reachable_deceleration: u32::MAX,
            max_velocity: 500_000,
            max_torque: 1_000,
            torque_slope: 10_000,
            profile_velocity: 300_000,
            acceleration: 3_000_000,
            deceleration: 3_000_000,
            smoothing: 0,
            relative_to: RelativeTo::Target,
            homing: HomingParameters::default(),
            quick_stop_deceleration: 6_000_000,
            stop_time_ms: 500,
            interpolation_us: 20_000,
            following_error_window: 5_000,
            following_error_timeout_ms: 200,
            position_window: 500,
            position_window_time_ms: 20,
            velocity_window: 2_000,
            velocity_window_time_ms: 20,
            velocity_threshold: 1_000,
            velocity_threshold_time_ms: 20,
        }
    }
}

impl Parameters {
    /// Most control periods of [`Parameters::smoothing`].
    pub const MOST_SMOOTHING: u8 = 16;

    /// Limits of a motion profile.
    pub(super) fn profile(&self, velocity: u32) -> Limits {
        Limits {
            velocity: velocity.min(self.max_velocity),
            acceleration: self.acceleration,
            deceleration: self.deceleration,
        }
    }

    /// Limits a position to the software position limits; returns it and whether it was changed.
    pub(super) fn within_position_limits(&self, position: i32) -> (i32, bool) {
        let Some((low, high)) = self.position_limits else {
            return (position, false);
        };
        let limited = position.max(low).min(high);
        (limited, limited != position)
    }
}
