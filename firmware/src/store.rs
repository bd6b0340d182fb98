//! Parameters in flash, so that a loss of power at any moment leaves the old set or the new one.

mod flash;

pub use flash::{Flash, Page, Status};
