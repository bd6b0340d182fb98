//! Inputs and outputs of a control period, requests and operating states: the types that the
//! application shares with its parts and its users.

use canopen::cia402::{Cia402State, Mode};
use model_core::{
    control::{
        cascade::{ActiveLimits, Setpoint},
        encoder_correction::EncoderCorrection,
        encoder_word::{EncoderWord, Magnet},
        pwm_timer::PwmCompare,
        units::{Angle, Percent, Rate},
    },
    sensors::adc::AdcCode,
    time::CONTROL_PERIODS_PER_WINDOW,
};

use crate::{
    application::{DeadBandSettings, MotorLimits},
    faults::{Fault, FaultSet},
    measure::{MotorConstants, Single},
    parameters::{BoardParameters, CommandSettings, Parameter},
};

/// The samples of a control period.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Samples {
    /// The encoder's word; `None` if the transfer has not ended.
    pub encoder: Option<EncoderWord>,
    /// The motor current in the middle of the last on time; `None` if it was not converted.
    pub current: Option<AdcCode>,
    /// The scan in and before the last coast window; `None` if it has not ended.
    pub scan: Option<Scan>,
    /// Whether that window was before an earlier control period.
    pub holds_scan: bool,
    /// Width of the servo pulse that ended since the last control period, us.
    pub servo_pulse_us: Option<u16>,
    /// Whether the break input has switched the bridge off since the last control period.
    pub bridge_tripped: bool,
    /// Control periods that were missed since the last one.
    pub missed_periods: u8,
    /// The worst state of the CAN controller since the last control period.
    pub bus: BusState,
}

/// Conversions while all switches are open, and of the supply before that.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Scan {
    /// Leg A of the motor.
    pub leg_a: AdcCode,
    /// Leg B of the motor.
    pub leg_b: AdcCode,
    /// The supply voltage in the middle of the last on time, under load.
    pub supply: AdcCode,
    /// The NTC.
    pub temperature: AdcCode,
}

impl Samples {
    /// Whether the scan is held: with a window in each control period it never is.
    pub const fn is_scan_held(&self) -> bool {
        CONTROL_PERIODS_PER_WINDOW > 1 && self.holds_scan
    }

    /// An encoder word and otherwise a board at rest: no current, no back-EMF, 6 V, 25 deg C.
    ///
    /// ```
    /// use firmware::{application::Samples, measure::supply_mv};
    /// use model_core::control::encoder_word::EncoderWord;
    /// let samples = Samples::at_rest(EncoderWord::new(0));
    /// assert_eq!(supply_mv(samples.scan.unwrap().supply), 5998);
    /// ```
    pub const fn at_rest(encoder: EncoderWord) -> Self {
        Self {
            encoder: Some(encoder),
            current: Some(AdcCode::new(2048)),
            scan: Some(Scan {
                leg_a: AdcCode::new(1241),
                leg_b: AdcCode::new(1241),
                supply: AdcCode::new(1489),
                temperature: AdcCode::new(2048),
            }),
            holds_scan: false,
            servo_pulse_us: None,
            bridge_tripped: false,
            missed_periods: 0,
            bus: BusState::Active,
        }
    }
}

/// What the application is configured by, apart from its state.
#[derive(Debug, Clone, Copy)]
pub struct Settings<'a> {
    /// The parameters of the board, checked.
    pub board: &'a BoardParameters,
    /// The constants of the motor.
    pub motor: &'a MotorConstants,
    /// The limits of current and temperature.
    pub limits: &'a MotorLimits,
    /// When a shaft rests.
    pub dead_band: &'a DeadBandSettings,
    /// The error of the encoder.
    pub encoder: &'a EncoderCorrection,
    /// Whether the rate of the control law changes with the back-EMF.
    pub observes_rate: bool,
}

/// State of the CAN controller (ISO 11898-1, fault confinement).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash)]
#[repr(u8)]
pub enum BusState {
    /// Error active.
    #[default]
    Active = 0,
    /// Error passive.
    Passive = 1,
    /// Bus off.
    Off = 2,
}

/// The operating state; in brackets the name in CiA 402.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash)]
#[repr(u8)]
pub enum BoardState {
    /// Measurements have not settled yet, or the shaft has not come to rest; the motor brakes (not
    /// ready to switch on).
    #[default]
    Initialising = 0,
    /// The bridge is off (switch on disabled).
    Disabled = 1,
    /// The loop is closed (operation enabled).
    Enabled = 2,
    /// The shaft is decelerated, or held at rest, on request (quick stop active).
    QuickStop = 3,
    /// The shaft is decelerated because of a fault (fault reaction active).
    FaultReaction = 4,
    /// The motor brakes or coasts because of a fault (fault).
    Fault = 5,
    /// The shaft is held with limited current because of a fault (fault).
    FaultHold = 6,
}

impl BoardState {
    /// Whether the loop is closed, or the shaft is decelerated to rest or held there.
    pub const fn is_driving(self) -> bool {
        matches!(
            self,
            Self::Enabled | Self::QuickStop | Self::FaultReaction | Self::FaultHold
        )
    }
}

/// Source of the setpoints.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash)]
#[repr(u8)]
pub enum CommandSource {
    /// The bus: [`Request::Command`].
    #[default]
    Bus = 0,
    /// The servo pulse.
    ServoPulse = 1,
    /// The excitation that runs on the board.
    Excitation = 2,
}

impl CommandSource {
    /// The source that is selected at the start.
    pub(crate) fn of(settings: &CommandSettings) -> Self {
        if settings.command_source == 1 {
            Self::ServoPulse
        } else {
            Self::Bus
        }
    }
}

