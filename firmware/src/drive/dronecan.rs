//! The actuator as a DroneCAN node: another front end of the drive, over the same messages,
//! telemetry and parameters.
//!
//! DroneCAN has no command that enables an actuator. The first command closes the loop; one that is
//! not a number, or a pulse of no width, stops the shaft and opens the loop, and acknowledges
//! faults. The loop takes these as the controlwords of CiA 402.

mod parameters;

use core::task::Poll;

use ::dronecan::{
    Application, Health, Identity, Level, Mode, Node, Opcode, Parameter, Settings, Status, Target,
    Telemetry, Value, circuit,
};
use canopen::ParameterGroup;
use canopen::cia402::{self, Cia402State};

use super::{Drive, emergency};
use crate::{
    application::{BoardState, CommandSource},
    faults::Fault,
    timing::thousandths,
};

/// The controlword of a quick stop, after which the loop is open, and the one with a fault reset.
/// The time-out of commands does not run meanwhile.
const RELEASE: u16 = 0x02;
const RESET: u16 = 0x82;

/// Thousandths of a degree in a radian.
const MDEG_PER_RAD: f32 = 180_000.0 / core::f32::consts::PI;

/// Zero degrees Celsius, K.
const ZERO_CELSIUS_K: f32 = 273.15;

impl Drive<'_> {
    /// A DroneCAN node with the present settings.
    pub(super) fn start_dronecan(&self, now_us: u64) -> Node {
        let settings = &self.values.dronecan;
        let rate_hz = u32::from(settings.status_rate_hz);
        let settings = Settings {
            node_id: settings.dronecan_node_id,
            status_period_us: 1_000_000_u32.checked_div(rate_hz).unwrap_or(0),
        };
        Node::new(settings, self, now_us)
    }

    fn release(&mut self) {
        self.is_stopped = self.is_on_servo_bus;
        if self.is_commanded() {
            self.change_command(|command| command.control = RELEASE);
        }
        // Once, and where it acts: the reaction to a fault may outlast the first release.
        let is_released = self.messages.commands.unverified().newest().control == RELEASE;
        if is_released && self.outputs.motion.state == Cia402State::Fault {
            self.change_command(|command| command.control = RESET);
        }
    }

    /// The angle of a target, mdeg, if it has one.
    fn angle_mdeg(&self, target: Target) -> Option<i32> {
        let servo = &self.parameters().servo;
        match target {
            Target::Unitless(share) => {
                let share = share.clamp(-1.0, 1.0);
                Some((share * servo.pulse_travel_mdeg as f32) as i32)
            }
            Target::Position(rad) => Some((rad * MDEG_PER_RAD) as i32),
            // A conversion to an integer saturates.
            Target::PulseWidth(us) => servo.angle(us as u16).map(thousandths),
            Target::Speed(_) | Target::Force(_) => None,
        }
    }
}

