//! Judges injections, one campaign at a time.

use std::sync::{Arc, Mutex, PoisonError};

use fault_campaign::campaign::{Boards, Judged, run_all};
use fault_campaign::injection::Injection;
use fault_campaign::outcome::Verdict;

/// A process that copies itself must have no other thread at work.
static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());

/// Judges injections by two processes after this warm-up, in the order of places and numbers.
pub fn verdicts(
    injections: &[Injection],
    warm_up: u64,
    judged: Judged,
) -> Vec<(Injection, Verdict)> {
    let _turn = (ONE_AT_A_TIME.lock()).unwrap_or_else(PoisonError::into_inner);
    let results = Arc::new(Mutex::new(Vec::new()));
    let kept = results.clone();
    let add = move |injection, verdict| kept.lock().unwrap().push((injection, verdict));
    let boards = Boards {
        processes: 2,
        warm_up,
    };
    run_all(injections, boards, judged, add).expect("the board runs");
    let mut results = results.lock().unwrap().clone();
    assert_eq!(results.len(), injections.len());
    results.sort_by_key(|(injection, _)| (injection.place, injection.number));
    results
}
