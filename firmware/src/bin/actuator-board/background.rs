//! What may wait until the control step is over: telemetry, parameters, log, watchdog.

use firmware::{
    application::Outputs,
    frames::Frames,
    parameters::BoardParameters,
    store::{Loaded, Progress, Saver},
};
use heapless::spsc::Consumer;

use crate::{can_frame::CanFrame, flash::Flash, report::Report, watchdog::Watchdog};

/// The background's own.
pub struct Background {
    outputs: Consumer<'static, Outputs, 4>,
    to_save: Consumer<'static, BoardParameters, 2>,
    frames: Frames,
    flash: Flash,
    saver: Saver,
    watchdog: Watchdog,
    report: Report,
}

impl Background {
    /// Takes over what the control step decides and hands over for saving.
    pub fn new(
        outputs: Consumer<'static, Outputs, 4>,
        to_save: Consumer<'static, BoardParameters, 2>,
        (flash, loaded): (Flash, &Loaded),
        watchdog: Watchdog,
    ) -> Self {
        Self {
            outputs,
            to_save,
            frames: Frames::new(loaded.parameters.bus.node_id as u8),
            flash,
            saver: Saver::new(loaded),
            watchdog,
            report: Report::default(),
        }
    }

    /// Serves the control periods that have passed since the last call, usually one.
    pub fn run(&mut self, mut send: impl FnMut(CanFrame)) {
        while let Some(outputs) = self.outputs.dequeue() {
            self.frames
                .telemetry(&outputs)
                .into_iter()
                .flatten()
                .for_each(&mut send);
            self.report.update(&outputs);
            self.watchdog.feed();
        }
        self.save();
    }

    /// Goes on with a save, or begins one.
    fn save(&mut self) {
        if !self.saver.is_running()
            && let Some(parameters) = self.to_save.dequeue()
        {
            self.saver.start(&parameters);
        }
        match self.saver.poll(&mut self.flash) {
            Progress::Idle | Progress::Running => {}
            Progress::Done => defmt::info!("parameters saved"),
            Progress::Failed(error) => defmt::error!("parameters not saved, stage {}", error as u8),
        }
    }
}
