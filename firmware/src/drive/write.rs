//! Values from the master. The server has checked access, length, limits and relations.

use canopen::Abort;
use canopen::dictionary::Address;

use super::{Drive, kept::Slot, numbers};
use crate::{
    application::{CommandSource, Request},
    capture::{CaptureSettings, MOST_SIGNALS, Signal, Trigger},
    command::excitation::ExcitationSettings,
    parameters::integers::Integers,
    timing::thousandths,
};

/// Shape of the excitation that is a sum.
const MULTISINE: i32 = 9;

/// What stands for no signal.
const NO_SIGNAL: u32 = 255;

impl Drive<'_> {
    /// A new value for an object.
    pub(super) fn set_value(&mut self, address: Address, value: u64) -> Result<(), Abort> {
        if let Some(number) = numbers::number_of(address) {
            numbers::write(&mut self.application, number, value)?;
            self.update_limits();
            return Ok(());
        }
        if matches!(address.index, 0x2031) && !is_signal(value as u32) {
            return Err(Abort::Value);
        }
        if let Some(place) = self.kept.place(address) {
            *place = value as u32;
            self.update_limits();
            return Ok(());
        }
        match (address.index, address.sub) {
            (0x2000, 0) => self.switch_source(value),
            (0x2020, 1) => self.control_excitation(value),
            (0x2030, 1) => {
                self.control_capture(value);
                Ok(())
            }
            _ => self.command_value(address, value),
        }
    }

    fn command_value(&mut self, address: Address, value: u64) -> Result<(), Abort> {
        let commands = &mut self.commands;
        match address.index {
            0x6040 => commands.controlword = value as u16,
            0x6060 => {
                let mode = value as i8;
                if canopen::cia402::Mode::from_code(mode).is_none() {
                    return Err(Abort::Value);
                }
                commands.mode = mode;
            }
            0x607A => commands.target_position_mdeg = value as i32,
            0x60B1 => commands.velocity_offset_mdeg_s = value as i32,
            0x60FF => commands.target_velocity_mdeg_s = value as i32,
            _ => return Err(Abort::NoObject),
        }
        if matches!(address.index, 0x607A | 0x60B1 | 0x60FF) {
            self.failsafe.commanded();
        }
        Ok(())
    }

    /// Where commands come from; at rest that is the source after a reset too, once it is stored.
    fn switch_source(&mut self, value: u64) -> Result<(), Abort> {
        let source = if value == 1 {
            CommandSource::ServoPulse
        } else {
            CommandSource::Bus
        };
        let request = Request::Source(source);
        self.application.request(request).map_err(numbers::abort)?;
        self.source = source;
        // While the loop is closed only gains change.
        let _ = numbers::write(&mut self.application, numbers::SOURCE, value);
        Ok(())
    }

    fn control_excitation(&mut self, value: u64) -> Result<(), Abort> {
        if value == 0 {
            let request = Request::StopExcitation;
            return self.application.request(request).map_err(numbers::abort);
        }
        let mut settings = ExcitationSettings::DEFAULT;
        let values = self.kept.from(Slot::Shape);
        for (row, value) in (0..ExcitationSettings::RANGES.len()).zip(values) {
            if let Some(place) = settings.get_mut(row) {
                *place = value as i32;
            }
        }
        let run = settings.run().ok_or(Abort::Incompatible)?;
        if !self.has_room(&settings) {
            return Err(Abort::Incompatible);
        }
        let started = self.application.start_excitation(run);
        started.map_err(numbers::abort)
    }

    /// Whether the command stays within 607Dh with this around it.
    fn has_room(&self, settings: &ExcitationSettings) -> bool {
        // Lines of a multisine add up, at the worst.
        let lines = if settings.shape == MULTISINE {
            settings.lines
        } else {
            1
        };
        let reach = settings
            .amplitude_mdeg
            .saturating_abs()
            .saturating_mul(lines);
        let from = thousandths(self.application.telemetry().command);
        let limit = |slot| self.kept.get(slot) as i32;
        from.saturating_sub(reach) >= limit(Slot::MinPosition)
            && from.saturating_add(reach) <= limit(Slot::MaxPosition)
    }

    fn control_capture(&mut self, value: u64) {
        if value == 0 {
            return self.capture.stop();
        }
        let mut signals = [None; MOST_SIGNALS];
        for (place, number) in signals.iter_mut().zip(self.kept.from(Slot::Signal1)) {
            *place = u8::try_from(number).ok().and_then(Signal::of_number);
        }
        self.capture.arm(CaptureSettings {
            signals,
            decimation: self.decimation(),
            trigger: match self.kept.get(Slot::Trigger) {
                1 => Trigger::Excitation,
                2 => Trigger::Fault,
                _ => Trigger::Now,
            },
            before: self.kept.get(Slot::Before) as u16,
        });
    }

    /// Control periods from record to record.
    pub(super) fn decimation(&self) -> u16 {
        self.kept.get(Slot::Decimation) as u16
    }
}

fn is_signal(number: u32) -> bool {
    let known = |number| Signal::of_number(number).is_some();
    number == NO_SIGNAL || u8::try_from(number).is_ok_and(known)
}
