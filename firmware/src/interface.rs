//! What goes into a control period and what comes out of it.

use model_core::{
    control::{
        cascade::ActiveLimits,
        compare::Compare,
        encoder_word::{EncoderWord, Magnet},
        units::{Angle, Percent, Rate},
    },
    sensors::adc::AdcCode,
};

use crate::{
    faults::{Fault, FaultSet},
    parameters::Parameter,
};

/// What was sampled for a control period.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Samples {
    /// The encoder's word; none where the transfer has not ended.
    pub encoder: Option<EncoderWord>,
    /// The motor current in the middle of the last on time; none where it was not converted.
    pub current: Option<AdcCode>,
    /// What was scanned in and before the last coast window; none where the scan has not ended.
    pub scan: Option<Scan>,
    /// Width of the servo pulse that ended since the last control period, us; none where none did.
    pub servo_pulse_us: Option<u16>,
    /// Whether the break input has switched the bridge off since the last control period.
    pub bridge_tripped: bool,
    /// Control periods that were missed since the last one.
    pub missed_periods: u8,
    /// State of the CAN controller: the worst since the last control period.
    pub bus: BusState,
}

/// What is scanned while all switches are open, and the supply before that.
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
    /// An encoder's word on a board that is otherwise at rest: no current, no back-EMF, 6 V, 25 deg C.
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
            servo_pulse_us: None,
            bridge_tripped: false,
            missed_periods: 0,
            bus: BusState::Active,
        }
    }
}

/// What the CAN controller may do (ISO 11898-1, fault confinement).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(u8)]
pub enum BusState {
    /// All.
    #[default]
    Active = 0,
    /// It may not disturb others any more.
    Passive = 1,
    /// It may not send any more.
    Off = 2,
}

/// The operating state; in brackets the name in CiA 402.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(u8)]
pub enum BoardState {
    /// Measurements have not settled yet, the bridge is off (not ready to switch on).
    #[default]
    Initialising = 0,
    /// The bridge is off (switch on disabled).
    Disabled = 1,
    /// The loop is closed (operation enabled).
    Enabled = 2,
    /// The shaft is brought to rest, or held there, on request (quick stop active).
    QuickStop = 3,
    /// The shaft is brought to rest because of a fault (fault reaction active).
    FaultReaction = 4,
    /// The bridge is off because of a fault (fault).
    Fault = 5,
}

impl BoardState {
    /// Whether the bridge is driven.
    pub const fn is_driving(self) -> bool {
        matches!(self, Self::Enabled | Self::QuickStop | Self::FaultReaction)
    }
}

/// Where the commanded angle comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(u8)]
pub enum CommandSource {
    /// [`Request::Command`].
    #[default]
    Bus = 0,
    /// The servo pulse.
    ServoPulse = 1,
    /// The excitation that runs on the board.
    Excitation = 2,
}

/// What the board is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Request {
    /// Close the loop; the angle is held until a command comes.
    Enable,
    /// Open the loop: the motor coasts.
    Disable,
    /// Bring the shaft to rest by the ramp, then open the loop or hold.
    QuickStop,
    /// Take note of the faults and go to [`BoardState::Disabled`].
    Acknowledge,
    /// Go to this angle.
    Command(Angle),
    /// Take commands from here from now on.
    Source(CommandSource),
    /// End the excitation; the command of the last period stays.
    StopExcitation,
}

/// Why a request was refused. Nothing was changed then.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Refused {
    /// The present state has no such transition.
    State(BoardState),
    /// This would be a fault at once.
    Blocked(Fault),
    /// Commands come from elsewhere.
    Source(CommandSource),
    /// These parameters change in [`BoardState::Disabled`] and [`BoardState::Fault`] only.
    NotWhileDriving,
    /// This parameter is out of its range or conflicts with another one.
    Parameter(Parameter),
}

/// What the bridge shall do from the next PWM edge on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Bridge {
    /// All switches open.
    Coast,
    /// Both low sides closed.
    Brake,
    /// Driven for this share of each PWM period, braked for the rest.
    Driven(Compare),
}

/// What a control period decided.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Outputs {
    /// For the bridge.
    pub bridge: Bridge,
    /// The operating state.
    pub state: BoardState,
    /// The fault with which the trouble began; none if nothing is latched.
    pub fault: Option<Fault>,
    /// What is known of the actuator.
    pub telemetry: Telemetry,
}

/// What is known of the actuator in a control period.
///
/// Where a measurement is missing the last one stays.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Telemetry {
    /// Number of the control period; wraps.
    pub tick: u32,
    /// The measured angle.
    pub angle: Angle,
    /// The estimated rate.
    pub rate: Rate,
    /// The commanded angle.
    pub command: Angle,
    /// The commanded rate.
    pub rate_command: Rate,
    /// The duty before the timer rounds it.
    pub duty: Percent,
    /// Motor current, mA.
    pub current_ma: i32,
    /// Back-EMF, mV.
    pub back_emf_mv: i32,
    /// Supply voltage, mV.
    pub supply_mv: i32,
    /// Temperature, thousandths of a degree Celsius.
    pub temperature_mdeg_c: i32,
    /// The last servo pulse, us; 0 before the first.
    pub servo_pulse_us: u16,
    /// Servo pulses since the reset whose width was none.
    pub servo_glitches: u32,
    /// Where the command came from.
    pub source: CommandSource,
    /// The limits that acted.
    pub limits: ActiveLimits,
    /// What the encoder said of its magnet.
    pub magnet: Magnet,
    /// The state of the CAN controller.
    pub bus: BusState,
    /// What is wrong at present, latched or not.
    pub present: FaultSet,
    /// What is latched.
    pub latched: FaultSet,
    /// Control periods missed since the reset.
    pub missed_periods: u32,
}
