//! Threads that wait for each other some ten thousand times a second.

use std::hint;
use std::num::NonZeroUsize;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::{self, Thread};
use std::time::{Duration, Instant};

/// Number of times that a thread looks for the end of a round before it sleeps: waking a thread,
/// and more so a processor, takes longer than the other threads need to reach it, some ten
/// microseconds.
const LOOKS: u32 = 2_000;

/// The same if other threads wait for its processor.
const YIELDS: u32 = 200;

/// A thread that gets its processor back later than this after it let others run has let another
/// process run. For so many rounds the threads then sleep at once.
const CROWDED: (Duration, u64) = (Duration::from_millis(3), 200);

/// Where the threads of boards wait until all have come.
#[derive(Debug)]
pub(super) struct Rendezvous {
    /// Number of rounds that have ended.
    round: AtomicU64,
    processors: usize,
    /// The first round in which threads let others run before they sleep.
    yields_from: AtomicU64,
    /// The round ends after a pause.
    is_paused: AtomicBool,
}

impl Rendezvous {
    pub fn new() -> Self {
        Self {
            round: AtomicU64::new(0),
            processors: thread::available_parallelism().map_or(1, NonZeroUsize::get),
            yields_from: AtomicU64::new(0),
            is_paused: AtomicBool::new(false),
        }
    }

    /// Sleeps while the other threads wait. They sleep as well.
    pub fn pause(&self, pause: Duration) {
        self.is_paused.store(true, Ordering::Relaxed);
        thread::sleep(pause);
        self.is_paused.store(false, Ordering::Relaxed);
    }

    /// Ends this round, and wakes the threads that wait for its end.
    pub fn end<'a>(&self, round: u64, threads: impl Iterator<Item = &'a Thread>) {
        self.round.store(round + 1, Ordering::Release);
        let own = thread::current().id();
        threads
            .filter(|thread| thread.id() != own)
            .for_each(Thread::unpark);
    }

    /// Waits for the end of this round, for which this number of threads is awaited.
    pub fn wait(&self, round: u64, awaited: usize) {
        let has_ended = || self.round.load(Ordering::Acquire) != round;
        let sleeps = || has_ended() || self.is_paused.load(Ordering::Relaxed);
        if awaited < self.processors {
            let looks = (0..LOOKS).take_while(|_| !sleeps());
            looks.for_each(|_| hint::spin_loop());
        } else {
            let is_crowded = || round < self.yields_from.load(Ordering::Relaxed);
            let yields = (0..YIELDS).take_while(|_| !sleeps() && !is_crowded());
            yields.for_each(|_| self.let_others_run(round));
        }
        while !has_ended() {
            thread::park();
        }
    }

    /// Lets threads run that wait for this processor.
    fn let_others_run(&self, round: u64) {
        let (longest, rounds) = CROWDED;
        let start = Instant::now();
        thread::yield_now();
        if start.elapsed() > longest {
            self.yields_from.store(round + rounds, Ordering::Relaxed);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::{Arc, Mutex};

    use super::*;

    /// More threads than processors, so that some sleep.
    const THREADS: usize = 6;
    const ROUNDS: u64 = 2_000;

    #[test]
    fn no_thread_passes_the_end_of_a_round_before_all_have_come() {
        let rendezvous = Arc::new(Rendezvous::new());
        // The threads that have come at all, and those that have come in this round.
        let come: Arc<Mutex<(Vec<Thread>, usize)>> = Arc::default();
        let total = Arc::new(AtomicU64::new(0));
        let run = |_| {
            let (rendezvous, come, total) = (rendezvous.clone(), come.clone(), total.clone());
            thread::spawn(move || {
                for round in 0..ROUNDS {
                    let mut come = come.lock().unwrap();
                    if round == 0 {
                        come.0.push(thread::current());
                    }
                    come.1 = come.1 % THREADS + 1;
                    total.fetch_add(1, Ordering::Relaxed);
                    let awaited = THREADS - come.1;
                    if awaited == 0 {
                        rendezvous.end(round, come.0.iter());
                    }
                    drop(come);
                    rendezvous.wait(round, awaited);
                    assert!(total.load(Ordering::Relaxed) >= (round + 1) * THREADS as u64);
                }
            })
        };
        let threads: Vec<_> = (0..THREADS).map(run).collect();
        threads
            .into_iter()
            .for_each(|thread| thread.join().unwrap());
        assert_eq!(total.load(Ordering::Relaxed), ROUNDS * THREADS as u64);
    }
}
