//! The page of a report: sections of text, figures and tables in one self-contained HTML file.

use std::fmt::Write as _;
use std::path::Path;

use super::table::Table;
use crate::error::Error;
use crate::file;
use crate::plot::Figure;
use crate::plot::html::{self, escape};

/// What stands in a section.
#[derive(Debug, Clone, PartialEq)]
enum Block {
    Text(String),
    Note(String),
    Warning(String),
    Remark(&'static str, &'static str),
    Folded(String, Vec<String>),
    Figures(Vec<Figure>),
    Table(Table),
}

/// A titled part of a page.
#[derive(Debug, Clone, PartialEq)]
pub struct Section {
    title: String,
    blocks: Vec<Block>,
}

impl Section {
    /// An empty section.
    ///
    /// ```
    /// # use host_sim::report::{Page, Section};
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

    /// With a text; empty lines part its paragraphs.
    pub fn text(self, text: impl Into<String>) -> Self {
        self.with(Block::Text(text.into()))
    }

    /// With a box that tells how something is to be read.
    pub fn note(self, text: impl Into<String>) -> Self {
        self.with(Block::Note(text.into()))
    }

    /// With a box that tells what is wrong or contradictory.
    pub fn warning(self, text: impl Into<String>) -> Self {
        self.with(Block::Warning(text.into()))
    }

    /// With a box that tells, under a title, what does not fit together.
    pub fn remark(self, title: &'static str, text: &'static str) -> Self {
        self.with(Block::Remark(title, text))
    }

    /// With warnings that nobody sees who does not open them under their title.
    pub fn folded(self, title: impl Into<String>, warnings: Vec<String>) -> Self {
        self.with(Block::Folded(title.into(), warnings))
    }

    /// With a figure. The page numbers its figures.
    pub fn figure(self, figure: Figure) -> Self {
        self.with(Block::Figures(vec![figure]))
    }

    /// With small figures, two beside each other where there is room.
    pub fn gallery(self, figures: impl IntoIterator<Item = Figure>) -> Self {
        self.with(Block::Figures(figures.into_iter().collect()))
    }

    /// With a table.
    pub fn table(self, table: Table) -> Self {
        self.with(Block::Table(table))
    }
}

/// A page.
#[derive(Debug, Clone, PartialEq)]
pub struct Page {
    title: String,
    introduction: String,
    sections: Vec<Section>,
    parameters: Vec<Table>,
}

impl Page {
    /// A page without sections.
    ///
    /// ```
    /// # use host_sim::report::Page;
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

    /// With this text before the sections; empty lines part its paragraphs.
    pub fn introduction(mut self, text: impl Into<String>) -> Self {
        self.introduction = text.into();
        self
    }

    /// With one more section.
    pub fn section(mut self, section: Section) -> Self {
        self.sections.push(section);
        self
    }

    /// With one more table of parameters in the footer.
    pub fn parameters(mut self, table: Table) -> Self {
        self.parameters.push(table);
        self
    }

    /// The page as HTML. It is the same for the same content: it carries no date.
    pub fn render(&self) -> String {
        let mut body = format!("<h1>{}</h1>\n", escape(&self.title));
        paragraphs(&mut body, &self.introduction);
        self.contents(&mut body);
        let mut figures = 0;
        for (number, section) in (1..).zip(&self.sections) {
            let title = escape(&section.title);
            let _ = writeln!(body, "<section id=\"section-{number}\">\n<h2>{title}</h2>");
            for block in &section.blocks {
                render_block(&mut body, block, &mut figures);
            }
            body.push_str("</section>\n");
        }
        self.footer(&mut body);
        html::document(&self.title, &body)
    }

    /// Writes the page, all of it or nothing.
    ///
    /// # Errors
    /// [`Error::Write`].
    pub fn write(&self, path: &Path) -> Result<(), Error> {
        file::write(path, &self.render())
    }

    /// The figures in their order.
    pub fn figures(&self) -> impl Iterator<Item = &Figure> {
        let blocks = self.sections.iter().flat_map(|section| &section.blocks);
        blocks.flat_map(|block| match block {
            Block::Figures(figures) => figures.as_slice(),
            _ => &[],
        })
    }

    fn contents(&self, body: &mut String) {
        if self.sections.is_empty() {
            return;
        }
        body.push_str("<nav aria-label=\"Contents\"><ol>\n");
        for (number, section) in (1..).zip(&self.sections) {
            let title = escape(&section.title);
            let _ = writeln!(body, "<li><a href=\"#section-{number}\">{title}</a></li>");
        }
        body.push_str("</ol></nav>\n");
        if self.figures().next().is_some() {
            body.push_str(html::HINT);
        }
    }

    fn footer(&self, body: &mut String) {
        let version = env!("CARGO_PKG_VERSION");
        let _ = writeln!(
            body,
            "<footer>\n<p>Written by smart-actuator {version}.</p>"
        );
        if !self.parameters.is_empty() {
            body.push_str("<details><summary>Parameters</summary>\n");
            for table in &self.parameters {
                body.push_str(&table.to_html());
            }
            body.push_str("</details>\n");
        }
        body.push_str("</footer>\n");
    }
}

fn render_block(body: &mut String, block: &Block, figures: &mut usize) {
    match block {
        Block::Text(text) => paragraphs(body, text),
        Block::Note(text) => boxed(body, "note", "", text),
        Block::Warning(text) => boxed(body, "warning", "", text),
        Block::Remark(title, text) => boxed(body, "warning", title, text),
        Block::Folded(title, warnings) => {
            let _ = writeln!(body, "<details><summary>{}</summary>", inline(title));
            for warning in warnings {
                boxed(body, "warning", "", warning);
            }
            body.push_str("</details>\n");
        }
        Block::Table(table) => body.push_str(&table.to_html()),
        Block::Figures(shown) => {
            let gallery = shown.len() > 1;
            body.push_str(if gallery {
                "<div class=\"gallery\">\n"
            } else {
                ""
            });
            for figure in shown {
                *figures += 1;
                body.push_str(&html::fragment(figure, *figures));
            }
            body.push_str(if gallery { "</div>\n" } else { "" });
        }
    }
}

fn paragraphs(body: &mut String, text: &str) {
    for paragraph in text.split("\n\n").filter(|p| !p.trim().is_empty()) {
        let _ = writeln!(body, "<p>{}</p>", inline(paragraph.trim()));
    }
}

fn boxed(body: &mut String, class: &str, title: &str, text: &str) {
    let title = match title {
        "" => String::new(),
        title => format!("<strong>{}</strong> ", escape(title)),
    };
    let _ = writeln!(body, "<p class=\"{class}\">{title}{}</p>", inline(text));
}

/// Escaped text with its names between `` ` `` as code.
fn inline(text: &str) -> String {
    let escaped = escape(text);
    let mut parts = escaped.split('`');
    let mut html = parts.next().unwrap_or_default().to_owned();
    while let Some(code) = parts.next() {
        let _ = match parts.next() {
            Some(after) => write!(html, "<code>{code}</code>{after}"),
            None => write!(html, "`{code}"),
        };
    }
    html
}
