//! What is known of each fault: condition, reaction, times.

use super::{Fault, FaultSet};
use crate::{
    parameters::BoardParameters,
    timing::{CONTROL_PERIOD_MS, periods},
};

/// What the board does when it latches a fault.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reaction {
    /// All switches open from the next PWM edge on: the motor coasts.
    Coast,
    /// The shaft is brought to rest by the quick-stop ramp, then all switches open.
    QuickStop,
}

/// When a condition is a fault; at other times it blocks the way to the enabled state.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Watched {
    /// While the bridge is driven.
    Driven,
    /// While the shaft follows a command.
    Following,
    /// Always.
    Always,
    /// Once, when the board starts.
    Start,
}

/// What is known of a fault; texts are for documents and tools, a board carries none of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Description {
    /// The fault.
    pub fault: Fault,
    /// Its name.
    pub name: &'static str,
    /// When it is latched.
    pub condition: &'static str,
    /// In which states.
    pub watched: Watched,
    /// Error code of CiA 402, object 0x603F.
    pub error_code: u16,
}

/// Faults that are latched whether the board drives or not.
pub const ALWAYS: FaultSet = FaultSet::of(&[
    Fault::BridgeTripped,
    Fault::LoopOverrun,
    Fault::ParametersCorrupt,
    Fault::WatchdogReset,
]);

/// Faults of the way from a command to the shaft: one that is being brought to rest follows none.
pub const OF_COMMANDS: FaultSet =
    FaultSet::of(&[Fault::FollowingError, Fault::CommandTimeout, Fault::BusOff]);

/// PWM period, after which a decision takes effect.
const PWM_PERIOD_MS: u32 = 1;

impl Fault {
    /// What the board does when it latches this fault while it drives.
    pub const fn reaction(self) -> Reaction {
        match self {
            // Angle, current and motor are known and well: they can bring the shaft to rest. Behind
            // a following error the sense of the encoder may be wrong, and a ramp would drive on.
            Self::MagnetWeak | Self::OverTemperature | Self::CommandTimeout | Self::BusOff => {
                Reaction::QuickStop
            }
            _ => Reaction::Coast,
        }
    }

    /// Time from the moment in which its condition holds to the control step that latches it, ms;
    /// at the most, and for [`Fault::Overload`] at twice the continuous current from cold.
    ///
    /// ```
    /// use firmware::{faults::Fault, parameters::BoardParameters};
    /// assert_eq!(Fault::EncoderInvalid.detected_ms(&BoardParameters::DEFAULT), 16);
    /// ```
    pub const fn detected_ms(self, p: &BoardParameters) -> u32 {
        let periods: i32 = match self {
            Self::EncoderInvalid | Self::MagnetLost | Self::EncoderJump => {
                p.encoder.lost_samples + 1
            }
            Self::MagnetWeak => periods(p.encoder.magnet_weak_ms) as i32,
            Self::EncoderStuck => periods(p.encoder.stuck_ms) as i32,
            Self::OverCurrent => p.current.over_current_samples,
            Self::Overload => periods(p.current.overload_ms) as i32,
            Self::Stall => periods(p.stall.stall_ms) as i32,
            // The commanded rate that is compared is that of the control period before.
            Self::FollowingError => periods(p.following.following_ms) as i32 + 1,
            Self::UnderVoltage | Self::OverVoltage => periods(p.supply.supply_ms) as i32,
            Self::OverTemperature => periods(p.temperature.over_temperature_ms) as i32,
            Self::MeasurementLost => periods(p.timing.measurement_ms) as i32,
            Self::CommandTimeout => periods(p.command.command_timeout_ms) as i32 + 1,
            // With the first control period that sees it.
            Self::BridgeTripped
            | Self::LoopOverrun
            | Self::ParametersCorrupt
            | Self::BusOff
            | Self::WatchdogReset => 1,
        };
        (periods * CONTROL_PERIOD_MS) as u32
    }

    /// Time from the moment in which its condition holds to the safe state, all switches open, ms;
    /// at the most.
    ///
    /// ```
    /// use firmware::{faults::Fault, parameters::BoardParameters};
    /// assert_eq!(Fault::EncoderInvalid.safe_ms(&BoardParameters::DEFAULT), 17);
    /// assert_eq!(Fault::BusOff.safe_ms(&BoardParameters::DEFAULT), 4 + 500 + 1);
    /// ```
    pub const fn safe_ms(self, p: &BoardParameters) -> u32 {
        let stop_ms = match self.reaction() {
            Reaction::Coast => 0,
            Reaction::QuickStop => periods(p.stop.quick_stop_ms) as u32 * CONTROL_PERIOD_MS as u32,
        };
        self.detected_ms(p) + stop_ms + PWM_PERIOD_MS
    }
}