/// A request to the application.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Request {
    /// Close the loop; the angle is held until the first command.
    Enable,
    /// Open the loop: the motor coasts.
    Disable,
    /// Decelerate the shaft by the ramp, then open the loop or hold.
    QuickStop,
    /// Acknowledge the faults and go to [`BoardState::Disabled`].
    Acknowledge,
    /// Follow this angle or rate.
    Command(Setpoint),
    /// Apply this torque.
    Torque(TorqueSetpoint),
    /// Select this source of commands.
    Source(CommandSource),
    /// End the excitation; the last command remains.
    StopExcitation,
}

/// A torque, and the rates between which it acts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TorqueSetpoint {
    /// In thousandths of the rated torque.
    pub permille: i16,
    /// Least and greatest rate, mdeg/s: beyond them the motor brakes.
    pub rates_mdeg_s: (i32, i32),
}

/// Reason why a request was refused, without effect.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Refused {
    /// The state has no such transition.
    State(BoardState),
    /// This fault is present.
    Blocked(Fault),
    /// Commands come from this source.
    Source(CommandSource),
    /// These parameters change in [`BoardState::Disabled`] and [`BoardState::Fault`] only.
    NotWhileDriving,
    /// This parameter is out of its range or conflicts with another one.
    Parameter(Parameter),
}

/// The command to the bridge, effective from the next update.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Bridge {
    /// All switches open.
    #[default]
    Coast,
    /// Both low sides closed.
    Brake,
    /// Driven for this share of each PWM period, braked for the rest.
    Driven(PwmCompare),
}

/// The outputs of a control period.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct Outputs {
    /// The command to the bridge.
    pub bridge: Bridge,
    /// The operating state.
    pub state: BoardState,
    /// The first fault that was latched.
    pub fault: Option<Fault>,
    /// Measurements and state.
    pub telemetry: Telemetry,
    /// State of the axis.
    pub motion: Motion,
    /// What was taken from the mailboxes.
    pub taken: Taken,
}

/// State of the axis in a control period.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Motion {
    /// State of the power drive system.
    pub state: Cia402State,
    /// Status bits of the power drive system (IEC 61800-7-201): [`canopen::cia402::statusword`].
    pub status: u16,
    /// The mode of operation.
    pub mode: Mode,
    /// The demanded position, mdeg; the measured one while a velocity is demanded.
    pub position_mdeg: i32,
    /// The demanded velocity, mdeg/s.
    pub velocity_mdeg_s: i32,
    /// The demanded torque in thousandths of the rated torque; 0 in other modes than those of
    /// torque.
    pub torque_permille: i16,
    /// The demanded position minus the measured one, mdeg; 0 in velocity modes.
    pub following_error_mdeg: i32,
    /// The position at which the encoder is at 0, mdeg.
    pub origin_mdeg: i32,
    /// The axis demands power.
    pub is_powered: bool,
    /// The control bits have the fault reset.
    pub resets: bool,
}

impl Default for Motion {
    fn default() -> Self {
        Self {
            state: Cia402State::NotReadyToSwitchOn,
            status: 0,
            mode: Mode::CyclicPosition,
            position_mdeg: 0,
            velocity_mdeg_s: 0,
            torque_permille: 0,
            following_error_mdeg: 0,
            origin_mdeg: 0,
            is_powered: false,
            resets: false,
        }
    }
}

/// Numbers of the messages that the control loop has taken from its mailboxes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct Taken {
    /// The command.
    pub command: u32,
    /// The set of parameters.
    pub parameters: u32,
    /// The request of an excitation.
    pub excitation: u8,
    /// The request of a source.
    pub source: u8,
    /// The report of the network.
    pub network_loss: u8,
    /// The restart.
    pub restarts: u8,
    /// The tick of the excitation whose sample the next control period needs.
    pub sample_due: Option<u64>,
}

/// Measurements and state in a control period. Without a new measurement the last one remains.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash)]
pub struct Telemetry {
    /// Number of the control period; wraps.
    pub tick: u32,
    /// The measured angle; 0 while it is unknown, from a fault of the encoder to the next valid
    /// word.
    pub angle: Angle,
    /// The estimated rate.
    pub rate: Rate,
    /// The commanded angle; the measured one while a rate is commanded.
    pub command: Angle,
    /// The commanded rate.
    pub rate_command: Rate,
    /// The duty before the timer rounds it.
    pub duty: Percent,
    /// Motor current, mA.
    pub current_ma: i32,
    /// The sample of the motor current in the on time, near its peak, mA.
    pub sampled_ma: i32,
    /// Back-EMF, mV.
    pub back_emf_mv: i32,
    /// Supply voltage, mV.
    pub supply_mv: i32,
    /// Temperature, thousandths of a degree Celsius.
    pub temperature_mdeg_c: i32,
    /// Temperature of the winding by its thermal model, deg C.
    pub winding: Single,
    /// The velocity that is reported, mdeg/s.
    pub velocity_mdeg_s: i32,
    /// The last servo pulse, us; 0 before the first.
    pub servo_pulse_us: u16,
    /// Control periods since the last servo pulse.
    pub pulse_age: u16,
    /// Servo pulses of invalid width since the reset.
    pub servo_glitches: u32,
    /// The protection's counter [of this tick](crate::protection::Counter::of_tick).
    pub counter: u16,
    /// The source of the setpoint.
    pub source: CommandSource,
    /// The source of the setpoint while no excitation runs.
    pub selected_source: CommandSource,
    /// The limits that acted.
    pub limits: ActiveLimits,
    /// The encoder's magnet status.
    pub magnet: Magnet,
    /// The state of the CAN controller.
    pub bus: BusState,
    /// The faults that are present, latched or not.
    pub present: FaultSet,
    /// The latched faults.
    pub latched: FaultSet,
    /// Control periods missed since the reset.
    pub missed_periods: u32,
}
