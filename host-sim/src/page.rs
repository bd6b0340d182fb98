//! A page of sections with text, figures and tables, as one self-contained HTML file.
//!
//! The HTML is in `templates/page.html`. The report and the page of an identification use it.

use std::path::Path;

use askama::Template;

use crate::{
    file::{self, WriteError},
    plot::Figure,
    table::Table,
};

/// A part of a section. Empty lines separate the paragraphs of a text.
#[derive(Debug, Clone, PartialEq)]
pub enum Block {
    /// Text.
    Text(String),
    /// A box that explains how to read the section.
    Note(String),
    /// A box that reports a problem, with a title that may be empty.
    Warning(String, String),
    /// Warnings that are hidden until the reader opens their title.
    Collapsed(String, Vec<String>),
    /// Figures; several are small, two side by side where the window is wide enough.
    Figures(Vec<Figure>),
    /// A table.
    Table(Table),
}

impl From<&str> for Block {
    fn from(text: &str) -> Self {
        Self::Text(text.into())
    }
}

impl From<Figure> for Block {
    fn from(figure: Figure) -> Self {
        Self::Figures(vec![figure])
    }
}

impl From<Table> for Block {
    fn from(table: Table) -> Self {
        Self::Table(table)
    }
}

/// A titled part of a page.
#[derive(Debug, Clone, PartialEq)]
pub struct Section {
    title: String,
    blocks: Vec<Block>,
}

impl Section {
    /// Creates a section.
    pub fn new(title: impl Into<String>, blocks: impl Into<Vec<Block>>) -> Self {
        Self {
            title: title.into(),
            blocks: blocks.into(),
        }
    }
}

/// A page.
#[derive(Debug, Clone, PartialEq, Template)]
#[template(path = "page.html")]
pub struct Page {
    /// The title.
    pub title: &'static str,
    /// The text before the sections. Empty lines separate its paragraphs.
    pub introduction: &'static str,
    /// The sections; their figures are numbered through.
    pub sections: Vec<Section>,
    /// The tables of the footer.
    pub parameters: Vec<Table>,
}

impl Page {
    /// Renders the page as HTML. Equal content has equal bytes: the page has no date.
    pub fn render(&self) -> String {
        // Writing to a string does not fail.
        Template::render(self).unwrap_or_default()
    }

    /// Writes the page to a file. An incomplete write leaves the old file unchanged.
    ///
    /// # Errors
    /// That of the operating system.
    pub fn write(&self, path: &Path) -> Result<(), WriteError> {
        file::write(path, self.render())
    }

    /// The figures in their order.
    pub fn figures(&self) -> impl Iterator<Item = &Figure> {
        let blocks = self.sections.iter().flat_map(|section| &section.blocks);
        blocks.flat_map(figures_of)
    }

    /// Number of figures that are not printed.
    fn details(&self) -> usize {
        self.figures().filter(|figure| figure.is_detail).count()
    }

    /// The number of the first figure of a block of this page.
    fn first_number(&self, block: &Block) -> usize {
        let mut blocks = self.sections.iter().flat_map(|section| &section.blocks);
        let before = blocks
            .by_ref()
            .take_while(|other| !std::ptr::eq(*other, block));
        1 + before.map(|other| figures_of(other).len()).sum::<usize>()
    }
}

fn figures_of(block: &Block) -> &[Figure] {
    match block {
        Block::Figures(figures) => figures,
        _ => &[],
    }
}

#[cfg(test)]
mod tests;
