//! An experiment: an injection into the running board, and the time after it.

use std::fs::File;
use std::io::Write;

use virtual_board::can::Port;
use virtual_board::faults::{Fault, MemoryLocation, Planned};
use virtual_board::plant::Bridge;
use virtual_board::run::View;
use virtual_board::trace::Row;

use crate::fork::Reporter;
use crate::injection::{Injection, Place};
use crate::injector::Injector;
use crate::outcome::{Judge, Observation};
use crate::reports::Reports;
use crate::twin::Twin;

/// Time for which an experiment is observed after its injection, ms: longer than a change of the
/// target and the time after which a deviation is hazardous. An injection into the core follows its
/// instant within 16 ms.
pub const OBSERVED_MS: u32 = 1200;

/// Time after which an experiment ends whose shaft remains safe after a fault was detected, ms: longer
/// than a restart and the master's period.
const SAFE_MS: u32 = 250;

/// Time by which an angle may differ, ms: two control periods, as old as a reported angle is at
/// most.
const TOLERATED_MS: usize = 8;

/// First line of a trace.
pub const TRACE_COLUMNS: &str =
    "time_ms,expected_deg,angle_deg,reported_deg,detected,error_code,restarted\n";

/// A running experiment.
#[derive(Debug)]
pub struct Experiment {
    injection: Injection,
    injector: Injector,
    reporter: Option<Reporter>,
    reports: Reports,
    judge: Judge,
    /// Angles of the twin, and of this board, one each millisecond, deg.
    expected: Twin,
    angles: Vec<f64>,
    resets: usize,
    trace: Option<File>,
}

impl Experiment {
    /// Injects into the board as it is. The trace gets a line each millisecond.
    pub fn start(
        view: &mut View<'_>,
        injection: Injection,
        (expected, injector, reports): (Twin, Injector, Reports),
        (reporter, trace): (Reporter, Option<File>),
    ) -> Self {
        let angles = expected[..expected.len().min(injection.at_ms as usize + 1)].to_vec();
        let resets = view.resets();
        inject(view, injection, &injector);
        Self {
            injection,
            injector,
            reporter: Some(reporter),
            reports,
            judge: Judge::default(),
            expected,
            angles,
            resets,
            trace,
        }
    }

    /// Observes the board in this millisecond after power-on. At the end of the experiment, it ends
    /// this process with the verdict.
    pub fn observe(&mut self, view: &mut View<'_>, ms: u32) {
        let elapsed_ms = ms - (self.angles.len() as u32 - 1);
        let received = view.port(0).map(Port::take_received).unwrap_or_default();
        let frames = received.into_iter().map(|(_, frame)| frame);
        self.reports.update(elapsed_ms, frames);
        // The plant advances with the levels of the pins, also while the timer does not run.
        let Row {
            angle_deg,
            rate_deg_s,
            bridge,
            ..
        } = *view.row;
        let now = ms as usize;
        self.angles.resize(now + 1, angle_deg);
        let moved = beyond(angle_deg, &self.expected, now, now + TOLERATED_MS);
        let reported = self.reports.angle_deg.unwrap_or(angle_deg);
        let misreported = beyond(reported, &self.angles, now, now);
        let after_ms = ms - self.injection.at_ms;
        let observed = Observation {
            deviation_deg: moved.max(misreported),
            rate_deg_s,
            is_driven: matches!(bridge, Bridge::Driven { .. }),
            is_detected: self.reports.is_detected,
            has_restarted: view.resets() > self.resets,
        };
        self.judge.update(after_ms, observed);
        self.write_trace(ms, angle_deg, observed);
        let is_over = after_ms >= OBSERVED_MS || self.judge.detected_and_safe_ms() >= SAFE_MS;
        if let Some(reporter) = self.reporter.take_if(|_| is_over) {
            let pc = match self.injection.place {
                // What the injector has is of an earlier injection into the core.
                Place::Ram | Place::Code | Place::Named => 0,
                Place::Registers | Place::Instruction => self.injector.pc(),
            };
            reporter.end(&self.judge.verdict(pc).to_bytes());
        }
    }

    /// Writes a line of the trace, if one is asked for. An error ends the trace, not the
    /// experiment.
    fn write_trace(&mut self, ms: u32, angle_deg: f64, observed: Observation) {
        let Some(mut file) = self.trace.take() else {
            return;
        };
        let expected_deg = self.expected.get(ms as usize).copied().unwrap_or_default();
        let reported_deg = self.reports.angle_deg.unwrap_or_default();
        let line = format!(
            "{ms},{expected_deg:.3},{angle_deg:.3},{reported_deg},{},{:#06x},{}\n",
            u8::from(observed.is_detected),
            self.reports.error_code,
            u8::from(observed.has_restarted),
        );
        if file.write_all(line.as_bytes()).is_ok() {
            self.trace = Some(file);
        }
    }
}

/// Injects into the board.
pub fn inject(view: &mut View<'_>, injection: Injection, injector: &Injector) {
    let place = MemoryLocation::Address(injection.address);
    let bit = injection.bit.into();
    let fault = match injection.place {
        Place::Code => Fault::FlipFlash { place, bit },
        Place::Ram | Place::Named => Fault::FlipRam { place, bit },
        Place::Registers | Place::Instruction => {
            injector.arm(injection);
            return;
        }
    };
    let at_ns = view.now_ns() + injection.phase_ns();
    view.plan(Planned::at_ns(at_ns, fault));
}

/// How far an angle is outside the range of these angles from [`TOLERATED_MS`] before `ms` to
/// `end`.
fn beyond(angle_deg: f64, angles: &[f64], ms: usize, end: usize) -> f64 {
    let begin = ms.saturating_sub(TOLERATED_MS);
    let window = angles.iter().take(end + 1).skip(begin);
    let (least, greatest) = window.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), deg| {
        (low.min(*deg), high.max(*deg))
    });
    (least - angle_deg).max(angle_deg - greatest).max(0.0)
}
