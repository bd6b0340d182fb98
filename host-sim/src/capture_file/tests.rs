//! The application of the board, captured, read and identified.

use firmware::{
    application::{Application, Samples},
    capture::{Capture, Signal},
    frames::{Access, Message, Operation, Order},
    parameters::BoardParameters,
    service::Service,
};
use model_core::control::encoder_word::{EncoderCount, EncoderWord, Magnet};

use super::*;
use identification::data::Import;

/// A board on a desk whose shaft somebody turns by a count each control period.
struct Desk<'a> {
    application: Application,
    service: Service,
    capture: Capture<'a>,
    count: u16,
}

impl<'a> Desk<'a> {
    fn new(buffer: &'a mut [i32]) -> Self {
        Self {
            application: Application::new(BoardParameters::DEFAULT),
            service: Service::default(),
            capture: Capture::new(buffer),
            count: 0,
        }
    }

    fn serve(&mut self, message: Message) -> Option<(Access, bool)> {
        let Self {
            application,
            service,
            capture,
            ..
        } = self;
        service.serve(application, capture, &message).answer
    }

    fn order(&mut self, order: Order) {
        self.serve(Message::Command {
            order: Some(order),
            angle: None,
        });
    }

    fn write(&mut self, number: u8, value: u32) {
        let answer = self.serve(Message::Access(Access {
            operation: Operation::Write,
            number,
            index: 0,
            value,
        }));
        assert!(!answer.expect("an answer").1, "{number}");
    }

    fn step(&mut self) {
        let word = EncoderWord::of(EncoderCount::new(self.count), Magnet::Steady);
        let outputs = self.application.step(&Samples::at_rest(word));
        self.capture.sample(&outputs);
        self.count += 1;
    }

    fn read(&mut self) -> Result<CaptureFile, ReadError> {
        let mut reader = Reader::default();
        while let Some(question) = reader.question() {
            let (answer, is_refused) = self.serve(Message::Access(question)).expect("an answer");
            reader.answer(&answer, is_refused)?;
        }
        Ok(reader.finish())
    }
}

/// A capture of angle and command each second control period.
fn captured(desk: &mut Desk<'_>) -> CaptureFile {
    for (number, signal) in [(160, 0), (161, 5), (162, 255)] {
        desk.write(number, signal);
    }
    desk.write(168, 2);
    desk.step();
    desk.order(Order::StartCapture);
    for _ in 0..40 {
        desk.step();
    }
    assert_eq!(desk.read(), Err(ReadError::Unfinished(2)));
    desk.order(Order::StopCapture);
    desk.read().expect("it is full")
}

#[test]
fn a_capture_comes_out_of_the_board_as_it_was_recorded_and_can_be_imported() {
    let mut buffer = [0; 100];
    let mut desk = Desk::new(&mut buffer);
    let file = captured(&mut desk);
    assert_eq!(file.signals, [Signal::Angle, Signal::Command]);
    assert_eq!((file.len(), file.decimation), (20, 2));
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("capture.csv");
    std::fs::write(&path, file.text()).expect("a file");
    let imported = Import::default().read(&path, &mut |_, _| {});
    let imported = imported.expect("a recording");
    assert_eq!(imported.notes, []);
    let recording = imported.recording;
    assert_eq!(recording.time_s[1], 0.008);
    for (index, angle_deg) in recording.angle_deg.iter().enumerate() {
        // Two counts a record, told in thousandths.
        let expected = f64::from(2 * index as u32 + 1) * 360.0 / 4096.0;
        assert!(
            (angle_deg - expected).abs() <= 0.001,
            "{index}: {angle_deg}"
        );
    }
}

#[test]
fn settings_that_were_changed_since_are_not_taken_for_those_of_the_records() {
    let mut buffer = [0; 100];
    let mut desk = Desk::new(&mut buffer);
    captured(&mut desk);
    // The third signal stood for the end of them: behind it there are three more.
    desk.write(162, 7);
    let (found, expected) = (2, 6);
    assert_eq!(desk.read(), Err(ReadError::Changed { found, expected }));
}

#[test]
fn an_answer_to_another_question_and_one_that_is_lost_do_no_harm() {
    let mut reader = Reader::default();
    let question = reader.question().expect("the first");
    let other = Access {
        number: 199,
        value: 77,
        ..question
    };
    reader.answer(&other, false).expect("it is passed over");
    assert_eq!(reader.question(), Some(question));
    assert_eq!(reader.answer(&question, true), Err(ReadError::Refused(192)));
}

#[test]
fn a_field_that_is_no_number_is_named_by_its_line() {
    let mut buffer = [0; 100];
    let text = captured(&mut Desk::new(&mut buffer)).text();
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("capture.csv");
    let torn = text.replace("\n16000,", "\n16000,x");
    std::fs::write(&path, torn).expect("a file");
    let error = Import::default().read(&path, &mut |_, _| {}).unwrap_err();
    let said = error.to_string();
    assert!(
        said.ends_with("capture.csv:5: column 2 (`angle_mdeg`) is not a finite number"),
        "{said}"
    );
}
