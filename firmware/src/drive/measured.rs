//! Values that are computed when they are read.

use canopen::cia402::{Mode, controlword, statusword};

use super::{Drive, emergency};
use crate::{
    application::CommandSource,
    control_loop::{PERIOD_US, Polarity},
    dictionary::Measured,
    protection::Counter,
    supervisor::ResetCause,
    timing::{CONTROL_PERIOD_MS, thousandths},
};

/// Counters of object 2050h that only the program of the board can keep, and the serial number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Diagnostics {
    /// Longest control step, us.
    pub longest_step_us: u32,
    /// Frames with process data that were discarded because they had waited for the bus too long.
    pub transmit_overflows: u32,
    /// Frames from the bus that were lost.
    pub receive_overflows: u32,
    /// Number of bus-off events.
    pub bus_offs: u32,
    /// Cause of the last reset.
    pub reset_cause: ResetCause,
    /// Control periods in which the watchdog was not fed because a task was late.
    pub starved_periods: u32,
    /// Serial number, sub-index 4 of the identity.
    pub serial_number: u32,
}

/// A signed integer, extended to 64 bits.
pub(super) fn signed(value: i32) -> u64 {
    value as u64
}

/// A signed integer that saturates at 16 bits.
fn short(value: i32) -> u64 {
    signed(value.max(i32::from(i16::MIN)).min(i32::from(i16::MAX)))
}

/// An unsigned integer that saturates at 16 bits; 0 if it is not known.
fn magnitude(value: Option<i32>) -> u64 {
    let value = value.unwrap_or(0).max(0);
    value.min(i32::from(u16::MAX)) as u64
}

/// The bit of 60FDh of the servo pulse; bits 0 to 3 are switches, which the board does not have.
const SERVO_PULSE_INPUT: u32 = 16;

/// Counts of the encoder.
fn increments(mdeg: i32) -> i32 {
    let scaled = i64::from(mdeg) * 4096;
    ((scaled + 180_000).div_euclid(360_000)) as i32
}

/// The bits of a REAL32.
pub(super) fn real(value: f32) -> u64 {
    u64::from(value.to_bits())
}

