//! The report: every model on every input of the paper, in one file.

pub mod figures;
pub mod page;
pub mod table;

pub use page::{Page, Section};
pub use table::{Cell, Column, Table};

#[cfg(test)]
mod tests;
