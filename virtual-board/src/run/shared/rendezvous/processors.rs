//! The processors of a run, and which of them a thread keeps to. Where the operating system offers
//! no choice, it places the threads itself.

use std::num::NonZeroUsize;
use std::thread;

#[cfg(target_os = "linux")]
use rustix::thread::{CpuSet, sched_getaffinity, sched_setaffinity};

/// The processors that this process may use.
#[derive(Debug)]
pub(super) struct Processors {
    count: usize,
    #[cfg(target_os = "linux")]
    numbers: Vec<usize>,
}

impl Processors {
    /// Those of the thread that calls this.
    pub fn available() -> Self {
        let count = thread::available_parallelism().map_or(1, NonZeroUsize::get);
        Self {
            count,
            #[cfg(target_os = "linux")]
            numbers: sched_getaffinity(None).map_or(Vec::new(), |set| {
                let numbers = 0..CpuSet::MAX_CPU;
                numbers.filter(|number| set.is_set(*number)).collect()
            }),
        }
    }

    /// How many threads can run at once.
    pub fn count(&self) -> usize {
        self.count
    }

    /// From now on this thread runs on the processor of this index, if the system allows it. Under
    /// a quota, which limits the time of the processors, all may be needed: no thread keeps
    /// to one.
    pub fn keep(&self, index: usize) {
        #[cfg(target_os = "linux")]
        if self.numbers.len() == self.count
            && let Some(number) = self.numbers.get(index)
        {
            let mut set = CpuSet::new();
            set.set(*number);
            // Without it the thread is only slower.
            let _ = sched_setaffinity(None, &set);
        }
        #[cfg(not(target_os = "linux"))]
        let _ = index;
    }
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;

    #[test]
    fn a_thread_keeps_to_one_of_the_available_processors() {
        let processors = Processors::available();
        let last = processors.numbers.len() - 1;
        let run = || {
            processors.keep(last);
            sched_getaffinity(None).expect("a set of processors")
        };
        let set = thread::scope(|scope| scope.spawn(run).join().expect("no panic"));
        assert_eq!(set.count(), 1);
        assert!(set.is_set(processors.numbers[last]));
    }
}
