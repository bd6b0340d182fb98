// Generated from object-dictionary.csv by `cargo run -p canopen-generator`; do not edit.

use super::CONTROL_DEFAULT;
use model_core::control::cascade::Coefficients;

/// Source of the commands, and how long a command is valid.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct CommandSettings {
    /// Source of the commands: 0 the bus; 1 the servo pulse; at standstill also the source after a
    /// reset. Default: 0 (the bus). Range: 0 to 1. Object 2000h Command source.
    pub command_source: i32,
    /// Time after which a command is stale; 0 disables the check. Unit: ms. Default: 100 (five
    /// periods of a 50 Hz host). Range: 0 to 60000. Object 2040h:01 Failsafe: Command timeout.
    pub command_timeout_ms: i32,
    /// Rate limit while the command changes over to another source. Unit: deg/s. Default: 60 (a
    /// quarter of the full rate). Range: 1 to 2000. Object 2040h:04 Failsafe: Approach rate.
    pub approach_rate_deg_s: i32,
}

impl CommandSettings {
    /// The defaults.
    pub const DEFAULT: Self = Self {
        command_source: 0,
        command_timeout_ms: 100,
        approach_rate_deg_s: 60,
    };
}

/// Angle of a servo pulse.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct ServoSettings {
    /// Pulse width of the smallest angle. Unit: us. Default: 1000 (usual for radio control). Range:
    /// 500 to 2500. Object 2001h:04 RC PWM input: Pulse minimum.
    pub pulse_min_us: i32,
    /// Pulse width of angle zero. Unit: us. Default: 1500 (usual for radio control). Range: 500 to
    /// 2500. Object 2001h:05 RC PWM input: Pulse centre.
    pub pulse_centre_us: i32,
    /// Pulse width of the largest angle. Unit: us. Default: 2000 (usual for radio control). Range:
    /// 500 to 2500. Object 2001h:06 RC PWM input: Pulse maximum.
    pub pulse_max_us: i32,
    /// A pulse beyond an end by up to this margin is clamped to the end; a pulse further off is
    /// invalid. Unit: us. Default: 200 (trims of transmitters). Range: 0 to 500. Object 2001h:07 RC
    /// PWM input: Pulse margin.
    pub pulse_margin_us: i32,
    /// Angle at the longest pulse; the shortest pulse gives the opposite angle. Unit: mdeg.
    /// Default: 60000 (usual travel of a servo). Range: -180000 to 180000. Object 2001h:08 RC PWM
    /// input: Travel per half range.
    pub pulse_travel_mdeg: i32,
}

impl ServoSettings {
    /// The defaults.
    pub const DEFAULT: Self = Self {
        pulse_min_us: 1000,
        pulse_centre_us: 1500,
        pulse_max_us: 2000,
        pulse_margin_us: 200,
        pulse_travel_mdeg: 60000,
    };
}

/// Protection: the encoder.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct EncoderLimits {
    /// Consecutive lost samples that are tolerated before the bridge is switched off. Default: 3
    /// (17 ms from the last valid angle until the bridge is off). Range: 0 to 50. Object 2100h:01
    /// Protection: Lost samples.
    pub lost_samples: i32,
    /// Largest rate that a valid angle can show. Unit: deg/s. Default: 1500 (four times the
    /// measured 350 deg/s). Range: 100 to 40000. Object 2100h:02 Protection: Greatest rate.
    pub greatest_rate_deg_s: i32,
    /// Time for which the magnetic field may be outside its range. Unit: ms. Default: 1000
    /// (tolerates knocks and bending). Range: 4 to 60000. Object 2100h:03 Protection: Magnet weak
    /// time.
    pub magnet_weak_ms: i32,
    /// Back-EMF that proves a turning motor while the encoder does not change. Unit: mV. Default:
    /// 800 (40 deg/s: two counts a control period). Range: 100 to 20000. Object 2100h:04
    /// Protection: Stuck back-EMF.
    pub stuck_back_emf_mv: i32,
    /// Duty at which the motor must turn unless it draws current. Unit: %. Default: 50 (far above
    /// what friction needs). Range: 5 to 100. Object 2100h:05 Protection: Stuck duty.
    pub stuck_duty_pct: i32,
    /// Mean motor current from which the shaft may be blocked at this duty. Unit: mA. Default: 100
    /// (a quarter of the mean current of 390 mA at 50 % duty and standstill). Range: 10 to 2800.
    /// Object 2100h:06 Protection: Stuck current.
    pub stuck_current_ma: i32,
    /// Time for which the encoder may then stay unchanged. Unit: ms. Default: 100 (25 control
    /// periods). Range: 12 to 10000. Object 2100h:07 Protection: Stuck time.
    pub stuck_ms: i32,
}

