//! The actuator for a page in a browser.
//!
//! A run is described by one line of text, the same that the page keeps in its address:
//! `model=board&preset=consistent&position_gain=12&input=pulse&input.amplitude_deg=45`. This crate
//! reads it ([`scenario`]), runs it ([`run`]), and evaluates it in time ([`figures`]) and in
//! frequency ([`frequency`]). What there is to choose from, it says itself ([`catalogue`]).
//! [`exports`] is what the page calls: plain functions and memory, without generated glue.

pub mod catalogue;
pub mod exports;
pub mod figures;
pub mod frequency;
pub mod run;
pub mod scenario;
