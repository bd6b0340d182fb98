//! The sampled loop: how far it is from instability, and a reading of the paper that is beyond.

use super::{
    contradictions,
    document::remarks,
    models::Model,
    page::Section,
    responses::{self, Quantity},
    small_signal::sampled,
    tables,
};
use crate::{
    analysis::{linear_models::Timing, loop_gain::Margins},
    error::Error,
    scenario::Scenario,
    settings::{ModelSettings, Settings},
    trace::Trace,
};

/// The gains of equation (1) as printed around the faster reading of equation (2).
const LITERAL: Model = Model::literal("board with both gains literal");

/// Both gains at their face value: K = 2.836 (deg/s)/% and Kp = 10 %/(deg/s).
fn literal() -> Scenario {
    let gains = [("proportional_gain", 10.0), ("integral_gain", 75.86)];
    let set = gains.map(|(name, value)| (name.into(), value)).into();
    Scenario {
        set,
        ..LITERAL.scenario("pulse")
    }
}

/// The section.
///
/// # Errors
/// None with the presets as they are.
pub fn section() -> Result<Section, Error> {
    let of = |preset: &str| {
        Scenario {
            preset: Some(preset.into()),
            ..LITERAL.scenario("pulse")
        }
        .settings()
    };
    let (default, literal_settings) = (of("consistent")?, literal().settings()?);
    let readings = [
        ("consistent, 1 ms", &default, 1e-3),
        ("consistent, 4 ms", &default, 4e-3),
        ("as-measured, 1 ms", &of("as-measured")?, 1e-3),
        (
            "as-measured-retuned, 1 ms",
            &of("as-measured-retuned")?,
            1e-3,
        ),
        ("both gains literal, 1 ms", &literal_settings, 1e-3),
        ("both gains literal, 4 ms", &literal_settings, 4e-3),
    ];
    let mut loops = Vec::new();
    for (name, settings, delay_s) in readings {
        loops.extend(margins(settings, delay_s)?.map(|margins| (name, margins)));
    }
    let caption = "Margins of the sampled loop, cut at the duty, by reading and by the time from \
        sample to duty. The board has 1 ms; 4 ms is a controller that uses its result a period \
        later.";
    let figure = responses::figure(
        "Both gains literal: a limit cycle",
        &[(&LITERAL, &trace()?)],
        &[Quantity::Angle, Quantity::Duty],
    );
    let figure = figure.caption(
        "A counter-example, not one of the models above: K = 2.836 (deg/s)/% and Kp = 10 %/(deg/s) \
         together, until the pulse ends. The angle arrives and stays within a count or two; the \
         duty never rests and goes from one limit to the other.",
    );
    let section = Section::new("Stability of the sampled loop")
        .text(
            "The board computes its duty from an angle that it has sampled, and the duty acts from \
             the next edge of the PWM, 1 ms later. The margins are those of this very loop: \
             zero-order hold, delay and filtered encoder difference, exact.",
        )
        .table(tables::margins(caption, &loops));
    let doubts = [contradictions::STEADY_GAIN, contradictions::LITERAL_GAINS];
    Ok(remarks(section, &doubts).figure(figure))
}

fn margins(settings: &Settings, duty_delay_s: f64) -> Result<Option<Margins>, Error> {
    let ModelSettings::Board(board) = &settings.model else {
        return Ok(None);
    };
    let timing = Timing {
        duty_delay_s,
        ..Timing::default()
    };
    Ok(Some(Margins::of(&sampled(board, timing)?)))
}

fn trace() -> Result<Trace, Error> {
    let scenario = Scenario {
        duration_s: Some(3.0),
        ..literal()
    };
    scenario.resolve()?.record()
}
