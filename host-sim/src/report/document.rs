//! The page: what stands on it, in which order and in which words.

use super::{
    Cell, Page, Section, Table, bode,
    comparison::{Comparison, Outcome},
    contradictions,
    responses::{self, Quantity, Shown},
    stability, tables,
};
use crate::{error::Error, plot::Figure};

const TITLE: &str = "Models of a low-cost actuator, and a board that is one";

const INTRODUCTION: &str = "Carlson, Dorobantu, Taylor and Seiler compare three models of a servo in “Analysis of \
    Modeling Techniques for Low-Cost Actuators”: two black boxes and a grey box. Here they are computed beside the \
    board itself: the fixed-point control step that runs on the hardware, in closed loop with a motor, with encoder, \
    delay and PWM.\n\n\
    Each model has one line through the whole page. The paper's data and figures were not at hand: where a figure \
    is said to be like one of the paper's, it follows the paper's words. The paper prints no amplitude, duration or \
    frequency of its inputs either; those are choices of this project.";

/// A section on one input.
struct InputSection {
    input: &'static str,
    title: &'static str,
    text: &'static str,
    quantities: &'static [Quantity],
    /// Whether one more figure shows all models.
    all: bool,
    contradictions: &'static [&'static str],
}

const INPUT_SECTIONS: [InputSection; 6] = [
    InputSection {
        input: "pulse",
        title: "Pulse",
        text: "90 deg from 1 s to 3 s, as in the paper's figures 9, 10 and 12. All models but the strict reading \
            are driven by a limit on most of the way, of the rate or of the duty; what differs is how they \
            arrive.",
        quantities: &[Quantity::Angle, Quantity::Rate],
        all: true,
        contradictions: &[
            contradictions::MOTOR_GAIN,
            contradictions::RATE_LIMITS,
            contradictions::DELAY,
            contradictions::IDENTIFICATION,
        ],
    },
    InputSection {
        input: "variable-step",
        title: "Variable step",
        text: "Fourteen steps of half a second, small and large, as in the paper's figure 13. The largest cannot \
            be followed in that time.",
        quantities: &[Quantity::Angle, Quantity::Rate],
        all: true,
        contradictions: &[contradictions::OVERSHOOT],
    },
    InputSection {
        input: "ramp",
        title: "Ramp",
        text: "60 deg/s up, down and up again. No limit acts, but for the strict reading; the lag behind the command is the delay plus \
            what the model adds: 1/p, B/A or 1/P.",
        quantities: &[Quantity::Angle, Quantity::Error],
        all: false,
        contradictions: &[contradictions::RAMP_LAG],
    },
    InputSection {
        input: "chirp",
        title: "Chirp",
        text: "5 deg, from 0.1 Hz to 10 Hz in 20 s. The envelope is the gain of the frequency response below.",
        quantities: &[Quantity::Angle],
        all: false,
        contradictions: &[],
    },
    InputSection {
        input: "sine",
        title: "Sine",
        text: "20 deg at 1 Hz.",
        quantities: &[Quantity::Angle, Quantity::Error],
        all: false,
        contradictions: &[],
    },
    InputSection {
        input: "3-2-1-1",
        title: "3-2-1-1",
        text: "20 deg in units of 0.3 s: three up, two down, one up, one down.",
        quantities: &[Quantity::Angle, Quantity::Rate],
        all: false,
        contradictions: &[],
    },
];

