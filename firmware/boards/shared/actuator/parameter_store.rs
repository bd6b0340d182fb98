//! Saves sets of parameters to the flash, in the background task.

use firmware::{
    drive::StoredParameters,
    store::{Loaded, Progress, Saver},
};

use super::queues::ToSave;
use crate::peripherals::flash::Flash;

/// Maximum polls of the flash in a call. A word takes 16 us, as long as some twenty polls: a set is
/// written in 20 control periods, plus 250 ms for an erase, and the background task is busy with it
/// for 0.2 ms of each, in the first call longer because the set is hashed.
const POLLS: usize = 200;

/// Whether a set is saved, and its memory for the next one.
pub type SaveResult = (bool, &'static mut StoredParameters);

/// The sets to be saved in the flash pages of parameters.
pub struct ParameterStore {
    saver: Saver<StoredParameters>,
    /// The set that is being saved.
    set: Option<&'static mut StoredParameters>,
}

impl ParameterStore {
    /// A store with the parameters loaded from the flash.
    pub fn new(loaded: &Loaded<StoredParameters>) -> Self {
        Self {
            saver: Saver::new(loaded),
            set: None,
        }
    }

    /// Whether a save is running.
    pub fn is_running(&self) -> bool {
        self.saver.is_running()
    }

    /// Continues a save or starts one, of the next set in the queue. Returns at its end whether the
    /// set is saved, and the memory of the set.
    pub fn run(&mut self, flash: &mut Flash, to_save: &mut ToSave) -> Option<SaveResult> {
        if !self.saver.is_running()
            && let Some(set) = to_save.dequeue()
        {
            self.saver.start(set);
            self.set = Some(set);
        }
        let mut polls = 0..POLLS;
        let progress = loop {
            let progress = self.saver.poll(flash);
            if progress != Progress::Running || polls.next().is_none() {
                break progress;
            }
        };
        let is_saved = match progress {
            Progress::Idle | Progress::Running => return None,
            Progress::Done => {
                defmt::info!("parameters saved");
                true
            }
            Progress::Failed(error) => {
                defmt::error!("parameters not saved, stage {}", error as u8);
                false
            }
        };
        Some((is_saved, self.set.take()?))
    }
}
