//! Values for the master.

use canopen::Abort;
use canopen::dictionary::Address;

use super::{Drive, emergency, numbers, parameters::PERIOD_US};
use crate::timing::{CONTROL_PERIOD_MS, thousandths};

/// A signed number as the server wants it.
fn signed(value: i32) -> u64 {
    value as u64
}

/// A signed number that ends where 16 bits do.
fn short(value: i32) -> u64 {
    signed(value.max(i32::from(i16::MIN)).min(i32::from(i16::MAX)))
}

/// A REAL32.
fn real(value: f32) -> u64 {
    u64::from(value.to_bits())
}

impl Drive<'_> {
    /// The value of an object.
    pub(super) fn value(&mut self, address: Address) -> Result<u64, Abort> {
        if let Some(number) = numbers::number_of(address) {
            return numbers::read(self.application.parameters(), number);
        }
        if let Some(place) = self.kept.place(address) {
            // Signed numbers of at most 32 bits extend themselves; of unsigned ones the upper half is cut.
            return Ok(signed(*place as i32));
        }
        match address.index {
            0x2000..0x2020 => self.measured(address),
            0x2020..0x2040 => self.recorded(address),
            0x2050 => self.counted(address.sub),
            _ => self.profile(address),
        }
    }

    fn measured(&self, Address { index, sub }: Address) -> Result<u64, Abort> {
        let t = self.application.telemetry();
        Ok(match (index, sub) {
            (0x2000, 0) => self.source as u64,
            (0x2001, 1) => u64::from(t.servo_pulse_us),
            (0x2001, 2) => u64::from(self.pulse_age < self.pulse_timeout()),
            (0x2001, 3) => u64::from(self.pulse_age.saturating_mul(CONTROL_PERIOD_MS as u16)),
            // Thousandths of a percent to hundredths.
            (0x2002, 0) => short(thousandths(t.duty) / 10),
            (0x2003, 0) => short(t.back_emf_mv),
            (0x2004, 0) => short(t.current_ma),
            // Within 100,000 times 20,000 mV, which an i32 holds.
            (0x2005, 0) => short(thousandths(t.duty).saturating_mul(t.supply_mv) / 100_000),
            (0x2006, 0) => short(t.temperature_mdeg_c / 100),
            (0x2007, 1) => u64::from(t.tick as u16),
            (0x2007, 2) => u64::from(t.tick.wrapping_mul(PERIOD_US)),
            (0x2008, 1) => short(thousandths(t.angle) / 10),
            (0x2008, 2) => short(thousandths(t.rate) / 100),
            (0x2012, 1) => real(self.model.angle_deg()),
            (0x2012, 2) => real(self.model.rate_deg_s()),
            (0x2012, 3) => real(self.model.residual_deg()),
            _ => return Err(Abort::NoObject),
        })
    }

    /// Control periods without a pulse after which there is none.
    fn pulse_timeout(&self) -> u16 {
        let timeout_ms = self.application.parameters().command.command_timeout_ms;
        crate::timing::periods(timeout_ms.max(100))
    }

    fn recorded(&self, Address { index, sub }: Address) -> Result<u64, Abort> {
        use crate::application::CommandSource;
        let t = self.application.telemetry();
        let record = u64::from(self.decimation()) * u64::from(PERIOD_US);
        Ok(match (index, sub) {
            (0x2020, 1 | 2) => u64::from(t.source == CommandSource::Excitation),
            (0x2030, 1) => u64::from(matches!(self.capture.phase() as u8, 1 | 2)),
            (0x2030, 2) => self.capture.phase() as u64,
            (0x2030, 6) => self.capture.count() as u64,
            (0x2030, 7) => self.capture.width() as u64 * 4,
            (0x2030, 8) => record,
            (0x2030, 9) => self.capture.capacity() as u64,
            _ => return Err(Abort::NoObject),
        })
    }

    fn counted(&self, sub: u8) -> Result<u64, Abort> {
        let t = self.application.telemetry();
        let board = &self.diagnostics;
        Ok(u64::from(match sub {
            1 => t.missed_periods,
            2 => board.longest_step_us,
            3 => board.transmit_overflows,
            4 => board.receive_overflows,
            5 => board.bus_offs,
            6 => t.servo_glitches,
            7 => board.reset_cause as u32,
            8 => board.starved_periods,
            9 => t.present.bits(),
            10 => self.latched().bits(),
            _ => return Err(Abort::NoObject),
        }))
    }

    fn profile(&self, Address { index, sub }: Address) -> Result<u64, Abort> {
        let t = self.application.telemetry();
        Ok(match (index, sub) {
            (0x1002, 0) => u64::from(self.latched().bits()),
            (0x1018, 4) => u64::from(self.diagnostics.serial_number),
            (0x603F, 0) => u64::from(self.error_code()),
            (0x6040, 0) => u64::from(self.commands.controlword),
            (0x6041, 0) => u64::from(self.motion.statusword),
            (0x6060, 0) => signed(i32::from(self.commands.mode)),
            (0x6061, 0) => signed(i32::from(self.motion.mode)),
            (0x6062, 0) => signed(self.motion.position_mdeg),
            (0x6064, 0) => signed(thousandths(t.angle)),
            (0x606B, 0) => signed(self.motion.velocity_mdeg_s),
            (0x606C, 0) => signed(thousandths(t.rate)),
            (0x6078, 0) => short(self.share_of_rated_current(t.current_ma)),
            (0x6079, 0) => t.supply_mv.max(0) as u64,
            (0x607A, 0) => signed(self.commands.target_position_mdeg),
            (0x60B1, 0) => signed(self.commands.velocity_offset_mdeg_s),
            (0x60F4, 0) => signed(self.motion.following_error_mdeg),
            (0x60FA, 0) => signed(thousandths(t.rate_command)),
            (0x60FF, 0) => signed(self.commands.target_velocity_mdeg_s),
            _ => return Err(Abort::NoObject),
        })
    }

    /// Of the fault with which it began.
    fn error_code(&self) -> u16 {
        let first = self.application.faults().first().map(|record| record.fault);
        first
            .or(self.own.first())
            .map_or(0, |fault| emergency::code(fault).0)
    }

    /// In thousandths.
    fn share_of_rated_current(&self, current_ma: i32) -> i32 {
        let rated_ma = self.application.parameters().current.continuous_ma;
        // Within 1650 times 1000.
        let share = current_ma.saturating_mul(1000).checked_div(rated_ma);
        share.unwrap_or(0)
    }
}
