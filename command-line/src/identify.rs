//! `actuator identify`.

mod data;
mod search;

use std::path::{Path, PathBuf};

use clap::{
    Args,
    builder::{PossibleValue, PossibleValuesParser},
};

pub use data::{DataOptions, Loaded};
pub use search::{SearchOptions, loss_names};

use super::{origin, output};
use crate::error::Error;
use host_sim::{
    file,
    fit_page::{self, Content, tables},
};
use identification::{
    assessment::{Assessment, NonparametricAnalysis},
    compare::Ranking,
    document, models, parameter_file,
};

/// Fits models to recordings, and estimates the uncertainty of each parameter
///
/// A recording is a text file with one line per sample and a header with the names of the columns,
/// as `simulate --csv` writes it, JSON, MAT, a workbook of Excel, Parquet or a log of ArduPilot,
/// also compressed. Warnings about files and fits go to standard error.
#[derive(Debug, Args)]
pub struct Identify {
    #[command(flatten)]
    data: DataOptions,
    /// Model to fit; repeatable [default: black-box-1, black-box-2 and grey-box]
    #[arg(long, value_name = "NAME", value_parser = model_names())]
    model: Vec<String>,
    #[command(flatten)]
    search: SearchOptions,
    #[command(flatten)]
    outputs: Outputs,
    /// Writes the fitted parameters of one model, for `simulate --parameters`
    #[arg(long, value_name = "FILE")]
    parameters: Option<PathBuf>,
}

/// Files for the results.
#[derive(Debug, Args)]
pub struct Outputs {
    #[command(flatten)]
    json: output::Json,
    /// Writes a self-contained page with all figures
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
}

/// The models that are fitted by default: those of the paper.
const USUAL: [&str; 3] = ["black-box-1", "black-box-2", "grey-box"];

/// The names of the models, with their summaries.
pub fn model_names() -> PossibleValuesParser {
    let value = |m: std::sync::Arc<dyn identification::Model>| {
        PossibleValue::new(m.name()).help(m.summary())
    };
    PossibleValuesParser::new(models::all().into_iter().map(value))
}

impl Identify {
    pub(super) fn run(mut self) -> Result<(), Error> {
        let joints = self.data.joints()?;
        if joints.is_empty() {
            return self.run_one();
        }
        if self.outputs.has_file() || self.parameters.is_some() {
            let problem = "a file of results is of one joint, expected --joint beside it";
            return Err(Error::Conflict(problem.into()));
        }
        // A joint that is not moved does not end the run.
        let mut open = Vec::new();
        for joint in joints {
            output::print(&format!("\n{joint}\n"))?;
            self.data.joint = Some(joint.clone());
            if let Err(error) = self.run_one() {
                note!("error: {error}");
                open.push(joint);
            }
        }
        match open.is_empty() {
            true => Ok(()),
            false => Err(Error::Refused(format!("not fitted: {}", open.join(", ")))),
        }
    }

    fn run_one(&self) -> Result<(), Error> {
        let names = match self.model.is_empty() {
            true => USUAL.map(String::from).to_vec(),
            false => self.model.clone(),
        };
        if self.parameters.is_some() && names.len() > 1 {
            let problem = "--parameters is of one model, expected one --model beside it";
            return Err(Error::Conflict(problem.into()));
        }
        self.outputs.check(self.parameters.as_deref(), &self.data)?;
        let chosen: Vec<_> = names
            .iter()
            .filter_map(|name| models::named(name))
            .collect();
        self.data.check(&chosen)?;
        self.search.check(&chosen)?;
        let loaded = self.data.load(&chosen)?;
        let assessments = self.search.fit(chosen, &loaded)?;
        let nonparametric = NonparametricAnalysis::of(&loaded.fitted);
        if let Some(path) = &self.parameters {
            for assessment in &assessments {
                let text = parameter_file::text(&assessment.fit)?;
                file::write(path, text)?;
            }
            note!("parameters: {}", path.display());
        }
        let found = Found {
            assessments: &assessments,
            ranking: None,
            nonparametric: &nonparametric,
            loaded: &loaded,
        };
        self.outputs.write(&found)?;
        // Behind the estimates.
        for assessment in &assessments {
            for warning in &assessment.warnings {
                note!("warning: {}: {warning}", assessment.name);
            }
        }
        converged(&assessments)
    }
}

/// Whether all fits have converged.
///
/// # Errors
/// With the names of those that have not.
pub fn converged(assessments: &[Assessment]) -> Result<(), Error> {
    let open = assessments.iter().filter(|a| !a.fit.has_converged());
    let open: Vec<String> = open.map(|a| a.name.clone()).collect();
    match open.is_empty() {
        true => Ok(()),
        false => Err(Error::NotConverged(open)),
    }
}

/// The results.
pub struct Found<'a> {
    /// The fitted models.
    pub assessments: &'a [Assessment],
    /// The ranking of the models; `None` unless they are compared.
    pub ranking: Option<&'a Ranking>,
    /// Estimates without a model.
    pub nonparametric: &'a NonparametricAnalysis,
    /// The recordings.
    pub loaded: &'a Loaded,
}

impl Outputs {
    /// Whether a file, or JSON on standard output, is wanted.
    fn has_file(&self) -> bool {
        self.json.is_given() || self.html.is_some()
    }

    /// Checks in advance that the files can be written, are different, and are not those of the
    /// data.
    pub fn check(&self, parameters: Option<&Path>, data: &DataOptions) -> Result<(), Error> {
        let all = [
            ("--json", self.json.file()),
            ("--html", self.html.as_deref()),
            ("--parameters", parameters),
        ];
        let given = all.into_iter().filter_map(|(o, path)| Some((o, path?)));
        Ok(file::check(&given.collect::<Vec<_>>(), data.files())?)
    }

    /// Writes the files, and prints tables unless JSON goes to standard output.
    pub fn write(&self, found: &Found<'_>) -> Result<(), Error> {
        if let Some(path) = &self.html {
            let content = Content {
                assessments: found.assessments,
                ranking: found.ranking,
                nonparametric: found.nonparametric,
                notes: &found.loaded.notes,
                origin: &origin::of_this_run(),
            };
            fit_page::page(&content).write(path)?;
            note!("report: {}", path.display());
        }
        self.json.write(|| json(found), || print(found))
    }
}

fn json(found: &Found<'_>) -> String {
    let notes = &found.loaded.notes;
    document::text(found.assessments, found.ranking, found.nonparametric, notes)
}

fn print(found: &Found<'_>) -> Result<(), Error> {
    match found.ranking {
        Some(ranking) => output::print_table(&tables::ranking(ranking, found.assessments))?,
        None => {
            let tables = found.assessments.iter().map(tables::parameters);
            tables
                .into_iter()
                .try_for_each(|table| output::print_table(&table))?;
        }
    }
    output::print_table(&tables::quality(found.assessments))?;
    let held_out = tables::held_out(found.assessments);
    if held_out.columns.len() > 2 {
        output::print_table(&held_out)?;
    }
    let systems = tables::equivalents(found.nonparametric);
    if !systems.rows.is_empty() {
        output::print_table(&systems)?;
    }
    output::print_table(&tables::delays(found.nonparametric))?;
    match found.ranking {
        Some(ranking) => output::print(&format!("\n{}.\n", ranking.verdict)),
        None => Ok(()),
    }
}
