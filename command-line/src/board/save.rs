//! Saves the board's capture as a file.

use std::path::PathBuf;

use firmware::frames::{ACCESS, ANSWER, Access};
use virtual_board::can::{Frame, Id};

use crate::error::Error;
use host_sim::{
    capture_file::{ReadError, Reader},
    file,
};

/// The node of the emulated board.
const NODE: u16 = 1;

/// PWM periods after which a question is asked again.
const PATIENCE: u64 = 40;

/// A capture that is being read.
#[derive(Debug)]
pub(super) struct Saving {
    reader: Reader,
    path: PathBuf,
    /// When the question that is open was asked, in PWM periods.
    asked: Option<u64>,
}

/// How a saving went.
#[derive(Debug)]
pub(super) enum Saved {
    /// The file is there, with so many records.
    Written(PathBuf, usize),
    /// The capture cannot be read.
    Unreadable(ReadError),
    /// The file cannot be written.
    Unwritable(Error),
}

impl Saving {
    /// Will save into this file.
    pub fn new(path: PathBuf) -> Self {
        Self {
            reader: Reader::default(),
            path,
            asked: None,
        }
    }

    /// What is to be sent in this PWM period, or how it ended.
    pub fn go_on(&mut self, period: u64, heard: &[(u64, Frame)]) -> Result<Option<Frame>, Saved> {
        let answers = heard.iter().map(|(_, frame)| frame);
        for frame in answers.filter(|frame| frame.id.value() == u32::from(ANSWER + NODE)) {
            let [operation, rest @ ..] = frame.data;
            let [number, a, b, w, x, y, z] = rest;
            let bytes = [operation & 0x7f, number, a, b, w, x, y, z];
            let Some(answer) = Access::of_bytes(bytes) else {
                continue;
            };
            let taken = self.reader.answer(&answer, operation & 0x80 != 0);
            taken.map_err(Saved::Unreadable)?;
            self.asked = None;
        }
        let Some(question) = self.reader.question() else {
            return Err(self.write());
        };
        if self.asked.is_some_and(|asked| period < asked + PATIENCE) {
            return Ok(None);
        }
        self.asked = Some(period);
        let id = Id::Standard(ACCESS + NODE);
        Ok(Some(Frame::data_frame(id, &question.bytes(false))))
    }

    fn write(&mut self) -> Saved {
        let capture = std::mem::take(&mut self.reader).finish();
        match file::write(&self.path, &capture.text()) {
            Ok(()) => Saved::Written(self.path.clone(), capture.len()),
            Err(error) => Saved::Unwritable(error),
        }
    }
}

impl std::fmt::Display for Saved {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Written(path, records) => write!(f, "{}: {records} records", path.display()),
            Self::Unreadable(error) => write!(f, "{error}"),
            Self::Unwritable(error) => write!(f, "{error}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use firmware::frames::Operation;

    use super::*;

    fn answer(question: &Frame, value: u32, is_refused: bool) -> (u64, Frame) {
        let mut access = Access::of_bytes(question.data).expect("a question");
        access.value = value;
        assert_eq!(access.operation, Operation::Read);
        let bytes = access.bytes(is_refused);
        (0, Frame::data_frame(Id::Standard(0x381), &bytes))
    }

    #[test]
    fn one_question_is_open_at_a_time_and_is_asked_again_after_a_while() {
        let mut saving = Saving::new("never.csv".into());
        let first = saving.go_on(0, &[]).expect("it goes on").expect("a frame");
        assert_eq!((first.id.value(), first.data[1]), (0x301, 192));
        assert_eq!(saving.go_on(39, &[]).expect("it waits"), None);
        assert_eq!(saving.go_on(40, &[]).expect("it goes on"), Some(first));
        let second = saving.go_on(41, &[answer(&first, 3, false)]);
        let second = second.expect("it goes on").expect("a frame");
        assert_eq!(second.data[1], 193);
        let end = saving.go_on(42, &[answer(&second, 0, true)]).unwrap_err();
        assert_eq!(end.to_string(), "the board refuses to tell number 193");
    }
}
