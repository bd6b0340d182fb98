//! The models in `f64`, tick by tick.

use model_core::{models::ActuatorModel, time::seconds};

use super::{Rows, Simulation};
use crate::{error::Error, input::CommandPath};

pub(super) fn run(
    mut model: impl ActuatorModel,
    simulation: &Simulation,
    path: &CommandPath,
    rows: &mut dyn Rows,
) -> Result<(), Error> {
    for tick in 0..simulation.ticks {
        simulation.check(tick)?;
        let arrived = path.command.at(path.source(tick));
        if tick % simulation.every.max(1) == 0 {
            let now = model.output(arrived);
            let command = path.command.at(tick);
            rows.row(&[
                seconds(tick),
                command,
                path.command.at(path.sent(tick)),
                now.angle_deg,
                now.rate_deg_s,
                now.duty_pct,
                now.angle_deg,
                now.rate_deg_s,
            ])?;
        }
        model.advance_tick(arrived);
    }
    Ok(())
}
