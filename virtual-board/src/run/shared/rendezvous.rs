//! Threads that wait for each other some ten thousand times a second.
//!
//! At most one thread per processor runs. One that waits for the others hands its processor
//! to one that has not run yet, so that no thread competes for a processor while it runs. A thread
//! on the same processor wakes fastest: each thread stays on its own.

mod processors;

use std::hint;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, Thread};
use std::time::Duration;

use self::processors::Processors;

/// Number of times that a thread whose processor no other thread needs looks for its turn before it
/// sleeps: waking a thread, and more so a processor, takes longer than the other threads need to
/// reach the end of the round, some ten microseconds.
const LOOKS: u32 = 2_000;

/// Which threads run in a round, by their indices. Each belongs to one of the processors, which
/// runs one of its threads at a time.
#[derive(Debug)]
pub(super) struct Turns {
    processors: Vec<ProcessorTurns>,
}

/// The threads of a processor.
#[derive(Debug, Clone, Default)]
struct ProcessorTurns {
    running: usize,
    /// Those that have not run in this round; the last one is next.
    ready: Vec<usize>,
    /// Those that wait for the end of this round, in the order in which they have come.
    waiting: Vec<usize>,
}

impl Turns {
    /// Before the first round all threads run.
    pub fn new(threads: usize, processors: usize) -> Self {
        let mut processors = vec![ProcessorTurns::default(); processors.max(1)];
        let count = processors.len();
        for thread in 0..threads {
            processors[thread % count].running += 1;
        }
        Self { processors }
    }

    /// A running thread waits for the end of the round. Returns the one that runs in its place.
    pub fn wait(&mut self, thread: usize) -> Option<usize> {
        let turns = self.of(thread);
        turns.waiting.push(thread);
        turns.running -= 1;
        turns.next()
    }

    /// A thread ends; one that waits ends by a panic. Returns the thread that runs in its place.
    pub fn leave(&mut self, thread: usize) -> Option<usize> {
        let turns = self.of(thread);
        let is_other = |other: &usize| *other != thread;
        if turns.waiting.iter().chain(&turns.ready).all(is_other) {
            turns.running -= 1;
        }
        turns.waiting.retain(is_other);
        turns.ready.retain(is_other);
        turns.next()
    }

    /// Number of threads that wait for the end of the round.
    pub fn waiting(&self) -> usize {
        self.processors
            .iter()
            .map(|turns| turns.waiting.len())
            .sum()
    }

    /// Begins the next round when all threads wait. Returns those that run first: of each processor
    /// the last one to arrive, as it is the least likely to sleep.
    pub fn begin_round(&mut self) -> Vec<usize> {
        let first = |turns: &mut ProcessorTurns| {
            turns.ready.append(&mut turns.waiting);
            turns.next()
        };
        self.processors.iter_mut().filter_map(first).collect()
    }

    fn of(&mut self, thread: usize) -> &mut ProcessorTurns {
        let count = self.processors.len();
        &mut self.processors[thread % count]
    }
}

impl ProcessorTurns {
    fn next(&mut self) -> Option<usize> {
        if self.running > 0 {
            return None;
        }
        let next = self.ready.pop()?;
        self.running += 1;
        Some(next)
    }
}

/// A thread and whether it may run.
#[derive(Debug, Default)]
struct Slot {
    may_run: AtomicBool,
    thread: OnceLock<Thread>,
}

/// Where the threads wait for their turns.
#[derive(Debug)]
pub(super) struct Rendezvous {
    slots: Vec<Slot>,
    processors: Processors,
    /// The round ends after a pause.
    is_paused: AtomicBool,
}

impl Rendezvous {
    /// For this number of threads, on the processors that this thread may use.
    pub fn new(threads: usize) -> Self {
        Self {
            slots: (0..threads).map(|_| Slot::default()).collect(),
            processors: Processors::available(),
            is_paused: AtomicBool::new(false),
        }
    }

    /// The turns of the threads before the first round.
    pub fn turns(&self) -> Turns {
        Turns::new(self.slots.len(), self.processors.count())
    }

    /// This thread has this index. To be called before any other one can let it run.
    pub fn join(&self, index: usize) {
        self.slots[index].thread.get_or_init(|| {
            let count = self.processors.count();
            // The system places fewer threads better.
            if self.slots.len() > count {
                self.processors.keep(index % count);
            }
            thread::current()
        });
    }

    /// Sleeps while the other threads wait. They sleep as well.
    pub fn pause(&self, pause: Duration) {
        self.is_paused.store(true, Ordering::Relaxed);
        thread::sleep(pause);
        self.is_paused.store(false, Ordering::Relaxed);
    }

