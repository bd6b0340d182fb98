//! Keeps sets of parameters in the flash, in the background.

use firmware::store::{Loaded, Progress, Saver, Stored};

use crate::actuator::{flash::Flash, slot::Taker};

/// Looks at the flash in a tick: a word takes 16 us, as long as some twenty of them. A set is written in 20 ticks so, beside
/// 250 ms for an erase, and the background is busy with it for 0.2 ms of each, once for longer: the set is hashed first.
const LOOKS: usize = 200;

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
        if !self.saver.is_running() {
            self.to_save.take_as(|set| self.saver.start(set));
        }
        let mut looks = 0..LOOKS;
        let progress = loop {
            let progress = self.saver.poll(&mut self.flash);
            if progress != Progress::Running || looks.next().is_none() {
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
