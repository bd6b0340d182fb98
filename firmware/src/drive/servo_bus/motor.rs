//! The drive as the motor of a servo: what it measures in the units of control tables, and what a
//! table has it do.

use canopen::cia402::{self, Cia402State, Limits};
use servo_bus::{EEPROM, Field, MIDDLE, Memory, Profile, TURN, Table, tables};

use super::super::Drive;
use crate::{
    control_loop::Polarity,
    faults::{Fault, FaultSet},
    interface::CommandSource,
    timing::thousandths,
};

/// The control tables that the board has, with their numbers of object 2102h:4.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Model {
    /// Feetech STS3215.
    Sts3215 = 1,
    /// Dynamixel XL330-M288.
    Xl330M288 = 2,
    /// Feetech STS3250.
    Sts3250 = 3,
    /// Dynamixel XM430-W350.
    Xm430W350 = 4,
}

/// The maker of a servo, which has a protocol and registers of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Maker {
    /// Feetech, with the STS series.
    Feetech,
    /// Robotis, with the X series of Dynamixels.
    Robotis,
}

impl Model {
    /// All of them.
    pub const ALL: [Self; 4] = [
        Self::Sts3215,
        Self::Xl330M288,
        Self::Sts3250,
        Self::Xm430W350,
    ];

    /// The model of a number.
    pub(crate) fn of_number(number: u8) -> Option<Self> {
        Self::ALL.into_iter().find(|model| *model as u8 == number)
    }

    /// Its maker.
    pub fn maker(self) -> Maker {
        match self {
            Self::Sts3215 | Self::Sts3250 => Maker::Feetech,
            Self::Xl330M288 | Self::Xm430W350 => Maker::Robotis,
        }
    }

    /// Its control table.
    pub fn table(self) -> &'static Table {
        match self {
            Self::Sts3215 => &tables::STS3215,
            Self::Xl330M288 => &tables::XL330_M288,
            Self::Sts3250 => &tables::STS3250,
            Self::Xm430W350 => &tables::XM430_W350,
        }
    }

    /// What a new servo with this ID keeps without power.
    pub(crate) fn eeprom(self, id: u8) -> [u8; EEPROM] {
        let mut memory = Memory::new(self.table());
        let field = match self.maker() {
            Maker::Feetech => tables::sts::ID,
            Maker::Robotis => tables::x::ID,
        };
        memory.store(field, id.into());
        *memory.eeprom()
    }
}

/// Thousandths of a degree in a turn.
const TURN_MDEG: i64 = 360_000;

/// Steps of a position, of which [`MIDDLE`] is 0 deg.
pub(super) fn steps(mdeg: i32) -> i32 {
    let steps = i64::from(mdeg) * i64::from(TURN);
    // A smaller number.
    (steps.div_euclid(TURN_MDEG) as i32).wrapping_add(MIDDLE)
}

/// The position of steps, mdeg.
pub(super) fn mdeg(steps: i32) -> i32 {
    let steps = steps.wrapping_sub(MIDDLE);
    // In the middle of the step, whose quantisation is that of the encoder.
    in_mdeg(steps.into()).saturating_add((TURN_MDEG / i64::from(TURN) / 2) as i32)
}

/// Steps/s.
pub(super) fn steps_s(mdeg_s: i32) -> i32 {
    steps(mdeg_s).wrapping_sub(MIDDLE)
}

/// A current in units of the table.
pub(super) fn current_units(table: &Table, ma: i32) -> i32 {
    ma.wrapping_mul(1000) / i32::from(table.current_ua).max(1)
}

/// A current of the table, mA.
pub(super) fn in_ma(table: &Table, units: i32) -> i32 {
    units.wrapping_mul(table.current_ua.into()) / 1000
}

/// The bit rate of this number in a table, bit/s.
pub(super) fn bit_rate(memory: &Memory, number: Field, rates: &[u32]) -> Option<u32> {
    let number = usize::try_from(memory.get(number)).ok()?;
    rates.get(number).copied()
}

/// A travel or a rate of steps, in mdeg.
pub(super) fn in_mdeg(steps: i64) -> i32 {
    let mdeg = steps.saturating_mul(TURN_MDEG) / i64::from(TURN);
    mdeg.clamp(i32::MIN.into(), i32::MAX.into()) as i32
}

/// Limits of a trajectory, in mdeg.
#[inline(never)]
pub(super) fn limits(profile: Profile) -> Limits {
    let mdeg = |steps: u32| {
        let mdeg = (u64::from(steps) * TURN_MDEG as u64).div_ceil(TURN as u64);
        mdeg.min(u32::MAX.into()) as u32
    };
    let acceleration = mdeg(profile.acceleration);
    Limits {
        velocity: mdeg(profile.velocity),
        acceleration,
        deceleration: acceleration,
    }
}

/// What the drive measures.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Sensed {
    pub position_mdeg: i32,
    pub rate_mdeg_s: i32,
    pub duty_permille: i32,
    pub current_ma: i32,
    /// 0.1 V.
    pub voltage: i32,
    /// degC.
    pub temperature: i32,
    /// What prevents that the shaft is driven.
    pub faults: FaultSet,
    /// The loop is closed, or will be by the commands that wait.
    pub is_driven: bool,
    /// The loop has still to take commands.
    pub is_waiting: bool,
    /// CANopen has ended the motion.
    pub is_stopped: bool,
    /// The deviation from the trajectory that is permitted while the torque is limited, mdeg.
    pub room_mdeg: Option<i32>,
}

