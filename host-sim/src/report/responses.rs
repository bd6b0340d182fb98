//! Figures of models over time.

use super::{
    comparison::Outcome,
    curves::{Curve, panel},
    models::Model,
};
use crate::{
    plot::{Figure, Panel},
    trace::Trace,
};

/// A model with its trace. The traces of a figure have the same times.
pub type Shown<'a> = (&'a Model, &'a Trace);

/// The quantity of a panel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// The angle, with the command.
    Angle,
    /// The command minus the angle.
    Error,
    /// The rate.
    Rate,
    /// The duty, for models that have one.
    Duty,
    /// The current, for models that have one.
    Current,
}

impl Quantity {
    fn label(self) -> &'static str {
        match self {
            Self::Angle => "angle (deg)",
            Self::Error => "command − angle (deg)",
            Self::Rate => "rate (deg/s)",
            Self::Duty => "duty (%)",
            Self::Current => "current (A)",
        }
    }

    fn of(self, (model, trace): Shown) -> Option<Vec<f64>> {
        let column = |name| trace.column(name).map(<[f64]>::to_vec);
        match self {
            Self::Angle => column("angle_deg"),
            Self::Rate => column("rate_deg_s"),
            Self::Duty => column("duty_pct").filter(|_| model.has_duty()),
            Self::Current => column("current_a"),
            Self::Error => {
                let command = trace.column("command_deg")?.iter();
                let angle = trace.column("angle_deg")?;
                Some(
                    command
                        .zip(angle)
                        .map(|(command, angle)| command - angle)
                        .collect(),
                )
            }
        }
    }
}

/// The traces of these models, one panel for each quantity that any of them has.
pub fn figure(title: impl Into<String>, shown: &[Shown], quantities: &[Quantity]) -> Figure {
    let of = |quantity: &Quantity| panel_of(*quantity, quantity.label(), shown);
    let panels = quantities.iter().filter_map(of);
    panels.fold(Figure::new(title, "time (s)"), Figure::panel)
}

/// The angle for several inputs, one labelled panel for each.
pub fn angles(title: &str, inputs: &[(&str, Vec<Shown>)]) -> Figure {
    let of = |(label, shown): &(&str, Vec<Shown>)| panel_of(Quantity::Angle, label, shown);
    let panels = inputs.iter().filter_map(of);
    panels.fold(Figure::new(title, "time (s)"), Figure::panel)
}

fn panel_of(quantity: Quantity, label: &str, shown: &[Shown]) -> Option<Panel> {
    let (_, first) = shown.first()?;
    let command = first
        .column("command_deg")
        .filter(|_| quantity == Quantity::Angle);
    let of = |shown: &Shown| Some(Curve::of(shown.0, quantity.of(*shown)?));
    let mut models: Vec<_> = shown.iter().filter_map(of).collect();
    if let [alone] = &mut models[..] {
        alone.undash();
    }
    if models.is_empty() {
        return None;
    }
    let curves: Vec<_> = command
        .map(Curve::command)
        .into_iter()
        .chain(models)
        .collect();
    Some(panel(label, first.column("time_s")?, &curves))
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
