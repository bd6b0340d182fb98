//! Options and limits of the axis, from the stored values.

use canopen::cia402::{Deceleration, Options, Parameters, QuickStop, StopOption};

use crate::{
    parameters::{BoardParameters, ObjectValues, ProfileSettings},
    timing::CONTROL_PERIOD_MS,
};

/// Length of a control period, us.
pub(super) const PERIOD_US: u32 = CONTROL_PERIOD_MS as u32 * 1000;

/// All parameters of the axis, in mdeg.
pub(super) fn axis_parameters(values: &ObjectValues, board: &BoardParameters) -> Parameters {
    let profile = &values.profile;
    Parameters {
        period_us: PERIOD_US,
        options: options(profile),
        position_limits: Some((profile.min_position_mdeg, profile.max_position_mdeg)),
        max_velocity: profile.max_velocity_mdeg_s,
        profile_velocity: profile.profile_velocity_mdeg_s,
        acceleration: profile.acceleration_mdeg_s2,
        deceleration: profile.deceleration_mdeg_s2,
        quick_stop_deceleration: profile.quick_stop_deceleration_mdeg_s2,
        interpolation_us: interpolation_us(profile),
        following_error_window: board.following.following_window_mdeg.unsigned_abs(),
        following_error_timeout_ms: board.following.following_ms as u16,
        position_window: profile.position_window_mdeg,
        position_window_time_ms: profile.position_window_ms,
        velocity_window: u32::from(profile.velocity_window_mdeg_s),
        velocity_window_time_ms: profile.velocity_window_ms,
        velocity_threshold: u32::from(profile.velocity_threshold_mdeg_s),
        velocity_threshold_time_ms: profile.velocity_threshold_ms,
    }
}

/// The ranges of the dictionary exclude undefined option codes.
fn options(profile: &ProfileSettings) -> Options {
    let stop = |code| StopOption::from_code(code).unwrap_or(StopOption::Disable);
    let quick_stop = QuickStop::from_code(profile.quick_stop_option);
    Options {
        quick_stop: quick_stop.unwrap_or(QuickStop {
            stop: StopOption::Stop(Deceleration::QuickStop),
            remains_active: false,
        }),
        shutdown: stop(profile.shutdown_option),
        disable_operation: stop(profile.disable_option),
        halt: stop(profile.halt_option),
        fault_reaction: stop(profile.fault_reaction_option),
    }
}

/// Object 60C2h: the value times 10 to the power of the index, in seconds; the index is -6 to 0.
fn interpolation_us(profile: &ProfileSettings) -> u32 {
    let index = i32::from(profile.interpolation_index);
    let zeros = index.saturating_add(6).clamp(0, 6).unsigned_abs();
    u32::from(profile.interpolation_time).saturating_mul(10_u32.saturating_pow(zeros))
}
