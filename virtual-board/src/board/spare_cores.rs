//! Cores of ended runs, with the code that they have translated.
//!
//! Translating the board's program takes longer than running its first seconds. A core whose run
//! ends is kept with a copy of the memory that its code was translated from. The next run of a core
//! of the same kind takes it over, drops the code of each page whose bytes differ, and loads its
//! own state: it computes what a new core computes.

use std::sync::{Mutex, MutexGuard, PoisonError};

use rigless::emulator::{Error, Processor, Queued};

use crate::processor::Memory;

/// Bytes of a page of the emulator's core, which maps whole ones.
const PAGE: usize = 1024;

/// Cores that are kept at most: those of a bus of eight boards.
const MOST: usize = 8;

/// Cores of different kinds execute the same code differently, or start elsewhere.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CoreKind {
    /// Name of the chip.
    pub chip: &'static str,
    /// Clock, Hz.
    pub clock_hz: u64,
    /// Where it finds its vector table after a reset, if that is not the start of the flash.
    pub vector_table: Option<u32>,
    /// Whether it has its memory protection unit.
    pub protects_memory: bool,
}

#[derive(Clone, Copy)]
#[repr(align(1024))]
struct Page([u8; PAGE]);

/// A copy of a region of the memory.
struct Copied {
    start: u64,
    pages: Vec<Page>,
}

/// A core that no run uses, on its own memory.
struct Spare {
    kind: CoreKind,
    core: Box<dyn Processor>,
    /// What the core maps; dropped after it.
    copies: Vec<Copied>,
}

static SPARES: Mutex<Vec<Spare>> = Mutex::new(Vec::new());

fn spares() -> MutexGuard<'static, Vec<Spare>> {
    // No state is left half changed by a panic.
    SPARES.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Keeps a core whose run ends, and the memory that it maps is still there.
pub(crate) fn keep(kind: CoreKind, mut core: Box<dyn Processor>, memory: &Memory) {
    let mut copies = Vec::new();
    for region in memory.regions() {
        let mut pages = vec![Page([0; PAGE]); region.length / PAGE];
        for (index, page) in pages.iter_mut().enumerate() {
            memory.copy(region.start + (index * PAGE) as u64, &mut page.0);
        }
        let length = (pages.len() * PAGE) as u64;
        let host = pages.as_mut_ptr().cast::<u8>();
        #[allow(
            unsafe_code,
            reason = "the core must not refer to the memory of its run"
        )]
        // SAFETY: the pages are aligned, are on the heap, where they do not move, and are dropped
        // after the core. They are read while no method of the core runs.
        unsafe {
            core.map(region.start, length, host, region.is_writable);
        }
        copies.push(Copied {
            start: region.start,
            pages,
        });
    }
    let mut spares = spares();
    let oldest = (spares.len() >= MOST).then(|| spares.remove(0));
    spares.push(Spare { kind, core, copies });
    drop(spares);
    // Freeing its code takes a while.
    drop(oldest);
}

/// A kept core of this kind for a run on this memory, in this state, if any.
///
/// # Errors
/// The emulator refuses the state.
pub(crate) fn take(
    kind: CoreKind,
    memory: &Memory,
    state: &[u8],
) -> Option<Result<Box<dyn Processor>, Error>> {
    let (spare, changed) = {
        let mut spares = spares();
        let fitting = spares.iter().enumerate();
        let fitting = fitting.filter(|(_, spare)| spare.kind == kind && spare.maps_as(memory));
        let (index, changed) = fitting
            .map(|(index, spare)| (index, spare.changed_pages(memory)))
            .min_by_key(|(_, changed)| changed.len())?;
        (spares.remove(index), changed)
    };
    let Spare {
        mut core, copies, ..
    } = spare;
    #[allow(unsafe_code, reason = "the memory of the run is lent by raw pointer")]
    // SAFETY: this core replaces one that maps the same memory, with the same promise.
    unsafe {
        memory.map_for(&mut *core);
    }
    // The core maps none of them any more.
    drop(copies);
    for page in changed {
        core.ask(Queued::Invalidate(page, page + PAGE as u64));
    }
    Some(core.load(state).map(|()| core))
}

impl Spare {
    /// Whether all that the core maps is mapped anew for this memory.
    fn maps_as(&self, memory: &Memory) -> bool {
        let copied = self.copies.iter();
        let mapped = memory.regions().iter();
        copied
            .map(|copied| (copied.start, copied.pages.len() * PAGE))
            .eq(mapped.map(|region| (region.start, region.length)))
    }

    /// The pages of the memory whose bytes are not those of the copies.
    fn changed_pages(&self, memory: &Memory) -> Vec<u64> {
        let pages = self
            .copies
            .iter()
            .flat_map(|copied| (copied.start..).step_by(PAGE).zip(&copied.pages));
        pages
            .filter(|(place, page)| memory.first_difference(*place, &page.0).is_some())
            .map(|(place, _)| place)
            .collect()
    }
}

/// Number of kept cores of this kind.
#[cfg(test)]
fn count(kind: CoreKind) -> usize {
    spares().iter().filter(|spare| spare.kind == kind).count()
}

#[cfg(test)]
mod tests;
