//! Condition, reaction and times of each fault.

use super::{Fault, FaultSet};
use crate::{
    integrity::PROGRAM_CHECK_PERIODS,
    parameters::BoardParameters,
    protection::{
        plausibility::{CURRENT_IMPLAUSIBLE_PERIODS, MOTOR_POLARITY_PERIODS},
        travel::AT_20_DEG_S_PERIODS,
    },
    timing::{CONTROL_PERIOD_MS, periods},
};

/// Reaction to a fault when it is latched.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reaction {
    /// The drive is off from the next update period on.
    SwitchOff,
    /// The shaft is brought to rest by the quick-stop ramp, then the drive is off.
    QuickStop,
    /// The shaft is brought to rest by a duty that opposes the back-EMF, then the motor brakes.
    /// Where `brake_faults` excludes the fault, the drive is off at once.
    StopByBackEmf,
}

impl Reaction {
    /// What comes before the drive is off, in words; `None` if nothing does.
    pub const fn words(self) -> Option<&'static str> {
        match self {
            Self::SwitchOff => None,
            Self::QuickStop => Some("quick stop"),
            Self::StopByBackEmf => Some("stop by back-EMF"),
        }
    }
}

/// When a condition latches its fault; at other times it only prevents the enabled state.
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

impl Watched {
    /// The states in words.
    pub const fn words(self) -> &'static str {
        match self {
            Self::Driven => "driven",
            Self::Following => "enabled",
            Self::Always => "always",
            Self::Start => "at the start",
        }
    }
}

/// Description of a fault. The texts are for documents and tools; the board's program contains none
/// of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FaultDescription {
    /// The fault.
    pub fault: Fault,
    /// Its name.
    pub name: &'static str,
    /// Condition that latches it.
    pub condition: &'static str,
    /// States in which the condition is monitored.
    pub watched: Watched,
    /// Error code of CiA 402, object 0x603F.
    pub error_code: u16,
}

/// Faults that are latched in every state, also while the bridge is off.
pub const ALWAYS: FaultSet = FaultSet::of(&[
    Fault::BridgeTripped,
    Fault::LoopOverrun,
    Fault::ParametersCorrupt,
    Fault::WatchdogReset,
    Fault::DataCorrupt,
    Fault::ProgramCorrupt,
]);

/// Faults whose condition cannot end while the program runs: acknowledged, they are latched again.
pub const PERMANENT: FaultSet = FaultSet::of(&[Fault::ProgramCorrupt]);

/// Faults of following a command; they do not occur while the shaft is being brought to rest.
pub const OF_COMMANDS: FaultSet =
    FaultSet::of(&[Fault::FollowingError, Fault::CommandTimeout, Fault::BusOff]);

/// Faults after which the shaft can be held, with limited current.
pub const HOLDABLE: FaultSet = FaultSet::of(&[
    Fault::MagnetWeak,
    Fault::Overload,
    Fault::Stall,
    Fault::OverTemperature,
    Fault::CommandTimeout,
    Fault::BusOff,
]);

/// Control periods in which twice the rated current heats the winding of the default model from 25
/// to 120 deg C.
const OVERLOADED_PERIODS: i32 = 38_080 / CONTROL_PERIOD_MS;

/// Update period of the PWM at most, the delay until a new duty takes effect.
const PWM_PERIOD_MS: u32 = 1;

impl Fault {
    /// Reaction when this fault is latched while the bridge is driven.
    pub const fn reaction(self) -> Reaction {
        match self {
            // Encoder, current measurement and motor work, so the shaft can be brought to rest. A
            // following error may be caused by an inverted encoder, where a ramp would accelerate.
            Self::MagnetWeak
            | Self::Overload
            | Self::Stall
            | Self::OverTemperature
            | Self::CommandTimeout
            | Self::BusOff => Reaction::QuickStop,
            // The encoder is lost, the back-EMF is not.
            Self::EncoderInvalid
            | Self::MagnetLost
            | Self::EncoderStuck
            | Self::EncoderJump
            | Self::EncoderImplausible => Reaction::StopByBackEmf,
            _ => Reaction::SwitchOff,
        }
    }

