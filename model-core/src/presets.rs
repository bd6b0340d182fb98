//! The readings of the paper by name.