impl EncoderLimits {
    /// The defaults.
    pub const DEFAULT: Self = Self {
        lost_samples: 3,
        greatest_rate_deg_s: 1500,
        magnet_weak_ms: 1000,
        stuck_back_emf_mv: 800,
        stuck_duty_pct: 50,
        stuck_current_ma: 100,
        stuck_ms: 100,
    };
}

/// Protection: the motor current.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct CurrentLimits {
    /// Largest sampled motor current. Unit: mA. Default: 1600 (a reversal at full rate takes (6 V +
    /// 5.7 V)/7.7 ohm = 1520 mA; the amplifier saturates at 2900 mA). Range: 100 to 2800. Object
    /// 2100h:08 Protection: Over-current.
    pub over_current_ma: i32,
    /// Consecutive samples above it that trip. Default: 2 (one sample may be noise). Range: 1 to
    /// 25. Object 2100h:09 Protection: Over-current samples.
    pub over_current_samples: i32,
    /// Root mean square of the current that the motor tolerates continuously. Unit: mA. Default:
    /// 500 (estimate: two thirds of the stall current of 780 mA). Range: 50 to 1600. Object
    /// 2100h:0A Protection: Continuous current.
    pub continuous_ma: i32,
    /// Time for which the motor tolerates twice that current from cold. Unit: ms. Default: 2000
    /// (estimate: winding of a small motor). Range: 20 to 60000. Object 2100h:0B Protection:
    /// Overload time.
    pub overload_ms: i32,
}

impl CurrentLimits {
    /// The defaults.
    pub const DEFAULT: Self = Self {
        over_current_ma: 1600,
        over_current_samples: 2,
        continuous_ma: 500,
        overload_ms: 2000,
    };
}

/// Protection: stall.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct StallLimits {
    /// Mean motor current above which a shaft that does not turn counts as stalled. Unit: mA.
    /// Default: 500 (two thirds of the stall current of 780 mA: 0.58 N m at the output). Range: 20
    /// to 2800. Object 2100h:0C Protection: Stall current.
    pub stall_current_ma: i32,
    /// Travel within which the shaft counts as standing. Unit: mdeg. Default: 1000 (eleven counts:
    /// 2 deg/s). Range: 100 to 90000. Object 2100h:0D Protection: Stall way.
    pub stall_way_mdeg: i32,
    /// Time for which it may stand. Unit: ms. Default: 500 (breaking loose takes less). Range: 20
    /// to 60000. Object 2100h:0E Protection: Stall time.
    pub stall_ms: i32,
}

impl StallLimits {
    /// The defaults.
    pub const DEFAULT: Self = Self {
        stall_current_ma: 500,
        stall_way_mdeg: 1000,
        stall_ms: 500,
    };
}

/// Protection: the following error.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct FollowingLimits {
    /// Position error that is tolerated. Unit: mdeg. Default: 10000 (half of what a rate of 160
    /// deg/s leaves at a gain of 8/s). Range: 100 to 360000. Object 2100h:0F Protection: Following
    /// window.
    pub following_window_mdeg: i32,
    /// Rate at which the error must shrink while it is larger. Unit: deg/s. Default: 20 (a twelfth
    /// of the full rate). Range: 1 to 2000. Object 2100h:10 Protection: Following rate.
    pub following_rate_deg_s: i32,
    /// Time for which it need not shrink. Unit: ms. Default: 300 (a reversal at full rate takes 150
    /// ms). Range: 4 to 60000. Object 2100h:11 Protection: Following time.
    pub following_ms: i32,
}

impl FollowingLimits {
    /// The defaults.
    pub const DEFAULT: Self = Self {
        following_window_mdeg: 10000,
        following_rate_deg_s: 20,
        following_ms: 300,
    };
}

/// Protection: the supply voltage.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct SupplyLimits {
    /// Lowest supply voltage to drive with. Unit: mV. Default: 4000 (below the 4.8 V that the servo
    /// is rated for). Range: 2500 to 16000. Object 2100h:12 Protection: Under-voltage.
    pub under_voltage_mv: i32,
    /// Highest supply voltage. Unit: mV. Default: 6300 (6 V plus 5 %: above it a reversal at full
    /// rate is an over-current). Range: 3000 to 16000. Object 2100h:13 Protection: Over-voltage.
    pub over_voltage_mv: i32,
    /// Time for which the voltage may be outside. Unit: ms. Default: 20 (a dip while the motor
    /// starts). Range: 4 to 10000. Object 2100h:14 Protection: Supply time.
    pub supply_ms: i32,
}

