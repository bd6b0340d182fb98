//! The page of the report: its sections in their order, and their texts.

use super::{
    bode,
    comparison::{Comparison, Outcome},
    contradictions::{self, Contradiction},
    input_sections::SECTIONS,
    models::Model,
    responses::{self, Quantity, Shown},
    stability, tables,
};
use crate::{
    error::Error,
    page::{Page, Section},
    plot::Figure,
    scenario::Scenario,
    table::{Cell, Table},
    trace::Trace,
};

const TITLE: &str = "Smart actuator: the models of the paper and the board";

const INTRODUCTION: &str = "“Analysis of Modeling Techniques for Low-Cost Actuators” by Carlson, \
    Dorobantu, Taylor and Seiler compares three models of a servo: two black boxes and a grey box. \
    This report compares them with the board: the fixed-point control step that runs on the \
    hardware, in closed loop with a motor model, with encoder, timing and PWM.\n\n\
    Each model has the same colour and line style in all figures. Some numbers in the paper \
    contradict each other. The suffix of a model's name identifies an interpretation of them; each \
    contradiction is explained beside a figure that it affects.\n\n\
    The data and figures of the paper were not available: where a figure is compared with one of \
    the paper, the comparison is with the paper's text. The paper states no amplitude, duration or \
    frequency of its inputs: those used here are choices of this project.";

/// Makes the page of a comparison.
///
/// # Errors
/// Does not fail with the built-in presets.
pub fn page(comparison: &Comparison) -> Result<Page, Error> {
    let mut page = Page::new(TITLE)
        .introduction(INTRODUCTION)
        .section(glance(comparison)?)
        .section(merits(comparison));
    for section in &SECTIONS {
        page = page.section(section.render(comparison));
    }
    page = page
        .section(frequency_response(comparison))
        .section(stability::section()?)
        .section(one_by_one(comparison));
    for outcome in &comparison.outcomes {
        page = page.parameters(parameters(outcome));
    }
    Ok(page)
}

fn glance(comparison: &Comparison) -> Result<Section, Error> {
    let [(_, leading), ..] = comparison.groups();
    // The pulse, simulated for as long as the variable step below it.
    let pulses: Vec<_> = leading
        .iter()
        .map(|o| pulse_of(&o.runs.model, 7.0))
        .collect::<Result<_, _>>()?;
    let pulses = leading
        .iter()
        .zip(&pulses)
        .map(|(o, trace)| (&o.runs.model, trace));
    let inputs = [
        ("pulse: angle (deg)", pulses.collect()),
        (
            "variable step: angle (deg)",
            shown(&leading, "variable-step"),
        ),
    ];
    Ok(Section::new("At a glance").figure(responses::angles("Step responses", &inputs).caption(
        "The paper's two validation inputs. The black boxes move at their rate limits almost until \
         they reach the command. Grey box and board agree with each other and slow down earlier: \
         with a position gain of 8 they command less than the rate limit when the error is below \
         35 deg.",
    )))
}

fn pulse_of(model: &Model, duration_s: f64) -> Result<Trace, Error> {
    let scenario = Scenario {
        duration_s: Some(duration_s),
        ..model.scenario("pulse")
    };
    scenario.resolve()?.record()
}

fn merits(comparison: &Comparison) -> Section {
    let section = Section::new("Figures of merit");
    tables::all(comparison)
        .into_iter()
        .fold(section, Section::table)
}

/// Adds a box for each contradiction.
pub(super) fn remarks(section: Section, contradictions: &[Contradiction]) -> Section {
    contradictions.iter().fold(section, |section, c| {
        section.titled_warning(c.title, c.text)
    })
}

/// Adds the warnings of the presets that the figure shows.
pub(super) fn warned(figure: Figure, outcomes: &[&Outcome]) -> Figure {
    outcomes.iter().fold(figure, |figure, outcome| {
        let preset = model_core::presets::preset(outcome.runs.model.preset);
        match preset.and_then(|preset| preset.warning) {
            Some(warning) => figure.warning(format!("{}: {warning}", outcome.runs.model.name)),
            None => figure,
        }
    })
}

/// The traces of these models on this input.
pub(super) fn shown<'a>(outcomes: &[&'a Outcome], input: &str) -> Vec<Shown<'a>> {
    let of = |outcome: &&'a Outcome| Some((&outcome.runs.model, outcome.runs.trace(input)?));
    outcomes.iter().filter_map(of).collect()
}

fn frequency_response(comparison: &Comparison) -> Section {
    const CAPTIONS: [&str; 3] = [
        "The paper's figure 11, with grey box and board added. Each line crosses half power at its \
         bandwidth.",
        "As-printed and as-printed-strict have the same loop F G as consistent and therefore the \
         same line: these interpretations differ in their limits only.",
        "Sampling and delays give the board more phase lag than the grey box. The default gains \
         with the motor as measured cause a resonance at 24 Hz. The bench has no line because it \
         is not linear: its friction, 3 % of the stall torque, and its backlash attenuate small \
         motions more than large ones.",
    ];
    let mut section = Section::new("Frequency response").text(
        "As in the paper's figure 11, the transport delay is not included. Lines are computed from \
         the parameters, without limits and quantization. Points are measured: the simulator, with \
         limits, encoder and timing, is driven by one sine after the other, and the delay of 17.5 ms \
         is removed from the phase. An amplitude of 5 deg is 57 encoder counts and reaches no limit; \
         as-printed-strict allows 1 deg only. A point is drawn where the motion is at least three \
         times larger than any motion within an octave that the sine does not cause, such as that \
         of quantization. If the motor has different gains up and down, the line is computed with \
         their harmonic mean.",
    );
    let groups = comparison.groups().into_iter().zip(CAPTIONS);
    for (i, ((group, outcomes), caption)) in groups.enumerate() {
        let title = format!("Bode plot: {group}");
        section = section.figure(bode::figure(&title, &outcomes).caption(caption));
        if i == 0 {
            section = remarks(
                section,
                &[contradictions::BANDWIDTHS, contradictions::SPEEDS],
            );
        }
    }
    section
}

fn one_by_one(comparison: &Comparison) -> Section {
    use Quantity::{Angle, Current, Duty, Rate};
    let figure = |outcome: &Outcome| {
        let title = format!("{} on the pulse", outcome.runs.model.name);
        let shown = shown(&[outcome], "pulse");
        warned(
            responses::figure(title, &shown, &[Angle, Rate, Duty, Current]),
            &[outcome],
        )
    };
    let section = Section::new("Each model on the pulse").text(
        "One figure for each model, as in the paper's figures 9, 10 and 12. A black box has no \
         duty. In as-printed, the duty has the paper's unit and no limit, and is far larger than \
         an H-bridge can apply.",
    );
    let section = remarks(section, &[contradictions::ENCODER]);
    section.gallery(comparison.outcomes.iter().map(figure))
}

fn parameters(outcome: &Outcome) -> Table {
    let columns = ["name", "symbol", "value", "unit", "meaning"].map(|name| (name, ""));
    let mut table = Table::new(outcome.runs.model.name, &columns);
    for value in outcome.runs.settings.values() {
        let p = value.parameter;
        let number = value.value.to_string();
        table.push([p.name, p.symbol, &number, p.unit, p.meaning].map(Cell::from));
    }
    table
}
