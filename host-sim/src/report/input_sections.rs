//! The sections on the inputs: their figures and words.

use super::{
    comparison::{Comparison, Outcome},
    contradictions::{self, Contradiction},
    document::{remarks, shown, warned},
    responses::{self, Quantity},
};
use crate::{page::Section, plot::Figure};

/// A section on one input.
pub(super) struct InputSection {
    input: &'static str,
    title: &'static str,
    text: &'static str,
    quantities: &'static [Quantity],
    /// What the figures of the three groups show.
    captions: [&'static str; 3],
    /// What one more figure shows, of all models; empty for none.
    all: &'static str,
    contradictions: &'static [Contradiction],
}

/// The sections in the order of the page.
pub(super) const SECTIONS: [InputSection; 6] = [
    InputSection {
        input: "pulse",
        title: "Pulse",
        text: "90 deg from 1 s to 3 s, as in the paper's figures 9, 10 and 12. A limit drives \
            every model for most of the way, of its rate or of its duty; they differ in how they \
            start and how they arrive.",
        quantities: &[Quantity::Angle, Quantity::Rate],
        captions: [
            "The black boxes run along +240 and −350 deg/s and part only where they arrive. Grey \
             box and board lie on each other but for some milliseconds at the end, the cost of \
             sampling, encoder and PWM.",
            "As printed, with the duty unlimited, the grey box follows the rise, overshoots the \
             peak and again overshoots zero: as the paper says of its figure 12. \
             With the duty limited to what a bridge can do, it does so by 1 % at the most.",
            "Average and switched PWM and the bench lie on each other. Around the motor as \
             measured the default gains leave 6.8 dB, and the rate answers to single encoder \
             counts; retuned, the board is as fast as the black boxes and quiet.",
        ],
        all: "All twelve. A click on a name hides or shows it.",
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
        text: "Thirteen steps, small and large, each held for half a second, as in the paper's \
            figure 13. The largest are too large to be followed in that time.",
        quantities: &[Quantity::Angle, Quantity::Rate],
        captions: [
            "The paper's figure 13 with the board in it. On the largest steps all models turn back \
             on the way; the black boxes have gone further by then.",
            "As printed the integrator winds up while the rate is limited and carries the shaft \
             far beyond the next command: the significant overshoot of which the paper speaks. \
             Only the anti-windup gain is ours, for the paper prints none.",
            "With the motor as measured the board reaches nearly as far as the black boxes.",
        ],
        all: "All twelve.",
        contradictions: &[contradictions::OVERSHOOT],
    },
    InputSection {
        input: "ramp",
        title: "Ramp",
        text: "60 deg/s up, down and up again, with holds. Only the strict reading is at its \
            limit. All others lag by the delay and by what their linear model adds.",
        quantities: &[Quantity::Angle, Quantity::Error],
        captions: [
            "60 deg/s times 17.5 ms of delay and 1/p, B/A or 1/P: 3.05, 4.65 and 8.55 deg.",
            "The lag depends on the position gain alone, which all readings share. At 37.4 deg/s \
             the strict one cannot follow.",
            "Retuned, the position gain is that of black box 2, and so is the lag.",
        ],
        all: "",
        contradictions: &[contradictions::RAMP_LAG],
    },
    InputSection {
        input: "chirp",
        title: "Chirp",
        text: "5 deg, from 0.1 Hz to 10 Hz in 20 s: half a hertz a second. The envelopes are the \
            gains of the frequency response below.",
        quantities: &[Quantity::Angle],
        captions: [
            "Black box 1 lets most through, then black box 2; grey box and board have 1.6 Hz.",
            "All readings but two are alike: as-measured has a faster motor, and the strict one is \
             at its duty limit.",
            "Retuned, the board follows about as black box 2 does.",
        ],
        all: "",
        contradictions: &[],
    },
    InputSection {
        input: "sine",
        title: "Sine",
        text: "20 deg at 1 Hz: 126 deg/s at the most, which all but the strict reading can do.",
        quantities: &[Quantity::Angle, Quantity::Error],
        captions: [
            "At this frequency the models differ in phase more than in gain.",
            "The strict reading runs at its limit almost all the time: a triangle of a quarter of \
             the amplitude.",
            "The boards, of which the retuned one lags least.",
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
            "The shortest unit is long enough for the black boxes, and not for a bandwidth of 1.6 \
             Hz.",
            "At 20 deg the duty is limited for short times only: as printed does not wind up here.",
            "The faster motor of as-measured helps little while the position gain is 8.",
        ],
        all: "",
        contradictions: &[],
    },
];

impl InputSection {
    /// The section.
    pub(super) fn render(&self, comparison: &Comparison) -> Section {
        let mut section = Section::new(self.title).text(self.text);
        let groups = comparison.groups().into_iter().zip(self.captions);
        for (i, ((group, outcomes), caption)) in groups.enumerate() {
            section = section.figure(self.figure(group, &outcomes, caption));
            if i == 0 {
                section = remarks(section, self.contradictions);
            }
        }
        if !self.all.is_empty() {
            section = section.figure(self.figure("all models", &comparison.all(), self.all));
        }
        section
    }

    fn figure(&self, group: &str, outcomes: &[&Outcome], caption: &str) -> Figure {
        let title = format!("{}: {group}", self.title);
        let figure = responses::figure(title, &shown(outcomes, self.input), self.quantities);
        warned(figure.caption(caption), outcomes)
    }
}
