//! The rows of the board in closed loop.

use model_core::{
    control::cascade::Coefficients,
    plant::{Plant, first_order::FirstOrder},
    time::PWM_PERIOD_TICKS,
};

use super::{
    Rows, Simulation,
    closed_loop::{ClosedLoop, Encoder, IdealEncoder},
    time_s,
};
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
    let coefficients = Coefficients::try_new(&settings.control)?;
    match settings.plant {
        PlantKind::FirstOrder => {
            let plant = FirstOrder::try_new(settings.first_order, simulation.pwm)?;
            record(
                ClosedLoop::new(coefficients, plant, IdealEncoder),
                simulation,
                path,
                rows,
            )
        }
        PlantKind::Bench => unreachable!(),
    }
}

fn record<P: Plant, E: Encoder<P>>(
    mut board: ClosedLoop<P, E>,
    simulation: &Simulation,
    path: &CommandPath,
    rows: &mut dyn Rows,
) -> Result<(), Error> {
    for edge in (0..simulation.ticks).step_by(PWM_PERIOD_TICKS as usize) {
        board.start_period(|tick| path.command.board(path.source(tick)));
        for tick in simulation.row_ticks(edge, edge + PWM_PERIOD_TICKS) {
            let now = board.plant.at((tick - edge) as usize);
            rows.row(&[
                time_s(tick),
                path.command.at(tick),
                path.command.at(path.source(tick)),
                now.angle_deg,
                now.rate_deg_s,
                board.duty_pct(),
                board.outputs.angle.to_num(),
                board.outputs.rate.to_num(),
                board.outputs.rate_command.to_num(),
                board.compare().get().into(),
            ])?;
        }
    }
    Ok(())
}
