//! The device on a bus with a simulated motor.

extern crate std;

mod bus_errors;
mod counters;
mod current;
mod dronecan;
mod enabling;
mod events;
mod failsafe;
mod homing;
mod interpolation;
mod limits;
mod motion;
mod objects;
mod polarity;
mod service;
mod servo_bus;
mod store;
mod torque;
mod tracking;
mod update;
mod velocity;

use canopen::CanFrame;
use canopen::cia402::statusword;
use embedded_can::{Frame, StandardId};
use std::{boxed::Box, vec::Vec};

use super::*;
use crate::{
    actuator::Actuator,
    application::{Samples, tests::Motor},
};

/// A device with node-ID 1, its motor, and a master that receives every frame.
struct Bench {
    actuator: Actuator<'static>,
    motor: Motor,
    outputs: Option<Outputs>,
    now_us: u64,
    /// Frames of the device.
    received: Vec<CanFrame>,
    /// Whether a write of the flash succeeds.
    flash: Flash,
    /// Control periods that a write takes, and those that are left.
    writes_for: u32,
    writing: Option<u32>,
    /// Written to RPDO 3 in each control period.
    cyclic: Option<(u16, i32)>,
}

/// Result of a write of the flash.
#[derive(Clone, Copy, PartialEq)]
enum Flash {
    Succeeds,
    Fails,
}

fn frame(id: u16, data: &[u8]) -> CanFrame {
    CanFrame::new(StandardId::new(id).expect("11 bits"), data).expect("at most 8 bytes")
}

impl Bench {
    fn new() -> Self {
        Self::with(StoredParameters::DEFAULT)
    }

    fn with(set: StoredParameters) -> Self {
        Self::started(set, Start::default())
    }

    fn after(start: Start) -> Self {
        Self::started(StoredParameters::DEFAULT, start)
    }

    fn started(set: StoredParameters, start: Start) -> Self {
        let buffer = Box::leak(Box::new([0; 4000]));
        let mut bench = Self {
            actuator: Actuator::new(set, start, buffer, 0),
            motor: Motor::new(),
            outputs: None,
            now_us: 0,
            received: Vec::new(),
            flash: Flash::Succeeds,
            writes_for: 0,
            writing: None,
            cyclic: None,
        };
        bench.steps(3);
        bench.send(0, &[1, 0]);
        bench.steps(2);
        bench
    }

    /// In OPERATION ENABLED, in this mode.
    fn enabled(mode: i8) -> Self {
        let mut bench = Self::new();
        bench.set(0x6060, 0, u32::from(mode as u8), 1);
        bench.enable();
        bench
    }

    fn enable(&mut self) {
        for word in [6, 7, 15] {
            self.control(word);
        }
        assert_eq!(self.status() & 0x6F, 0x27, "operation enabled");
    }

    fn control(&mut self, word: u16) {
        self.set(0x6040, 0, u32::from(word), 2);
        self.steps(2);
    }

    fn status(&mut self) -> u16 {
        self.get(0x6041, 0) as u16
    }

    fn is_reached(&mut self) -> bool {
        self.status() & statusword::TARGET_REACHED != 0
    }

    fn send(&mut self, id: u16, data: &[u8]) {
        self.actuator.receive(&frame(id, data), self.now_us);
        self.listen();
    }

    fn listen(&mut self) {
        while let Some(frame) = self.actuator.transmit() {
            self.received.push(frame);
        }
    }

    fn step(&mut self) -> Outputs {
        self.step_with(|_| {})
    }

    fn step_with(&mut self, hand: impl FnOnce(&mut Samples)) -> Outputs {
        if let Some((word, target)) = self.cyclic {
            let data: Vec<u8> = word
                .to_le_bytes()
                .into_iter()
                .chain(target.to_le_bytes())
                .collect();
            self.send(0x401, &data);
        }
        let mut samples = self.motor.samples();
        hand(&mut samples);
        self.now_us += 4_000;
        let outputs = self.actuator.step(&samples, self.now_us);
        self.motor.turn(&outputs);
        self.write_flash();
        self.listen();
        self.outputs = Some(outputs);
        outputs
    }

    fn write_flash(&mut self) {
        if self.actuator.device.drive.take_save().is_some() {
            self.writing = Some(self.writes_for);
        }
        self.writing = match self.writing {
            Some(0) => {
                self.actuator
                    .device
                    .drive
                    .saved(self.flash == Flash::Succeeds);
                None
            }
            left => left.map(|left| left - 1),
        };
    }

    fn steps(&mut self, count: u32) {
        for _ in 0..count {
            self.step();
        }
    }

    /// One SDO request and its answer; a save takes some control periods.
    fn sdo(&mut self, request: [u8; 8]) -> [u8; 8] {
        self.received.clear();
        self.send(0x601, &request);
        for _ in 0..10 {
            let answer = self.received.iter().find(|frame| frame.raw_id().0 == 0x581);
            if let Some(answer) = answer {
                return answer.bytes();
            }
            self.step();
        }
        panic!("no answer to {request:x?}");
    }

    fn try_get(&mut self, index: u16, sub: u8) -> Result<u32, u32> {
        let [low, high] = index.to_le_bytes();
        let [command, _, _, _, a, b, c, d] = self.sdo([0x40, low, high, sub, 0, 0, 0, 0]);
        let value = u32::from_le_bytes([a, b, c, d]);
        if command == 0x80 {
            Err(value)
        } else {
            Ok(value)
        }
    }

    fn get(&mut self, index: u16, sub: u8) -> u32 {
        self.try_get(index, sub).expect("readable")
    }

    fn try_set(&mut self, index: u16, sub: u8, value: u32, size: u8) -> Result<(), u32> {
        let [low, high] = index.to_le_bytes();
        let [a, b, c, d] = value.to_le_bytes();
        let command = 0x23 | (4 - size) << 2;
        let answer = self.sdo([command, low, high, sub, a, b, c, d]);
        let [_, _, _, _, a, b, c, d] = answer;
        if answer[0] == 0x80 {
            Err(u32::from_le_bytes([a, b, c, d]))
        } else {
            Ok(())
        }
    }

    fn set(&mut self, index: u16, sub: u8, value: u32, size: u8) {
        let done = self.try_set(index, sub, value, size);
        assert_eq!(done, Ok(()), "{index:x}:{sub} = {value}");
    }

    fn set_real(&mut self, index: u16, sub: u8, value: f32) {
        self.set(index, sub, value.to_bits(), 4);
    }

    fn angle_mdeg(&mut self) -> i32 {
        self.get(0x6064, 0) as i32
    }

    /// EMCY messages so far: code and instance.
    fn emergencies(&self) -> Vec<(u16, u8)> {
        let frames = self
            .received
            .iter()
            .filter(|frame| frame.raw_id().0 == 0x81);
        frames
            .map(|frame| {
                let [low, high, _, instance, ..] = frame.bytes();
                (u16::from_le_bytes([low, high]), instance)
            })
            .collect()
    }

    /// Steps until this holds.
    fn until(&mut self, most: u32, mut holds: impl FnMut(&mut Self) -> bool) -> u32 {
        for count in 0..most {
            if holds(self) {
                return count;
            }
            self.step();
        }
        panic!("not within {most} control periods");
    }
}
