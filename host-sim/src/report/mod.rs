//! The report: every model on every input of the paper, in one file.
