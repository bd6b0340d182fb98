//! Tables of numbers with units, for pages (`templates/table.html`) and for the terminal.

use std::fmt;

use comfy_table::{CellAlignment, ColumnConstraint, ContentArrangement, presets};

/// One entry of a table.
#[derive(Debug, Clone, PartialEq)]
pub enum Cell {
    /// Text.
    Text(String),
    /// A value, shown with this many decimals. NaN and infinities are shown as a dash.
    Number(f64, usize),
    /// No value: shown as a dash.
    None,
}

impl Cell {
    /// A value with this many decimals, or a dash.
    pub fn optional(value: Option<f64>, decimals: usize) -> Self {
        value.map_or(Self::None, |value| Self::Number(value, decimals))
    }

    /// A value with five significant digits.
    ///
    /// ```
    /// # use host_sim::table::Cell;
    /// assert_eq!(Cell::significant(0.012345678).to_string(), "0.012346");
    /// ```
    pub fn significant(value: f64) -> Self {
        let magnitude = if value == 0.0 {
            0.0
        } else {
            value.abs().log10().floor()
        };
        Self::Number(value, (4.0 - magnitude).clamp(0.0, 12.0) as usize)
    }
}

impl fmt::Display for Cell {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Text(text) => f.write_str(text),
            // Hundreds of digits of which none is meant.
            Self::Number(value, _) if value.is_finite() && value.abs() >= 1e15 => {
                write!(f, "{value:.4e}")
            }
            Self::Number(value, decimals) if value.is_finite() => {
                let text = format!("{value:.decimals$}");
                // A value that is rounded to zero has no sign.
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
    /// The quantity.
    pub name: String,
    /// Its unit; empty if it has none.
    pub unit: String,
}

/// Rows of cells under named columns.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// What the table shows.
    pub caption: String,
    /// The headings.
    pub columns: Vec<Column>,
    /// One cell for each column. Missing cells at the end of a row are shown empty.
    pub rows: Vec<Vec<Cell>>,
}

impl Table {
    /// Creates an empty table with these columns, each a name and a unit.
    ///
    /// ```
    /// # use host_sim::table::{Cell, Table};
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

    /// For each column, whether it contains numbers, which are aligned right.
    pub fn numeric_columns(&self) -> Vec<bool> {
        let is_numeric = |column| {
            let cells = || self.rows.iter().filter_map(|row| row.get(column));
            cells().any(|c| matches!(c, Cell::Number(..)))
                && !cells().any(|c| matches!(c, Cell::Text(_)))
        };
        (0..self.columns.len()).map(is_numeric).collect()
    }

    /// Renders the table as text of at most `width` columns. Long cells are wrapped.
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
        for (column, is_numeric) in table.column_iter_mut().zip(self.numeric_columns()) {
            if is_numeric {
                column.set_cell_alignment(CellAlignment::Right);
            }
        }
        // A name would be broken within its unit.
        let first = self.rows.iter().filter_map(|row| row.first());
        let longest = first.map(|cell| cell.to_string().chars().count()).max();
        if longest < Some(usize::from(width / 2))
            && let Some(names) = table.column_mut(0)
        {
            names.set_constraint(ColumnConstraint::ContentWidth);
        }
        format!("{}\n{table}", self.caption)
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
    fn a_value_rounded_to_zero_has_no_sign() {
        let shown = [-0.004, -0.006, 0.0, -10.0].map(|value| Cell::Number(value, 2).to_string());
        assert_eq!(shown, ["0.00", "-0.01", "0.00", "-10.00"]);
    }

    #[test]
    fn names_are_whole_where_half_of_the_terminal_holds_them() {
        let columns = ["parameter", "estimate", "standard error", "remark"].map(|name| (name, ""));
        let mut table = Table::new("", &columns);
        let remark = "at its lower bound: not identifiable";
        table.push(["motor_inertia_kg_m2", "0.0233182", "0.0000270", remark].map(Cell::from));
        for width in [40, 60, 80] {
            assert!(table.to_terminal(width).contains("motor_inertia_kg_m2"));
        }
    }

    #[test]
    fn terminal_output_has_units_and_no_line_wider_than_the_terminal() {
        for width in [20, 80] {
            let text = table().to_terminal(width);
            assert!(text.contains("(ms)") && text.contains("76.8"), "{text}");
            let widest = text.lines().skip(1).map(|l| l.chars().count()).max();
            assert!(widest <= Some(usize::from(width)), "{text}");
        }
    }
}
