//! Which page commands the actuators: one at a time. Another one requests control
//! and gets it if the holder agrees, or does not answer in time.

use std::time::{Duration, Instant};

use serde_json::{Value, json};

use crate::web::PageId;

/// Time that the holder has to refuse.
pub const PATIENCE: Duration = Duration::from_secs(5);

/// The page that has control, and the one that requests it.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct Control {
    holder: Option<PageId>,
    asking: Option<(PageId, Instant)>,
}

impl Control {
    /// Whether the page holds it.
    pub fn is_held_by(&self, page: PageId) -> bool {
        self.holder == Some(page)
    }

    /// Registers a page; the first one holds the control.
    pub fn joined(&mut self, page: PageId) {
        self.holder.get_or_insert(page);
    }

    /// A page has closed; if it had control, the requesting page gets it.
    pub fn left(&mut self, page: PageId) {
        if self.asking.is_some_and(|(asking, _)| asking == page) {
            self.asking = None;
        }
        if self.is_held_by(page) {
            self.holder = self.asking.take().map(|(asking, _)| asking);
        }
    }

    /// A page requests control.
    pub fn ask(&mut self, page: PageId, now: Instant) {
        match self.holder {
            None => self.holder = Some(page),
            Some(holder) if holder == page => {}
            Some(_) => {
                self.asking.get_or_insert((page, now));
            }
        }
    }

    /// The holder answers; whether it holds it.
    pub fn answer(&mut self, page: PageId, gives: bool) -> bool {
        if !self.is_held_by(page) {
            return false;
        }
        let asking = self.asking.take();
        if gives {
            self.holder = asking.map(|(asking, _)| asking);
        }
        true
    }

    /// The control changes hands when the holder has not answered; whether it did.
    pub fn expire(&mut self, now: Instant) -> bool {
        let Some((page, since)) = self.asking else {
            return false;
        };
        let is_over = now.duration_since(since) >= PATIENCE;
        if is_over {
            (self.holder, self.asking) = (Some(page), None);
        }
        is_over
    }

    /// The event for the pages.
    pub fn event(&self) -> Value {
        json!({
            "event": "control", "holder": self.holder,
            "asking": self.asking.map(|(page, _)| page), "patience_s": PATIENCE.as_secs(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_page_holds_the_control_and_others_get_it_by_asking() {
        let mut control = Control::default();
        let start = Instant::now();
        control.joined(1);
        control.joined(2);
        assert!(control.is_held_by(1) && !control.is_held_by(2));
        control.ask(2, start);
        assert!(control.is_held_by(1), "not yet");
        assert!(!control.answer(2, true), "only the holder can grant it");
        assert!(control.answer(1, false));
        assert!(!control.expire(start + 2 * PATIENCE), "it was refused");
        control.ask(2, start);
        assert!(control.answer(1, true));
        assert!(control.is_held_by(2));
    }

    #[test]
    fn a_holder_that_is_silent_or_gone_loses_the_control() {
        let mut control = Control::default();
        let start = Instant::now();
        control.joined(1);
        control.ask(2, start);
        control.ask(3, start);
        assert!(!control.expire(start + PATIENCE / 2));
        assert!(control.expire(start + PATIENCE));
        assert!(control.is_held_by(2), "the first request");
        control.ask(3, start);
        control.left(2);
        assert!(control.is_held_by(3));
        control.left(3);
        assert_eq!(control.holder, None);
        control.joined(4);
        assert!(control.is_held_by(4));
    }
}
