//! Options and limits of the axis, from the stored values.

use canopen::cia402::{
    Deceleration, HomingMethod, HomingParameters, Options, Parameters, QuickStop, RelativeTo,
    StopOption,
};

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

/// Signs of positions and velocities of objects, object 607Eh: the axis counts in the direction of
/// the encoder.
pub(crate) struct Polarity {
    /// 1 or -1.
    pub position: i32,
    /// 1 or -1.
    pub velocity: i32,
}

impl Polarity {
    /// That of these values.
    pub fn of(values: &ObjectValues) -> Self {
        let sign = |bit: u8| {
            if values.profile.polarity & bit == 0 {
                1
            } else {
                -1
            }
        };
        Self {
            position: sign(1 << 7),
            velocity: sign(1 << 6),
        }
    }
}

/// The jerk limit of 60A4h as periods of a mean, and the greatest acceleration with which these are
/// enough.
fn smoothing(profile: &ProfileSettings) -> (u8, u32) {
    if profile.motion_profile_type != JERK_LIMITED {
        return (0, u32::MAX);
    }
    let fastest = profile
        .acceleration_mdeg_s2
        .max(profile.deceleration_mdeg_s2);
    // Change of the acceleration in a control period: below 2^42.
    let step = (u64::from(profile.jerk_mdeg_s3) * u64::from(PERIOD_US) / 1_000_000).max(1);
    let periods = u64::from(fastest).div_ceil(step);
    let periods = periods.min(Parameters::MOST_SMOOTHING.into());
    let most = step * periods;
    (periods as u8, u32::try_from(most).unwrap_or(u32::MAX))
}

/// 6086h: with 60A4h.
const JERK_LIMITED: i16 = 3;

/// Homing in the direction of the encoder.
fn homing(values: &ObjectValues) -> HomingParameters {
    let (settings, sign) = (&values.homing, Polarity::of(values).position);
    // The dictionary has the supported methods only.
    let method = HomingMethod::from_code(settings.homing_method).unwrap_or(HomingMethod::None);
    HomingParameters {
        method: if sign < 0 { method.reversed() } else { method },
        offset: settings.home_offset_mdeg.saturating_mul(sign),
        stop_velocity: settings.stop_velocity_mdeg_s,
        index_velocity: settings.index_velocity_mdeg_s,
        acceleration: (settings.homing_acceleration_mdeg_s2)
            .min(values.profile.max_acceleration_mdeg_s2),
        index_distance: 360_000,
        stop_current: settings.stop_current_ma.unsigned_abs(),
        stop_way: STOP_WAY_MDEG,
        stop_time_ms: settings.stop_ms as u16,
    }
}

/// Two counts of the encoder: what flickers there, and what a gear train yields.
const STOP_WAY_MDEG: u32 = 200;

/// All parameters of the axis, in mdeg.
pub(super) fn axis_parameters(values: &ObjectValues, board: &BoardParameters) -> Parameters {
    let profile = &values.profile;
    let (smoothing, most) = smoothing(profile);
    Parameters {
        options: options(profile),
        position_limits: Some(position_limits(values)),
        approach_gain: approach_gain(&board.control),
        // Within 100,000 deg/s^2.
        reachable_deceleration: board.stop.quick_stop_deceleration_deg_s2.unsigned_abs() * 1000,
        max_velocity: (profile.max_velocity_mdeg_s).min(profile.max_motor_speed_mdeg_s),
        max_torque: (values.limits.max_torque_permille).min(values.limits.max_current_permille),
        torque_slope: profile.torque_slope_permille_s,
        profile_velocity: profile.profile_velocity_mdeg_s,
        acceleration: (profile.acceleration_mdeg_s2)
            .min(profile.max_acceleration_mdeg_s2)
            .min(most),
        deceleration: (profile.deceleration_mdeg_s2)
            .min(profile.max_deceleration_mdeg_s2)
            .min(most),
        smoothing,
        relative_to: match profile.positioning_option {
            1 => RelativeTo::Demand,
            2 => RelativeTo::Actual,
            _ => RelativeTo::Target,
        },
        homing: homing(values),
        quick_stop_deceleration: (profile.quick_stop_deceleration_mdeg_s2)
            .min(profile.max_deceleration_mdeg_s2),
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

/// 607Dh in the direction of the encoder.
fn position_limits(values: &ObjectValues) -> (i32, i32) {
    let (low, high) = (
        values.profile.min_position_mdeg,
        values.profile.max_position_mdeg,
    );
    if Polarity::of(values).position < 0 {
        (high.saturating_neg(), low.saturating_neg())
    } else {
        (low, high)
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
