//! The sections on the inputs: their figures and texts.

use super::{
    comparison::{Comparison, Outcome},
    contradictions::{self, Contradiction},
    responses::{self, Quantity, shown, warned},
};
use crate::{
    page::{Block, Section},
    plot::Figure,
};

/// A section on one input.
pub(super) struct InputSection {
    input: &'static str,
    title: &'static str,
    text: &'static str,
    quantities: &'static [Quantity],
    /// Captions of the figures of the three groups.
    captions: [&'static str; 3],
    /// Caption of a figure of all models; empty for no such figure.
    all: &'static str,
    contradictions: &'static [Contradiction],
}

/// The sections in the order of the page.
pub(super) const SECTIONS: [InputSection; 6] = [
    InputSection {
        input: "pulse",
        title: "Pulse",
        text: "90 deg from 1 s to 3 s, as in the paper's figures 9, 10 and 12. During most of the \
            motion each model is at a limit, of its rate or of its duty. The models differ in how \
            they accelerate and how they approach the command.",
        quantities: &[Quantity::Angle, Quantity::Rate],
        captions: [
            "The black boxes move at +240 and −350 deg/s and differ only near the command. Grey box \
             and board agree, except for some milliseconds at the end that are caused by sampling, \
             encoder and PWM.",
            "As-printed has no duty limit: the grey box follows the rise, overshoots the peak and \
             then overshoots zero, as the paper describes its figure 12. With the duty limited to \
             100 % the overshoot is 1 % at most.",
            "Average PWM, switched PWM and the bench agree. With the motor as measured the default \
             gains leave a gain margin of 6.8 dB, and the rate shows single encoder counts. The \
             retuned board is as fast as the black boxes and its rate is smooth.",
        ],
        all: "All twelve models. Click a name to hide or show its curve.",
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
        text: "Thirteen steps of different sizes, each held for half a second, as in the paper's \
            figure 13. No model reaches the largest ones in that time.",
        quantities: &[Quantity::Angle, Quantity::Rate],
        captions: [
            "The paper's figure 13, with the board added. On the largest steps all models reverse \
             before they reach the command; the black boxes get further than the others.",
            "In as-printed the integrator winds up while the rate is limited and drives the shaft \
             far beyond the next command: the significant overshoot that the paper mentions. The \
             anti-windup gain is a choice of this project, because the paper states none.",
            "With the motor as measured the board gets nearly as far as the black boxes.",
        ],
        all: "All twelve models.",
        contradictions: &[contradictions::OVERSHOOT],
    },
    InputSection {
        input: "ramp",
        title: "Ramp",
        text: "60 deg/s up, down and up again, with holds. Only as-printed-strict is at its limit. \
            The lag of the others is the delay plus the lag of the linear model.",
        quantities: &[Quantity::Angle, Quantity::Error],
        captions: [
            "The lag is 60 deg/s times the sum of the delay, 17.5 ms, and 1/p, B/A or 1/P: 3.05, \
             4.65 and 8.55 deg.",
            "The lag depends on the position gain only, which is the same in all interpretations. \
             As-printed-strict reaches 37.4 deg/s and cannot follow.",
            "The retuned board has the equivalent position gain of black box 2 and the same lag.",
        ],
        all: "",
        contradictions: &[contradictions::RAMP_LAG],
    },
    InputSection {
        input: "chirp",
        title: "Chirp",
        text: "5 deg, from 0.1 Hz to 10 Hz in 20 s: half a hertz per second. The envelopes follow \
            the gains of the frequency response below.",
        quantities: &[Quantity::Angle],
        captions: [
            "Black box 1 has the largest bandwidth, black box 2 the second largest; grey box and \
             board have 1.6 Hz.",
            "All interpretations but two agree: as-measured has a faster motor, and \
             as-printed-strict is at its duty limit.",
            "The retuned board behaves much like black box 2.",
        ],
        all: "",
        contradictions: &[],
    },
    InputSection {
        input: "sine",
        title: "Sine",
        text: "20 deg at 1 Hz: 126 deg/s at most, which all models but as-printed-strict reach.",
        quantities: &[Quantity::Angle, Quantity::Error],
        captions: [
            "At this frequency the models differ in phase more than in gain.",
            "As-printed-strict is at its limit almost all the time: its output is a triangle of a \
             quarter of the amplitude.",
            "The retuned board has the smallest lag.",
        ],
        all: "",
        contradictions: &[],
    },
    InputSection {
        input: "3-2-1-1",
        title: "3-2-1-1",
        text: "20 deg in units of 0.3 s: three up, two down, one up, one down.",
        quantities: &[Quantity::Angle, Quantity::Rate],
        captions: [
            "The shortest pulse is long enough for the black boxes, but not for a bandwidth of \
             1.6 Hz.",
            "At 20 deg the duty is limited for short times only: as-printed does not wind up here.",
            "With a position gain of 8 the faster motor of as-measured has little effect.",
        ],
        all: "",
        contradictions: &[],
    },
];

impl InputSection {
    /// Makes the section.
    pub(super) fn render(&self, comparison: &Comparison) -> Section {
        let mut blocks: Vec<Block> = vec![self.text.into()];
        let groups = comparison.groups().into_iter().zip(self.captions);
        for (i, ((group, outcomes), caption)) in groups.enumerate() {
            let figure = self.figure(group, &outcomes, caption);
            blocks.push(if i == 0 { figure } else { figure.detail() }.into());
            if i == 0 {
                blocks.extend(self.contradictions.iter().map(Block::from));
            }
        }
        if !self.all.is_empty() {
            blocks.push(
                self.figure("all models", &comparison.all(), self.all)
                    .detail()
                    .into(),
            );
        }
        Section::new(self.title, blocks)
    }

    fn figure(&self, group: &str, outcomes: &[&Outcome], caption: &str) -> Figure {
        let title = format!("{}: {group}", self.title);
        let figure = responses::figure(title, &shown(outcomes, self.input), self.quantities);
        warned(figure.caption(caption), outcomes)
    }
}
