//! The page: what stands on it, in which order and in which words.

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

const INTRODUCTION: &str = "In “Analysis of Modeling Techniques for Low-Cost Actuators” Carlson, \
    Dorobantu, Taylor and Seiler compare three models of a servo: two black boxes and a grey box. \
    Here they stand beside the board itself: the fixed-point control step that runs on the \
    hardware, in closed loop with a motor, with encoder, timing and PWM.\n\n\
    Each model keeps its line through the whole page. The numbers of the paper contradict each \
    other; a name behind a model is a reading of them, and what contradicts what stands beside the \
    figure that it touches.\n\n\
    The data and figures of the paper were not at hand: where a figure is said to be like one of \
    the paper's, it follows the paper's words. Nor does the paper print any amplitude, duration or \
    frequency of its inputs: those are choices of this project.";

/// The page of a comparison.
///
/// # Errors
/// None with the presets as they are.
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
    // The pulse once more, as long as the variable step below it.
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
        "The paper's two validation inputs. The black boxes turn at the limits of their rate until \
         they are there; grey box and board slow down earlier, for a position gain of 8 asks for \
         less rate than the limit from 35 deg on, and agree with each other.",
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

/// The section with these boxes.
pub(super) fn remarks(section: Section, contradictions: &[Contradiction]) -> Section {
    contradictions.iter().fold(section, |section, c| {
        section.titled_warning(c.title, c.text)
    })
}

/// The figure with what must be said of the presets in it.
pub(super) fn warned(figure: Figure, outcomes: &[&Outcome]) -> Figure {
    outcomes.iter().fold(figure, |figure, outcome| {
        let preset = model_core::presets::preset(outcome.runs.model.preset);
        match preset.and_then(|preset| preset.warning) {
            Some(warning) => figure.warning(format!("{}: {warning}", outcome.runs.model.name)),
            None => figure,
        }
    })
}

/// What these models did on this input.
pub(super) fn shown<'a>(outcomes: &[&'a Outcome], input: &str) -> Vec<Shown<'a>> {
    let of = |outcome: &&'a Outcome| Some((&outcome.runs.model, outcome.runs.trace(input)?));
    outcomes.iter().filter_map(of).collect()
}

fn frequency_response(comparison: &Comparison) -> Section {
    const CAPTIONS: [&str; 3] = [
        "The paper's figure 11 with grey box and board. Each line passes through half power at its \
         bandwidth.",
        "As printed and strict have the loop F G of consistent, and so its line: what tells these \
         readings apart are limits.",
        "The board's samples and delays turn the phase beyond that of the grey box. The default \
         gains around the motor as measured leave a resonance at 24 Hz. The bench has points \
         alone: its friction, 3 % of the stall torque, and its backlash hold back small motions \
         more than large ones.",
    ];
    let mut section = Section::new("Frequency response").text(
        "As in the paper's figure 11 the transport delay is left out. Lines are computed from the \
         parameters, without limits and rounding. Points are measured: sine by sine through the \
         simulator with its limits, encoder and timing, the delay of 17.5 ms then taken out of the \
         phase. A sine of 5 deg is 57 encoder counts and leaves every limit alone; the strict reading \
         bears 1 deg. Where the motor's gains up and down differ, the line is that of their harmonic \
         mean.",
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
    let section = Section::new("Each model by itself").text(
        "The pulse, a figure for each model, as the paper's figures 9, 10 and 12. A black box has \
         no duty. As printed, the duty is in the paper's unit and without limit, far from anything \
         that a bridge can do.",
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
