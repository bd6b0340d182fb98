//! The page of the study, in Markdown, and its tables of numbers.

use std::fmt::Write as _;

use crate::{
    claims::{Claim, MAIN, PRINTED},
    figures::{PULSE_FIGURES, called, file},
    models::MODELS,
    runs::{CONDITIONS, INPUTS, Rate},
    study::Study,
};

/// What is made of the study beside the figures: the files with their texts.
pub fn files(study: &Study, claims: &[Claim]) -> Vec<(&'static str, String)> {
    vec![
        ("README.md", page(study, claims)),
        ("runs.csv", runs(study)),
        ("fits.csv", fits(study)),
    ]
}

const INTRODUCTION: &str = include_str!("page/introduction.md");
const LIMITS: &str = include_str!("page/limits.md");

fn page(study: &Study, claims: &[Claim]) -> String {
    let mut page = String::from(INTRODUCTION);
    page += "\n## The claims\n\n";
    page += "| | section | the paper says | here | why | figure |\n|---|---|---|---|---|---|\n";
    for (number, c) in (1..).zip(claims) {
        let verdict = c.verdict.name();
        let figure = format!("[figure]({})", c.figure);
        let _ = writeln!(
            page,
            "| {number} | {} | {} | **{verdict}** | {} | {figure} |",
            c.section, c.text, c.evidence
        );
    }
    page += "\n## The figures\n\nNumbered as in the paper. Grey: five runs. Above, models with the \
             paper's numbers; below, fitted here.\n";
    for number in [PULSE_FIGURES[0], PULSE_FIGURES[1], 11, PULSE_FIGURES[2], 13] {
        let _ = write!(
            page,
            "\n### Figure {number}\n\n![]({})\n\nThe same of ",
            file(number, MAIN)
        );
        let others = (0..CONDITIONS.len()).filter(|condition| *condition != MAIN);
        let links = others.map(|c| format!("[the {}]({})", called(c), file(number, c)));
        let _ = writeln!(page, "{}.", links.collect::<Vec<_>>().join(" and "));
    }
    page += "\n## How well each model fits\n\nFit (NRMSE, %) to the five runs of an input together, \
             recorded at 250 and at 50 Hz.\n\n";
    page += &quality_table(study);
    page += "\n## What a model fitted to one input makes of the others\n\nFit (%) on the five runs of \
             each input, recorded at 50 Hz, of the retuned loop without load. A row is fitted to the \
             input that it names.\n\n";
    page += &cross_table(study);
    page += "\n## Parameters\n\nOf the pulse at 250 Hz and at 50 Hz; standard errors allow for coloured \
             residuals.\n\n";
    page += &parameter_table(study);
    page += "\n## Which model is enough\n\nFitted to runs 1 to 3 of all inputs together at 50 Hz, judged \
             by runs 4 and 5.\n\n";
    for (condition, verdict) in study.verdicts.iter().enumerate() {
        let _ = writeln!(page, "- {}: {verdict}", called(condition));
    }
    page + "\n" + LIMITS
}

fn quality_table(study: &Study) -> String {
    let mut text = String::from("| condition | input |");
    for rate in Rate::ALL {
        for model in MODELS {
            let _ = write!(text, " {model}, {} Hz |", rate.hz());
        }
    }
    text += "\n|---|---|";
    text += &"---|".repeat(2 * MODELS.len());
    text.push('\n');
    for condition in 0..CONDITIONS.len() {
        for input in INPUTS {
            let _ = write!(text, "| {} | {input} |", called(condition));
            for rate in Rate::ALL {
                for model in 0..MODELS.len() {
                    let fit = study.fit(condition, rate, input, model);
                    let percent = fit.map_or(f64::NAN, |f| f.quality.fit_percent);
                    let _ = write!(text, " {percent:.2} |");
                }
            }
            text.push('\n');
        }
    }
    text
}

fn cross_table(study: &Study) -> String {
    let mut text = String::from("| model | fitted to |");
    text += &INPUTS.map(|input| format!(" {input} |")).concat();
    text += "\n|---|---|";
    text += &"---|".repeat(INPUTS.len());
    text.push('\n');
    for (model, name) in MODELS.iter().enumerate() {
        for input in INPUTS {
            let Some(fit) = study.fit(MAIN, Rate::Hz50, input, model) else {
                continue;
            };
            let percent = fit
                .predicted
                .iter()
                .map(|q| q.map_or(f64::NAN, |q| q.fit_percent));
            let cells = percent.map(|percent| format!(" {percent:.1} |"));
            let _ = writeln!(text, "| {name} | {input} |{}", cells.collect::<String>());
        }
    }
    text
}

fn parameter_table(study: &Study) -> String {
    let mut text = String::from("| condition | model | parameter | unit | 250 Hz | 50 Hz |\n");
    text += "|---|---|---|---|---|---|\n";
    for condition in [PRINTED, MAIN, 2] {
        for (model, name) in MODELS.iter().enumerate() {
            let of = |rate| study.fit(condition, rate, "pulse", model);
            let (Some(fine), Some(coarse)) = (of(Rate::Hz250), of(Rate::Hz50)) else {
                continue;
            };
            let shared = fine
                .fit
                .estimates
                .iter()
                .filter(|e| !e.fixed && e.experiment.is_none());
            for e in shared {
                let number = |estimate: Option<&identification::Estimate>| {
                    estimate.map_or(String::from("–"), |e| {
                        with_error(e.value, e.standard_error_coloured)
                    })
                };
                let row = [
                    called(condition),
                    (*name).into(),
                    format!("`{}`", e.name),
                    e.unit.into(),
                ];
                let values = [number(Some(e)), number(coarse.fit.estimate(e.name))];
                let _ = writeln!(text, "| {} | {} |", row.join(" | "), values.join(" | "));
            }
        }
    }
    text
}

fn with_error(value: f64, error: f64) -> String {
    match error.is_finite() {
        true => format!("{value:.4} ± {error:.2e}"),
        false => format!("{value:.4}, not identifiable"),
    }
}

/// A row a run: what was recorded, so that another machine can tell whether it has the same.
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

/// A row a parameter of a fit.
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
