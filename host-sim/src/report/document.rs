//! The page of the report: its sections in their order, and their texts.

use super::{
    bode,
    comparison::{Comparison, Outcome},
    contradictions,
    input_sections::SECTIONS,
    models::Model,
    responses::{self, Quantity, shown, warned},
    stability, tables,
};
use crate::{
    error::Error,
    page::{Block, Page, Section},
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
    let mut sections = vec![glance(comparison)?, merits(comparison)];
    sections.extend(SECTIONS.iter().map(|section| section.render(comparison)));
    sections.extend([
        frequency_response(comparison),
        stability::section()?,
        one_by_one(comparison),
    ]);
    Ok(Page {
        title: TITLE,
        introduction: INTRODUCTION,
        sections,
        parameters: comparison.outcomes.iter().map(parameters).collect(),
    })
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
    let figure = responses::angles("Step responses", &inputs).caption(
        "The paper's two validation inputs. The black boxes move at their rate limits almost until \
         they reach the command. Grey box and board agree with each other and slow down earlier: \
         with a position gain of 8 they command less than the rate limit when the error is below \
         35 deg.",
    );
    Ok(Section::new("At a glance", [figure.into()]))
}

fn pulse_of(model: &Model, duration_s: f64) -> Result<Trace, Error> {
    let scenario = Scenario {
        duration_s: Some(duration_s),
        ..model.scenario("pulse")
    };
    scenario.resolve()?.record()
}

fn merits(comparison: &Comparison) -> Section {
    let tables = tables::all(comparison).into_iter().map(Block::Table);
    Section::new("Figures of merit", tables.collect::<Vec<_>>())
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
    let mut blocks: Vec<Block> = vec![
        "As in the paper's figure 11, the transport delay is not included. Lines are computed from \
         the parameters, without limits and quantization. Points are measured: the simulator, with \
         limits, encoder and timing, is driven by one sine after the other, and the delay of 17.5 ms \
         is removed from the phase. An amplitude of 5 deg is 57 encoder counts and reaches no limit; \
         as-printed-strict allows 1 deg only. A point is drawn where the motion is at least three \
         times larger than any motion within an octave that the sine does not cause, such as that \
         of quantization. If the motor has different gains up and down, the line is computed with \
         their harmonic mean."
            .into(),
    ];
    let groups = comparison.groups().into_iter().zip(CAPTIONS);
    for (i, ((group, outcomes), caption)) in groups.enumerate() {
        let title = format!("Bode plot: {group}");
        let figure = bode::figure(&title, &outcomes).caption(caption);
        blocks.push(if i == 0 { figure } else { figure.detail() }.into());
        if i == 0 {
            blocks.extend([&contradictions::BANDWIDTHS, &contradictions::SPEEDS].map(Block::from));
        }
    }
    Section::new("Frequency response", blocks)
}

fn one_by_one(comparison: &Comparison) -> Section {
    use Quantity::{Angle, Current, Duty, Rate};
    let figure = |outcome: &Outcome| {
        let title = format!("{} on the pulse", outcome.runs.model.name);
        let shown = shown(&[outcome], "pulse");
        warned(
            responses::figure(title, &shown, &[Angle, Rate, Duty, Current]).detail(),
            &[outcome],
        )
    };
    let blocks = [
        "One figure for each model, as in the paper's figures 9, 10 and 12. A black box has no \
         duty. In as-printed, the duty has the paper's unit and no limit, and is far larger than \
         an H-bridge can apply."
            .into(),
        (&contradictions::ENCODER).into(),
        Block::Figures(comparison.outcomes.iter().map(figure).collect()),
    ];
    Section::new("Each model on the pulse", blocks)
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
