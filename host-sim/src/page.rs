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

/// One part of a section.
#[derive(Debug, Clone, PartialEq)]
enum Block {
    Text(String),
    Note(String),
    Warning {
        title: String,
        text: String,
    },
    Collapsed {
        title: String,
        warnings: Vec<String>,
    },
    Figures {
        /// Number of the first figure in the page.
        first: usize,
        figures: Vec<Figure>,
    },
    Table(Table),
}

/// A titled part of a page.
#[derive(Debug, Clone, PartialEq)]
pub struct Section {
    title: String,
    blocks: Vec<Block>,
}

impl Section {
    /// Creates an empty section.
    ///
    /// ```
    /// # use host_sim::page::{Page, Section};
    /// let html = Page::new("Report").section(Section::new("Steps").note("by eye")).render();
    /// assert_eq!(html.matches("by eye").count(), 1);
    /// ```
    pub fn new(title: impl Into<String>) -> Self {
        Self {
            title: title.into(),
            blocks: Vec::new(),
        }
    }

    fn with(mut self, block: Block) -> Self {
        self.blocks.push(block);
        self
    }

    /// Adds text. Empty lines separate its paragraphs.
    pub fn text(self, text: impl Into<String>) -> Self {
        self.with(Block::Text(text.into()))
    }

    /// Adds a box that explains how to read the section.
    pub fn note(self, text: impl Into<String>) -> Self {
        self.with(Block::Note(text.into()))
    }

    /// Adds a box that reports a problem.
    pub fn warning(self, text: impl Into<String>) -> Self {
        self.titled_warning("", text)
    }

    /// Adds a box that reports a problem under a title.
    pub fn titled_warning(self, title: impl Into<String>, text: impl Into<String>) -> Self {
        self.with(Block::Warning {
            title: title.into(),
            text: text.into(),
        })
    }

    /// Adds warnings that are hidden until the reader opens their title.
    pub fn collapsed_warnings(self, title: impl Into<String>, warnings: Vec<String>) -> Self {
        self.with(Block::Collapsed {
            title: title.into(),
            warnings,
        })
    }

    /// Adds a figure. The page numbers its figures.
    pub fn figure(self, figure: Figure) -> Self {
        self.gallery([figure])
    }

    /// Adds small figures, two side by side where the window is wide enough.
    pub fn gallery(self, figures: impl IntoIterator<Item = Figure>) -> Self {
        self.with(Block::Figures {
            first: 1,
            figures: figures.into_iter().collect(),
        })
    }

    /// Adds a table.
    pub fn table(self, table: Table) -> Self {
        self.with(Block::Table(table))
    }
}

/// A page.
#[derive(Debug, Clone, PartialEq, Template)]
#[template(path = "page.html")]
pub struct Page {
    title: String,
    introduction: String,
    sections: Vec<Section>,
    parameters: Vec<Table>,
}

impl Page {
    /// Creates a page without sections.
    ///
    /// ```
    /// # use host_sim::page::Page;
    /// assert_eq!(Page::new("Report").render().matches("<h1>Report</h1>").count(), 1);
    /// ```
    pub fn new(title: impl Into<String>) -> Self {
        Self {
            title: title.into(),
            introduction: String::new(),
            sections: Vec::new(),
            parameters: Vec::new(),
        }
    }

    /// Sets the text before the sections. Empty lines separate its paragraphs.
    pub fn introduction(mut self, text: impl Into<String>) -> Self {
        self.introduction = text.into();
        self
    }

    /// Adds a section and numbers its figures.
    pub fn section(mut self, mut section: Section) -> Self {
        let mut number = 1 + self.figures().count();
        for block in &mut section.blocks {
            if let Block::Figures { first, figures } = block {
                *first = number;
                number += figures.len();
            }
        }
        self.sections.push(section);
        self
    }

    /// Adds a table of parameters to the footer.
    pub fn parameters(mut self, table: Table) -> Self {
        self.parameters.push(table);
        self
    }

    /// Renders the page as HTML. Equal content gives equal bytes: the page has no date.
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
        blocks.flat_map(|block| match block {
            Block::Figures { figures, .. } => figures.as_slice(),
            _ => &[],
        })
    }
}

#[cfg(test)]
mod tests;
