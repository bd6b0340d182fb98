//! What frames ask of the board beyond the control step: parameters, excitations, capture, faults.

#[cfg(test)]
mod tests;
mod values;

use crate::{
    application::{Application, Refused, Request},
    capture::{Capture, CaptureSettings},
    command::excitation::ExcitationSettings,
    frames::{Access, Message, Operation, Order},
    parameters::BoardParameters,
    supervisor::ResetCause,
};

/// What came of a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Served {
    /// What is to be sent, and whether it is a refusal.
    pub answer: Option<(Access, bool)>,
    /// The parameters in force are to be saved.
    pub save: bool,
    /// [`Service::excitation`] is to be started: what it takes to make a [`Run`] of it has no place in a
    /// control period. The caller makes it where there is time and hands it to
    /// [`Application::start_excitation`] in a later one.
    ///
    /// [`Run`]: crate::command::excitation::Run
    pub start: bool,
}

/// Serves messages; called in the control step's context, before the step.
///
/// | number | value | unit |
/// |---|---|---|
/// | 0 to 127 | the parameter of that number in [`BoardParameters`]: it is in force at once, if all of them fit together | its own |
/// | 128 to 137 | [`ExcitationSettings`], by row | its own |
/// | 160 to 167 | the signals of the capture, by number; 255 for none | |
/// | 168 | decimation of the capture | control periods |
/// | 169 | trigger of the capture: 0 none, 1 excitation, 2 fault | |
/// | 170 | records from before the trigger | |
/// | 192 | phase of the capture: 0 idle, 1 armed, 2 running, 3 full; read only | |
/// | 193 | records that are there; read only | |
/// | 194 | signals of a record; read only | |
/// | 195 | faults that are latched, bit n for fault n; read only | |
/// | 196 | control periods that were missed; read only | |
/// | 197 | servo pulses that were none; read only | |
/// | 198 | cause of the reset, by the numbers of [`ResetCause`]; read only | |
/// | 199 | control periods in which a late part kept the watchdog unfed; read only | |
///
/// Settings of excitation and capture are used by the next start. None of them is stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Service {
    excitation: ExcitationSettings,
    capture: CaptureSettings,
    reset_cause: ResetCause,
    starved_periods: u32,
}

impl Service {
    /// A service with default settings, on a board that started for this reason.
    ///
    /// ```
    /// use firmware::{service::Service, supervisor::ResetCause};
    /// assert_eq!(Service::after(ResetCause::Power), Service::default());
    /// ```
    pub fn after(reset_cause: ResetCause) -> Self {
        Self {
            reset_cause,
            ..Self::default()
        }
    }

    /// The excitation that the next start is of.
    pub fn excitation(&self) -> &ExcitationSettings {
        &self.excitation
    }

    /// Takes note of what [`Supervisor::starved`](crate::supervisor::Supervisor::starved) counts.
    pub fn note_starved(&mut self, periods: u32) {
        self.starved_periods = periods;
    }

    /// Does what a message asks for. What is refused leaves everything as it was.
    pub fn serve(
        &mut self,
        application: &mut Application,
        capture: &mut Capture<'_>,
        message: &Message,
    ) -> Served {
        match *message {
            Message::Command { order, angle } => {
                let save = matches!(order, Some(Order::SaveParameters));
                if let Some(order) = order {
                    // Telemetry shows what came of it.
                    let _ = self.obey(application, capture, order);
                }
                if let Some(angle) = angle {
                    let _ = application.request(Request::Command(angle.into()));
                }
                Served {
                    answer: None,
                    save,
                    start: matches!(order, Some(Order::StartExcitation)),
                }
            }
            Message::Access(access) => Served {
                answer: Some(match self.access(application, capture, access) {
                    Some(value) => (Access { value, ..access }, false),
                    None => (access, true),
                }),
                save: false,
                start: false,
            },
        }
    }

    fn obey(
        &mut self,
        application: &mut Application,
        capture: &mut Capture<'_>,
        order: Order,
    ) -> Result<(), Refused> {
        match order {
            Order::Application(request) => application.request(request),
            // The caller's.
            Order::SaveParameters | Order::StartExcitation => Ok(()),
            Order::RestoreDefaults => application.retune(&BoardParameters::DEFAULT),
            Order::StartCapture => {
                capture.arm(self.capture);
                Ok(())
            }
            Order::StopCapture => {
                capture.stop();
                Ok(())
            }
        }
    }

    /// Reads or writes; the value afterwards, none for a refusal.
    fn access(
        &mut self,
        application: &mut Application,
        capture: &Capture<'_>,
        access: Access,
    ) -> Option<u32> {
        match access.operation {
            Operation::Read => self.read(application, capture, access.number),
            Operation::Write => {
                self.write(application, access.number, access.value)?;
                self.read(application, capture, access.number)
            }
            Operation::ReadCapture => {
                let mut value = [0];
                let count = capture.read(usize::from(access.index), &mut value);
                let [value] = value;
                (count == 1).then_some(value as u32)
            }
            Operation::ReadHistory => {
                let mut history = application.faults().history();
                let record = history.nth(usize::from(access.index))?;
                Some(u32::from(record.fault.number()) << 16 | record.tick & 0xffff)
            }
        }
    }
}
