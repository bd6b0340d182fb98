//! A CANopen master that sends by a timetable.

use model_core::time::UPDATE_RATE_HZ;
use virtual_board::run::{Flow, Script, View};

use crate::frames::{Frame, control, start, to_wire};

/// Ticks of the master in a second: the control periods of the paper. With the second set of rates
/// there are four control periods in each.
pub const TICK_RATE_HZ: u32 = 250;

/// Update periods of the PWM in a tick.
pub const PERIODS: u64 = (UPDATE_RATE_HZ / TICK_RATE_HZ) as u64;

/// The master: `frames` returns what it sends at the start of a tick, with which a control period
/// begins. The node receives these frames in its first call of that period, and the next control
/// step uses them.
pub struct Master<F> {
    frames: F,
    period: u64,
    /// The port that it sends through.
    pub port: usize,
}

impl<F: Fn(u64) -> Vec<Frame>> Master<F> {
    /// From the first tick on, through the first port.
    pub fn new(frames: F) -> Self {
        Self {
            frames,
            period: 0,
            port: 0,
        }
    }

    /// The tick that begins with this update period, if one does.
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

/// The first tick in which [`driven`] sends targets: the drive is in OPERATION ENABLED by
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

/// A target angle for each tick, mdeg.
pub type Targets = fn(tick: u64) -> i32;

/// 10 deg and -10 deg, alternating every second.
pub fn to_and_fro(tick: u64) -> i32 {
    steps(tick, 10_000, 250)
}

/// An angle and its opposite, alternating every `hold` ticks.
pub fn steps(tick: u64, mdeg: i32, hold: u64) -> i32 {
    if (tick / hold).is_multiple_of(2) {
        mdeg
    } else {
        -mdeg
    }
}
