//! Bounds of loops, from a table.

use std::collections::BTreeMap;

use crate::{Error, Function};

/// How often the header of each loop is executed each time the loop is entered.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct LoopBounds(BTreeMap<String, Vec<u64>>);

impl LoopBounds {
    /// Reads a table of rows `function | bound | reason`, with a row for each loop of a function in
    /// the order of the report: outer loops first, by address. A function is given by the end of
    /// its path, and by its number of loops, `function/3`, where others have the same path. Lines
    /// that start with `#` are comments.
    ///
    /// # Errors
    /// If a row has no bound, or no reason.
    pub fn parse(text: &str) -> Result<Self, Error> {
        let mut bounds = BTreeMap::<String, Vec<u64>>::new();
        for (index, line) in text.lines().enumerate() {
            if line.is_empty() || line.starts_with('#') {
                continue;
            }
            let columns: Vec<_> = line.split('|').map(str::trim).collect();
            let row = match columns[..] {
                [function, bound, reason] if !reason.is_empty() => {
                    bound.parse().ok().map(|bound| (function, bound))
                }
                _ => None,
            };
            let (function, bound) = row.ok_or_else(|| Error::Table {
                line: index + 1,
                what: format!("`{line}`, expected `function | bound | reason`"),
            })?;
            bounds.entry(function.into()).or_default().push(bound);
        }
        Ok(Self(bounds))
    }

    /// The bounds of the loops of a function that has this number of them.
    pub(crate) fn of(&self, function: &Function, loops: usize) -> &[u64] {
        let is_its = |key: &str| match key.split_once('/') {
            Some((name, number)) => function.is_named(name) && number == loops.to_string(),
            None => function.is_named(key),
        };
        let row = self.0.iter().find(|(key, _)| is_its(key));
        row.map_or(&[], |(_, bounds)| bounds.as_slice())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_without_bound_or_reason_is_refused_with_its_line() {
        assert!(LoopBounds::parse("# comment\nf | 3 | three items\nf | 4 | four bits\n").is_ok());
        for text in ["f | 3 |", "f | many | x", "f | 3"] {
            let error = LoopBounds::parse(text).unwrap_err().to_string();
            assert!(error.starts_with("line 1: "), "{error}");
        }
    }
}