/// The page of a comparison.
///
/// # Errors
/// None with the presets as they are.
pub fn page(comparison: &Comparison) -> Result<Page, Error> {
    let mut page = Page::new(TITLE)
        .introduction(INTRODUCTION)
        .section(glance(comparison))
        .section(merits(comparison));
    for section in &INPUT_SECTIONS {
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

fn glance(comparison: &Comparison) -> Section {
    let section = Section::new("At a glance");
    let Some((_, leading)) = comparison.groups().into_iter().next() else {
        return section;
    };
    let inputs = [
        ("pulse", "pulse: angle (deg)"),
        ("variable-step", "variable step: angle (deg)"),
    ];
    let inputs = inputs.map(|(input, label)| (label, shown(&leading, input)));
    section.figure(responses::angles("Step responses", &inputs).caption(
        "The paper's two validation inputs. The black boxes turn at the limits of their rate until they are there; \
         grey box and board slow down earlier, for a position gain of 8 asks for less rate than the limit from \
         35 deg on, and agree with each other.",
    ))
}

fn merits(comparison: &Comparison) -> Section {
    let section = Section::new("Figures of merit");
    tables::all(comparison)
        .into_iter()
        .fold(section, Section::table)
}

impl InputSection {
    fn render(&self, comparison: &Comparison) -> Section {
        let mut section = Section::new(self.title).text(self.text);
        for (i, (group, outcomes)) in comparison.groups().into_iter().enumerate() {
            section = section.figure(self.figure(group, &outcomes));
            if i == 0 {
                section = self
                    .contradictions
                    .iter()
                    .fold(section, |s, text| s.warning(*text));
            }
        }
        if self.all {
            let all: Vec<_> = comparison.outcomes.iter().collect();
            section = section.figure(self.figure("all models", &all));
        }
        section
    }

    fn figure(&self, group: &str, outcomes: &[&Outcome]) -> Figure {
        let title = format!("{}: {group}", self.title);
        let figure = responses::figure(title, &shown(outcomes, self.input), self.quantities);
        warned(figure, outcomes)
    }
}

fn warned(figure: Figure, outcomes: &[&Outcome]) -> Figure {
    outcomes.iter().fold(figure, |figure, outcome| {
        let preset = model_core::presets::preset(outcome.runs.model.preset);
        match preset.and_then(|preset| preset.warning) {
            Some(warning) => figure.warning(format!("{}: {warning}", outcome.runs.model.name)),
            None => figure,
        }
    })
}

fn shown<'a>(outcomes: &[&'a Outcome], input: &str) -> Vec<Shown<'a>> {
    let of = |outcome: &&'a Outcome| Some((&outcome.runs.model, outcome.runs.trace(input)?));
    outcomes.iter().filter_map(of).collect()
}

fn frequency_response(comparison: &Comparison) -> Section {
    let mut section = Section::new("Frequency response").text(
        "As in the paper's figure 11 the transport delay is left out. Lines are computed from the parameters, without \
         limits and rounding. Points are measured: a sine of 5 deg (1 deg for the strict reading) through the simulator, \
         rounding and limits included, and its delay of 17.5 ms taken out of the phase. Where the \
         motor's two gains differ the line is that of their harmonic mean.",
    );
    for (i, (group, outcomes)) in comparison.groups().into_iter().enumerate() {
        let title = format!("Bode plot: {group}");
        section = section.figure(bode::figure(&title, &outcomes));
        if i == 0 {
            section = section
                .warning(contradictions::BANDWIDTHS)
                .warning(contradictions::SPEEDS);
        }
    }
    section.note(
        "The bench has points alone: its friction, 3 % of the stall torque, and its backlash answer to small amplitudes \
         otherwise than to large ones. The readings `as-printed` and `as-printed-strict` have the loop F G of \
         `consistent` and so lie on its line.",
    )
}

fn one_by_one(comparison: &Comparison) -> Section {
    use Quantity::{Angle, Current, Duty, Rate};
    let figure = |outcome: &Outcome| {
        let title = format!("{} on the pulse", outcome.runs.model.name);
        warned(
            responses::figure(
                title,
                &shown(&[outcome], "pulse"),
                &[Angle, Rate, Duty, Current],
            ),
            &[outcome],
        )
    };
    Section::new("Each model by itself")
        .text("The pulse, a figure for each model, as the paper's figures 9, 10 and 12.")
        .warning(contradictions::ENCODER)
        .gallery(comparison.outcomes.iter().map(figure))
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