impl Application for Drive<'_> {
    fn unique_id(&self) -> [u8; 16] {
        let mut id = *b"____smart-servo\0";
        for (place, byte) in (id.iter_mut()).zip(self.diagnostics.serial_number.to_le_bytes()) {
            *place = byte;
        }
        id
    }

    fn identity(&self) -> Identity {
        Identity {
            software: self.program_version(),
            hardware: (1, 0),
            name: "org.smart-actuator",
        }
    }

    fn status(&self) -> Status {
        let health = if !self.latched().is_empty() {
            Health::Error
        } else if !self.outputs.telemetry.present.is_empty() || self.health.warnings() != 0 {
            Health::Warning
        } else {
            Health::Ok
        };
        let mode = if self.update.is_updating() {
            Mode::SoftwareUpdate
        } else if self.outputs.state == BoardState::Initialising {
            Mode::Initialisation
        } else {
            Mode::Operational
        };
        Status {
            health,
            mode,
            code: self.error_code(),
        }
    }

    fn telemetry(&self) -> Telemetry {
        let (t, model) = (&self.outputs.telemetry, &self.values.model);
        let current_a = t.current_ma as f32 / 1000.0;
        let has = |fault, flag| if t.present.contains(fault) { flag } else { 0 };
        Telemetry {
            actuator_id: self.values.dronecan.actuator_id,
            position_rad: self.axis_position_mdeg() as f32 / MDEG_PER_RAD,
            torque_nm: current_a * model.torque_constant_nm_a * model.gear_ratio,
            rate_rad_s: t.velocity_mdeg_s as f32 / MDEG_PER_RAD,
            load_pct: (self.permille_of_rated_current(t.current_ma).unsigned_abs() / 10).min(255)
                as u8,
            supply_v: t.supply_mv as f32 / 1000.0,
            current_a,
            circuit_errors: has(Fault::OverVoltage, circuit::OVER_VOLTAGE)
                | has(Fault::UnderVoltage, circuit::UNDER_VOLTAGE)
                | has(Fault::OverCurrent, circuit::OVER_CURRENT),
            temperature_k: t.temperature_mdeg_c as f32 / 1000.0 + ZERO_CELSIUS_K,
            is_overheated: t.present.contains(Fault::OverTemperature),
        }
    }

    fn command(&mut self, actuator_id: u8, target: Target) {
        let is_refused = self.is_on_servo_bus && !target.is_release();
        if actuator_id != self.values.dronecan.actuator_id || is_refused {
            return;
        }
        if target.is_release() {
            self.release();
        } else if self.selected_source() != CommandSource::Bus {
            // The servo pulse commands, and this must not close the loop for it.
        } else if let Target::Speed(rad_s) = target {
            let mdeg_s = (rad_s * MDEG_PER_RAD) as i32;
            self.follow(cia402::Mode::CyclicVelocity, |it| it.set_velocity(mdeg_s));
        } else if let Some(mdeg) = self.angle_mdeg(target) {
            self.follow(cia402::Mode::CyclicPosition, |it| it.set_position(mdeg));
        }
    }

    fn find(&self, name: &[u8]) -> Option<u16> {
        parameters::find(name)
    }

    fn parameter(&mut self, index: u16) -> Option<Parameter> {
        self.described(index)
    }

    fn set(&mut self, index: u16, value: Value) {
        // The response has the value that is in force.
        let _ = self.set_described(index, value);
    }

    fn perform(&mut self, opcode: Opcode) -> Poll<bool> {
        let group = ParameterGroup::Application;
        let done = match opcode {
            Opcode::Save => self.save(group, core::iter::empty()),
            Opcode::Erase => canopen::Application::restore(self, group),
        };
        done.map(|done| done.is_ok())
    }

    fn begin_update(&mut self) -> Result<(), &'static str> {
        if self.is_locked() {
            return Err("locked by the service password");
        }
        let begun = self.update.begin(&mut self.capture, None);
        begun.map_err(|_| "no bootloader, or busy")
    }

    fn write_update(&mut self, offset: u32, bytes: &[u8]) -> bool {
        self.update.write(offset, bytes).is_ok()
    }

    fn end_update(&mut self, size: u32) -> bool {
        let is_whole = self.end_download(size) == Poll::Ready(Ok(()));
        if is_whole {
            self.update.install_when_possible();
        }
        is_whole
    }

    fn cancel_update(&mut self) {
        self.update.cancel(&mut self.capture);
    }

    fn take_log(&mut self, text: &mut [u8; 32]) -> Option<(Level, usize)> {
        let latched = self.latched();
        self.reported = self.reported.and(latched);
        let fault = latched.without(self.reported).first()?;
        self.reported.put(fault, true);
        let number = fault.number() as u8;
        let code = emergency::code(fault).0;
        let digit = |value: u16| match value & 0xF {
            low @ 0..=9 => b'0' + low as u8,
            high => b'A' + (high - 10) as u8,
        };
        let [tens, units] = [number / 10, number % 10].map(|decimal| digit(decimal.into()));
        let code = [12, 8, 4, 0].map(|shift| digit(code >> shift));
        let words: [&[u8]; 5] = [b"fault ", &[tens, units], b", code ", &code, b"h"];
        let mut length = 0;
        for (place, byte) in text.iter_mut().zip(words.into_iter().flatten()) {
            *place = *byte;
            length += 1;
        }
        Some((Level::Error, length))
    }
}
