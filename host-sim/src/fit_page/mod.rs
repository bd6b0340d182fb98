//! The page of an identification: data against models, residuals, frequency response, parameters.

mod curves;
mod frequency;
mod residuals;
pub mod tables;

use crate::page::{Page, Section};
use identification::{
    assessment::{Assessed, Assessment, SecondOpinion},
    compare::Ranking,
    data::Note,
};

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
    for note in content.notes {
        section = section.note(note.to_string());
    }
    warnings(section, content)
}

/// What speaks against each model. Of many, what concerns the one that is enough stands open.
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

/// Of more curves a figure cannot be read.
const MOST_CURVES: usize = 6;

/// The models whose curves are drawn: all of them, or of many the best that are whole.
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
    let shown = shown(content);
    let (all, drawn) = (content.assessments.len(), shown.len());
    if drawn < all {
        section = section.text(format!(
            "Of {all} models the curves are those of the best {drawn} from which nothing was left out; the \
             table has all."
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
