//! Values by number.

use super::Service;
use crate::{
    application::Application,
    capture::{Capture, Signal, Trigger},
    command::excitation::ExcitationSettings,
    parameters::integers::Integers,
};

/// Number of the first setting of the excitation.
pub(super) const EXCITATION: u8 = 128;
/// Number of the first signal of the capture.
pub(super) const SIGNALS: u8 = 160;
const DECIMATION: u8 = 168;
pub(super) const TRIGGER: u8 = 169;
const BEFORE: u8 = 170;

/// What stands for no signal.
const NO_SIGNAL: u32 = 255;

impl Service {
    /// The value of a number.
    pub(super) fn read(
        &self,
        application: &Application,
        capture: &Capture<'_>,
        number: u8,
    ) -> Option<u32> {
        Some(match number {
            ..EXCITATION => application.parameters().word(number)?,
            EXCITATION..SIGNALS => self.excitation.get(usize::from(number - EXCITATION))? as u32,
            SIGNALS..DECIMATION => {
                let signal = self.capture.signals.get(usize::from(number - SIGNALS))?;
                signal.map_or(NO_SIGNAL, |signal| signal as u32)
            }
            DECIMATION => u32::from(self.capture.decimation),
            TRIGGER => self.capture.trigger as u32,
            BEFORE => u32::from(self.capture.before),
            192 => capture.phase() as u32,
            193 => capture.count() as u32,
            194 => capture.width() as u32,
            195 => application.faults().latched().bits(),
            196 => application.telemetry().missed_periods,
            197 => application.telemetry().servo_glitches,
            198 => self.reset_cause as u32,
            199 => self.starved_periods,
            _ => return None,
        })
    }

    /// Writes a number; none where that is refused.
    pub(super) fn write(
        &mut self,
        application: &mut Application,
        number: u8,
        value: u32,
    ) -> Option<()> {
        match number {
            ..EXCITATION => set(application, number, value),
            EXCITATION..SIGNALS => {
                let row = usize::from(number - EXCITATION);
                let range = ExcitationSettings::RANGES.get(row)?;
                range.takes(value as i32).then_some(())?;
                *self.excitation.get_mut(row)? = value as i32;
                Some(())
            }
            SIGNALS..DECIMATION => {
                let signal = match value {
                    NO_SIGNAL => None,
                    value => Some(Signal::of_number(u8::try_from(value).ok()?)?),
                };
                *self
                    .capture
                    .signals
                    .get_mut(usize::from(number - SIGNALS))? = signal;
                Some(())
            }
            DECIMATION => {
                self.capture.decimation = u16::try_from(value).ok().filter(|&value| value > 0)?;
                Some(())
            }
            TRIGGER => {
                self.capture.trigger = match value {
                    0 => Trigger::Now,
                    1 => Trigger::Excitation,
                    2 => Trigger::Fault,
                    _ => return None,
                };
                Some(())
            }
            BEFORE => {
                self.capture.before = u16::try_from(value).ok()?;
                Some(())
            }
            _ => None,
        }
    }
}

/// Sets a parameter of the board.
fn set(application: &mut Application, number: u8, value: u32) -> Option<()> {
    let mut parameters = *application.parameters();
    parameters.set_word(number, value).then_some(())?;
    application.retune(&parameters).ok()
}
