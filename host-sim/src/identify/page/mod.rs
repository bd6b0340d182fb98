//! The page of an identification: data against models, residuals, frequency response, parameters.

mod curves;
mod frequency;
mod residuals;
pub mod tables;

use super::{
    assessment::{Assessed, Assessment, SecondOpinion},
    compare::Ranking,
    data::Note,
};
use crate::report::{Page, Section};

const INTRODUCTION: &str = "Each model was simulated on the recorded command alone, and its parameters are those with \
    the least sum of squared differences to the recorded angle: output error in the time domain. \
    Standard errors are Cramer-Rao bounds. Residuals are measured less predicted angles.";

/// What stands on the page.
pub struct Content<'a> {
    /// The models.
    pub assessments: &'a [Assessment],
    /// Which of them is enough; `None` where that was not asked.
    pub ranking: Option<&'a Ranking>,
    /// What the recordings say without a model.
    pub second_opinion: &'a SecondOpinion,
    /// What was odd in the files.
    pub notes: &'a [Note],
}

/// The page.
pub fn page(content: &Content<'_>) -> Page {
    let page = Page::new("Identification").introduction(INTRODUCTION);
    let mut page = page.section(overview(content));
    for (title, of) in [
        (
            "Data and models",
            experiments as fn(&Assessment) -> &[Assessed],
        ),
        ("Validation: recordings left out of the fit", validation),
    ] {
        page = data(page, content, title, of);
    }
    page.section(residuals::section(content.assessments))
        .section(frequency::section(content))
        .section(parameters(content))
}

fn experiments(assessment: &Assessment) -> &[Assessed] {
    &assessment.experiments
}

fn validation(assessment: &Assessment) -> &[Assessed] {
    &assessment.validation
}

/// Figures of merit, the verdict, and everything that must be known first.
fn overview(content: &Content<'_>) -> Section {
    let mut section = Section::new("At a glance");
    if let Some(ranking) = content.ranking {
        section = section
            .note(format!("{}.", ranking.verdict))
            .table(tables::ranking(ranking, content.assessments));
    }
    section = section.table(tables::quality(content.assessments));
    for assessment in content.assessments {
        for warning in &assessment.warnings {
            section = section.warning(format!("{}: {warning}.", assessment.name));
        }
    }
    for note in content.notes {
        section = section.note(note.to_string());
    }
    section
}

/// A figure for each recording of one kind, where there is one.
fn data(
    page: Page,
    content: &Content<'_>,
    title: &str,
    of: fn(&Assessment) -> &[Assessed],
) -> Page {
    let count = content.assessments.first().map_or(0, |a| of(a).len());
    if count == 0 {
        return page;
    }
    let mut section = Section::new(title);
    for index in 0..count {
        let models = content.assessments.iter();
        let models = models.filter_map(|a| Some((a.name.as_str(), of(a).get(index)?)));
        section = section.figure(curves::figure(&models.collect::<Vec<_>>()));
    }
    page.section(section.table(tables::runs(content.assessments, of)))
}

fn parameters(content: &Content<'_>) -> Section {
    let mut section = Section::new("Parameters").text(
        "The standard error for white residuals is the Cramer-Rao bound with the variance of the \
         residuals; the other one allows for residuals that are correlated in time. A parameter at \
         its bound, or one that the experiments leave open, has none.",
    );
    for assessment in content.assessments {
        section = section.table(tables::parameters(assessment));
        section = section.table(tables::correlation(assessment));
    }
    section
}

#[cfg(test)]
mod tests;
