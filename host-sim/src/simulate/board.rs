//! The board's application in closed loop with a plant (reference semantics S9).
//!
//! At each PWM edge the timer takes the compare value that it was given; at every fourth edge the
//! application then samples the encoder and decides on the next one, which acts a period later.

use firmware::application::{Application, Bridge, Outputs, Request, Samples};
use model_core::{
    control::{
        cascade::Coefficients,
        encoder_word::{COUNT_DEG, EncoderCount, EncoderWord},
    },
    plant::{Plant, first_order::FirstOrder},
    time::{CONTROL_PERIOD_TICKS, PWM_PERIOD_TICKS},
};

use super::{Rows, Simulation, time_s};
use crate::{
    error::Error,
    input::CommandPath,
    settings::{BoardSettings, PlantKind},
};

/// The columns that the board has beyond the common ones.
pub(super) fn columns(_settings: &BoardSettings) -> Vec<&'static str> {
    vec!["rate_command_deg_s", "compare"]
}

pub(super) fn run(
    settings: &BoardSettings,
    simulation: &Simulation,
    path: &CommandPath,
    rows: &mut dyn Rows,
) -> Result<(), Error> {
    match settings.plant {
        PlantKind::FirstOrder => {
            let plant = FirstOrder::try_new(settings.first_order, simulation.pwm)?;
            Loop::try_new(settings, plant)?.run(simulation, path, rows)
        }
        PlantKind::Bench => unreachable!(),
    }
}

/// The word of the encoder on a shaft at this angle.
fn encoder_word(angle_deg: f64) -> EncoderWord {
    let count = (angle_deg / COUNT_DEG + 0.5).floor() as i64;
    EncoderWord::healthy(EncoderCount::new(count as u16))
}

/// The closed loop.
struct Loop<P> {
    application: Application,
    plant: P,
    outputs: Outputs,
}

impl<P: Plant> Loop<P> {
    /// A board that was switched on and enabled at rest, just before tick 0.
    fn try_new(settings: &BoardSettings, plant: P) -> Result<Self, Error> {
        let mut application = Application::new(Coefficients::try_new(&settings.control)?);
        let at_rest = Samples { encoder: encoder_word(plant.at(0).angle_deg), command: Default::default() };
        let outputs = application.step(&at_rest);
        application.request(Request::Enable);
        Ok(Self { application, plant, outputs })
    }

    fn run(
        mut self,
        simulation: &Simulation,
        path: &CommandPath,
        rows: &mut dyn Rows,
    ) -> Result<(), Error> {
        for edge in (0..simulation.ticks).step_by(PWM_PERIOD_TICKS as usize) {
            let duty_pct = self.pending_duty_pct();
            self.plant.start_period(duty_pct);
            if edge % CONTROL_PERIOD_TICKS == 0 {
                self.control(path, edge);
            }
            for tick in simulation.row_ticks(edge, edge + PWM_PERIOD_TICKS) {
                let now = self.plant.at((tick - edge) as usize);
                let command = path.command.at(tick);
                let delayed = path.command.at(path.source(tick));
                rows.row(&[
                    time_s(tick),
                    command,
                    delayed,
                    now.angle_deg,
                    now.rate_deg_s,
                    duty_pct,
                    self.outputs.angle.to_num(),
                    self.outputs.rate.to_num(),
                    self.outputs.rate_command.to_num(),
                    self.compare().into(),
                ])?;
            }
        }
        Ok(())
    }

    fn control(&mut self, path: &CommandPath, tick: u64) {
        self.outputs = self.application.step(&Samples {
            encoder: encoder_word(self.plant.at(0).angle_deg),
            command: path.command.board(path.source(tick)),
        });
    }

    fn pending_duty_pct(&self) -> f64 {
        match self.outputs.bridge {
            Bridge::Driven(compare) => compare.duty_pct(),
            Bridge::Off => 0.0,
        }
    }

    fn compare(&self) -> i32 {
        match self.outputs.bridge {
            Bridge::Driven(compare) => compare.get(),
            Bridge::Off => 0,
        }
    }
}
