//! What may wait until the control step is over: telemetry, answers, parameters, log.

use canopen::CanFrame;
use firmware::{
    application::Outputs,
    command::excitation::{ExcitationSettings, Run, Sample},
    frames::Frames,
    parameters::BoardParameters,
    supervisor::Part,
};
use heapless::spsc::Consumer;

use crate::{
    actuator::{
        heard,
        keeper::Keeper,
        report::Report,
        slot::{Giver, Taker},
    },
    plain::control_step::{Answer, Numbered},
};

/// Excitations that are asked for, and what has been made of them.
pub struct Excitations {
    pub asked: Taker<Numbered<ExcitationSettings>>,
    pub made: Giver<Numbered<Run>>,
    pub due: Taker<Numbered<u64>>,
    pub samples: Giver<Numbered<Sample>>,
}

impl Excitations {
    /// Does what the control step has no time for; it fetches all of it in the next tick.
    fn serve(&mut self) {
        if let Some((number, tick)) = self.due.take()
            && let Some((made, run)) = self.made.last()
            && *made == number
        {
            self.samples.put((number, run.sample(tick)));
        }
        if let Some((number, settings)) = self.asked.take()
            && let Some(run) = settings.run()
        {
            self.made.put((number, run));
        }
    }
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
        self.excitations.serve();
        // Nobody asked for an answer.
        let _ = self.keeper.run();
        heard::from(Part::Background);
    }
}
