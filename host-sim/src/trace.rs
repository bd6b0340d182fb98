//! The recording of a simulation: named columns of equal length.

/// Named columns of equal length, the first of them the time `t` in seconds.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Trace {
    names: Vec<&'static str>,
    columns: Vec<Vec<f64>>,
}

impl Trace {
    /// An empty trace with these columns and room for `rows` rows.
    pub fn new(names: &[&'static str], rows: usize) -> Self {
        Self {
            names: names.to_vec(),
            columns: names.iter().map(|_| Vec::with_capacity(rows)).collect(),
        }
    }

    /// Appends a row.
    ///
    /// # Panics
    /// If the row does not have one value per column.
    pub fn push(&mut self, row: &[f64]) {
        assert_eq!(
            row.len(),
            self.columns.len(),
            "a row has one value a column"
        );
        for (column, value) in self.columns.iter_mut().zip(row) {
            column.push(*value);
        }
    }

    /// The names of the columns.
    pub fn names(&self) -> &[&'static str] {
        &self.names
    }

    /// The columns, each with its name, in order.
    pub fn columns(&self) -> impl Iterator<Item = (&'static str, &[f64])> {
        let columns = self.columns.iter().map(Vec::as_slice);
        self.names.iter().copied().zip(columns)
    }

    /// Removes all rows.
    pub fn clear(&mut self) {
        self.columns.iter_mut().for_each(Vec::clear);
    }

    /// The column of this name.
    pub fn column(&self, name: &str) -> Option<&[f64]> {
        let index = self.names.iter().position(|n| *n == name)?;
        Some(&self.columns[index])
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.columns.first().map_or(0, Vec::len)
    }

    /// Whether there is no row.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The rows in order.
    pub fn rows(&self) -> impl Iterator<Item = Vec<f64>> + '_ {
        (0..self.len()).map(|i| self.columns.iter().map(|c| c[i]).collect())
    }
}