impl SupplyLimits {
    /// The defaults.
    pub const DEFAULT: Self = Self {
        under_voltage_mv: 4000,
        over_voltage_mv: 6300,
        supply_ms: 20,
    };
}

/// Protection: the temperature.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct TemperatureLimits {
    /// Highest temperature. Unit: mdegC. Default: 85000 (parts of the industrial range). Range:
    /// 30000 to 125000. Object 2100h:15 Protection: Over-temperature.
    pub over_temperature_mdeg_c: i32,
    /// Time for which it may be higher. Unit: ms. Default: 1000 (temperature changes slowly).
    /// Range: 4 to 60000. Object 2100h:16 Protection: Over-temperature time.
    pub over_temperature_ms: i32,
}

impl TemperatureLimits {
    /// The defaults.
    pub const DEFAULT: Self = Self {
        over_temperature_mdeg_c: 85000,
        over_temperature_ms: 1000,
    };
}

/// Protection: missed control periods and measurements.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct TimingLimits {
    /// Missed control periods that are tolerated; each second without one cancels one. Default: 3
    /// (three within a second). Range: 0 to 250. Object 2100h:17 Protection: Overruns.
    pub overruns: i32,
    /// Time for which a measurement may be missing. Unit: ms. Default: 20 (five control periods).
    /// Range: 4 to 1000. Object 2100h:18 Protection: Measurement time.
    pub measurement_ms: i32,
}

impl TimingLimits {
    /// The defaults.
    pub const DEFAULT: Self = Self {
        overruns: 3,
        measurement_ms: 20,
    };
}

/// Quick stop.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct StopSettings {
    /// Faults after which both low sides short the motor, bit n for fault n; after all others it
    /// coasts. Default: 16776894 (all but over-current and a tripped bridge: the braking current,
    /// at most 5.7 V/7.7 ohm = 740 mA, is within the limits of bridge and motor). Range: 0 to
    /// 16777214. Object 2100h:19 Protection: Brake faults.
    pub brake_faults: i32,
    /// Deceleration of a quick stop. Unit: deg/s^2. Default: 2000 (full duty against the motion
    /// gives 2150 deg/s^2 and more). Range: 50 to 100000. Object 2101h:01 Stop on a fault:
    /// Deceleration.
    pub quick_stop_deceleration_deg_s2: i32,
    /// Time after which a quick stop ends with the bridge off in any case. Unit: ms. Default: 500
    /// (350 deg/s at this deceleration take 175 ms). Range: 20 to 10000. Object 2101h:02 Stop on a
    /// fault: Longest time.
    pub quick_stop_ms: i32,
    /// After a requested quick stop: 0 the bridge is switched off; 1 the angle is held. Default: 0
    /// (CiA 402 quick stop option code 2). Range: 0 to 1. Object 2101h:03 Stop on a fault: Hold
    /// after a quick stop.
    pub quick_stop_hold: i32,
}

impl StopSettings {
    /// The defaults.
    pub const DEFAULT: Self = Self {
        brake_faults: 16776894,
        quick_stop_deceleration_deg_s2: 2000,
        quick_stop_ms: 500,
        quick_stop_hold: 0,
    };
}

/// The CAN bus.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct BusSettings {
    /// Node-ID. Default: 1 (CiA 301). Range: 1 to 127. Object 2102h:01 Bus: Node-ID.
    pub node_id: i32,
    /// Bit rate: 1000, 500, 250 or 125. Unit: kbit/s. Default: 1000 (the bit timings that the board
    /// configures). Range: 125 to 1000. Object 2102h:02 Bus: Bit rate.
    pub bit_rate_kbit_s: i32,
}

impl BusSettings {
    /// The defaults.
    pub const DEFAULT: Self = Self {
        node_id: 1,
        bit_rate_kbit_s: 1000,
    };
}

