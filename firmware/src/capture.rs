//! Records chosen signals at the control rate or a whole fraction of it, into a buffer that the
//! caller owns.
//!
//! A record is one `i32` a signal. The buffer is a ring while the capture waits for its trigger, so
//! that records from before it are kept; from the trigger on it is filled to its end and stays. One
//! call a control period, some 20 instructions a signal.
//!
//! An excitation that starts in a control period triggers in that very period, so the first record
//! from the trigger on is the one of its tick 0.

mod signal;
#[cfg(test)]
mod tests;

pub use signal::Signal;

use crate::interface::{CommandSource, Outputs};

/// Signals of a record at most.
pub const MOST_SIGNALS: usize = 8;

/// What ends the waiting.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(u8)]
pub enum Trigger {
    /// Nothing: it records at once.
    #[default]
    Now = 0,
    /// An excitation starts.
    Excitation = 1,
    /// A fault is latched.
    Fault = 2,
}

/// What is recorded, and when.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CaptureSettings {
    /// The signals, up to the first that is none.
    pub signals: [Option<Signal>; MOST_SIGNALS],
    /// Control periods from record to record, one at the least.
    pub decimation: u16,
    /// What starts it.
    pub trigger: Trigger,
    /// Records to be kept from before the trigger.
    pub before: u16,
}

impl CaptureSettings {
    /// Angle, rate, current, back-EMF, duty and command of each control period, from now on.
    pub const DEFAULT: Self = Self {
        signals: [
            Some(Signal::Angle),
            Some(Signal::Rate),
            Some(Signal::Current),
            Some(Signal::BackEmf),
            Some(Signal::Duty),
            Some(Signal::Command),
            None,
            None,
        ],
        decimation: 1,
        trigger: Trigger::Now,
        before: 0,
    };
}

impl Default for CaptureSettings {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// How far a capture is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(u8)]
pub enum Phase {
    /// Not started.
    #[default]
    Idle = 0,
    /// It waits for its trigger.
    Armed = 1,
    /// It records.
    Running = 2,
    /// The buffer is full.
    Full = 3,
}

/// A capture into a buffer.
#[derive(Debug)]
pub struct Capture<'a> {
    buffer: &'a mut [i32],
    settings: CaptureSettings,
    phase: Phase,
    /// Signals of a record.
    width: usize,
    /// Records that fit.
    capacity: usize,
    /// Where the next record goes.
    next: usize,
    /// Records that are there.
    count: usize,
    /// Records from the trigger on that are still to come.
    left: usize,
    /// Control periods until the next record.
    skip: u16,
    was_exciting: bool,
    was_faulty: bool,
}

impl<'a> Capture<'a> {
    /// A capture that has not started.
    ///
    /// ```
    /// use firmware::capture::{Capture, CaptureSettings};
    /// let mut buffer = [0; 600];
    /// let mut capture = Capture::new(&mut buffer);
    /// capture.arm(CaptureSettings::DEFAULT);
    /// assert_eq!(capture.capacity(), 100); // of six signals
    /// ```
    pub fn new(buffer: &'a mut [i32]) -> Self {
        Self {
            buffer,
            settings: CaptureSettings::DEFAULT,
            phase: Phase::Idle,
            width: 1,
            capacity: 0,
            next: 0,
            count: 0,
            left: 0,
            skip: 0,
            was_exciting: false,
            was_faulty: false,
        }
    }

    /// Starts over with these settings. Without a signal, or in a buffer that is too small for one
    /// record, there is nothing to record: it is full at once.
    pub fn arm(&mut self, settings: CaptureSettings) {
        let signals = settings.signals.iter().map_while(|&signal| signal).count();
        self.settings = settings;
        self.width = signals.max(1);
        self.capacity = if signals == 0 {
            0
        } else {
            self.buffer.len().checked_div(signals).unwrap_or(0)
        };
        (self.next, self.count, self.skip) = (0, 0, 0);
        // What was so in the last control period is no trigger.
        let before = usize::from(settings.before).min(self.capacity.saturating_sub(1));
        self.left = self.capacity.saturating_sub(before);
        self.phase = match settings.trigger {
            _ if self.capacity == 0 => Phase::Full,
            Trigger::Now => Phase::Running,
            _ => Phase::Armed,
        };
        if settings.trigger == Trigger::Now {
            self.left = self.capacity;
        }
    }

