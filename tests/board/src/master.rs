//! A CANopen master that sends by a timetable.

use model_core::time::UPDATE_PERIODS_PER_CONTROL_PERIOD;
use virtual_board::run::{Flow, Script, View};

use crate::frames::{Frame, control, start, to_wire};

/// PWM periods in a control period.
pub const PERIODS: u64 = UPDATE_PERIODS_PER_CONTROL_PERIOD as u64;

/// The master: `frames` returns what it sends at the start of a control period. The node receives
/// these frames in its first call of that period, and the next control step uses them.
pub struct Master<F> {
    frames: F,
    period: u64,
    /// The port that it sends through.
    pub port: usize,
}

impl<F: Fn(u64) -> Vec<Frame>> Master<F> {
    /// From the first control period on, through the first port.
    pub fn new(frames: F) -> Self {
        Self {
            frames,
            period: 0,
            port: 0,
        }
    }

    /// The control period that begins with this PWM period, if one does.
    pub fn tick(&self) -> Option<u64> {
        let is_start = self.period.is_multiple_of(PERIODS);
        is_start.then_some(self.period / PERIODS)
    }
}

impl<F: Fn(u64) -> Vec<Frame> + Send> Script for Master<F> {
    fn at_edge(&mut self, view: &mut View<'_>) -> Flow {
        if let Some(tick) = self.tick() {
            let now_ns = view.now_ns();
            if let Some(port) = view.port(self.port) {
                for frame in (self.frames)(tick) {
                    port.send(now_ns, to_wire(&frame));
                }
            }
        }
        self.period += 1;
        Flow::Continue
    }
}

/// The first control period in which [`driven`] sends targets: the drive is in OPERATION ENABLED by
/// then.
pub const ENABLED_TICK: u64 = 40;

/// Starts the node and takes the drive to OPERATION ENABLED; from [`ENABLED_TICK`] on sends a
/// target, mdeg, each fifth tick.
pub fn driven(tick: u64, target_mdeg: i32) -> Vec<Frame> {
    match tick {
        20 => vec![start()],
        30 => vec![control(0x06, 0)],
        32 => vec![control(0x07, 0)],
        34 => vec![control(0x0f, 0)],
        ENABLED_TICK.. if tick.is_multiple_of(5) => vec![control(0x0f, target_mdeg)],
        _ => Vec::new(),
    }
}

/// A target angle for each control period, mdeg.
pub type Targets = fn(tick: u64) -> i32;

/// 10 deg and -10 deg, alternating every second.
pub fn to_and_fro(tick: u64) -> i32 {
    steps(tick, 10_000, 250)
}

/// An angle and its opposite, alternating every `hold` control periods.
pub fn steps(tick: u64, mdeg: i32, hold: u64) -> i32 {
    if (tick / hold).is_multiple_of(2) {
        mdeg
    } else {
        -mdeg
    }
}