/// The motor model that runs beside the motor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModelSettings {
    /// Model selection. Default: 0. Range: 0 to 1. Object 2010h:02 Controller: Model selection.
    pub model_selection: u8,
    /// Armature resistance. Unit: Ohm. Default: 7.7. Range: 0.05 to 1000. Object 2011h:01 Model
    /// parameters: Armature resistance.
    pub resistance_ohm: f32,
    /// Torque constant. Unit: N m/A. Default: 0.00362. Range: 1e-05 to 1. Object 2011h:02 Model
    /// parameters: Torque constant.
    pub torque_constant_nm_a: f32,
    /// Gear ratio. Default: 320.0. Range: 1 to 2000. Object 2011h:03 Model parameters: Gear ratio.
    pub gear_ratio: f32,
    /// Inertia at the output. Unit: kg m^2. Default: 0.0232. Range: 1e-06 to 100. Object 2011h:04
    /// Model parameters: Inertia at the output.
    pub inertia_kg_m2: f32,
    /// Viscous friction. Unit: N m s/rad. Default: 0.002. Range: 0 to 10. Object 2011h:05 Model
    /// parameters: Viscous friction.
    pub viscous_friction_nm_s: f32,
    /// Coulomb friction. Unit: N m. Default: 0.03. Range: 0 to 10. Object 2011h:06 Model
    /// parameters: Coulomb friction.
    pub coulomb_friction_nm: f32,
    /// Correction time. Unit: s. Default: 1.0. Range: 0.02 to 1000. Object 2011h:07 Model
    /// parameters: Correction time.
    pub correction_time_s: f32,
    /// Armature inductance. Unit: H. Default: 0.001. Range: 1e-06 to 1. Object 2011h:08 Model
    /// parameters: Armature inductance.
    pub inductance_h: f32,
}

impl ModelSettings {
    /// The defaults.
    pub const DEFAULT: Self = Self {
        model_selection: 0,
        resistance_ohm: 7.7,
        torque_constant_nm_a: 0.00362,
        gear_ratio: 320.0,
        inertia_kg_m2: 0.0232,
        viscous_friction_nm_s: 0.002,
        coulomb_friction_nm: 0.03,
        correction_time_s: 1.0,
        inductance_h: 0.001,
    };
}

/// The excitation that the board runs on request.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct ExcitationSettings {
    /// Shape: 0 pulse; 1 doublet; 2 3-2-1-1; 3 variable step; 4 ramp; 5 linear chirp; 6 logarithmic
    /// chirp; 7 sine; 8 PRBS; 9 multisine. Default: 5 (identifies best). Range: 0 to 9. Object
    /// 2020h:03 Excitation generator: Shape.
    pub shape: i32,
    /// Amplitude. Unit: mdeg. Default: 5000 (default chirp of model-core). Range: -180000 to
    /// 180000. Object 2020h:04 Excitation generator: Amplitude.
    pub amplitude_mdeg: i32,
    /// Frequency; of a chirp its start frequency. Unit: mHz. Default: 100 (default chirp of
    /// model-core). Range: 1 to 100000. Object 2020h:05 Excitation generator: Start frequency.
    pub start_mhz: i32,
    /// End frequency of a chirp. Unit: mHz. Default: 10000 (default chirp of model-core). Range: 1
    /// to 100000. Object 2020h:06 Excitation generator: End frequency.
    pub end_mhz: i32,
    /// Duration of a chirp. Unit: ms. Default: 20000 (default chirp of model-core). Range: 10 to
    /// 3600000. Object 2020h:07 Excitation generator: Duration.
    pub duration_ms: i32,
    /// Width of a step; dwell; hold or chip time. Unit: ms. Default: 300 (default 3-2-1-1 of
    /// model-core). Range: 4 to 100000. Object 2020h:08 Excitation generator: Unit.
    pub unit_ms: i32,
    /// Slope of a ramp. Unit: deg/s. Default: 60 (default ramp of model-core). Range: 1 to 10000.
    /// Object 2020h:09 Excitation generator: Rate.
    pub rate_deg_s: i32,
    /// Order of the shift register of a PRBS. Default: 7 (default PRBS of model-core). Range: 3 to
    /// 16. Object 2020h:0A Excitation generator: Order.
    pub order: i32,
    /// Lines of a multisine. Default: 8 (each takes 150 instructions a sample). Range: 1 to 8.
    /// Object 2020h:0B Excitation generator: Lines.
    pub lines: i32,
    /// Number of repetitions. Default: 1 (one run). Range: 1 to 10000. Object 2020h:0C Excitation
    /// generator: Repetitions.
    pub repetitions: i32,
}

impl ExcitationSettings {
    /// The defaults.
    pub const DEFAULT: Self = Self {
        shape: 5,
        amplitude_mdeg: 5000,
        start_mhz: 100,
        end_mhz: 10000,
        duration_ms: 20000,
        unit_ms: 300,
        rate_deg_s: 60,
        order: 7,
        lines: 8,
        repetitions: 1,
    };
}

