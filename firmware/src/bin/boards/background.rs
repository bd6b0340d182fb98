//! What may wait until the control step is over: telemetry, answers, parameters, log.

use canopen::CanFrame;
use firmware::{
    application::Outputs,
    command::excitation::{ExcitationSettings, Run},
    frames::Frames,
    parameters::BoardParameters,
    store::{Loaded, Progress, Saver},
    supervisor::Part,
};
use heapless::spsc::Consumer;

use crate::{
    control_step::{Answer, Numbered},
    flash::Flash,
    heard,
    report::Report,
    slot::{Giver, Taker},
};

/// Excitations that are asked for, and what has been made of them.
pub struct Excitations {
    pub asked: Taker<Numbered<ExcitationSettings>>,
    pub made: Giver<Numbered<Run>>,
}

/// The background's own.
pub struct Background {
    outputs: Consumer<'static, Outputs, 3>,
    answers: Consumer<'static, Answer, 8>,
    to_save: Taker<BoardParameters>,
    excitations: Excitations,
    frames: Frames,
    flash: Flash,
    saver: Saver,
    report: Report,
}

impl Background {
    /// Takes over what the control step decides, answers and hands over for saving.
    pub fn new(
        outputs: Consumer<'static, Outputs, 3>,
        answers: Consumer<'static, Answer, 8>,
        to_save: Taker<BoardParameters>,
        excitations: Excitations,
        (flash, loaded): (Flash, &Loaded),
    ) -> Self {
        Self {
            outputs,
            answers,
            to_save,
            excitations,
            frames: Frames::new(loaded.parameters.bus.node_id as u8),
            flash,
            saver: Saver::new(loaded),
            report: Report::default(),
        }
    }

    /// Serves the control periods that have passed since the last call, usually one.
    pub fn run(&mut self, mut send: impl FnMut(CanFrame)) {
        while let Some((access, refused)) = self.answers.dequeue() {
            if let Some(frame) = self.frames.answer(access, refused) {
                send(frame);
            }
        }
        while let Some(outputs) = self.outputs.dequeue() {
            let frames = self.frames.telemetry(&outputs);
            frames.iter().flatten().for_each(|&frame| send(frame));
            self.report.update(&outputs);
        }
        if let Some((number, settings)) = self.excitations.asked.take()
            && let Some(run) = settings.run()
        {
            // The control step fetches each in the next tick.
            self.excitations.made.put((number, run));
        }
        self.save();
        heard::from(Part::Background);
    }

    /// Goes on with a save, or begins one.
    fn save(&mut self) {
        if !self.saver.is_running()
            && let Some(parameters) = self.to_save.take()
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