impl Drive<'_> {
    /// The present value, as the server of the crate `canopen` expects it.
    pub(super) fn measured(&self, value: Measured) -> u64 {
        let (t, motion) = (&self.outputs.telemetry, &self.outputs.motion);
        let board = &self.diagnostics;
        let sign = || Polarity::of(&self.values);
        let position = |mdeg: i32| signed(mdeg.wrapping_mul(sign().position));
        let velocity = |mdeg_s: i32| signed(mdeg_s.wrapping_mul(sign().velocity));
        match value {
            Measured::PositionMdeg => signed(self.position_mdeg()),
            Measured::EncoderIncrements => signed(increments(thousandths(t.angle))),
            Measured::VelocityMdegS => velocity(t.velocity_mdeg_s),
            Measured::CompactAngle => short(self.position_mdeg() / 10),
            Measured::CompactRate => short(sign().velocity * (thousandths(t.rate) / 100)),
            Measured::RateCommandMdegS => velocity(thousandths(t.rate_command)),
            Measured::PositionDemandMdeg => position(motion.position_mdeg),
            Measured::VelocityDemandMdegS => velocity(motion.velocity_mdeg_s),
            Measured::FollowingErrorMdeg => position(motion.following_error_mdeg),
            Measured::TouchProbeStatus => u64::from(self.touch_probes.status()),
            Measured::TouchProbe1Positive => position(self.touch_probes.position(0, 0)),
            Measured::TouchProbe1Negative => position(self.touch_probes.position(0, 1)),
            Measured::TouchProbe2Positive => position(self.touch_probes.position(1, 0)),
            Measured::TouchProbe2Negative => position(self.touch_probes.position(1, 1)),
            Measured::BufferedPoints => self.points.waiting() as u64,
            Measured::DigitalInputs => {
                u64::from(t.pulse_age < self.pulse_timeout()) << SERVO_PULSE_INPUT
            }
            // Thousandths of a percent to hundredths.
            Measured::Duty => short(thousandths(t.duty) / 10),
            Measured::BackEmfMv => short(t.back_emf_mv),
            Measured::CurrentMa => short(t.current_ma),
            Measured::CurrentPermille => {
                short(sign().velocity * self.permille_of_rated_current(t.current_ma))
            }
            Measured::TorqueDemandPermille => {
                signed(sign().velocity * i32::from(motion.torque_permille))
            }
            // Within 100,000 times 20,000 mV: an i32.
            Measured::MotorVoltageMv => {
                short(thousandths(t.duty).saturating_mul(t.supply_mv) / 100_000)
            }
            Measured::SupplyMv => t.supply_mv.max(0) as u64,
            Measured::WindingTemperature => short((t.winding.get() * 10.0) as i32),
            Measured::RatedTorqueMnm => u64::from(self.rated_torque_mnm()),
            Measured::Temperature => short(t.temperature_mdeg_c / 100),
            Measured::SampleCounter => u64::from(t.tick as u16),
            Measured::SampleTimeUs => u64::from(t.tick.wrapping_mul(PERIOD_US)),
            Measured::Statusword => u64::from(self.statusword()),
            Measured::Mode => signed(i32::from(motion.mode as i8)),
            Measured::ErrorCode => u64::from(self.error_code()),
            Measured::PresentFaults => u64::from(t.present.bits()),
            Measured::LatchedFaults => u64::from(self.latched().bits()),
            Measured::PulseWidthUs => u64::from(t.servo_pulse_us),
            Measured::PulseIsPresent => u64::from(t.pulse_age < self.pulse_timeout()),
            Measured::PulseAgeMs => u64::from(t.pulse_age.saturating_mul(CONTROL_PERIOD_MS as u16)),
            Measured::PredictedAngleDeg => real(self.model.angle_deg()),
            Measured::PredictedRateDegS => real(self.model.rate_deg_s()),
            Measured::ResidualDeg => real(self.model.residual_deg()),
            Measured::ExcitationStatus => u64::from(self.is_exciting()),
            Measured::CaptureStatus => self.capture.phase() as u64,
            Measured::CapturedRecords => self.capture.count() as u64,
            Measured::RecordSize => self.capture.width() as u64 * 4,
            Measured::RecordPeriodUs => {
                u64::from(self.values.capture.decimation) * u64::from(PERIOD_US)
            }
            Measured::CaptureCapacity => self.capture.capacity() as u64,
            Measured::MissedPeriods => u64::from(t.missed_periods),
            Measured::LongestStepUs => u64::from(board.longest_step_us),
            Measured::TransmitOverflows => u64::from(board.transmit_overflows),
            Measured::ReceiveOverflows => u64::from(board.receive_overflows),
            Measured::BusOffCount => u64::from(board.bus_offs),
            Measured::ServoGlitches => u64::from(t.servo_glitches),
            Measured::ResetCause => board.reset_cause as u64,
            Measured::StarvedPeriods => u64::from(board.starved_periods),
            Measured::LostSamplesCounter => self.counter(Counter::LostSamples),
            Measured::MagnetWeakCounter => self.counter(Counter::MagnetWeak),
            Measured::OverCurrentCounter => self.counter(Counter::OverCurrent),
            Measured::StallCounter => self.counter(Counter::Stall),
            Measured::NotFollowingCounter => self.counter(Counter::NotFollowing),
            Measured::UnderVoltageCounter => self.counter(Counter::UnderVoltage),
            Measured::OverVoltageCounter => self.counter(Counter::OverVoltage),
            Measured::OverTemperatureCounter => self.counter(Counter::OverTemperature),
            Measured::UnmeasuredCounter => self.counter(Counter::Unmeasured),
            Measured::NoBackEmfCounter => self.counter(Counter::NoBackEmf),
            Measured::OverrunsCounter => self.counter(Counter::Overruns),
            Measured::CurrentImplausibleCounter => self.counter(Counter::CurrentImplausible),
            Measured::MotorPolarityCounter => self.counter(Counter::MotorPolarity),
            Measured::HealthFriction => magnitude(self.health.results().map(|it| it.friction)),
            Measured::HealthLoad => {
                short(sign().velocity * self.health.results().map_or(0, |it| it.load))
            }
            Measured::HealthConstant => self
                .health
                .results()
                .map_or(0, |it| it.constant.max(0) as u64),
            Measured::HealthSamples => u64::from(self.health.samples()),
            Measured::HealthWeakMagnet => self.health.weak() as u64,
            Measured::HealthFrictionChange => short(
                self.health
                    .friction_change(&self.values.health)
                    .unwrap_or(0),
            ),
            Measured::HealthConstantChange => short(
                self.health
                    .constant_change(&self.values.health)
                    .unwrap_or(0),
            ),
            Measured::HealthSupply => magnitude(self.health.supply()),
            Measured::HealthPlay => magnitude(self.health.play()),
            Measured::HealthFrictionError => magnitude(self.health.friction_error()),
            Measured::HealthConstantError => magnitude(self.health.constant_error()),
            Measured::HealthSupplyError => magnitude(self.health.supply_error()),
            Measured::HealthPlayError => magnitude(self.health.play_error()),
            Measured::HealthSupplyChange => {
                short(self.health.supply_change(&self.values.health).unwrap_or(0))
            }
            Measured::HealthPlayChange => {
                short(self.health.play_change(&self.values.health).unwrap_or(0))
            }
            Measured::HealthWarnings => u64::from(self.health.warnings()),
            Measured::SerialNumber => u64::from(board.serial_number),
            Measured::ProgramIdentity => u64::from(self.program_identity()),
            Measured::FlashStatus => u64::from(self.flash_status()),
            Measured::DownloadImage => u64::from(self.download().identity),
            Measured::DownloadBytes => u64::from(self.download().bytes),
            Measured::ServiceState => self.service.state(self.values.service.password) as u64,
            Measured::ServiceBackOffMs => u64::from(self.service.back_off_ms()),
        }
    }

    /// The counter as it was reported last.
    fn counter(&self, counter: Counter) -> u64 {
        u64::from(self.counters.get(counter as usize).copied().unwrap_or(0))
    }

    /// Position actual value 6064h.
    pub(super) fn position_mdeg(&self) -> i32 {
        let position = self.axis_position_mdeg();
        position.wrapping_mul(Polarity::of(&self.values).position)
    }

    /// The position as the axis counts it: from its origin, without the polarity 607Eh.
    pub(super) fn axis_position_mdeg(&self) -> i32 {
        let (t, motion) = (&self.outputs.telemetry, &self.outputs.motion);
        thousandths(t.angle).saturating_add(motion.origin_mdeg)
    }

    /// The statusword: "remote" while the bus commands the shaft, and homing in progress as soon as
    /// its start is queued, whatever was attained before.
    pub(super) fn statusword(&self) -> u16 {
        let motion = &self.outputs.motion;
        let mut cleared = 0;
        if motion.mode == Mode::Homing && self.is_homing_requested() {
            cleared = statusword::TARGET_REACHED | statusword::MODE_12 | statusword::HOMING_ERROR;
        }
        if self.outputs.telemetry.selected_source != CommandSource::Bus {
            cleared |= statusword::REMOTE;
        }
        motion.status & !cleared
    }

    /// Whether a start of homing is queued that the loop has not taken.
    fn is_homing_requested(&self) -> bool {
        let commands = self.messages.commands.unverified();
        let taken = commands.at(self.outputs.taken.command);
        let starts = |control: u16| control & controlword::START_HOMING != 0;
        starts(commands.newest().control) && !starts(taken.control)
    }

    /// Control periods without a servo pulse after which the pulse counts as absent.
    fn pulse_timeout(&self) -> u16 {
        let timeout_ms = self.parameters().command.command_timeout_ms;
        crate::timing::periods(timeout_ms.max(100))
    }

    /// The error code of the fault that was latched first.
    pub(super) fn error_code(&self) -> u16 {
        let first = self.outputs.fault;
        first.map_or(0, |fault| emergency::code(fault).0)
    }

    /// Torque of the rated current at the output.
    fn rated_torque_mnm(&self) -> u32 {
        let model = &self.values.model;
        let rated_ma = self.parameters().current.rated_ma as f32;
        // mA times N m/A; saturates.
        (rated_ma * model.torque_constant_nm_a * model.gear_ratio) as u32
    }

    /// In thousandths.
    pub(super) fn permille_of_rated_current(&self, current_ma: i32) -> i32 {
        let rated_ma = self.parameters().current.rated_ma;
        // Within 1650 times 1000.
        let share = current_ma.saturating_mul(1000).checked_div(rated_ma);
        share.unwrap_or(0)
    }
}
