//! The device on the PC, on the rig of the emulated board, in the board's order.

use firmware::application::Start;
use firmware::drive::{Device, Set};
use firmware::native::{bridge, samples};
use virtual_board::rig::{Rig, RigOptions, TickedRig};

use crate::frames::Frame;
use crate::native::Row;
use crate::runs::PERIODS;

/// The native run.
pub struct NativeNode {
    /// A row for each PWM period.
    pub rows: Vec<Row>,
    /// Every frame for the bus.
    pub frames: Vec<Frame>,
    rig: TickedRig,
    device: Device<'static>,
    tick: u64,
}

impl NativeNode {
    /// A board after power-on, up to its first control period: a PWM period has passed by then.
    ///
    /// # Panics
    /// If a parameter of the rig is outside its range.
    pub fn new(options: &RigOptions) -> Self {
        let mut rows = Vec::new();
        let rig = Rig::try_new(options).expect("in range");
        let rig = TickedRig::new(rig, &mut |rig, edge| rows.push(Row::of(rig, edge)));
        Self {
            rows,
            frames: Vec::new(),
            rig,
            device: Device::new(Set::defaults(), Start::default(), &mut [], 0),
            tick: 0,
        }
    }

    /// A control period with the four PWM periods behind it; these frames come in within the first of them.
    pub fn tick(&mut self, frames: &[Frame]) {
        let outputs = self.device.control(&samples(&self.rig.sampled()));
        self.turn(1, frames);
        self.turn(2, &[]);
        let rows = &mut self.rows;
        self.rig.tick(bridge(outputs.bridge), &mut |rig, edge| {
            rows.push(Row::of(rig, edge));
        });
        self.tick += 1;
    }

    /// The node's turn in this PWM period of the tick.
    fn turn(&mut self, period: u64, frames: &[Frame]) {
        let now_us = (PERIODS * self.tick + period) * 1000;
        for frame in frames {
            self.device.receive(frame, now_us);
            self.listen();
        }
        self.device.communicate(now_us);
        self.listen();
    }

    fn listen(&mut self) {
        while let Some(frame) = self.device.transmit() {
            self.frames.push(frame);
        }
    }
}
