//! Servos on one line, with one supply.

use model_core::parameter::ParameterError;
use servo_bus::{Answer, Receiver, dynamixel, feetech};

use super::Model;
use super::dynamixel::X;
use super::feetech::Sts;
use super::model::Family;
use super::motor::{Motor, Sensed};

/// Late periods that are computed after a pause. More are skipped, as of a suspended computer.
const MAX_LATE_PERIODS: u64 = 100;

/// Length of a period, us.
const PERIOD_US: u64 = 1000;

/// A servo of either family.
#[derive(Debug)]
pub enum Servo {
    /// Of the STS series.
    Sts(Box<Sts>),
    /// Of the X series.
    X(Box<X>),
}

impl Servo {
    /// A new servo with this ID.
    ///
    /// # Errors
    /// For parameters of the model out of range.
    pub fn new(model: &Model, id: u8) -> Result<Self, ParameterError> {
        let motor = Motor::new(model)?;
        Ok(match model.family {
            Family::Sts => Self::Sts(Box::new(Sts::new(model, id, motor))),
            Family::X => Self::X(Box::new(X::new(model, id, motor))),
        })
    }

    fn receive(&mut self, packet: &[u8]) -> Option<Answer> {
        match self {
            Self::Sts(servo) => servo.receive(packet),
            Self::X(servo) => servo.receive(packet),
        }
    }

    /// A period of 1 ms with this supply, V.
    pub fn step(&mut self, supply_v: f64) {
        match self {
            Self::Sts(servo) => servo.step(supply_v),
            Self::X(servo) => servo.step(supply_v),
        }
    }

    /// Its motor.
    pub fn motor(&mut self) -> &mut Motor {
        match self {
            Self::Sts(servo) => &mut servo.motor,
            Self::X(servo) => &mut servo.motor,
        }
    }

    /// What it measures.
    pub fn sensed(&self) -> &Sensed {
        match self {
            Self::Sts(servo) => servo.motor.sensed(),
            Self::X(servo) => servo.motor.sensed(),
        }
    }
}

/// The packets of the line, by the protocol of its servos.
#[derive(Debug)]
enum Line {
    Feetech(Box<Receiver<feetech::Framing>>),
    Dynamixel(Box<Receiver<dynamixel::Framing>>),
}

/// Servos of one model on a line.
#[derive(Debug)]
pub struct Bus {
    servos: Vec<Servo>,
    line: Line,
    supply_v: f64,
    /// Of the supply and its cable.
    supply_ohm: f64,
    next_us: u64,
}

/// An answer to the line.
#[derive(Debug, Default)]
pub struct Sent {
    /// Pauses before its packets, us.
    pub delay_us: u64,
    /// Its bytes.
    pub bytes: Vec<u8>,
}

impl Bus {
    /// A bus of `count` servos with IDs from 1, and a supply with this resistance.
    ///
    /// # Errors
    /// For parameters of the model out of range.
    pub fn new(model: &Model, count: u8, supply_ohm: f64) -> Result<Self, ParameterError> {
        let servos = (1..=count).map(|id| Servo::new(model, id));
        let line = match model.family {
            Family::Sts => Line::Feetech(Box::default()),
            Family::X => Line::Dynamixel(Box::default()),
        };
        Ok(Self {
            servos: servos.collect::<Result<_, _>>()?,
            line,
            supply_v: model.supply_v,
            supply_ohm,
            next_us: PERIOD_US,
        })
    }

    /// The servos.
    pub fn servos(&mut self) -> &mut [Servo] {
        &mut self.servos
    }

    /// Time of the next period, us.
    pub fn next_us(&self) -> u64 {
        self.next_us
    }

    /// Computes the periods until this time.
    pub fn advance_to(&mut self, now_us: u64) {
        let earliest = now_us.saturating_sub(MAX_LATE_PERIODS * PERIOD_US);
        self.next_us = self.next_us.max(earliest);
        while self.next_us <= now_us {
            self.step();
            self.next_us += PERIOD_US;
        }
    }

    /// A period of all servos.
    pub fn step(&mut self) {
        // A bridge takes the share of the current for which it is on.
        let currents = self
            .servos
            .iter()
            .map(|servo| servo.sensed().duty * servo.sensed().current_a);
        let supply_v = (self.supply_v - self.supply_ohm * currents.sum::<f64>()).max(0.0);
        for servo in &mut self.servos {
            servo.step(supply_v);
        }
    }

    /// Discards a part of a packet, after a pause of the line.
    pub fn discard(&mut self) {
        match &mut self.line {
            Line::Feetech(receiver) => receiver.discard(),
            Line::Dynamixel(receiver) => receiver.discard(),
        }
    }

    /// Receives bytes; appends the answers.
    pub fn receive(&mut self, bytes: &[u8], sent: &mut Sent) {
        let Self { servos, line, .. } = self;
        for byte in bytes {
            match line {
                Line::Feetech(receiver) => {
                    receiver.push(*byte);
                    while let Some(packet) = receiver.next_packet() {
                        deliver(servos, packet, sent);
                    }
                }
                Line::Dynamixel(receiver) => {
                    receiver.push(*byte);
                    while let Some(packet) = receiver.next_packet() {
                        deliver(servos, packet, sent);
                    }
                }
            }
        }
    }
}

/// A packet to all servos, and their answers in turn. Those of one packet end at a servo that is
/// missing, as each waits for the one before.
fn deliver(servos: &mut [Servo], packet: &[u8], sent: &mut Sent) {
    let answers = servos.iter_mut().filter_map(|servo| servo.receive(packet));
    let mut answers: Vec<Answer> = answers.collect();
    answers.sort_by_key(|answer| answer.turn);
    let mut crc = 0;
    for (turn, mut answer) in answers.into_iter().enumerate() {
        if answer.is_linked {
            if usize::from(answer.turn) != turn {
                return;
            }
            crc = dynamixel::link(&mut answer.bytes, crc);
        }
        sent.delay_us += u64::from(answer.delay_us);
        sent.bytes.extend_from_slice(&answer.bytes);
    }
}
