//! A second opinion on the emulated processor.

pub mod document;
mod frames;
mod registers;
mod replay;
pub mod shadow;
mod streams;
mod tap;
pub mod unicorn;
