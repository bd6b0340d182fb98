//! `actuator report`.

use std::path::{Path, PathBuf};

use clap::Args;

use super::output;
use crate::error::Error;
use host_sim::{
    file,
    page::Page,
    plot::svg,
    report::{Comparison, document, models::MODELS, tables},
};

/// Runs every model on every input of the paper and writes the results as a page
///
/// The page is self-contained, and its tables are printed too. Each run writes the same bytes.
#[derive(Debug, Args)]
pub struct Report {
    /// The page
    #[arg(long, value_name = "FILE", default_value = "actuator-report.html")]
    out: PathBuf,
    #[command(flatten)]
    json: output::Json,
    /// Writes each figure of the page as an SVG into this folder
    #[arg(long, value_name = "DIR")]
    figures: Option<PathBuf>,
}

impl Report {
    pub(super) fn run(self) -> Result<(), Error> {
        let files: Vec<_> = [("--out", Some(&*self.out)), ("--json", self.json.file())]
            .into_iter()
            .filter_map(|(option, path)| Some((option, path?)))
            .collect();
        file::check(&files, [])?;
        if let Some(folder) = &self.figures {
            file::create_folder("--figures", folder)?;
        }
        let progress = output::progress(Comparison::steps(MODELS.len()), "runs");
        let comparison = Comparison::of(&MODELS, &|| progress.inc(1))?;
        progress.finish_and_clear();
        let page = document::page(&comparison)?;
        page.write(&self.out)?;
        if let Some(folder) = &self.figures {
            write_figures(&page, folder)?;
            note!("figures: {}", folder.display());
        }
        let print = || {
            let tables = tables::all(&comparison);
            tables.iter().try_for_each(output::print_table)
        };
        self.json.write(|| comparison.to_json(), print)?;
        note!("report: {}", self.out.display());
        Ok(())
    }
}

fn write_figures(page: &Page, folder: &Path) -> Result<(), Error> {
    for figure in page.figures() {
        let name = file_name(&figure.title) + ".svg";
        file::write(&folder.join(name), svg::render(figure))?;
    }
    Ok(())
}

/// A title as a file name: its letters and digits, and a hyphen for anything between them.
fn file_name(title: &str) -> String {
    let lower = title.replace('\'', "").to_lowercase();
    let words = lower.split(|c: char| !c.is_ascii_alphanumeric());
    words
        .filter(|word| !word.is_empty())
        .collect::<Vec<_>>()
        .join("-")
}
