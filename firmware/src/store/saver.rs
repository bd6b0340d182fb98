//! Saves a set, one operation of the flash after the other.

use super::{
    Flash, Loaded, MAX_ROW, Newest, Page, Status, Stored,
    page::{Image, offsets},
};

/// Progress of a save.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Progress {
    /// No save is running.
    Idle,
    /// Call again.
    Running,
    /// The set is stored.
    Done,
    /// The set is not stored; the previous one still is.
    Failed(SaveError),
}

/// Why a set was not stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SaveError {
    /// The flash could not erase the page.
    Erase,
    /// The flash could not write a word.
    Program,
    /// The words that were read back differ from those written.
    Verify,
}

/// The next step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Step {
    Idle,
    Erase,
    Erased,
    /// Write the row from the word of this index on.
    Program(u16),
    /// Wait until that row is written.
    Programmed(u16),
}

/// Saves sets without blocking.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Saver<S: Stored> {
    newest: Option<Newest>,
    sequence: u32,
    image: Image<S>,
    step: Step,
}

impl<S: Stored> Saver<S> {
    /// A saver for a flash with this content.
    pub fn new(loaded: &Loaded<S>) -> Self {
        Self {
            newest: loaded.newest,
            sequence: 0,
            image: Image::blank(),
            step: Step::Idle,
        }
    }

    /// Starts to save this set. Returns `false` and does nothing while another save is running.
    pub fn start(&mut self, parameters: &S) -> bool {
        let is_idle = self.step == Step::Idle;
        if is_idle {
            self.sequence = self.newest.map_or(0, |n| n.sequence.wrapping_add(1));
            self.image.fill(self.sequence, parameters);
            self.step = Step::Erase;
        }
        is_idle
    }

    /// Whether a save is running.
    pub fn is_running(&self) -> bool {
        self.step != Step::Idle
    }

    /// Does as much as is possible without blocking: at most one operation of the flash.
    ///
    /// [`Progress::Done`] and [`Progress::Failed`] are returned once.
    pub fn poll(&mut self, flash: &mut impl Flash) -> Progress {
        let status = match self.step {
            Step::Idle => return Progress::Idle,
            _ => flash.status(),
        };
        let page = self.page();
        self.step = match (self.step, status) {
            (_, Status::Busy) => return Progress::Running,
            (Step::Idle, _) => return Progress::Idle,
            // The very first save: an interrupted erase could leave any content.
            (Step::Erase, _) if self.newest.is_none() && is_blank::<S>(flash, page) => {
                Step::Program(0)
            }
            (Step::Erase, _) => {
                flash.start_erase(page);
                Step::Erased
            }
            (Step::Erased, Status::Ready) if !is_blank::<S>(flash, page) => {
                return self.failed(SaveError::Erase);
            }
            (Step::Erased, Status::Failed) => return self.failed(SaveError::Erase),
            (Step::Programmed(_), Status::Failed) => return self.failed(SaveError::Program),
            (Step::Erased, Status::Ready) => Step::Program(0),
            (Step::Programmed(index), Status::Ready) => {
                Step::Program(index.saturating_add(row_words(flash)))
            }
            (Step::Program(index), _) => match self.image.row(index) {
                Some(row) => {
                    let row = row.get(..usize::from(row_words(flash))).unwrap_or_default();
                    flash.start_program(page, index.saturating_mul(4), row);
                    Step::Programmed(index)
                }
                None => return self.finish(flash, page),
            },
        };
        Progress::Running
    }

    /// The page that does not hold the newest set.
    fn page(&self) -> Page {
        match self.newest {
            Some(Newest {
                page: Page::First, ..
            }) => Page::Second,
            _ => Page::First,
        }
    }

    fn finish(&mut self, flash: &impl Flash, page: Page) -> Progress {
        self.step = Step::Idle;
        if !self.image.is_in(flash, page) {
            return Progress::Failed(SaveError::Verify);
        }
        self.newest = Some(Newest {
            page,
            sequence: self.sequence,
        });
        Progress::Done
    }

    fn failed(&mut self, error: SaveError) -> Progress {
        self.step = Step::Idle;
        Progress::Failed(error)
    }
}

/// Words that this flash writes together.
const fn row_words<F: Flash>(_: &F) -> u16 {
    const { assert!(F::ROW > 0 && F::ROW <= MAX_ROW) }
    F::ROW as u16
}

/// Whether the words of a page that a set takes are erased.
fn is_blank<S: Stored>(flash: &impl Flash, page: Page) -> bool {
    S::ZEROS
        .as_ref()
        .iter()
        .zip(offsets())
        .all(|(_, offset)| flash.read(page, offset) == u32::MAX)
}

#[cfg(test)]
impl<S: Stored> Saver<S> {
    /// Words that were written so far.
    pub(super) fn step_index(&self) -> u16 {
        match self.step {
            Step::Program(index) | Step::Programmed(index) => index,
            _ => 0,
        }
    }
}
