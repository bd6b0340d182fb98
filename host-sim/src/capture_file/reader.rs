//! Reads a capture out of the board, one value a frame; whoever uses it moves the frames.

use firmware::{
    capture::{MOST_SIGNALS, Signal},
    frames::{Access, Operation},
};

use super::CaptureFile;

/// Numbers of the board's service: signals of the capture, its decimation, phase, records and width.
const SIGNALS: u8 = 160;
const DECIMATION: u8 = 168;
const PHASE: u8 = 192;
const RECORDS: u8 = 193;
const WIDTH: u8 = 194;

/// The phases in which nothing is recorded any more, and something may be there.
const FULL: u32 = 3;
/// What stands for no signal.
const NO_SIGNAL: u32 = 255;

/// Why a capture cannot be read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ReadError {
    /// It still records, or was never started.
    #[error("the capture is in phase {0}, expected 3: full; end it first")]
    Unfinished(u32),
    /// What the board says of its signals and of its records does not go together.
    #[error("the records have {found} signals, the settings {expected}: these were changed since")]
    Changed {
        /// Signals of a record.
        found: u32,
        /// Signals in the settings.
        expected: usize,
    },
    /// A signal that this program does not know.
    #[error("signal {0} is unknown")]
    UnknownSignal(u32),
    /// The board refuses.
    #[error("the board refuses to tell number {0}")]
    Refused(u8),
}

/// Asks for one value after the other.
#[derive(Debug, Clone, Default)]
pub struct Reader {
    /// Answers so far.
    answered: usize,
    phase: u32,
    records: u32,
    width: u32,
    file: CaptureFile,
}

/// What is asked before the values, in its order.
const QUESTIONS: [u8; 4 + MOST_SIGNALS] = {
    let mut questions = [PHASE, RECORDS, WIDTH, DECIMATION, 0, 0, 0, 0, 0, 0, 0, 0];
    let mut signal = 0;
    while signal < MOST_SIGNALS {
        questions[4 + signal] = SIGNALS + signal as u8;
        signal += 1;
    }
    questions
};

impl Reader {
    /// What is to be asked now; `None` once everything is told. Asked again where an answer is lost.
    pub fn question(&self) -> Option<Access> {
        let (operation, number, index) = match QUESTIONS.get(self.answered) {
            Some(number) => (Operation::Read, *number, 0),
            None => {
                let index = self.answered - QUESTIONS.len();
                if index >= self.expected() {
                    return None;
                }
                (Operation::ReadCapture, 0, index as u16)
            }
        };
        Some(Access {
            operation,
            number,
            index,
            value: 0,
        })
    }

    /// Takes an answer; one to another question is passed over.
    ///
    /// # Errors
    /// [`ReadError`] where nothing can come of it any more.
    pub fn answer(&mut self, answer: &Access, is_refused: bool) -> Result<(), ReadError> {
        let Some(question) = self.question() else {
            return Ok(());
        };
        let told = |access: &Access| (access.operation, access.number, access.index);
        if told(answer) != told(&question) {
            return Ok(());
        }
        if is_refused {
            return Err(ReadError::Refused(question.number));
        }
        self.answered += 1;
        match (question.operation, question.number) {
            (Operation::ReadCapture, _) => self.file.values.push(answer.value as i32),
            (_, PHASE) => self.phase = answer.value,
            (_, RECORDS) => self.records = answer.value,
            (_, WIDTH) => self.width = answer.value,
            (_, DECIMATION) => self.file.decimation = answer.value as u16,
            _ => self.signal(question.number - SIGNALS, answer.value)?,
        }
        if self.answered == QUESTIONS.len() {
            self.check()?;
        }
        Ok(())
    }

    fn signal(&mut self, place: u8, number: u32) -> Result<(), ReadError> {
        // The signals end at the first that is none.
        if number == NO_SIGNAL || self.file.signals.len() < usize::from(place) {
            return Ok(());
        }
        let known = u8::try_from(number).ok().and_then(Signal::of_number);
        let signal = known.ok_or(ReadError::UnknownSignal(number))?;
        self.file.signals.push(signal);
        Ok(())
    }

    fn check(&self) -> Result<(), ReadError> {
        if self.phase != FULL {
            return Err(ReadError::Unfinished(self.phase));
        }
        let expected = self.file.signals.len();
        if self.width as usize != expected {
            return Err(ReadError::Changed {
                found: self.width,
                expected,
            });
        }
        Ok(())
    }

    /// Values that there are.
    fn expected(&self) -> usize {
        self.records as usize * self.width as usize
    }

    /// Values read, and values in all: unknown at first.
    pub fn progress(&self) -> (usize, usize) {
        (self.file.values.len(), self.expected())
    }

    /// The capture, as far as it was read.
    pub fn finish(self) -> CaptureFile {
        self.file
    }
}
