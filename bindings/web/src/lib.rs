//! The actuator for pages in a browser.
//!
//! A run is described by one line of text, which may be the fragment of a page's address:
//! `model=board&preset=consistent&position_gain=12&input=pulse&input.amplitude_deg=45`. This crate
//! reads it ([`scenario`]) and runs it ([`run`]). [`catalogue`] lists the models, inputs and
//! parameters. A page calls the functions in [`exports`]: plain functions and memory, without
//! generated glue code.

pub mod catalogue;
pub mod exports;
pub mod run;
pub mod scenario;

/// JSON of a value. NaN and infinity become `null`.
fn json(value: &impl serde::Serialize) -> String {
    // Serialising strings, numbers and lists does not fail.
    serde_json::to_string(value).unwrap_or_default()
}