/// Signals and trigger of a capture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct CaptureObjects {
    /// Trigger source. Default: 0. Range: 0 to 2. Object 2030h:03 Capture: Trigger source.
    pub trigger: u8,
    /// Pre-trigger records. Default: 0. Object 2030h:04 Capture: Pre-trigger records.
    pub pre_trigger_records: u16,
    /// Decimation. Default: 1. Range: 1 to 65535. Object 2030h:05 Capture: Decimation.
    pub decimation: u16,
    /// Signal 1. Default: 0. Object 2031h:01 Capture signals: Signal 1.
    pub signal_1: u8,
    /// Signal 2. Default: 1. Object 2031h:02 Capture signals: Signal 2.
    pub signal_2: u8,
    /// Signal 3. Default: 2. Object 2031h:03 Capture signals: Signal 3.
    pub signal_3: u8,
    /// Signal 4. Default: 3. Object 2031h:04 Capture signals: Signal 4.
    pub signal_4: u8,
    /// Signal 5. Default: 4. Object 2031h:05 Capture signals: Signal 5.
    pub signal_5: u8,
    /// Signal 6. Default: 5. Object 2031h:06 Capture signals: Signal 6.
    pub signal_6: u8,
    /// Signal 7. Default: 255. Object 2031h:07 Capture signals: Signal 7.
    pub signal_7: u8,
    /// Signal 8. Default: 255. Object 2031h:08 Capture signals: Signal 8.
    pub signal_8: u8,
}

impl CaptureObjects {
    /// The defaults.
    pub const DEFAULT: Self = Self {
        trigger: 0,
        pre_trigger_records: 0,
        decimation: 1,
        signal_1: 0,
        signal_2: 1,
        signal_3: 2,
        signal_4: 3,
        signal_5: 4,
        signal_6: 5,
        signal_7: 255,
        signal_8: 255,
    };
}

/// Reaction to the loss of the master.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct FailsafeSettings {
    /// Action. Default: 1. Range: 0 to 2. Object 2040h:02 Failsafe: Action.
    pub failsafe_action: u8,
    /// Failsafe position. Unit: mdeg. Default: 0. Range: -2000000000 to 2000000000. Object 2040h:03
    /// Failsafe: Failsafe position.
    pub failsafe_position_mdeg: i32,
}

impl FailsafeSettings {
    /// The defaults.
    pub const DEFAULT: Self = Self {
        failsafe_action: 1,
        failsafe_position_mdeg: 0,
    };
}

/// Settings of the drive profile CiA 402.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct ProfileSettings {
    /// Quick stop option code. Default: 2. Range: 0 to 8. Object 605Ah Quick stop option code.
    pub quick_stop_option: i16,
    /// Shutdown option code. Default: 0. Range: 0 to 1. Object 605Bh Shutdown option code.
    pub shutdown_option: i16,
    /// Disable operation option code. Default: 1. Range: 0 to 1. Object 605Ch Disable operation
    /// option code.
    pub disable_option: i16,
    /// Halt option code. Default: 1. Range: 1 to 4. Object 605Dh Halt option code.
    pub halt_option: i16,
    /// Fault reaction option code. Default: 2. Range: 0 to 4. Object 605Eh Fault reaction option
    /// code.
    pub fault_reaction_option: i16,
    /// Position window. Unit: mdeg. Default: 500. Object 6067h Position window.
    pub position_window_mdeg: u32,
    /// Position window time. Unit: ms. Default: 20. Object 6068h Position window time.
    pub position_window_ms: u16,
    /// Velocity window. Unit: mdeg/s. Default: 3000 (twice what 606Ch and the shaft ripple at a
    /// constant velocity). Object 606Dh Velocity window.
    pub velocity_window_mdeg_s: u16,
    /// Velocity window time. Unit: ms. Default: 20. Object 606Eh Velocity window time.
    pub velocity_window_ms: u16,
    /// Velocity threshold. Unit: mdeg/s. Default: 1500 (above the ripple of 606Ch). Object 606Fh
    /// Velocity threshold.
    pub velocity_threshold_mdeg_s: u16,
    /// Velocity threshold time. Unit: ms. Default: 20. Object 6070h Velocity threshold time.
    pub velocity_threshold_ms: u16,
    /// Min position limit. Unit: mdeg. Default: -60000. Object 607Dh:01 Software position limit:
    /// Min position limit.
    pub min_position_mdeg: i32,
    /// Max position limit. Unit: mdeg. Default: 60000. Object 607Dh:02 Software position limit: Max
    /// position limit.
    pub max_position_mdeg: i32,
    /// Max profile velocity. Unit: mdeg/s. Default: 500000. Range: 1 to 4294967295. Object 607Fh
    /// Max profile velocity.
    pub max_velocity_mdeg_s: u32,
    /// Profile velocity. Unit: mdeg/s. Default: 300000. Range: 1 to 4294967295. Object 6081h
    /// Profile velocity.
    pub profile_velocity_mdeg_s: u32,
    /// Profile acceleration. Unit: mdeg/s^2. Default: 3000000. Range: 1 to 4294967295. Object 6083h
    /// Profile acceleration.
    pub acceleration_mdeg_s2: u32,
    /// Profile deceleration. Unit: mdeg/s^2. Default: 3000000. Range: 1 to 4294967295. Object 6084h
    /// Profile deceleration.
    pub deceleration_mdeg_s2: u32,
    /// Quick stop deceleration. Unit: mdeg/s^2. Default: 6000000. Range: 1 to 4294967295. Object
    /// 6085h Quick stop deceleration.
    pub quick_stop_deceleration_mdeg_s2: u32,
    /// Interpolation time period value. Default: 20. Object 60C2h:01 Interpolation time period:
    /// Interpolation time period value.
    pub interpolation_time: u8,
    /// Interpolation time index. Default: -3. Range: -6 to 0. Object 60C2h:02 Interpolation time
    /// period: Interpolation time index.
    pub interpolation_index: i8,
}

