//! Keeps sets of parameters in the flash, in the background.

use firmware::store::{Loaded, Progress, Saver, Stored};

use crate::{flash::Flash, slot::Taker};

/// Saves what it is given.
pub struct Keeper<S: Stored + 'static> {
    to_save: Taker<S>,
    flash: Flash,
    saver: Saver<S>,
}

impl<S: Stored> Keeper<S> {
    /// One that knows what the flash holds.
    pub fn new(to_save: Taker<S>, flash: Flash, loaded: &Loaded<S>) -> Self {
        Self {
            to_save,
            flash,
            saver: Saver::new(loaded),
        }
    }

    /// Goes on with a save, or begins one; whether it went well, at its end.
    pub fn run(&mut self) -> Option<bool> {
        if !self.saver.is_running()
            && let Some(set) = self.to_save.take()
        {
            self.saver.start(&set);
        }
        match self.saver.poll(&mut self.flash) {
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
