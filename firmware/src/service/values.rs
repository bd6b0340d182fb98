//! Values by number.

use super::Service;
use crate::{
    application::Application,
    capture::{Capture, Signal, Trigger},
    parameters::{
        BoardParameters, CONTROL, ExcitationSettings, ObjectValue, ObjectValues, Parameter,
    },
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
            ..EXCITATION => by_number(application.parameters(), number)?,
            EXCITATION..SIGNALS => values(&self.excitation).word(setting(number)?),
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
                let mut values = values(&self.excitation);
                values.set_word(setting(number)?, value);
                values.is_in_range(setting(number)?).then_some(())?;
                self.excitation = values.excitation;
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
    match usize::from(number).checked_sub(CONTROL) {
        None => (parameters
            .control
            .set(usize::from(number), f32::from_bits(value)))
        .then_some(())?,
        Some(at) => parameters.set_word(*Parameter::ALL.get(at)?, value),
    }
    application.retune(&parameters).ok()
}

fn setting(number: u8) -> Option<ObjectValue> {
    let at = usize::from(number - EXCITATION);
    let settings = ObjectValue::ALL.get(ObjectValue::Shape as usize..)?;
    settings.get(at).copied().filter(|_| at < 10)
}

fn values(excitation: &ExcitationSettings) -> ObjectValues {
    ObjectValues {
        excitation: *excitation,
        ..ObjectValues::DEFAULT
    }
}

fn by_number(parameters: &BoardParameters, number: u8) -> Option<u32> {
    let number = usize::from(number);
    match parameters.control.get(number) {
        Some(value) => Some(value.to_bits()),
        None => Some(parameters.word(*Parameter::ALL.get(number.checked_sub(CONTROL)?)?)),
    }
}

/// A parameter by its number.
pub struct Meaning(&'static str);

impl Meaning {
    /// Its name.
    pub const fn name(&self) -> &'static str {
        self.0
    }
}

impl BoardParameters {
    /// How many there are.
    pub const COUNT: u8 = (CONTROL + Parameter::ALL.len()) as u8;

    /// The parameter of a number.
    pub fn meaning(number: u8) -> Option<Meaning> {
        use model_core::{control::parameters::ControlParameters, parameter::Parameters};
        let number = usize::from(number);
        let control = ControlParameters::TABLE
            .get(number)
            .map(|parameter| parameter.name);
        let integer = || Some(Parameter::FIELDS.get(number.checked_sub(CONTROL)?)?.0);
        control.or_else(integer).map(Meaning)
    }

    /// The number of a parameter.
    pub fn number_of(name: &str) -> Option<u8> {
        (0..Self::COUNT).find(|&n| Self::meaning(n).is_some_and(|known| known.name() == name))
    }
}

impl Default for ExcitationSettings {
    fn default() -> Self {
        Self::DEFAULT
    }
}

const WORDS: usize = CONTROL + Parameter::ALL.len();

impl crate::store::Stored for BoardParameters {
    const LAYOUT: u32 = 0x5341_0003;
    const DEFAULT: Self = Self::DEFAULT;
    type Page = [u32; WORDS + crate::store::EDGES];
    const ZEROS: Self::Page = [0; WORDS + crate::store::EDGES];

    fn write(&self, words: &mut [u32]) {
        self.write_words(&mut words.iter_mut());
    }

    fn read(words: &[u32]) -> Option<Self> {
        Self::read_words(&mut words.iter().copied())
    }
}