    /// Maximum time from the start of the condition to the control step that latches the fault, ms;
    /// for [`Fault::Overload`] at twice the rated current, starting at 25 deg C, with the default
    /// model, for [`Fault::EncoderStuck`] and [`Fault::EncoderImplausible`] at a difference of 20
    /// deg/s, for [`Fault::MotorPolarity`] at 90 deg/s.
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
            Self::OverCurrent => p.current.over_current_samples,
            Self::Overload => OVERLOADED_PERIODS,
            Self::Stall => periods(p.stall.stall_ms) as i32,
            // It compares the commanded rate of the previous control period.
            Self::FollowingError => periods(p.following.following_ms) as i32 + 1,
            Self::UnderVoltage | Self::OverVoltage => periods(p.supply.supply_ms) as i32,
            Self::OverTemperature => periods(p.temperature.over_temperature_ms) as i32,
            Self::MeasurementLost => periods(p.timing.measurement_ms) as i32,
            // The duty that is compared is that of the control period before.
            Self::CurrentImplausible => CURRENT_IMPLAUSIBLE_PERIODS + 1,
            // At 90 deg/s the way, of which the first period has half, takes one more.
            Self::MotorPolarity => MOTOR_POLARITY_PERIODS + 1,
            Self::CommandTimeout => periods(p.command.command_timeout_ms) as i32 + 1,
            // The end of the pass after that in which it changed.
            Self::ProgramCorrupt => 2 * PROGRAM_CHECK_PERIODS as i32 + 1,
            Self::EncoderStuck | Self::EncoderImplausible => AT_20_DEG_S_PERIODS,
            // In the first control period with the condition.
            Self::BridgeTripped
            | Self::DataCorrupt
            | Self::LoopOverrun
            | Self::ParametersCorrupt
            | Self::BusOff
            | Self::WatchdogReset => 1,
        };
        (periods * CONTROL_PERIOD_MS) as u32
    }

    /// Time from the moment in which its condition holds to the moment from which the motor is no
    /// longer driven, ms; at the most.
    ///
    /// ```
    /// use firmware::{faults::Fault, parameters::BoardParameters};
    /// assert_eq!(Fault::EncoderInvalid.safe_ms(&BoardParameters::DEFAULT), 16 + 500 + 1);
    /// assert_eq!(Fault::LoopOverrun.safe_ms(&BoardParameters::DEFAULT), 5);
    /// assert_eq!(Fault::BusOff.safe_ms(&BoardParameters::DEFAULT), 4 + 500 + 1);
    /// ```
    pub const fn safe_ms(self, p: &BoardParameters) -> u32 {
        let stop_ms = match self.reaction() {
            Reaction::SwitchOff => 0,
            Reaction::QuickStop | Reaction::StopByBackEmf => {
                periods(p.stop.quick_stop_ms) as u32 * CONTROL_PERIOD_MS as u32
            }
        };
        self.detected_ms(p) + stop_ms + PWM_PERIOD_MS
    }
}

/// All faults in the order of their numbers.
pub const TABLE: [FaultDescription; 24] = {
    use Watched::{Always, Driven, Following, Start};
    const fn row(
        fault: Fault,
        name: &'static str,
        condition: &'static str,
        watched: Watched,
        error_code: u16,
    ) -> FaultDescription {
        FaultDescription {
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
            "more than `lost_samples` words, less the valid ones after them, missing, of odd parity or with OCF clear",
            Driven,
            0x7305,
        ),
        row(
            Fault::MagnetLost,
            "magnet lost",
            "the same, the last with COF or LIN set",
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
            "as encoder implausible, with no count travelled",
            Driven,
            0x7305,
        ),
        row(
            Fault::EncoderJump,
            "encoder jump",
            "the same, the last 1.9 deg or more from where the motor has turned the encoder",
            Driven,
            0x7305,
        ),
        row(
            Fault::OverCurrent,
            "over-current",
            "`over_current_samples` samples more in the on time above `over_current_ma` than below",
            Driven,
            0x2310,
        ),
        row(
            Fault::Overload,
            "overload",
            "the winding, by its thermal model, at `winding_mdeg_c` although the current decreases over the 15 K below it",
            Driven,
            0x2350,
        ),
        row(
            Fault::BridgeTripped,
            "bridge tripped",
            "the break input has opened all switches in hardware, within a microsecond",
            Always,
            0x2340,
        ),
        row(
            Fault::Stall,
            "stall",
            "mean current of `stall_current_ma` or more for `stall_ms` over a travel of `stall_way_mdeg` or less, or less than a \
             quarter of it in each sixth of that time",
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
            "no current, no scan, or no temperature within -46 to 160 deg C for `measurement_ms`; or no back-EMF for 100 ms of drive",
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
            "the flash is not blank, but has no valid parameters; the defaults are used",
            Start,
            0x6320,
        ),
        row(
            Fault::BusOff,
            "bus off",
            "the CAN controller is bus-off while the bus is the command source",
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
        row(
            Fault::CurrentImplausible,
            "current implausible",
            "for 60 ms, in sum, a sampled current below a third of the expected sample where that is 100 mA or more, or a mean \
             current 150 mA and 44 % of both parts beyond (duty x supply - back-EMF)/resistance: the current sense is wrong, or \
             the motor is not connected",
            Driven,
            0x5210,
        ),
        row(
            Fault::MotorPolarity,
            "motor polarity",
            "for 12 ms a back-EMF of `stuck_back_emf_mv` or more while the encoder turns the other way, by 2 deg or more in all; the time is that at 90 deg/s",
            Driven,
            0x7122,
        ),
        row(
            Fault::DataCorrupt,
            "data corrupt",
            "the two copies of the control loop differ, or a message to them differs from its check value",
            Always,
            0x5510,
        ),
        row(
            Fault::ProgramCorrupt,
            "program corrupt",
            "the CRC of the program's flash is not that of the program that was built; all of it is checked every \
             244 ms and at the start",
            Always,
            0x5520,
        ),
        row(
            Fault::EncoderImplausible,
            "encoder implausible",
            "the encoder's travel and the motor's, by the back-EMF, differ by 2.2 deg more than a share of it (45 % ahead, \
             25 % behind; 22 % around the error of the constant once a motion to and fro has shown it) and 1 deg/s; the \
             time is that of a drift of 20 deg/s",
            Driven,
            0x7320,
        ),
    ]
};