impl ProfileSettings {
    /// The defaults.
    pub const DEFAULT: Self = Self {
        quick_stop_option: 2,
        shutdown_option: 0,
        disable_option: 1,
        halt_option: 1,
        fault_reaction_option: 2,
        position_window_mdeg: 500,
        position_window_ms: 20,
        velocity_window_mdeg_s: 3000,
        velocity_window_ms: 20,
        velocity_threshold_mdeg_s: 1500,
        velocity_threshold_ms: 20,
        min_position_mdeg: -60000,
        max_position_mdeg: 60000,
        max_velocity_mdeg_s: 500000,
        profile_velocity_mdeg_s: 300000,
        acceleration_mdeg_s2: 3000000,
        deceleration_mdeg_s2: 3000000,
        quick_stop_deceleration_mdeg_s2: 6000000,
        interpolation_time: 20,
        interpolation_index: -3,
    };
}

/// Access for service.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct ServiceSettings {
    /// Replaces the password; 0 removes it. 1010h stores it. 1011h keeps it. Default: 0 (the
    /// factory sets none). Object 2103h:04 Service access: New password.
    pub password: u32,
}

impl ServiceSettings {
    /// The defaults.
    pub const DEFAULT: Self = Self {
        password: 0,
    };
}

/// All parameters of the board's application.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct BoardParameters {
    /// Gains and limits of the control step.
    pub control: Coefficients,
    /// Source of the commands, and how long a command is valid.
    pub command: CommandSettings,
    /// Angle of a servo pulse.
    pub servo: ServoSettings,
    /// Protection: the encoder.
    pub encoder: EncoderLimits,
    /// Protection: the motor current.
    pub current: CurrentLimits,
    /// Protection: stall.
    pub stall: StallLimits,
    /// Protection: the following error.
    pub following: FollowingLimits,
    /// Protection: the supply voltage.
    pub supply: SupplyLimits,
    /// Protection: the temperature.
    pub temperature: TemperatureLimits,
    /// Protection: missed control periods and measurements.
    pub timing: TimingLimits,
    /// Quick stop.
    pub stop: StopSettings,
    /// The CAN bus.
    pub bus: BusSettings,
}

impl BoardParameters {
    /// The defaults.
    pub const DEFAULT: Self = Self {
        control: CONTROL_DEFAULT,
        command: CommandSettings::DEFAULT,
        servo: ServoSettings::DEFAULT,
        encoder: EncoderLimits::DEFAULT,
        current: CurrentLimits::DEFAULT,
        stall: StallLimits::DEFAULT,
        following: FollowingLimits::DEFAULT,
        supply: SupplyLimits::DEFAULT,
        temperature: TemperatureLimits::DEFAULT,
        timing: TimingLimits::DEFAULT,
        stop: StopSettings::DEFAULT,
        bus: BusSettings::DEFAULT,
    };
}