    /// Ends it; what was recorded can be read.
    pub fn stop(&mut self) {
        if matches!(self.phase, Phase::Armed | Phase::Running) {
            self.phase = Phase::Full;
        }
    }

    /// How far it is.
    pub fn phase(&self) -> Phase {
        self.phase
    }

    /// Records that fit.
    pub fn capacity(&self) -> usize {
        self.capacity
    }

    /// Records that are there.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Signals of a record.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Takes the outputs of a control period.
    pub fn sample(&mut self, outputs: &Outputs) {
        let is_triggered = self.is_triggered(outputs);
        if self.phase == Phase::Armed && is_triggered {
            self.phase = Phase::Running;
            // The trigger's own period is recorded, whatever the decimation.
            self.skip = 0;
        }
        if !matches!(self.phase, Phase::Armed | Phase::Running) {
            return;
        }
        if let Some(skip) = self.skip.checked_sub(1) {
            self.skip = skip;
            return;
        }
        self.skip = self.settings.decimation.saturating_sub(1);
        self.record(outputs);
    }

    /// Whether what it waits for begins in this control period.
    fn is_triggered(&mut self, outputs: &Outputs) -> bool {
        let is_exciting = outputs.telemetry.source == CommandSource::Excitation;
        let is_faulty = outputs.fault.is_some();
        let begins = match self.settings.trigger {
            Trigger::Now => true,
            Trigger::Excitation => is_exciting && !self.was_exciting,
            Trigger::Fault => is_faulty && !self.was_faulty,
        };
        (self.was_exciting, self.was_faulty) = (is_exciting, is_faulty);
        begins
    }

    fn record(&mut self, outputs: &Outputs) {
        let start = self.next.saturating_mul(self.width);
        let record = self.buffer.get_mut(start..).unwrap_or_default();
        for (place, signal) in record.iter_mut().zip(&self.settings.signals) {
            let Some(signal) = signal else { break };
            *place = signal.of(outputs);
        }
        self.next += 1;
        if self.next >= self.capacity {
            self.next = 0;
        }
        self.count = (self.count + 1).min(self.capacity);
        if self.phase == Phase::Armed {
            let before = self.capacity.saturating_sub(self.left);
            // Older ones are overwritten: they are too many.
            self.count = self.count.min(before);
            return;
        }
        self.left = self.left.saturating_sub(1);
        if self.left == 0 {
            self.phase = Phase::Full;
        }
    }

    /// A value: signal `signal` of record `record`, the oldest being 0; `None` where there is none.
    pub fn value(&self, record: usize, signal: usize) -> Option<i32> {
        if record >= self.count || signal >= self.width {
            return None;
        }
        // The oldest lies `count` records behind the next one.
        let oldest = self.next + self.capacity - self.count;
        let mut place = oldest + record;
        while place >= self.capacity {
            place -= self.capacity;
        }
        self.buffer.get(place * self.width + signal).copied()
    }

    /// Values one after the other, record by record, from number `from` on, as many as there are
    /// and fit; returns how many. A bus reads in pieces so.
    pub fn read(&self, from: usize, piece: &mut [i32]) -> usize {
        let (mut record, mut signal) = (
            from.checked_div(self.width).unwrap_or(0),
            from.checked_rem(self.width).unwrap_or(0),
        );
        let mut count = 0;
        for place in piece {
            let Some(value) = self.value(record, signal) else {
                break;
            };
            *place = value;
            count += 1;
            signal += 1;
            if signal >= self.width {
                (record, signal) = (record + 1, 0);
            }
        }
        count
    }
}
