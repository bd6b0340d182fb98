//! The page of an identification: data against models, residuals, frequency response, parameters.

mod curves;
mod frequency;
mod residuals;
pub mod tables;

use crate::page::{Page, Section};
use identification::{
    assessment::{Assessed, Assessment, NonparametricAnalysis},
    compare::Ranking,
    data::Note,
};

const INTRODUCTION: &str = "Each model is simulated with the recorded command as its only input. Its \
    parameters minimise the sum of the squared differences to the recorded angle: output error in \
    the time domain. Standard errors are Cramer-Rao bounds. Residuals are measured minus predicted \
    angles.";

/// The content of the page.
pub struct Content<'a> {
    /// The models.
    pub assessments: &'a [Assessment],
    /// The ranking of the models; `None` if they were not compared.
    pub ranking: Option<&'a Ranking>,
    /// The analysis of the recordings without a model.
    pub nonparametric: &'a NonparametricAnalysis,
    /// Notes about the files of the recordings.
    pub notes: &'a [Note],
}

/// Makes the page.
pub fn page(content: &Content<'_>) -> Page {
    let page = Page::new("Identification").introduction(INTRODUCTION);
    let mut page = page.section(overview(content));
    for (title, of) in [
        (
            "Data and models",
            experiments as fn(&Assessment) -> &[Assessed],
        ),
        (
            "Validation: each recording predicted by a fit without it",
            validation,
        ),
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

/// The verdict, figures of merit, notes and warnings.
fn overview(content: &Content<'_>) -> Section {
    let mut section = Section::new("At a glance");
    if let Some(ranking) = content.ranking {
        section = section
            .note(format!("{}.", ranking.verdict))
            .table(tables::ranking(ranking, content.assessments));
    }
    section = section.table(tables::quality(content.assessments));
    for note in content.notes {
        section = section.note(note.to_string());
    }
    warnings(section, content)
}

/// The warnings of each model. If the models were ranked, only those of the chosen one are
/// expanded.
fn warnings(mut section: Section, content: &Content<'_>) -> Section {
    for (index, assessment) in content.assessments.iter().enumerate() {
        let is_chosen = content
            .ranking
            .is_none_or(|ranking| ranking.enough == index);
        let name = &assessment.name;
        let all = assessment.warnings.iter();
        let all: Vec<String> = all.map(|warning| format!("{name}: {warning}.")).collect();
        if is_chosen {
            section = all.into_iter().fold(section, Section::warning);
        } else if !all.is_empty() {
            section = section.collapsed_warnings(format!("{name}: {} warnings", all.len()), all);
        }
    }
    section
}

/// A figure with more curves is not readable.
const MOST_CURVES: usize = 6;

/// The models whose curves are drawn: all, or the best complete ones of many.
fn shown<'a>(content: &Content<'a>) -> Vec<&'a Assessment> {
    let all = content.assessments;
    if all.len() <= MOST_CURVES {
        return all.iter().collect();
    }
    let place = |a: &Assessment| match content.ranking {
        Some(ranking) => {
            let mut ranks = ranking.ranks.iter();
            ranks.position(|rank| std::ptr::eq(&all[rank.index], a))
        }
        None => Some(all.iter().filter(|b| b.fit.cost < a.fit.cost).count()),
    };
    let mut whole: Vec<&Assessment> = all.iter().filter(|a| a.name == a.fit.model).collect();
    whole.sort_by_key(|a| place(a));
    whole.truncate(MOST_CURVES);
    whole
}

/// A section with a figure for each recording of one kind, if there are any.
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
    let shown = shown(content);
    let (all, drawn) = (content.assessments.len(), shown.len());
    if drawn < all {
        section = section.text(format!(
            "The curves are those of the best {drawn} complete models of {all}; the table lists all \
             models."
        ));
    }
    for index in 0..count {
        let models = shown.iter();
        let models = models.filter_map(|a| Some((a.name.as_str(), of(a).get(index)?)));
        section = section.figure(curves::figure(&models.collect::<Vec<_>>()));
    }
    page.section(section.table(tables::runs(content.assessments, of)))
}

fn parameters(content: &Content<'_>) -> Section {
    let mut section = Section::new("Parameters").text(
        "The standard error for white residuals is the Cramer-Rao bound with the variance of the \
         residuals; the coloured one accounts for residuals that are correlated in time. A parameter \
         that is at its bound or not identifiable has no standard error.",
    );
    for assessment in content.assessments {
        section = section.table(tables::parameters(assessment));
        section = section.table(tables::correlation(assessment));
    }
    section
}

#[cfg(test)]
mod tests;
