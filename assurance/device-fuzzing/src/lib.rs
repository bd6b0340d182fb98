//! The whole device, run by a sequence of bytes.
//!
//! [`run`] reads the bytes as actions ([`action`]): frames of a master, control periods, words of
//! the encoder, codes of the converters, disturbances. They act on the device and on a motor that
//! its bridge drives ([`mod@bench`]), and in every control period [`oracle`] checks what must hold
//! for all of them. Every sequence is valid.

#![deny(missing_docs)]

pub mod action;
pub mod bench;
pub mod corpus;
pub mod oracle;

use action::Actions;
use bench::Bench;
pub use oracle::Summary;

/// Control periods after which a run ends: a quick stop of the greatest time, and as long again.
const PERIODS: u32 = 5_000;

/// Runs a new device by these bytes; returns what it reached.
///
/// # Panics
/// If a check of [`oracle`] fails.
pub fn run(input: &[u8]) -> Summary {
    let mut buffer = [0; 400];
    let mut bench = Bench::new(&mut buffer);
    for action in Actions::new(input) {
        if bench.periods() >= PERIODS {
            break;
        }
        bench.act(action);
    }
    bench.end()
}
