//! Options and limits of the axis, from the stored values.

use canopen::cia402::{Deceleration, Options, Parameters, QuickStop, StopOption};

use model_core::control::{cascade::Coefficients, parameters::ControlParameters};

use crate::{
    parameters::{BoardParameters, ObjectValues, ProfileSettings},
    timing::CONTROL_PERIOD_MS,
};

const INTEGRAL_GAIN: usize = ControlParameters::row("integral_gain");
const PROPORTIONAL_GAIN: usize = ControlParameters::row("proportional_gain");
const POSITION_GAIN: usize = ControlParameters::row("position_gain");

/// Length of a control period, us.
pub(super) const PERIOD_US: u32 = CONTROL_PERIOD_MS as u32 * 1000;

/// All parameters of the axis, in mdeg.
pub(super) fn axis_parameters(values: &ObjectValues, board: &BoardParameters) -> Parameters {
    let profile = &values.profile;
    Parameters {
        period_us: PERIOD_US,
        options: options(profile),
        position_limits: Some((profile.min_position_mdeg, profile.max_position_mdeg)),
        approach_gain: approach_gain(&board.control),
        // Within 100,000 deg/s^2.
        reachable_deceleration: board.stop.quick_stop_deceleration_deg_s2.unsigned_abs() * 1000,
        max_velocity: profile.max_velocity_mdeg_s,
        profile_velocity: profile.profile_velocity_mdeg_s,
        acceleration: profile.acceleration_mdeg_s2,
        deceleration: profile.deceleration_mdeg_s2,
        quick_stop_deceleration: profile.quick_stop_deceleration_mdeg_s2,
        stop_time_ms: board.stop.quick_stop_ms as u16,
        interpolation_us: u32::from(profile.interpolation_time) * 1000,
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

/// Velocity per distance at which a velocity mode approaches a position limit, in units of 2^-10/s.
///
/// With `v = k d` for the distance `d` and a rate loop that follows its command like a first-order
/// lag `T`, the distance obeys `T d'' + d' + k d = 0`: it ends without overshoot up to
/// `k = 1/(4 T)`. With the motor `K/(1 + s/w)` the rate loop has `1/T = K Ki` where it cancels the
/// motor's pole, as that of the paper does, and `1/T = w (1 + K Kp)` where the proportional gain
/// alone closes it; the slower of the two counts: 7.1/s and 9.0/s by default. No faster than the
/// position loop would approach the limit; at most 8/s, with which the motor's greatest rate of
/// 280 deg/s asks for the deceleration that full duty gives; and at least 1/s, so that a loop with
/// hardly any integral gain still reaches the limit.
fn approach_gain(control: &Coefficients) -> u32 {
    // Equation (2) of the paper: (deg/s)/%, and rad/s.
    const MOTOR_GAIN: f32 = 2.836;
    const MOTOR_POLE: f32 = 7.586;
    let gain = |row| control.get(row).unwrap_or(0.0);
    let by_integral = MOTOR_GAIN / 4.0 * gain(INTEGRAL_GAIN);
    let by_proportional = MOTOR_POLE / 4.0 * (1.0 + MOTOR_GAIN * gain(PROPORTIONAL_GAIN));
    let units = |gain: f32| (gain * 1024.0) as u32;
    units(by_integral)
        .min(units(by_proportional))
        .min(units(gain(POSITION_GAIN)))
        .clamp(1 << 10, 8 << 10)
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
