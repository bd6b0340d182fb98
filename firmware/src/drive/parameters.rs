//! The axis' parameters out of the objects.

use canopen::cia402::{Deceleration, Options, Parameters, QuickStop, StopOption};

use super::kept::{Kept, Slot};
use crate::{parameters::BoardParameters, timing::CONTROL_PERIOD_MS};

/// Length of a control period, us.
pub(super) const PERIOD_US: u32 = CONTROL_PERIOD_MS as u32 * 1000;

/// All parameters of the axis, in mdeg.
pub(super) fn axis(kept: &Kept, board: &BoardParameters) -> Parameters {
    let limits = (
        kept.get(Slot::MinPosition) as i32,
        kept.get(Slot::MaxPosition) as i32,
    );
    let time_ms = |slot| kept.get(slot) as u16;
    Parameters {
        period_us: PERIOD_US,
        options: options(kept),
        position_limits: Some(limits),
        max_velocity: kept.get(Slot::MaxVelocity),
        profile_velocity: kept.get(Slot::ProfileVelocity),
        acceleration: kept.get(Slot::Acceleration),
        deceleration: kept.get(Slot::Deceleration),
        quick_stop_deceleration: kept.get(Slot::QuickStopDeceleration),
        interpolation_us: interpolation_us(kept),
        following_error_window: board.following.following_window_mdeg.unsigned_abs(),
        following_error_timeout_ms: board.following.following_ms as u16,
        position_window: kept.get(Slot::PositionWindow),
        position_window_time_ms: time_ms(Slot::PositionWindowTime),
        velocity_window: kept.get(Slot::VelocityWindow),
        velocity_window_time_ms: time_ms(Slot::VelocityWindowTime),
        velocity_threshold: kept.get(Slot::VelocityThreshold),
        velocity_threshold_time_ms: time_ms(Slot::VelocityThresholdTime),
    }
}

/// The dictionary lets no option pass that does not exist.
fn options(kept: &Kept) -> Options {
    let stop = |slot| {
        let code = kept.get(slot) as i16;
        StopOption::from_code(code).unwrap_or(StopOption::Disable)
    };
    let quick_stop = QuickStop::from_code(kept.get(Slot::QuickStopOption) as i16);
    Options {
        quick_stop: quick_stop.unwrap_or(QuickStop {
            stop: StopOption::Stop(Deceleration::QuickStop),
            remains_active: false,
        }),
        shutdown: stop(Slot::ShutdownOption),
        disable_operation: stop(Slot::DisableOption),
        halt: stop(Slot::HaltOption),
        fault_reaction: stop(Slot::FaultOption),
    }
}

/// 60C2h: so many times 10 to the power of the index, in seconds; the index is -6 to 0.
fn interpolation_us(kept: &Kept) -> u32 {
    let index = kept.get(Slot::InterpolationIndex) as i32;
    let zeros = index.saturating_add(6).clamp(0, 6).unsigned_abs();
    kept.get(Slot::InterpolationTime)
        .saturating_mul(10_u32.saturating_pow(zeros))
}
