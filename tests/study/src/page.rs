//! The page of the study in Markdown (`templates/page.md`), and its tables as CSV.

use std::fmt::Write as _;

use askama::Template;
use host_sim::table::{Cell, Table};

use crate::{
    claims::{Claim, MAIN},
    figures::{PULSE_FIGURES, called, file},
    models::MODELS,
    runs::{CONDITIONS, INPUTS, SampleRate},
    spread,
    study::Study,
};

/// The files of the study, except for the figures.
pub fn files(study: &Study, claims: &[Claim]) -> Vec<(&'static str, String)> {
    vec![
        ("README.md", page(study, claims)),
        ("runs.csv", runs(study)),
        ("fits.csv", fits(study)),
    ]
}

/// The number of a figure in the paper, the file of the main condition, and name and file of each
/// other condition.
type Figure = (u32, String, Vec<(String, String)>);

#[derive(Template)]
#[template(path = "page.md")]
struct Page<'a> {
    claims: &'a [Claim],
    figures: Vec<Figure>,
    quality: Table,
    cross: Table,
    spread: Table,
    verdicts: Vec<(String, &'a str)>,
}

fn page(study: &Study, claims: &[Claim]) -> String {
    let figure = |number: u32| {
        let others = (0..CONDITIONS.len()).filter(|condition| *condition != MAIN);
        let others = others.map(|c| (called(c), file(number, c)));
        (number, file(number, MAIN), others.collect())
    };
    let verdicts = study.verdicts.iter().enumerate();
    let page = Page {
        claims,
        figures: [PULSE_FIGURES[0], PULSE_FIGURES[1], 11, PULSE_FIGURES[2], 13]
            .map(figure)
            .into(),
        quality: quality_table(study),
        cross: cross_table(study),
        spread: spread::table(study),
        verdicts: verdicts
            .map(|(c, verdict)| (called(c), verdict.as_str()))
            .collect(),
    };
    // Writing to a string does not fail.
    page.render().unwrap_or_default() + "\n"
}

fn table<S: AsRef<str>>(columns: &[S]) -> Table {
    let columns: Vec<_> = columns.iter().map(|name| (name.as_ref(), "")).collect();
    Table::new("", &columns)
}

fn quality_table(study: &Study) -> Table {
    let labels = ["condition", "input"].into_iter();
    let mut table = table(&labels.chain(MODELS).collect::<Vec<_>>());
    for condition in 0..CONDITIONS.len() {
        for input in INPUTS {
            let cells = (0..MODELS.len()).map(|model| {
                let fit = study.fit(condition, SampleRate::Hz250, input, model);
                Cell::optional(fit.map(|f| f.quality.fit_percent), 2)
            });
            let labels = [Cell::from(called(condition)), input.into()];
            table.push(labels.into_iter().chain(cells));
        }
    }
    table
}

fn cross_table(study: &Study) -> Table {
    let mut table = table(&[&["model", "fitted to"][..], &INPUTS].concat());
    for (model, name) in MODELS.iter().enumerate() {
        for input in INPUTS {
            let Some(fit) = study.fit(MAIN, SampleRate::Hz50, input, model) else {
                continue;
            };
            let percent = fit.predicted.iter();
            let cells = percent.map(|q| Cell::optional(q.as_ref().map(|q| q.fit_percent), 1));
            table.push([Cell::from(*name), input.into()].into_iter().chain(cells));
        }
    }
    table
}

/// One row for each run, with a checksum that shows whether another machine has the same data.
fn runs(study: &Study) -> String {
    let mut text = String::from("controller,load,input,run,samples,checksum\n");
    for run in &study.runs {
        let _ = writeln!(text, "{}", run_row(run));
    }
    text
}

/// The row of a run in `runs.csv`.
pub fn run_row(run: &crate::runs::Run) -> String {
    let key = run.key;
    let (controller, load) = (key.controller.name(), key.load.name());
    let (input, checksum) = (INPUTS[key.input], run.checksum());
    format!(
        "{controller},{load},{input},{},{},{checksum:016x}",
        key.run,
        run.len()
    )
}

/// One row for each parameter of each fit.
fn fits(study: &Study) -> String {
    let mut text = String::from(
        "controller,load,rate_hz,input,model,fit_percent,rms_deg,parameter,unit,estimate,\
         standard_error,standard_error_coloured\n",
    );
    for ((condition, rate, input, model), fitted) in &study.fits {
        let (controller, load) = CONDITIONS[*condition];
        let (controller, load, hz) = (controller.name(), load.name(), rate.hz());
        let (input, model) = (INPUTS[*input], MODELS[*model]);
        let (percent, rms) = (fitted.quality.fit_percent, fitted.quality.rms_deg);
        for e in fitted
            .fit
            .estimates
            .iter()
            .filter(|e| e.experiment.is_none() && !e.fixed)
        {
            let _ = writeln!(
                text,
                "{controller},{load},{hz},{input},{model},{percent:.4},{rms:.5},{},{},{:.7e},{:.3e},\
                 {:.3e}",
                e.name, e.unit, e.value, e.standard_error, e.standard_error_coloured
            );
        }
    }
    text
}
