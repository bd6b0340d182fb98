//! The stability margins of the sampled loop, and an interpretation of the paper that is unstable.

use super::{
    contradictions,
    models::Model,
    responses::{self, Quantity},
    small_signal::sampled,
    tables,
};
use crate::{
    analysis::{
        linear_models::{Motor, Timing},
        loop_gain::Margins,
        robustness::{SPREAD, stability_limits},
    },
    error::Error,
    page::Section,
    plot::Figure,
    scenario::{Scenario, Setting},
    settings::Settings,
    table::{Cell, Table},
    trace::Trace,
};
use model_core::control::parameters::ControlParameters;

/// The gains of equation (1) as printed, with the faster interpretation of equation (2).
const LITERAL: Model = Model::literal("board with both gains literal");

/// Both gains taken literally: K = 2.836 (deg/s)/% and Kp = 10 %/(deg/s).
fn literal() -> Scenario {
    let gains = [("proportional_gain", 10.0), ("integral_gain", 75.86)];
    let set = gains.map(|(name, value)| Setting::new(name, value)).into();
    Scenario {
        set,
        ..LITERAL.scenario("pulse")
    }
}

/// Makes the section.
///
/// # Errors
/// Does not fail with the built-in presets.
pub fn section() -> Result<Section, Error> {
    let blocks = [
        "The board computes the duty from a sampled angle; the duty takes effect at the next \
             PWM edge, 1 ms later. The margins are computed exactly for this loop, with zero-order \
             hold, delay and filtered encoder difference."
            .into(),
        table()?.into(),
        limits()?.into(),
        (&contradictions::STEADY_GAIN).into(),
        (&contradictions::LITERAL_GAINS).into(),
        figure()?.detail().into(),
    ];
    Ok(Section::new("Stability of the sampled loop", blocks))
}

fn table() -> Result<Table, Error> {
    let of = |preset: &str| {
        let preset = Some(preset.into());
        let scenario = LITERAL.scenario("pulse");
        Scenario { preset, ..scenario }.settings()
    };
    let (consistent, literal) = (of("consistent")?, literal().settings()?);
    let (measured, retuned) = (of("as-measured")?, of("as-measured-retuned")?);
    let readings = [
        ("consistent, 1 ms", &consistent, 1e-3),
        ("consistent, 4 ms", &consistent, 4e-3),
        ("as-measured, 1 ms", &measured, 1e-3),
        ("as-measured-retuned, 1 ms", &retuned, 1e-3),
        ("both gains literal, 1 ms", &literal, 1e-3),
        ("both gains literal, 4 ms", &literal, 4e-3),
    ];
    let mut loops = Vec::new();
    for (name, settings, delay_s) in readings {
        loops.push((name, margins(settings, delay_s)?));
    }
    let caption = "Margins of the sampled loop, opened at the duty, by interpretation and by the \
        time from sample to duty. The board has 1 ms; 4 ms is a controller that applies its result \
        one period later.";
    Ok(tables::margins(caption, &loops))
}

/// Factors on the gains at which the loop becomes unstable.
fn limits() -> Result<Table, Error> {
    let columns = [
        ("interpretation", ""),
        ("position gain", "times"),
        ("gains of the rate loop", "times"),
        ("position gain, box", "times"),
        ("gains of the rate loop, box", "times"),
    ];
    let caption = format!(
        "Factors on the gains of a preset from which on the sampled loop is unstable: for its motor, \
         and for some motor of the box in which gain, pole, supply and inertia differ by up to \
         {:.0} %.",
        100.0 * SPREAD
    );
    let mut table = Table::new(&caption, &columns);
    for preset in ["consistent", "as-measured", "as-measured-retuned"] {
        let scenario = Scenario {
            preset: Some(preset.into()),
            ..LITERAL.scenario("pulse")
        };
        let settings = scenario.settings()?;
        // The direction with the larger gain is less stable.
        let plant = &settings.first_order;
        let motor = Motor {
            motor_gain: plant.motor_gain_up.max(plant.motor_gain_down),
            ..Motor::upward(plant)
        };
        let limits = |scale: fn(&mut ControlParameters, f64)| {
            stability_limits(&motor, &settings.control, &Timing::default(), scale)
        };
        let position = limits(|control, factor| control.position_gain *= factor);
        let rate = limits(|control, factor| {
            control.proportional_gain *= factor;
            control.integral_gain *= factor;
        });
        let cells = [position[0], rate[0], position[1], rate[1]];
        let cells = cells.map(|factor| Cell::optional(factor, 2));
        table.push([Cell::from(preset)].into_iter().chain(cells));
    }
    Ok(table)
}

fn figure() -> Result<Figure, Error> {
    let figure = responses::figure(
        "Both gains literal: limit cycle of encoder counts",
        &[(&LITERAL, &trace()?)],
        &[Quantity::Angle, Quantity::Duty],
    );
    Ok(figure.caption(
        "A counterexample that is not one of the models above: K = 2.836 (deg/s)/% and \
         Kp = 10 %/(deg/s) together, until the end of the pulse. The angle reaches the command and \
         stays within one or two counts, but each change of a count drives the duty to a limit.",
    ))
}

fn margins(settings: &Settings, duty_delay_s: f64) -> Result<Margins, Error> {
    let timing = Timing {
        duty_delay_s,
        ..Timing::default()
    };
    Ok(Margins::of(&sampled(settings, timing)?))
}

fn trace() -> Result<Trace, Error> {
    let scenario = Scenario {
        duration_s: Some(3.0),
        ..literal()
    };
    scenario.resolve()?.record()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_gains_literal_are_stable_with_1_ms_by_3_db_and_unstable_with_4_ms() {
        let settings = literal().settings().expect("a board");
        let margins = |delay_s| margins(&settings, delay_s).expect("in range");
        assert!(margins(1e-3).stable && !margins(4e-3).stable);
        assert!((margins(1e-3).gain_db.expect("one").value - 3.05).abs() < 0.005);
    }

    #[test]
    fn with_both_literal_gains_the_duty_saturates_and_the_angle_stays_within_two_counts() {
        let trace = trace().expect("a run");
        let column = |name: &str| trace.column(name).expect(name);
        let arrived = column("time_s").partition_point(|t| *t < 2.25);
        let duty = &column("duty_pct")[arrived..];
        assert!(duty.contains(&100.0) && duty.contains(&-100.0));
        let two_counts = 2.0 * 360.0 / 4096.0;
        let angle = column("angle_deg")[arrived..].iter();
        let worst = angle.fold(0.0_f64, |worst, angle| worst.max((angle - 90.0).abs()));
        assert!(worst < two_counts, "{worst}");
    }
}
