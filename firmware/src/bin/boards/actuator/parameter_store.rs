//! Saves sets of parameters to the flash, in the background task.

use firmware::store::{Loaded, Progress, Saver, Stored};
use heapless::spsc::Consumer;

use super::{canopen_task::SINGLE, flash::Flash};

/// Maximum polls of the flash in a call. A word takes 16 us, as long as some twenty polls: a set is
/// written in 20 control periods, plus 250 ms for an erase, and the background task is busy with it
/// for 0.2 ms of each, in the first call longer because the set is hashed.
const POLLS: usize = 200;

/// Flash pages of parameters, and the sets to be saved there.
pub struct ParameterStore<S: Stored + 'static> {
    to_save: Consumer<'static, S, SINGLE>,
    flash: Flash,
    saver: Saver<S>,
}

impl<S: Stored> ParameterStore<S> {
    /// A store with the parameters loaded from this flash.
    pub fn new(to_save: Consumer<'static, S, SINGLE>, flash: Flash, loaded: &Loaded<S>) -> Self {
        Self {
            to_save,
            flash,
            saver: Saver::new(loaded),
        }
    }

    /// Continues a save or starts one. Returns at its end whether the set is saved.
    pub fn run(&mut self) -> Option<bool> {
        if !self.saver.is_running()
            && let Some(set) = self.to_save.dequeue()
        {
            self.saver.start(&set);
        }
        let mut polls = 0..POLLS;
        let progress = loop {
            let progress = self.saver.poll(&mut self.flash);
            if progress != Progress::Running || polls.next().is_none() {
                break progress;
            }
        };
        match progress {
            Progress::Idle | Progress::Running => None,
            Progress::Done => {
                defmt::info!("parameters saved");
                Some(true)
            }
            Progress::Failed(error) => {
                defmt::error!("parameters not saved, stage {}", error as u8);
                Some(false)
            }
        }
    }
}
