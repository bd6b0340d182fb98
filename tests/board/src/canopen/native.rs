//! The device on the PC, on the plant of the emulated board, in the board's order.

use firmware::application::Start;
use firmware::drive::{Device, StoredParameters};
use virtual_board::plant::BoardPlantOptions;

use crate::frames::Frame;
use crate::native_plant::NativePlant;
use crate::runs::PERIODS;

/// The native run.
pub struct NativeNode {
    /// The plant.
    pub plant: NativePlant,
    /// Every frame for the bus.
    pub frames: Vec<Frame>,
    device: Device<'static>,
    tick: u64,
}

impl NativeNode {
    /// A board after power-on, up to its first control period: a PWM period has passed by then.
    ///
    /// # Panics
    /// If a parameter of the plant is outside its range.
    pub fn new(options: &BoardPlantOptions) -> Self {
        Self {
            plant: NativePlant::new(options),
            frames: Vec::new(),
            device: Device::new(StoredParameters::DEFAULT, Start::default(), &mut [], 0),
            tick: 0,
        }
    }

    /// A control period with the four PWM periods behind it; these frames come in within the first of them.
    pub fn tick(&mut self, frames: &[Frame]) {
        let outputs = self.device.control(&self.plant.samples());
        self.turn(1, frames);
        self.turn(2, &[]);
        self.plant.tick(outputs.bridge);
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