entries! {
    /// An integer parameter of the board.
    Parameter of BoardParameters {
        CommandSource: command.command_source as i32 in 0..=1,
        PulseMinUs: servo.pulse_min_us as i32 in 500..=2500,
        PulseCentreUs: servo.pulse_centre_us as i32 in 500..=2500,
        PulseMaxUs: servo.pulse_max_us as i32 in 500..=2500,
        PulseMarginUs: servo.pulse_margin_us as i32 in 0..=500,
        PulseTravelMdeg: servo.pulse_travel_mdeg as i32 in -180000..=180000,
        CommandTimeoutMs: command.command_timeout_ms as i32 in 0..=60000,
        ApproachRateDegS: command.approach_rate_deg_s as i32 in 1..=2000,
        LostSamples: encoder.lost_samples as i32 in 0..=50,
        GreatestRateDegS: encoder.greatest_rate_deg_s as i32 in 100..=40000,
        MagnetWeakMs: encoder.magnet_weak_ms as i32 in 4..=60000,
        StuckBackEmfMv: encoder.stuck_back_emf_mv as i32 in 100..=20000,
        StuckDutyPct: encoder.stuck_duty_pct as i32 in 5..=100,
        StuckCurrentMa: encoder.stuck_current_ma as i32 in 10..=2800,
        StuckMs: encoder.stuck_ms as i32 in 12..=10000,
        OverCurrentMa: current.over_current_ma as i32 in 100..=2800,
        OverCurrentSamples: current.over_current_samples as i32 in 1..=25,
        ContinuousMa: current.continuous_ma as i32 in 50..=1600,
        OverloadMs: current.overload_ms as i32 in 20..=60000,
        StallCurrentMa: stall.stall_current_ma as i32 in 20..=2800,
        StallWayMdeg: stall.stall_way_mdeg as i32 in 100..=90000,
        StallMs: stall.stall_ms as i32 in 20..=60000,
        FollowingWindowMdeg: following.following_window_mdeg as i32 in 100..=360000,
        FollowingRateDegS: following.following_rate_deg_s as i32 in 1..=2000,
        FollowingMs: following.following_ms as i32 in 4..=60000,
        UnderVoltageMv: supply.under_voltage_mv as i32 in 2500..=16000,
        OverVoltageMv: supply.over_voltage_mv as i32 in 3000..=16000,
        SupplyMs: supply.supply_ms as i32 in 4..=10000,
        OverTemperatureMdegC: temperature.over_temperature_mdeg_c as i32 in 30000..=125000,
        OverTemperatureMs: temperature.over_temperature_ms as i32 in 4..=60000,
        Overruns: timing.overruns as i32 in 0..=250,
        MeasurementMs: timing.measurement_ms as i32 in 4..=1000,
        BrakeFaults: stop.brake_faults as i32 in 0..=16777214,
        QuickStopDecelerationDegS2: stop.quick_stop_deceleration_deg_s2 as i32 in 50..=100000,
        QuickStopMs: stop.quick_stop_ms as i32 in 20..=10000,
        QuickStopHold: stop.quick_stop_hold as i32 in 0..=1,
        NodeId: bus.node_id as i32 in 1..=127,
        BitRateKbitS: bus.bit_rate_kbit_s as i32 in 125..=1000,
    }
}

impl BoardParameters {
    /// The first value that breaks a relation.
    pub(super) fn broken_relation(&self) -> Option<Parameter> {
        if self.servo.pulse_min_us >= self.servo.pulse_centre_us {
            return Some(Parameter::PulseMinUs);
        }
        if self.servo.pulse_centre_us >= self.servo.pulse_max_us {
            return Some(Parameter::PulseCentreUs);
        }
        if self.current.continuous_ma > self.current.over_current_ma {
            return Some(Parameter::ContinuousMa);
        }
        if self.supply.under_voltage_mv >= self.supply.over_voltage_mv {
            return Some(Parameter::UnderVoltageMv);
        }
        if !matches!(self.bus.bit_rate_kbit_s, 125 | 250 | 500 | 1000) {
            return Some(Parameter::BitRateKbitS);
        }
        None
    }
}

/// Values of objects that a master sets and the drive stores beside the parameters of the board.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ObjectValues {
    /// The motor model that runs beside the motor.
    pub model: ModelSettings,
    /// The excitation that the board runs on request.
    pub excitation: ExcitationSettings,
    /// Signals and trigger of a capture.
    pub capture: CaptureObjects,
    /// Reaction to the loss of the master.
    pub failsafe: FailsafeSettings,
    /// Settings of the drive profile CiA 402.
    pub profile: ProfileSettings,
    /// Access for service.
    pub service: ServiceSettings,
}

impl ObjectValues {
    /// The defaults.
    pub const DEFAULT: Self = Self {
        model: ModelSettings::DEFAULT,
        excitation: ExcitationSettings::DEFAULT,
        capture: CaptureObjects::DEFAULT,
        failsafe: FailsafeSettings::DEFAULT,
        profile: ProfileSettings::DEFAULT,
        service: ServiceSettings::DEFAULT,
    };
}

