//! The models of the report, each with its colour and line style.

use crate::{
    plot::Style,
    scenario::Scenario,
    settings::{ModelKind, PlantKind, Pwm},
};

/// The group of figures in which a model is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Family {
    /// A black box of the paper.
    BlackBox,
    /// The grey box, in one of the interpretations of the paper.
    GreyBox,
    /// The board's own control step.
    Board,
}

/// A model of the report.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Model {
    /// Its name.
    pub name: &'static str,
    /// Its family, which is drawn together.
    pub family: Family,
    /// Whether it is drawn in the figures that compare the families.
    pub leads: bool,
    /// Colour of its line, an index into [`crate::plot::palette::PALETTE`].
    pub colour: usize,
    /// Style of its line.
    pub style: Style,
    kind: ModelKind,
    plant: Option<PlantKind>,
    pwm: Pwm,
    /// The preset.
    pub preset: &'static str,
    /// Amplitude with which its frequency response is measured, deg.
    ///
    /// Small enough to stay below all limits: one degree requires a duty of up to `Kp P`, 10.5 % by
    /// default, so that 5 deg require 53 %, and 94 % in the worst resonance, that of
    /// `board as-measured`; black box 1 moves at up to `p` times the amplitude, 150 deg/s. Large
    /// enough for the encoder: 5 deg are 57 counts, and the rounding to counts, 0.025 deg RMS, is
    /// 0.5 % of them. In as-printed-strict `Kp P` is 80 % per degree, which allows 1 deg. The grey
    /// box has no encoder.
    pub sweep_amplitude_deg: f64,
}

impl Model {
    /// Its scenario with this input.
    pub fn scenario(&self, input: &str) -> Scenario {
        Scenario {
            model: Some(self.kind),
            plant: self.plant,
            preset: Some(self.preset.into()),
            pwm: Some(self.pwm),
            input: Some(input.into()),
            ..Scenario::default()
        }
    }

    /// Whether it drives a motor: a black box has no duty.
    pub fn has_duty(&self) -> bool {
        self.family != Family::BlackBox
    }

    const fn new(
        name: &'static str,
        family: Family,
        kind: ModelKind,
        preset: &'static str,
    ) -> Self {
        Self {
            name,
            family,
            leads: false,
            colour: 0,
            style: Style::Line,
            kind,
            plant: None,
            pwm: Pwm::Average,
            preset,
            sweep_amplitude_deg: 5.0,
        }
    }

    const fn black_box(name: &'static str, kind: ModelKind) -> Self {
        Self::new(name, Family::BlackBox, kind, "paper").leading()
    }

    const fn grey_box(name: &'static str, preset: &'static str) -> Self {
        Self::new(name, Family::GreyBox, ModelKind::GreyBox, preset)
    }

    const fn board(name: &'static str, preset: &'static str) -> Self {
        Self::new(name, Family::Board, ModelKind::Board, preset)
    }

    /// A board that is not in [`MODELS`].
    pub(super) const fn literal(name: &'static str) -> Self {
        Self::board(name, "consistent").drawn(PINK, Style::Line)
    }

    const fn leading(mut self) -> Self {
        self.leads = true;
        self
    }

    const fn drawn(mut self, colour: usize, style: Style) -> Self {
        self.colour = colour;
        self.style = style;
        self
    }
}

const BLUE: usize = 1;
const RED: usize = 2;
const GREEN: usize = 3;
const PINK: usize = 4;
const ORANGE: usize = 5;
const SKY: usize = 6;
const GREY: usize = 7;

/// The name of the model with which the others are compared.
pub const BASELINE: &str = "board";

/// The models. Related models share a colour: `board as-measured-retuned` has the linear loop of
/// `black-box-2`. Models that coincide with others are dashed, so that both are visible.
pub const MODELS: [Model; 12] = [
    Model::black_box("black-box-1", ModelKind::BlackBox1).drawn(BLUE, Style::Line),
    Model::black_box("black-box-2", ModelKind::BlackBox2).drawn(RED, Style::Dashed),
    Model::grey_box("grey-box", "consistent")
        .leading()
        .drawn(GREEN, Style::Line),
    Model::grey_box("grey-box asymmetric", "asymmetric").drawn(GREEN, Style::Dashed),
    Model::grey_box("grey-box as-measured", "as-measured").drawn(SKY, Style::Dashed),
    Model::grey_box("grey-box as-printed", "as-printed").drawn(ORANGE, Style::Line),
    Model {
        sweep_amplitude_deg: 1.0,
        ..Model::grey_box("grey-box as-printed-strict", "as-printed-strict")
            .drawn(ORANGE, Style::Dashed)
    },
    Model::board(BASELINE, "consistent")
        .leading()
        .drawn(PINK, Style::Dashed),
    Model {
        pwm: Pwm::Switched,
        ..Model::board("board, switched PWM", "consistent").drawn(PINK, Style::Line)
    },
    Model::board("board as-measured", "as-measured").drawn(SKY, Style::Line),
    Model::board("board as-measured-retuned", "as-measured-retuned").drawn(RED, Style::Line),
    Model {
        plant: Some(PlantKind::Drivetrain),
        ..Model::board("board on the bench", "consistent").drawn(GREY, Style::Line)
    },
];
