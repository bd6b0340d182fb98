//! The outcomes of a campaign by class, as a picture.

use std::collections::BTreeMap;

use kuva::backend::svg::SvgBackend;
use kuva::plot::BarPlot;
use kuva::plot::legend::LegendPosition;
use kuva::render::layout::Layout;
use kuva::render::plots::Plot;
use kuva::render::render::render_multiple;

use crate::class::Class;
use crate::outcome::{Outcome, Verdict};

/// Size of the drawing without the bars, and height of a bar with its gap, px.
const WIDTH: f64 = 960.0;
const FRAME_HEIGHT: f64 = 80.0;
const BAR_HEIGHT: f64 = 20.0;

/// Outcomes that a bar shows as one part: its name and its colour. The colours are those of Okabe
/// and Ito, "Color Universal Design" (2008).
const PARTS: [(&str, &str, &[Outcome]); 5] = [
    (
        "no effect, small or short",
        "#bbbbbb",
        &[Outcome::NoEffect, Outcome::Small],
    ),
    (
        "detected and safe, also after a restart",
        "#009e73",
        &[Outcome::Detected, Outcome::Restarted],
    ),
    ("detected, coasting", "#e69f00", &[Outcome::Coasting]),
    ("detected, still driven", "#cc79a7", &[Outcome::Driven]),
    (
        "silent and hazardous, or not judged",
        "#d55e00",
        &[Outcome::Hazardous, Outcome::Unjudged],
    ),
];

/// A bar for each class: the shares of the outcomes, percent. A name ends with the number of
/// injections.
pub fn picture(verdicts: &BTreeMap<Class, Vec<Verdict>>) -> String {
    let mut plot = BarPlot::new().with_horizontal(true);
    // From bottom to top.
    for (class, verdicts) in verdicts.iter().rev() {
        let share = |outcomes: &[Outcome]| {
            let with_one = verdicts.iter().filter(|v| outcomes.contains(&v.outcome));
            100.0 * with_one.count() as f64 / verdicts.len() as f64
        };
        let label = format!("{} ({})", class.name(), verdicts.len());
        let parts = PARTS.map(|(_, colour, outcomes)| (share(outcomes), colour));
        plot = plot.with_group(label, parts);
    }
    let legend = PARTS.map(|(name, ..)| name);
    let plots = vec![Plot::Bar(plot.with_stacked().with_legend(legend.into()))];
    let layout = Layout::auto_from_plots(&plots)
        .with_x_label("share, %")
        .with_legend_position(LegendPosition::OutsideRightTop)
        .with_width(WIDTH)
        .with_height(FRAME_HEIGHT + BAR_HEIGHT * verdicts.len() as f64);
    SvgBackend::new().render_scene(&render_multiple(plots, layout)) + "\n"
}