entries! {
    /// A value of [`ObjectValues`].
    ObjectValue of ObjectValues {
        ModelSelection: model.model_selection as u8 in 0..=1,
        ResistanceOhm: model.resistance_ohm as f32 in 0.05..=1000.0,
        TorqueConstantNmA: model.torque_constant_nm_a as f32 in 1e-5..=1.0,
        GearRatio: model.gear_ratio as f32 in 1.0..=2000.0,
        InertiaKgM2: model.inertia_kg_m2 as f32 in 1e-6..=100.0,
        ViscousFrictionNmS: model.viscous_friction_nm_s as f32 in 0.0..=10.0,
        CoulombFrictionNm: model.coulomb_friction_nm as f32 in 0.0..=10.0,
        CorrectionTimeS: model.correction_time_s as f32 in 0.02..=1000.0,
        InductanceH: model.inductance_h as f32 in 1e-6..=1.0,
        Shape: excitation.shape as i32 in 0..=9,
        AmplitudeMdeg: excitation.amplitude_mdeg as i32 in -180000..=180000,
        StartMhz: excitation.start_mhz as i32 in 1..=100000,
        EndMhz: excitation.end_mhz as i32 in 1..=100000,
        DurationMs: excitation.duration_ms as i32 in 10..=3600000,
        UnitMs: excitation.unit_ms as i32 in 4..=100000,
        RateDegS: excitation.rate_deg_s as i32 in 1..=10000,
        Order: excitation.order as i32 in 3..=16,
        Lines: excitation.lines as i32 in 1..=8,
        Repetitions: excitation.repetitions as i32 in 1..=10000,
        Trigger: capture.trigger as u8 in 0..=2,
        PreTriggerRecords: capture.pre_trigger_records as u16,
        Decimation: capture.decimation as u16 in 1..=65535,
        Signal1: capture.signal_1 as u8,
        Signal2: capture.signal_2 as u8,
        Signal3: capture.signal_3 as u8,
        Signal4: capture.signal_4 as u8,
        Signal5: capture.signal_5 as u8,
        Signal6: capture.signal_6 as u8,
        Signal7: capture.signal_7 as u8,
        Signal8: capture.signal_8 as u8,
        FailsafeAction: failsafe.failsafe_action as u8 in 0..=2,
        FailsafePositionMdeg: failsafe.failsafe_position_mdeg as i32 in -2000000000..=2000000000,
        Password: service.password as u32,
        QuickStopOption: profile.quick_stop_option as i16 in 0..=8,
        ShutdownOption: profile.shutdown_option as i16 in 0..=1,
        DisableOption: profile.disable_option as i16 in 0..=1,
        HaltOption: profile.halt_option as i16 in 1..=4,
        FaultReactionOption: profile.fault_reaction_option as i16 in 0..=4,
        PositionWindowMdeg: profile.position_window_mdeg as u32,
        PositionWindowMs: profile.position_window_ms as u16,
        VelocityWindowMdegS: profile.velocity_window_mdeg_s as u16,
        VelocityWindowMs: profile.velocity_window_ms as u16,
        VelocityThresholdMdegS: profile.velocity_threshold_mdeg_s as u16,
        VelocityThresholdMs: profile.velocity_threshold_ms as u16,
        MinPositionMdeg: profile.min_position_mdeg as i32,
        MaxPositionMdeg: profile.max_position_mdeg as i32,
        MaxVelocityMdegS: profile.max_velocity_mdeg_s as u32 in 1..=4294967295,
        ProfileVelocityMdegS: profile.profile_velocity_mdeg_s as u32 in 1..=4294967295,
        AccelerationMdegS2: profile.acceleration_mdeg_s2 as u32 in 1..=4294967295,
        DecelerationMdegS2: profile.deceleration_mdeg_s2 as u32 in 1..=4294967295,
        QuickStopDecelerationMdegS2: profile.quick_stop_deceleration_mdeg_s2 as u32 in 1..=4294967295,
        InterpolationTime: profile.interpolation_time as u8,
        InterpolationIndex: profile.interpolation_index as i8 in -6..=0,
    }
}

impl ObjectValues {
    /// The first value that breaks a relation.
    pub(super) fn broken_relation(&self) -> Option<ObjectValue> {
        if self.profile.min_position_mdeg > self.profile.max_position_mdeg {
            return Some(ObjectValue::MinPositionMdeg);
        }
        None
    }
}
