//! Records selected signals at the control rate or an integer fraction of it, into a buffer of the
//! caller.
//!
//! A record has one `i32` for each signal. The buffer is a ring while the capture waits for its
//! trigger, so that records from before the trigger are kept; from the trigger on it is filled to
//! its end. The capture takes about 20 instructions for each signal in a control period.
//!
//! An excitation triggers in the control period in which it starts, so the first record after the
//! trigger is that of its tick 0.

mod signal;
#[cfg(test)]
mod tests;

pub use signal::Signal;

use crate::interface::{CommandSource, Outputs};

/// Maximum number of signals in a record.
pub const MAX_SIGNALS: usize = 8;

/// Condition that starts the recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(u8)]
pub enum Trigger {
    /// No condition: it records immediately.
    #[default]
    Now = 0,
    /// An excitation starts.
    Excitation = 1,
    /// A fault is latched.
    Fault = 2,
}

/// Settings of a capture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CaptureSettings {
    /// The signals, up to the first `None`.
    pub signals: [Option<Signal>; MAX_SIGNALS],
    /// Control periods from one record to the next, at least one.
    pub decimation: u16,
    /// Condition that starts the recording.
    pub trigger: Trigger,
    /// Number of records to be kept from before the trigger.
    pub before: u16,
}

impl CaptureSettings {
    /// Angle, rate, current, back-EMF, duty and command of each control period, without a trigger.
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

/// State of a capture.
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
    /// Number of signals in a record.
    width: usize,
    /// Number of records that fit into the buffer.
    capacity: usize,
    /// Position of the next record.
    next: usize,
    /// Number of stored records.
    count: usize,
    /// Number of records still to be stored from the trigger on.
    left: usize,
    /// Control periods until the next record.
    skip: u16,
    had_excitation: bool,
    had_fault: bool,
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
            had_excitation: false,
            had_fault: false,
        }
    }

    /// Restarts with these settings. Without a signal, or with a buffer that is too small for one
    /// record, its state is [`Phase::Full`] immediately.
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

    /// Ends the recording; the stored records can be read.
    pub fn stop(&mut self) {
        if matches!(self.phase, Phase::Armed | Phase::Running) {
            self.phase = Phase::Full;
        }
    }

    /// Lends the buffer, unless a recording waits or runs; what was recorded is lost. Until
    /// [`Capture::take_back`] a capture has room for no record.
    pub fn lend(&mut self) -> Option<&'a mut [i32]> {
        if matches!(self.phase, Phase::Armed | Phase::Running) {
            return None;
        }
        (self.capacity, self.count, self.phase) = (0, 0, Phase::Idle);
        Some(core::mem::take(&mut self.buffer))
    }

    /// Takes the buffer back.
    pub fn take_back(&mut self, buffer: &'a mut [i32]) {
        self.buffer = buffer;
    }

    /// Its state.
    pub fn phase(&self) -> Phase {
        self.phase
    }

    /// Number of records that fit into the buffer.
    pub fn capacity(&self) -> usize {
        self.capacity
    }

    /// Number of stored records.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Number of signals in a record.
    pub fn width(&self) -> usize {
        self.width
    }

    /// To be called with the outputs of each control period.
    pub fn sample(&mut self, outputs: &Outputs) {
        let is_triggered = self.is_triggered(outputs);
        if self.phase == Phase::Armed && is_triggered {
            self.phase = Phase::Running;
            // The control period of the trigger is recorded for any decimation.
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

    /// Whether the condition of the trigger begins in this control period.
    fn is_triggered(&mut self, outputs: &Outputs) -> bool {
        let has_excitation = outputs.telemetry.source == CommandSource::Excitation;
        let has_fault = outputs.fault.is_some();
        let begins = match self.settings.trigger {
            Trigger::Now => true,
            Trigger::Excitation => has_excitation && !self.had_excitation,
            Trigger::Fault => has_fault && !self.had_fault,
        };
        (self.had_excitation, self.had_fault) = (has_excitation, has_fault);
        begins
    }

    fn record(&mut self, outputs: &Outputs) {
        let start = self.next.saturating_mul(self.width);
        let record = self.buffer.get_mut(start..).unwrap_or_default();
        for (slot, signal) in record.iter_mut().zip(&self.settings.signals) {
            let Some(signal) = signal else { break };
            *slot = signal.of(outputs);
        }
        self.next += 1;
        if self.next >= self.capacity {
            self.next = 0;
        }
        self.count = (self.count + 1).min(self.capacity);
        if self.phase == Phase::Armed {
            let before = self.capacity.saturating_sub(self.left);
            // Records older than the requested number before the trigger are discarded.
            self.count = self.count.min(before);
            return;
        }
        self.left = self.left.saturating_sub(1);
        if self.left == 0 {
            self.phase = Phase::Full;
        }
    }

    /// The value of signal `signal` in record `record`, 0 for the oldest; `None` beyond the stored
    /// records.
    pub fn value(&self, record: usize, signal: usize) -> Option<i32> {
        if record >= self.count || signal >= self.width {
            return None;
        }
        // The oldest record is `count` records before the next one.
        let oldest = self.next + self.capacity - self.count;
        let mut slot = oldest + record;
        while slot >= self.capacity {
            slot -= self.capacity;
        }
        self.buffer.get(slot * self.width + signal).copied()
    }

    /// Copies values, record by record, from value number `from` on, until `piece` is full or the
    /// values end; returns their number. The bus reads the buffer in such pieces.
    pub fn read(&self, from: usize, piece: &mut [i32]) -> usize {
        let (mut record, mut signal) = (
            from.checked_div(self.width).unwrap_or(0),
            from.checked_rem(self.width).unwrap_or(0),
        );
        let mut count = 0;
        for slot in piece {
            let Some(value) = self.value(record, signal) else {
                break;
            };
            *slot = value;
            count += 1;
            signal += 1;
            if signal >= self.width {
                (record, signal) = (record + 1, 0);
            }
        }
        count
    }
}