/// Every fault.
pub const TABLE: [Description; 19] = {
    use Watched::{Always, Driven, Following, Start};
    const fn row(
        fault: Fault,
        name: &'static str,
        condition: &'static str,
        watched: Watched,
        error_code: u16,
    ) -> Description {
        Description {
            fault,
            name,
            condition,
            watched,
            error_code,
        }
    }
    [
        row(
            Fault::EncoderInvalid,
            "encoder invalid",
            "more than `lost_samples` words in a row missing, of odd parity or with OCF clear",
            Driven,
            0x7305,
        ),
        row(
            Fault::MagnetLost,
            "magnet lost",
            "more than `lost_samples` words in a row lost, the last with COF or LIN set",
            Driven,
            0x7306,
        ),
        row(
            Fault::MagnetWeak,
            "magnet weak",
            "MagINC and MagDEC both set for `magnet_weak_ms`",
            Driven,
            0x7306,
        ),
        row(
            Fault::EncoderStuck,
            "encoder stuck",
            "no count travelled for `stuck_ms` although the back-EMF is `stuck_back_emf_mv` or more, or the duty \
             `stuck_duty_pct` or more at less than `stuck_current_ma`; a motor that is not connected looks the same",
            Driven,
            0x7305,
        ),
        row(
            Fault::EncoderJump,
            "encoder jump",
            "more than `lost_samples` words in a row lost, the last further away than `greatest_rate_deg_s` allows",
            Driven,
            0x7305,
        ),
        row(
            Fault::OverCurrent,
            "over-current",
            "`over_current_samples` in a row above `over_current_ma`",
            Driven,
            0x2310,
        ),
        row(
            Fault::Overload,
            "overload",
            "I2t: heat of twice `continuous_ma` for `overload_ms`",
            Driven,
            0x2350,
        ),
        row(
            Fault::BridgeTripped,
            "bridge tripped",
            "the break input has opened all switches, within a microsecond and without the program",
            Always,
            0x2340,
        ),
        row(
            Fault::Stall,
            "stall",
            "`stall_current_ma` or more for `stall_ms` on a way of `stall_way_mdeg` or less",
            Driven,
            0x7121,
        ),
        row(
            Fault::FollowingError,
            "following error",
            "off by more than `following_window_mdeg`, and nearing by less than `following_rate_deg_s` and half the \
             commanded rate, for `following_ms`",
            Following,
            0x8611,
        ),
        row(
            Fault::UnderVoltage,
            "under-voltage",
            "supply below `under_voltage_mv` for `supply_ms`",
            Driven,
            0x3220,
        ),
        row(
            Fault::OverVoltage,
            "over-voltage",
            "supply above `over_voltage_mv` for `supply_ms`",
            Driven,
            0x3210,
        ),
        row(
            Fault::OverTemperature,
            "over-temperature",
            "board above `over_temperature_mdeg_c` for `over_temperature_ms`",
            Driven,
            0x4210,
        ),
        row(
            Fault::MeasurementLost,
            "measurement lost",
            "current, scan or a temperature within -46 and 160 deg C missing for `measurement_ms`",
            Driven,
            0x5210,
        ),
        row(
            Fault::CommandTimeout,
            "command timeout",
            "no command of the source for more than `command_timeout_ms`",
            Following,
            0x8130,
        ),
        row(
            Fault::LoopOverrun,
            "loop overrun",
            "more than `overruns` control periods missed; each second without one cancels one",
            Always,
            0x6100,
        ),
        row(
            Fault::ParametersCorrupt,
            "parameters corrupt",
            "the flash holds something, but no valid set; the defaults serve",
            Start,
            0x6320,
        ),
        row(
            Fault::BusOff,
            "bus off",
            "the CAN controller has left the bus that commands",
            Following,
            0x8140,
        ),
        row(
            Fault::WatchdogReset,
            "watchdog reset",
            "the watchdog has reset the board",
            Start,
            0x6010,
        ),
    ]
};
