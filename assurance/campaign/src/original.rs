//! The undisturbed board, of which a copy is made at the instant of each injection.

use std::cmp::Reverse;
use std::fs::File;
use std::io;

use board_tests::frames::to_wire;
use board_tests::master::PERIODS;
use virtual_board::can::Port;
use virtual_board::run::{Flow, Script, View};

use crate::experiment::{Experiment, OBSERVED_MS};
use crate::fork::{Copies, Reporter};
use crate::injection::Injection;
use crate::injector::Injector;
use crate::motion::Motion;
use crate::outcome::Verdict;
use crate::reports::Reports;
use crate::timetable::{Instant, Timetable};
use crate::twin::{self, Recorder, Twin};

/// What is called with each result.
pub type Report = Box<dyn FnMut(Injection, Verdict) + Send>;

/// What this process does with its board.
#[derive(Debug)]
enum Role {
    /// Copies itself for the twin, then for each injection.
    Original(Twin),
    /// Records the undisturbed board.
    Twin(Recorder),
    /// Carries out an experiment.
    Experiment(Box<Experiment>),
}

/// The script of the board of which the experiments are copies.
pub struct Original {
    /// The injections that are left, latest first.
    left: Vec<Injection>,
    /// Copies that run at the same time.
    limit: usize,
    copies: Copies<Injection>,
    injector: Injector,
    timetable: Timetable,
    reports: Reports,
    role: Role,
    report: Report,
    trace: Option<File>,
    /// Whether all copies could be made.
    pub result: io::Result<()>,
}

impl Original {
    /// Carries out these injections by this number of copies at a time. Each experiment writes its
    /// lines to the trace.
    pub fn new(
        mut injections: Vec<Injection>,
        limit: usize,
        (injector, timetable): (Injector, Timetable),
        (report, trace): (Report, Option<File>),
    ) -> Self {
        injections.sort_by_key(|injection| Reverse((injection.motion, injection.at_ms)));
        Self {
            left: injections,
            limit: limit.max(1),
            copies: Copies::default(),
            injector,
            timetable,
            reports: Reports::default(),
            role: Role::Original(Twin::default()),
            report,
            trace,
            result: Ok(()),
        }
    }

    fn act(&mut self, view: &mut View<'_>, is_edge: bool) -> io::Result<Flow> {
        let is_original = matches!(self.role, Role::Original(_));
        if is_original {
            self.timetable.carry_out(view);
            if self.left.is_empty() || self.timetable.is_over(view.now_ns()) {
                self.wait_for_all()?;
                return Ok(Flow::End);
            }
        }
        let Some(instant) = self.timetable.next(view.now_ns(), is_edge) else {
            return Ok(Flow::Continue);
        };
        let Instant { motion, ms, .. } = instant;
        send(view, motion, ms);
        match &mut self.role {
            Role::Original(_) if instant.is_warm_up => {
                self.timetable.carry_out_warm_up(ms, view, &self.injector);
            }
            Role::Original(_) => self.copy(view, motion, ms)?,
            Role::Twin(recorder) => recorder.record(view.row.angle_deg, ms),
            Role::Experiment(experiment) => experiment.observe(view, ms),
        }
        Ok(Flow::Continue)
    }

    /// Makes the copies of this millisecond. In a copy, its role has begun.
    fn copy(&mut self, view: &mut View<'_>, motion: Motion, ms: u32) -> io::Result<()> {
        if ms == 0 {
            self.reports = Reports::default();
            let of_motion = |injection: &&Injection| injection.motion == motion;
            let latest = self.left.iter().find(of_motion).map(|latest| latest.at_ms);
            if let Some(latest_ms) = latest
                && self.copy_twin(view, latest_ms)?
            {
                return Ok(());
            }
        }
        let received = view.port(0).map(Port::take_received).unwrap_or_default();
        let frames = received.into_iter().map(|(_, frame)| frame);
        self.reports.update(1, frames);
        let is_due =
            |injection: &mut Injection| injection.motion == motion && injection.at_ms <= ms;
        while let Some(injection) = self.left.pop_if(is_due) {
            if self.copies.len() >= self.limit {
                self.wait()?;
            }
            if let Some(reporter) = self.copies.start(injection)? {
                self.begin(view, injection, reporter);
                return Ok(());
            }
        }
        Ok(())
    }

    /// Has a copy record the twin until it has observed the injection at this time; returns whether
    /// this is the copy.
    fn copy_twin(&mut self, view: &mut View<'_>, latest_ms: u32) -> io::Result<bool> {
        let mut copies = Copies::default();
        if let Some(reporter) = copies.start(())? {
            let mut recorder = Recorder::new(latest_ms + OBSERVED_MS, reporter);
            recorder.record(view.row.angle_deg, 0);
            self.role = Role::Twin(recorder);
            return Ok(true);
        }
        let report = copies.wait()?.map(|((), report)| report);
        let twin = twin::from_bytes(&report.unwrap_or_default());
        self.role = Role::Original(twin);
        Ok(false)
    }

    fn wait_for_all(&mut self) -> io::Result<()> {
        while !self.copies.is_empty() {
            self.wait()?;
        }
        Ok(())
    }

    /// Begins an experiment, in its copy.
    fn begin(&mut self, view: &mut View<'_>, injection: Injection, reporter: Reporter) {
        if let Role::Original(twin) = &self.role {
            let mut reports = self.reports;
            reports.forget();
            let observer = (twin.clone(), self.injector.clone(), reports);
            let trace = self.trace.take();
            let experiment = Experiment::start(view, injection, observer, (reporter, trace));
            self.role = Role::Experiment(Box::new(experiment));
        }
    }

    fn wait(&mut self) -> io::Result<()> {
        if let Some((injection, report)) = self.copies.wait()? {
            (self.report)(injection, Verdict::from_bytes(&report));
        }
        Ok(())
    }

    fn act_or_end(&mut self, view: &mut View<'_>, is_edge: bool) -> Flow {
        self.act(view, is_edge).unwrap_or_else(|error| {
            self.result = Err(error);
            Flow::End
        })
    }
}

/// Sends what the master sends in this millisecond.
pub fn send(view: &mut View<'_>, motion: Motion, ms: u32) {
    if !u64::from(ms).is_multiple_of(PERIODS) {
        return;
    }
    let now_ns = view.now_ns();
    if let Some(port) = view.port(0) {
        for frame in motion.frames(u64::from(ms) / PERIODS) {
            port.send(now_ns, to_wire(&frame));
        }
    }
}

impl Script for Original {
    fn at_edge(&mut self, view: &mut View<'_>) -> Flow {
        self.act_or_end(view, true)
    }

    fn at_poll(&mut self, view: &mut View<'_>) -> Flow {
        self.act_or_end(view, false)
    }
}
