//! What may wait until the control step is over: telemetry, answers, parameters, log.

use canopen::CanFrame;
use firmware::{
    application::Outputs,
    command::excitation::{ExcitationSettings, Run},
    frames::Frames,
    parameters::BoardParameters,
    supervisor::Part,
};
use heapless::spsc::Consumer;

use crate::{
    heard,
    keeper::Keeper,
    plain::control_step::{Answer, Numbered},
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
    keeper: Keeper<BoardParameters>,
    excitations: Excitations,
    frames: Frames,
    report: Report,
}

impl Background {
    /// Takes over what the control step decides, answers and hands over for saving.
    pub fn new(
        outputs: Consumer<'static, Outputs, 3>,
        answers: Consumer<'static, Answer, 8>,
        keeper: Keeper<BoardParameters>,
        excitations: Excitations,
        node_id: u8,
    ) -> Self {
        Self {
            outputs,
            answers,
            keeper,
            excitations,
            frames: Frames::new(node_id),
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
        // Nobody asked for an answer.
        let _ = self.keeper.run();
        heard::from(Part::Background);
    }
}