    /// Lets a thread run.
    pub fn resume(&self, index: usize) {
        let Slot { may_run, thread } = &self.slots[index];
        may_run.store(true, Ordering::Release);
        if let Some(thread) = thread.get() {
            thread.unpark();
        }
    }

    /// Waits until this thread may run; at first without sleeping, if no other one needs its
    /// processor.
    pub fn wait(&self, index: usize, is_idle: bool) {
        let may_run = || self.slots[index].may_run.swap(false, Ordering::Acquire);
        if is_idle {
            for _ in 0..LOOKS {
                if may_run() {
                    return;
                }
                if self.is_paused.load(Ordering::Relaxed) {
                    break;
                }
                hint::spin_loop();
            }
        }
        while !may_run() {
            thread::park();
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicU64, AtomicUsize};
    use std::sync::{Arc, Mutex};

    use super::*;

    #[test]
    fn as_many_threads_run_as_there_are_processors_and_the_last_ones_first() {
        let mut turns = Turns::new(4, 2);
        for thread in 0..4 {
            assert_eq!(turns.wait(thread), None);
        }
        assert_eq!(turns.begin_round(), [2, 3]);
        assert_eq!(turns.wait(2), Some(0));
        assert_eq!(turns.leave(3), Some(1));
        assert_eq!(turns.wait(0), None);
        assert_eq!(turns.wait(1), None);
        assert_eq!(turns.waiting(), 3);
        assert_eq!(turns.begin_round(), [0, 1]);
    }

    #[test]
    fn a_thread_that_ends_while_it_waits_leaves_its_processor_to_the_running_one() {
        let mut turns = Turns::new(4, 2);
        turns.wait(0);
        assert_eq!(turns.leave(0), None);
        assert_eq!(turns.waiting(), 0);
        for thread in 1..4 {
            assert_eq!(turns.wait(thread), None);
        }
        assert_eq!(turns.begin_round(), [2, 3]);
        assert_eq!(turns.leave(1), None);
        assert_eq!(turns.wait(3), None);
    }

    /// More threads than processors.
    const THREADS: usize = 6;
    const ROUNDS: u64 = 500;

    #[test]
    fn no_thread_passes_the_end_of_a_round_before_all_have_come_and_no_more_than_may_run_at_once() {
        let rendezvous = Arc::new(Rendezvous::new(THREADS));
        let turns = Arc::new(Mutex::new(Turns::new(THREADS, 2)));
        let total = Arc::new(AtomicU64::new(0));
        let running = Arc::new(AtomicUsize::new(0));
        // Counted, not asserted: the other threads would wait for one that panicked.
        let violations = Arc::new(AtomicUsize::new(0));
        let run = |index| {
            let (rendezvous, turns) = (rendezvous.clone(), turns.clone());
            let (total, running) = (total.clone(), running.clone());
            let violations = violations.clone();
            thread::spawn(move || {
                rendezvous.join(index);
                for round in 0..ROUNDS {
                    // Before the first round all run.
                    let others = running.fetch_add(1, Ordering::AcqRel);
                    let is_crowded = round > 0 && others >= 2;
                    violations.fetch_add(is_crowded.into(), Ordering::Relaxed);
                    total.fetch_add(1, Ordering::Relaxed);
                    thread::yield_now();
                    running.fetch_sub(1, Ordering::AcqRel);
                    let mut turns = turns.lock().unwrap();
                    let mut resumed: Vec<_> = turns.wait(index).into_iter().collect();
                    let is_idle = resumed.is_empty();
                    if turns.waiting() == THREADS {
                        resumed = turns.begin_round();
                    }
                    drop(turns);
                    resumed.into_iter().for_each(|next| rendezvous.resume(next));
                    rendezvous.wait(index, is_idle);
                    let is_early = total.load(Ordering::Relaxed) < (round + 1) * THREADS as u64;
                    violations.fetch_add(is_early.into(), Ordering::Relaxed);
                }
                // In the last round each releases the next one.
                let next = turns.lock().unwrap().leave(index);
                next.into_iter().for_each(|next| rendezvous.resume(next));
            })
        };
        let threads: Vec<_> = (0..THREADS).map(run).collect();
        threads
            .into_iter()
            .for_each(|thread| thread.join().unwrap());
        assert_eq!(total.load(Ordering::Relaxed), ROUNDS * THREADS as u64);
        assert_eq!(violations.load(Ordering::Relaxed), 0);
    }
}
