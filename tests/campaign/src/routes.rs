//! Pages of the memory whose accesses the emulator's core makes by way of its bus.

use std::collections::BTreeMap;

use virtual_board::processor::{Processor, Queued};

/// The pages in which injections are undecided: an access elsewhere decides none, and is faster.
#[derive(Debug, Default)]
pub struct Routes {
    /// Reasons for which each page is routed.
    reasons: BTreeMap<u64, u32>,
    changes: Vec<Queued>,
}

impl Routes {
    /// The page of this address is to be routed for one reason more.
    pub fn add(&mut self, address: u64, page_size: u64) {
        let page = address / page_size * page_size;
        let reasons = self.reasons.entry(page).or_insert(0);
        *reasons += 1;
        if *reasons == 1 {
            self.changes.push(Queued::Route(page));
        }
    }

    /// One reason less.
    pub fn remove(&mut self, address: u64, page_size: u64) {
        let page = address / page_size * page_size;
        if let Some(reasons) = self.reasons.get_mut(&page) {
            *reasons = reasons.saturating_sub(1);
            if *reasons == 0 {
                self.changes.push(Queued::Unroute(page));
            }
        }
    }

    /// Has the core do so.
    pub fn apply(&mut self, core: &mut dyn Processor) {
        self.changes.drain(..).for_each(|change| core.ask(change));
    }
}
