//! Experiments one after the other on one emulated board.
//!
//! The emulator translates the program once for all of them: between two experiments the supply is
//! cut, and memory and shaft are as at the first power-on afterwards.

use std::sync::mpsc::Sender;

use virtual_board::can::Port;
use virtual_board::faults::{Fault, MemoryLocation, Planned};
use virtual_board::plant::{BoardPlant, BoardPlantOptions};
use virtual_board::run::{Flow, Script, View};

use board_tests::frames::to_wire;
use board_tests::master::PERIODS;

use crate::injection::{Injection, Place};
use crate::injector::Injector;
use crate::motion::Motion;
use crate::outcome::{Judge, Outcome};
use crate::tell::Tell;

/// Duration of the supply cut between two experiments, ms, and the time from its start to the next
/// power-on.
const CUT_MS: u64 = 3;
const OFF_MS: u32 = 6;

/// Time for which an experiment is observed after its injection, ms: longer than a change of the
/// target and the time after which a deviation is hazardous. An injection into the core follows its
/// instant within 16 ms.
const OBSERVED_MS: u32 = 1200;

/// Duration of an undisturbed run, ms: the latest injection and its observation.
const REFERENCE_MS: u32 = 2800;

/// Time by which two runs of one motion may differ, ms: two control periods, since the phase of the
/// board's timer to the master differs from run to run. A reported angle is as old at most.
const TOLERATED_MS: usize = 8;

/// First and last address of the stored parameters that an experiment might change.
const STORE: [u64; 2] = [0x0810_0000, 0x0810_8000];

const BLANK: u32 = u32::MAX;

/// Angles of the undisturbed board by motion, one each millisecond after power-on, deg.
pub type References = [Vec<f64>; 3];

/// The script that carries out the experiments.
pub struct Experiments {
    injections: std::vec::IntoIter<Injection>,
    current: Option<Injection>,
    references: References,
    /// Motions whose undisturbed run is still to be recorded.
    to_record: Vec<Motion>,
    recording: Option<Motion>,
    /// ms since power-on; `None` before the first one.
    ms: Option<u32>,
    off_ms: u32,
    tell: Tell,
    judge: Judge,
    /// Angles of this run, one each millisecond, deg.
    angles: Vec<f64>,
    original: Option<(u64, u32)>,
    injector: Injector,
    judged: Sender<(Injection, Outcome)>,
}

impl Experiments {
    /// These experiments, after the undisturbed runs; each result is sent when it is known.
    pub fn new(
        injections: Vec<Injection>,
        injector: Injector,
        judged: Sender<(Injection, Outcome)>,
    ) -> Self {
        Self {
            injections: injections.into_iter(),
            current: None,
            references: References::default(),
            to_record: vec![Motion::Position, Motion::Velocity, Motion::Disabled],
            recording: None,
            ms: None,
            off_ms: 0,
            tell: Tell::default(),
            judge: Judge::default(),
            angles: Vec::new(),
            original: None,
            injector,
            judged,
        }
    }

    /// Selects the next run; returns whether there is one.
    fn select(&mut self) -> bool {
        self.recording = self.to_record.pop();
        if self.recording.is_none() {
            self.current = self.injections.next();
        }
        self.recording.is_some() || self.current.is_some()
    }

    fn motion(&self) -> Motion {
        let current = self.current.map(|injection| injection.motion);
        self.recording.or(current).unwrap_or(Motion::Disabled)
    }

    /// Cuts the supply, and restores flash, shaft and bus.
    fn restart(&mut self, view: &mut View<'_>) {
        if let Some((address, word)) = self.original.take() {
            view.program_word(address, word);
        }
        for address in (STORE[0]..STORE[1]).step_by(4) {
            if view.word(address) != Some(BLANK) {
                view.program_word(address, BLANK);
            }
        }
        let now_ns = view.now_ns();
        view.plan(Planned::at_ms(now_ns / 1_000_000 + 1, Fault::PowerLoss).for_ms(CUT_MS));
        self.ms = None;
        self.off_ms = OFF_MS;
        self.tell = Tell::default();
        self.judge = Judge::default();
        self.angles.clear();
    }

    fn inject(&mut self, view: &mut View<'_>, injection: Injection) {
        self.tell.forget();
        let word_address = injection.address & !3;
        let (place, bit) = (
            MemoryLocation::Address(injection.address),
            injection.bit.into(),
        );
        let fault = match injection.place {
            Place::Code => {
                self.original = view.word(word_address).map(|word| (word_address, word));
                Fault::FlipFlash { place, bit }
            }
            Place::Ram => Fault::FlipRam { place, bit },
            Place::Registers | Place::Instruction => {
                self.injector.arm(injection);
                return;
            }
        };
        // Within the next period, at an instant that does not depend on the PWM.
        let phase_ns = injection.number * 7_919 % 1000 * 1000;
        view.plan(Planned::at_ns(view.now_ns() + phase_ns, fault));
    }

    /// A millisecond of a run; returns whether the run is over.
    fn observe(&mut self, view: &mut View<'_>, ms: u32) -> bool {
        let received = view.port(0).map(Port::take_received).unwrap_or_default();
        self.tell
            .update(received.into_iter().map(|(_, frame)| frame));
        let angle_deg = view.row.angle_deg;
        self.angles.push(angle_deg);
        if let Some(motion) = self.recording {
            self.references[motion.index()].push(angle_deg);
            return ms + 1 >= REFERENCE_MS;
        }
        let Some(injection) = self.current else {
            return true;
        };
        if ms == injection.at_ms {
            self.inject(view, injection);
        } else if ms > injection.at_ms {
            let ms = ms as usize;
            let reference = &self.references[injection.motion.index()];
            let moved = beyond(angle_deg, reference, ms, ms + TOLERATED_MS);
            let reported = self.tell.angle_deg.unwrap_or(angle_deg);
            let misreported = beyond(reported, &self.angles, ms, ms);
            self.judge.update(moved.max(misreported), self.tell.is_told);
        }
        let is_over = ms >= injection.at_ms + OBSERVED_MS;
        if is_over {
            // The receiver lives until the end of the run.
            let _ = self.judged.send((injection, self.judge.outcome()));
            self.current = None;
        }
        is_over
    }
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

impl Script for Experiments {
    fn at_edge(&mut self, view: &mut View<'_>) -> Flow {
        if self.off_ms > 0 {
            self.off_ms -= 1;
            if self.off_ms == 0 {
                if let Ok(plant) = BoardPlant::try_new(&BoardPlantOptions::default()) {
                    *view.plant = plant;
                }
                if let Some(port) = view.port(0) {
                    *port = Port::at_rate(1_000_000);
                }
                self.ms = Some(0);
            }
            return Flow::Continue;
        }
        let Some(ms) = self.ms else {
            if !self.select() {
                return Flow::End;
            }
            self.restart(view);
            return Flow::Continue;
        };
        if u64::from(ms).is_multiple_of(PERIODS) {
            let now_ns = view.now_ns();
            for frame in self.motion().frames(u64::from(ms) / PERIODS) {
                if let Some(port) = view.port(0) {
                    port.send(now_ns, to_wire(&frame));
                }
            }
        }
        self.ms = Some(ms + 1);
        if self.observe(view, ms) {
            self.ms = None;
        }
        Flow::Continue
    }
}