impl Sensed {
    pub fn of(drive: &Drive<'_>) -> Self {
        let t = &drive.outputs.telemetry;
        let sign = Polarity::of(&drive.values);
        Self {
            position_mdeg: drive.position_mdeg(),
            rate_mdeg_s: t.velocity_mdeg_s.wrapping_mul(sign.velocity),
            duty_permille: thousandths(t.duty) / 100 * sign.velocity,
            current_ma: t.current_ma.wrapping_mul(sign.velocity),
            voltage: t.supply_mv / 100,
            temperature: t.temperature_mdeg_c / 1000,
            faults: drive.latched(),
            is_driven: drive.is_commanded() && (drive.has_waiting_command() || drive.is_enabled()),
            is_waiting: drive.has_waiting_command(),
            is_stopped: drive.is_stopped,
            room_mdeg: (t.limits.current)
                .then(|| drive.parameters().following.following_window_mdeg / 2),
        }
    }

    /// Whether there is no fault but those of the load.
    pub fn has_load_faults_only(&self) -> bool {
        self.faults.without(LOAD).is_empty()
    }

    /// The bits of the faults of each kind: of the supply, the encoder, the temperature, the
    /// current, the load, and all others.
    pub fn bits(&self, kinds: [i32; 6]) -> i32 {
        let [supply, encoder, temperature, current, load, others] = kinds;
        let has = |faults: FaultSet, bit: i32| {
            if self.faults.and(faults).is_empty() {
                0
            } else {
                bit
            }
        };
        let known = [SUPPLY, ENCODER, TEMPERATURE, CURRENT, LOAD];
        let rest = (known.into_iter()).fold(self.faults, |rest, of| rest.without(of));
        has(SUPPLY, supply)
            | has(ENCODER, encoder)
            | has(TEMPERATURE, temperature)
            | has(CURRENT, current)
            | has(LOAD, load)
            | has(rest, others)
    }
}

const SUPPLY: FaultSet = FaultSet::of(&[Fault::UnderVoltage, Fault::OverVoltage]);
const ENCODER: FaultSet = FaultSet::of(&[
    Fault::EncoderInvalid,
    Fault::MagnetLost,
    Fault::MagnetWeak,
    Fault::EncoderStuck,
    Fault::EncoderJump,
    Fault::MotorPolarity,
    Fault::EncoderImplausible,
]);
const TEMPERATURE: FaultSet = FaultSet::of(&[Fault::OverTemperature]);
const CURRENT: FaultSet = FaultSet::of(&[Fault::OverCurrent, Fault::BridgeTripped]);
const LOAD: FaultSet = FaultSet::of(&[Fault::Overload, Fault::Stall, Fault::FollowingError]);

/// The greatest torque of a demand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum MostTorque {
    /// A share of those of objects 6072h and 6073h, 0.1 %.
    Share(u16),
    /// That of a current, mA.
    OfCurrent(i32),
}

/// What a table has the drive follow.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Target {
    /// Nothing: the bridge is off.
    Off,
    /// mdeg.
    Position(i32),
    /// mdeg/s.
    Velocity(i32),
    /// mA.
    Current(i32),
}

/// What a table has the drive do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Demand {
    pub target: Target,
    pub most_torque: MostTorque,
    /// Faults are acknowledged before.
    pub acknowledges: bool,
    /// The torque was turned on, which ends a stop by CANopen.
    pub ends_stop: bool,
}

/// Controlword that removes the power at once, and the same with a fault reset.
const OFF: u16 = 0x00;
const RESET: u16 = 0x80;

impl Drive<'_> {
    /// Acknowledges the faults, if the reaction to them has ended; returns whether it has.
    pub(super) fn acknowledge(&mut self) -> bool {
        let is_in_fault = self.outputs.motion.state == Cia402State::Fault;
        if is_in_fault {
            for control in [OFF, RESET] {
                self.change_command(|command| command.control = control);
            }
        }
        is_in_fault
    }

    /// Has the drive do this; targets are written in new control periods only, one in each.
    pub(super) fn carry_out(&mut self, demand: &Demand, is_new_period: bool) {
        self.limit_torque(self.most_permille(demand.most_torque));
        self.is_stopped &= !demand.ends_stop;
        let sign = Polarity::of(&self.values);
        // The servo pulse commands a closed loop, and this must not close it.
        let is_source = self.selected_source() == CommandSource::Bus;
        let target = if is_source {
            demand.target
        } else {
            Target::Off
        };
        match target {
            Target::Off if self.is_commanded() => {
                self.change_command(|command| command.control = OFF);
            }
            Target::Off => {}
            _ if !is_new_period && self.is_commanded() => {}
            Target::Position(mdeg) => {
                let mdeg = mdeg.wrapping_mul(sign.position);
                self.follow(cia402::Mode::CyclicPosition, |it| it.set_position(mdeg));
            }
            Target::Velocity(mdeg_s) => {
                let mdeg_s = mdeg_s.wrapping_mul(sign.velocity);
                self.follow(cia402::Mode::CyclicVelocity, |it| it.set_velocity(mdeg_s));
            }
            Target::Current(ma) => {
                let permille = self.permille_of_rated_current(ma.wrapping_mul(sign.velocity));
                let permille = permille.clamp(i16::MIN.into(), i16::MAX.into()) as i16;
                self.follow(cia402::Mode::CyclicTorque, |it| it.set_torque(permille));
            }
        }
    }

    /// The greatest torque, thousandths of the rated one.
    fn most_permille(&self, most: MostTorque) -> u16 {
        let limits = &self.values.limits;
        let permille = match most {
            MostTorque::Share(1000..) => u32::MAX,
            MostTorque::Share(share) => {
                let most = (limits.max_torque_permille).min(limits.max_current_permille);
                u32::from(most) * u32::from(share) / 1000
            }
            MostTorque::OfCurrent(ma) => self.permille_of_rated_current(ma.abs()) as u32,
        };
        permille.min(u16::MAX.into()) as u16
    }
}
