//! The page of an identification: data against models, residuals, frequency response, parameters.

mod curves;
mod frequency;
mod residuals;
pub mod tables;

use crate::page::{Block, Page, Section};
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
    /// How the page was made: date, program and command; empty for figures alone.
    pub origin: &'a str,
}

/// Makes the page.
pub fn page(content: &Content<'_>) -> Page {
    let mut sections = vec![overview(content)];
    sections.extend(data(content, "Data and models", |a| &a.experiments));
    let validation = "Validation: each recording predicted by a fit without it";
    sections.extend(data(content, validation, |a| &a.validation));
    sections.extend([
        residuals::section(content.assessments),
        frequency::section(content),
        parameters(content),
    ]);
    Page {
        title: "Identification",
        introduction: INTRODUCTION,
        sections,
        parameters: Vec::new(),
    }
}

/// Origin, verdict, estimates, figures of merit, and only then notes and warnings.
fn overview(content: &Content<'_>) -> Section {
    let mut blocks = Vec::new();
    if !content.origin.is_empty() {
        blocks.push(content.origin.into());
    }
    if let Some(ranking) = content.ranking {
        blocks.push(Block::Note(format!("{}.", ranking.verdict)));
        blocks.push(tables::ranking(ranking, content.assessments).into());
    }
    let estimates = content.assessments.iter().enumerate();
    let estimates = estimates.filter(|(index, _)| is_chosen(content, *index));
    blocks.extend(estimates.map(|(_, a)| tables::parameters(a).into()));
    blocks.push(tables::quality(content.assessments).into());
    let notes = content
        .notes
        .iter()
        .map(|note| Block::Note(note.to_string()));
    blocks.extend(notes.chain(warnings(content)));
    Section::new("At a glance", blocks)
}

/// Whether a model is the chosen one, as each is where they were not ranked.
fn is_chosen(content: &Content<'_>, index: usize) -> bool {
    content
        .ranking
        .is_none_or(|ranking| ranking.enough == index)
}

/// The warnings of each model. If the models were ranked, only those of the chosen one are
/// expanded.
fn warnings(content: &Content<'_>) -> Vec<Block> {
    let mut blocks = Vec::new();
    for (index, assessment) in content.assessments.iter().enumerate() {
        let name = &assessment.name;
        let all = assessment.warnings.iter();
        let all: Vec<String> = all.map(|warning| format!("{name}: {warning}.")).collect();
        if is_chosen(content, index) {
            let warning = |text| Block::Warning(String::new(), text);
            blocks.extend(all.into_iter().map(warning));
        } else if !all.is_empty() {
            let title = format!("{name}: {} warnings", all.len());
            blocks.push(Block::Collapsed(title, all));
        }
    }
    blocks
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
fn data(content: &Content<'_>, title: &str, of: fn(&Assessment) -> &[Assessed]) -> Option<Section> {
    let count = content.assessments.first().map_or(0, |a| of(a).len());
    if count == 0 {
        return None;
    }
    let mut blocks = Vec::new();
    let shown = shown(content);
    let (all, drawn) = (content.assessments.len(), shown.len());
    if drawn < all {
        blocks.push(Block::Text(format!(
            "The curves are those of the best {drawn} complete models of {all}; the table lists all \
             models."
        )));
    }
    for index in 0..count {
        let models = shown.iter();
        let models = models.filter_map(|a| Some((a.name.as_str(), of(a).get(index)?)));
        blocks.push(curves::figure(&models.collect::<Vec<_>>()).into());
    }
    blocks.push(tables::runs(content.assessments, of).into());
    Some(Section::new(title, blocks))
}

fn parameters(content: &Content<'_>) -> Section {
    let mut blocks: Vec<Block> = vec![
        "The standard error for white residuals is the Cramer-Rao bound with the variance of the \
         residuals; the coloured one accounts for residuals that are correlated in time. A parameter \
         that is at its bound or not identifiable has no standard error."
            .into(),
    ];
    for (index, assessment) in content.assessments.iter().enumerate() {
        // Those of the others are at a glance.
        if !is_chosen(content, index) {
            blocks.push(tables::parameters(assessment).into());
        }
        blocks.push(tables::correlation(assessment).into());
    }
    Section::new("Parameters", blocks)
}

#[cfg(test)]
mod tests;
