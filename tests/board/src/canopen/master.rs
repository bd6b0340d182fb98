//! A master that sends by a timetable.

use virtual_board::run::{Flow, Script, View};

use super::frames::{control, start};
use crate::frames::{BoardFrame, Frame};
use crate::runs::PERIODS;

/// The master: `orders` says what it sends at the start of a control period; it is there when the node has its first
/// turn in that.
pub struct Master<F> {
    orders: F,
    period: u64,
    /// The port that it sends through.
    pub port: usize,
}

impl<F: Fn(u64) -> Vec<Frame>> Master<F> {
    /// From the first control period on, through the first port.
    pub fn new(orders: F) -> Self {
        Self {
            orders,
            period: 0,
            port: 0,
        }
    }

    /// The control period that is about to begin, if one is.
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
                for frame in (self.orders)(tick) {
                    port.send(now_ns, frame.on_the_wire());
                }
            }
        }
        self.period += 1;
        Flow::On
    }
}

/// Starts the node and takes the drive to OPERATION ENABLED in ticks 20 to 40; from then on a target, mdeg, each fifth tick.
pub fn driven(tick: u64, target_mdeg: i32) -> Vec<Frame> {
    match tick {
        20 => vec![start()],
        30 => vec![control(0x06, 0)],
        32 => vec![control(0x07, 0)],
        34 => vec![control(0x0f, 0)],
        40.. if tick.is_multiple_of(5) => vec![control(0x0f, target_mdeg)],
        _ => Vec::new(),
    }
}
