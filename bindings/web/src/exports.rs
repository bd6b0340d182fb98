//! What a page calls.
//!
//! The functions that can fail return 0 or the code of an [`Error`]; the text out is then its
//! message. Text goes in through [`text_in`] and out through [`text_out`]; commands go in through
//! [`commands_in`] and the trace out through [`trace`]. A pointer is good until the next call.
//!
//! The page provides one function, `watch`: its argument is the share of a run that is done, and it
//! returns 0 to end the run.
//!
//! No input traps: numbers are checked where they enter, and all lengths are limited.

#![allow(
    unsafe_code,
    reason = "exported names and the declaration of an imported function; no pointer is read"
)]

use std::cell::RefCell;

use crate::catalogue;
use crate::run::{self, Trace};
use crate::scenario::{Error, MOST_ROWS, Scenario};

/// The longest text, bytes: a hundred parameters take a tenth of it.
const LONGEST_TEXT: usize = 1 << 16;

#[derive(Default)]
struct Session {
    text_in: Vec<u8>,
    text_out: String,
    commands: Vec<f64>,
    trace: Trace,
}

#[cfg(target_arch = "wasm32")]
#[link(wasm_import_module = "page")]
unsafe extern "C" {
    /// The page's function: the share that is done, 0 to end the run.
    safe fn watch(share: f64) -> i32;
}

/// Without a page no run is cancelled.
#[cfg(not(target_arch = "wasm32"))]
fn watch(_share: f64) -> i32 {
    1
}

fn goes_on(share: f64) -> bool {
    watch(share) != 0
}

thread_local! {
    static SESSION: RefCell<Session> = RefCell::default();
}

fn with<T>(act: impl FnOnce(&mut Session) -> T) -> T {
    SESSION.with_borrow_mut(act)
}

impl Session {
    fn scenario(&self) -> Result<Scenario, Error> {
        let text = core::str::from_utf8(&self.text_in);
        Scenario::parse(text.map_err(|_| Error::Request("the request is not UTF-8".into()))?)
    }

    /// Keeps the text or the message of the error, and says which.
    fn answer(&mut self, result: Result<String, Error>) -> i32 {
        let (text, code) = match result {
            Ok(text) => (text, 0),
            Err(error) => (error.to_string(), error.code()),
        };
        self.text_out = text;
        code
    }
}

/// Memory for a request of this number of bytes of UTF-8; null if it is too long.
#[cfg_attr(target_arch = "wasm32", unsafe(no_mangle))]
pub extern "C" fn text_in(len: usize) -> *mut u8 {
    if len > LONGEST_TEXT {
        return core::ptr::null_mut();
    }
    with(|session| {
        session.text_in.clear();
        session.text_in.resize(len, b' ');
        session.text_in.as_mut_ptr()
    })
}

/// The answer, or the message of the last error.
#[cfg_attr(target_arch = "wasm32", unsafe(no_mangle))]
pub extern "C" fn text_out() -> *const u8 {
    with(|session| session.text_out.as_ptr())
}

/// How many bytes it has.
#[cfg_attr(target_arch = "wasm32", unsafe(no_mangle))]
pub extern "C" fn text_out_len() -> usize {
    with(|session| session.text_out.len())
}

/// Answers what there is to choose from.
#[cfg_attr(target_arch = "wasm32", unsafe(no_mangle))]
pub extern "C" fn catalogue() -> i32 {
    with(|session| session.answer(Ok(catalogue::catalogue())))
}

/// Runs the request and keeps its trace.
#[cfg_attr(target_arch = "wasm32", unsafe(no_mangle))]
pub extern "C" fn run() -> i32 {
    with(|session| {
        let trace = session
            .scenario()
            .and_then(|scenario| run::run(&scenario, goes_on));
        session.keep(trace)
    })
}

/// Memory for this number of commands, deg; null if they are too many.
#[cfg_attr(target_arch = "wasm32", unsafe(no_mangle))]
pub extern "C" fn commands_in(count: usize) -> *mut f64 {
    if count as u64 > MOST_ROWS {
        return core::ptr::null_mut();
    }
    with(|session| {
        session.commands.clear();
        session.commands.resize(count, 0.0);
        session.commands.as_mut_ptr()
    })
}

/// As [`run()`], but on the commands that were put in, each held for `every` ticks.
#[cfg_attr(target_arch = "wasm32", unsafe(no_mangle))]
pub extern "C" fn follow() -> i32 {
    with(|session| {
        let trace = session.scenario();
        let trace = trace.and_then(|scenario| run::follow(&scenario, &session.commands, goes_on));
        session.keep(trace)
    })
}

impl Session {
    fn keep(&mut self, trace: Result<Trace, Error>) -> i32 {
        let kept = trace.map(|trace| self.trace = trace);
        self.answer(kept.map(|()| "null".into()))
    }
}

/// The trace of the last run that was successful, column after column.
#[cfg_attr(target_arch = "wasm32", unsafe(no_mangle))]
pub extern "C" fn trace() -> *const f64 {
    with(|session| session.trace.values().as_ptr())
}

/// How many rows it has.
#[cfg_attr(target_arch = "wasm32", unsafe(no_mangle))]
pub extern "C" fn trace_rows() -> usize {
    with(|session| session.trace.rows())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As the page does it, but for the memory.
    fn call(request: &[u8], function: extern "C" fn() -> i32) -> (i32, String) {
        assert!(!text_in(request.len()).is_null());
        with(|session| session.text_in.copy_from_slice(request));
        let code = function();
        assert_eq!(text_out_len(), with(|session| session.text_out.len()));
        (code, with(|session| session.text_out.clone()))
    }

    #[test]
    fn a_run_leaves_its_trace() {
        let (code, _) = call(b"model=black-box-1&duration_s=2", run);
        assert_eq!((code, trace_rows()), (0, 2000));
        assert!(!trace().is_null());
    }

    #[test]
    fn a_request_that_fails_says_why_and_leaves_the_last_trace() {
        call(b"duration_s=1", run);
        for (request, code) in [
            (&b"P=1e999"[..], 2),
            (b"P=NaN", 2),
            (b"delay_s=-1", 2),
            (b"every=1e9", 2),
            (b"\xff\xfe", 1),
            (b"P", 1),
            (b"duration_s=120&every=1", 4),
        ] {
            let answer = call(request, run);
            assert_eq!(answer.0, code, "{answer:?}");
            assert!(!answer.1.is_empty());
        }
        assert_eq!(trace_rows(), 1000);
    }

    #[test]
    fn commands_are_followed_and_those_that_are_no_numbers_refused() {
        assert!(!commands_in(100).is_null());
        assert_eq!(call(b"", follow).0, 0);
        assert_eq!(trace_rows(), 100);
        with(|session| session.commands[7] = f64::NEG_INFINITY);
        assert_eq!(call(b"", follow).0, 3);
    }

    #[test]
    fn what_is_too_long_gets_no_place() {
        assert!(text_in(LONGEST_TEXT + 1).is_null());
        assert!(commands_in(usize::MAX).is_null());
    }
}
