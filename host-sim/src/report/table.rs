//! Tables of numbers with units, for the page and for the terminal.

use std::fmt::{self, Write as _};

use comfy_table::{CellAlignment, ContentArrangement, presets};

use crate::plot::html::escape;

/// One entry of a table.
#[derive(Debug, Clone, PartialEq)]
pub enum Cell {
    /// Words.
    Text(String),
    /// A value, shown with this many decimals. NaN and infinities are shown as a dash.
    Number(f64, usize),
    /// Nothing that could be said: shown as a dash.
    None,
}

impl fmt::Display for Cell {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Text(text) => f.write_str(text),
            Self::Number(value, decimals) if value.is_finite() => {
                let text = format!("{value:.decimals$}");
                // What is rounded to zero has no sign.
                let is_zero = !text.contains(|c: char| ('1'..='9').contains(&c));
                f.write_str(text.trim_start_matches(if is_zero { "-" } else { "" }))
            }
            Self::Number(..) | Self::None => f.write_str("–"),
        }
    }
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl From<String> for Cell {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

/// A column's heading.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Column {
    /// What stands in it.
    pub name: String,
    /// In which unit; empty where there is none.
    pub unit: String,
}

/// Rows of cells under named columns.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// What the table shows.
    pub caption: String,
    /// The headings.
    pub columns: Vec<Column>,
    /// Each row has a cell a column; what lacks is shown empty.
    pub rows: Vec<Vec<Cell>>,
}

impl Table {
    /// An empty table with these columns, each a name and a unit.
    ///
    /// ```
    /// # use host_sim::report::{Cell, Table};
    /// let mut table = Table::new("Steps", &[("model", ""), ("rise time", "ms")]);
    /// table.push(["black-box-1".into(), Cell::Number(73.24, 1)]);
    /// assert!(table.to_terminal(80).contains("73.2"));
    /// ```
    pub fn new(caption: impl Into<String>, columns: &[(&str, &str)]) -> Self {
        let column = |(name, unit): &(&str, &str)| Column {
            name: (*name).to_owned(),
            unit: (*unit).to_owned(),
        };
        Self {
            caption: caption.into(),
            columns: columns.iter().map(column).collect(),
            rows: Vec::new(),
        }
    }

    /// Appends a row.
    pub fn push(&mut self, row: impl IntoIterator<Item = Cell>) {
        self.rows.push(row.into_iter().collect());
    }

    /// Whether a column holds numbers, which are aligned on the right.
    fn is_numeric(&self, column: usize) -> bool {
        let cells = || self.rows.iter().filter_map(|row| row.get(column));
        cells().any(|c| matches!(c, Cell::Number(..)))
            && !cells().any(|c| matches!(c, Cell::Text(_)))
    }

    /// The table as text of at most `width` columns; cells are wrapped where it is narrow.
    pub fn to_terminal(&self, width: u16) -> String {
        let mut table = comfy_table::Table::new();
        table
            .load_style(presets::UTF8_FULL_CONDENSED)
            .set_content_arrangement(ContentArrangement::Dynamic)
            .set_width(width)
            .set_header(self.columns.iter().map(|c| match c.unit.as_str() {
                "" => c.name.clone(),
                unit => format!("{}\n({unit})", c.name),
            }));
        for row in &self.rows {
            table.add_row(row.iter().map(Cell::to_string));
        }
        for index in (0..self.columns.len()).filter(|&i| self.is_numeric(i)) {
            if let Some(column) = table.column_mut(index) {
                column.set_cell_alignment(CellAlignment::Right);
            }
        }
        format!("{}\n{table}", self.caption)
    }

    /// The table as HTML.
    pub fn to_html(&self) -> String {
        let class = |i| {
            if self.is_numeric(i) {
                " class=\"number\""
            } else {
                ""
            }
        };
        let mut html = format!(
            "<div class=\"table\"><table class=\"data\">\n<caption>{}</caption>\n<thead><tr>",
            escape(&self.caption)
        );
        for (i, column) in self.columns.iter().enumerate() {
            let _ = write!(
                html,
                "<th scope=\"col\"{}>{}",
                class(i),
                escape(&column.name)
            );
            if !column.unit.is_empty() {
                let _ = write!(
                    html,
                    " <span class=\"unit\">({})</span>",
                    escape(&column.unit)
                );
            }
            html.push_str("</th>");
        }
        html.push_str("</tr></thead>\n<tbody>\n");
        for row in &self.rows {
            html.push_str("<tr>");
            for (i, cell) in row.iter().enumerate() {
                let _ = write!(html, "<td{}>{}</td>", class(i), escape(&cell.to_string()));
            }
            html.push_str("</tr>\n");
        }
        html + "</tbody></table></div>\n"
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table() -> Table {
        let mut table = Table::new("Steps & <ramps>", &[("model", ""), ("t90", "ms")]);
        table.push(["a<b".into(), Cell::Number(76.753, 1)]);
        table.push(["none".into(), Cell::Number(f64::NAN, 1)]);
        table.push(["short row".into()]);
        table
    }

    #[test]
    fn html_escapes_and_aligns_numbers_on_the_right() {
        let html = table().to_html();
        assert!(html.contains("<td>a&lt;b</td><td class=\"number\">76.8</td>"));
        assert!(html.contains("Steps &amp; &lt;ramps&gt;"));
        assert!(html.contains("<td class=\"number\">–</td>"));
        roxmltree::Document::parse(&html).expect("the table is well-formed");
    }

    #[test]
    fn what_is_rounded_to_zero_has_no_sign() {
        let shown = [-0.004, -0.006, 0.0, -10.0].map(|value| Cell::Number(value, 2).to_string());
        assert_eq!(shown, ["0.00", "-0.01", "0.00", "-10.00"]);
    }

    #[test]
    fn the_terminal_gets_units_and_no_line_beyond_its_width() {
        for width in [20, 80] {
            let text = table().to_terminal(width);
            assert!(text.contains("(ms)") && text.contains("76.8"), "{text}");
            let widest = text.lines().skip(1).map(|l| l.chars().count()).max();
            assert!(widest <= Some(usize::from(width)), "{text}");
        }
    }
}
