//! Servos on one line, with one supply.

use model_core::parameter::ParameterError;
use model_core::plant::drivetrain::load::LoadParameters;
use servo_bus::tables::{sts, x};
use servo_bus::{Answer, Field, Memory, Receiver, dynamixel, feetech};

use super::dynamixel::X;
use super::fault::OfServo;
use super::feetech::Sts;
use super::model::Family;
use super::motor::{Motor, Sensed};
use super::{Model, PERIOD_US};

/// Late periods that are computed after a pause. More are skipped, as of a suspended computer.
const MAX_LATE_PERIODS: u64 = 100;

/// The table and control of a servo.
#[derive(Debug)]
enum Kind {
    Sts(Box<Sts>),
    X(Box<X>),
}

/// A servo of either family.
#[derive(Debug)]
pub struct Servo {
    kind: Kind,
    is_absent: bool,
    /// Next answers of which a bit is wrong.
    corrupt_answers: u32,
}

impl Servo {
    /// A new servo with this ID, and this load at its horn.
    ///
    /// # Errors
    /// For parameters of the model or the load out of range.
    pub fn new(model: &Model, id: u8, load: LoadParameters) -> Result<Self, ParameterError> {
        let motor = Motor::new(model, load)?;
        let kind = match model.family {
            Family::Sts => Kind::Sts(Box::new(Sts::new(model, id, motor))),
            Family::X => Kind::X(Box::new(X::new(model, id, motor))),
        };
        Ok(Self {
            kind,
            is_absent: false,
            corrupt_answers: 0,
        })
    }

    fn receive(&mut self, packet: &[u8]) -> Option<Answer> {
        if self.is_absent {
            return None;
        }
        match &mut self.kind {
            Kind::Sts(servo) => servo.receive(packet),
            Kind::X(servo) => servo.receive(packet),
        }
    }

    /// What the line does to the last byte of an answer.
    fn damage(&mut self) -> u8 {
        let is_damaged = self.corrupt_answers > 0;
        self.corrupt_answers -= u32::from(is_damaged);
        u8::from(is_damaged)
    }

    /// A period of 1 ms with this supply, V.
    pub fn step(&mut self, supply_v: f64) {
        match &mut self.kind {
            Kind::Sts(servo) => servo.step(supply_v),
            Kind::X(servo) => servo.step(supply_v),
        }
    }

    /// Begins or ends a fault.
    pub fn apply(&mut self, fault: OfServo) {
        match fault {
            OfServo::Jam(is_jammed) => self.motor().set_jammed(is_jammed),
            OfServo::Load(torque_nm) => self.motor().set_load_nm(torque_nm),
            OfServo::Absent(is_absent) => self.is_absent = is_absent,
            OfServo::Corrupt(answers) => self.corrupt_answers = answers,
            OfServo::Id(id) => {
                let field = self.id_field();
                self.memory().store(field, i32::from(id));
            }
        }
    }

    fn id_field(&self) -> Field {
        match &self.kind {
            Kind::Sts(_) => sts::ID,
            Kind::X(_) => x::ID,
        }
    }

    /// Its registers.
    pub fn memory(&mut self) -> &mut Memory {
        match &mut self.kind {
            Kind::Sts(servo) => &mut servo.server.memory,
            Kind::X(servo) => &mut servo.server.memory,
        }
    }

    fn motor(&mut self) -> &mut Motor {
        match &mut self.kind {
            Kind::Sts(servo) => &mut servo.motor,
            Kind::X(servo) => &mut servo.motor,
        }
    }

    /// What it measures.
    pub fn sensed(&self) -> &Sensed {
        match &self.kind {
            Kind::Sts(servo) => servo.motor.sensed(),
            Kind::X(servo) => servo.motor.sensed(),
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
    /// A bus of `count` servos with IDs from 1, without loads, and a supply with this resistance,
    /// ohm.
    ///
    /// # Errors
    /// For parameters of the model out of range.
    pub fn new(model: &Model, count: u8, supply_ohm: f64) -> Result<Self, ParameterError> {
        Self::with_loads(model, count, |_| LoadParameters::default(), supply_ohm)
    }

    /// As [`Self::new`], with the load at the horn of the servo with each ID. Angle zero of a load
    /// is the middle of the turn, 2048.
    ///
    /// # Errors
    /// For parameters of the model or of a load out of range.
    pub fn with_loads(
        model: &Model,
        count: u8,
        load: impl Fn(u8) -> LoadParameters,
        supply_ohm: f64,
    ) -> Result<Self, ParameterError> {
        let servos = (1..=count).map(|id| Servo::new(model, id, load(id)));
        let line = match model.family {
            Family::Sts => Line::Feetech(Box::default()),
            Family::X => Line::Dynamixel(Box::default()),
        };
        Ok(Self {
            servos: servos.collect::<Result<_, _>>()?,
            line,
            supply_v: model.supply_v,
            supply_ohm,
            next_us: u64::from(PERIOD_US),
        })
    }

    /// The servos.
    pub fn servos(&mut self) -> &mut [Servo] {
        &mut self.servos
    }

    /// Sets the voltage of the supply without a load, V.
    pub fn set_supply_v(&mut self, supply_v: f64) {
        self.supply_v = supply_v;
    }

    /// Computes the periods until this time.
    pub fn advance_to(&mut self, now_us: u64) {
        let earliest = now_us.saturating_sub(MAX_LATE_PERIODS * u64::from(PERIOD_US));
        self.next_us = self.next_us.max(earliest);
        while self.next_us <= now_us {
            self.step();
            self.next_us += u64::from(PERIOD_US);
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
    let answers = servos.iter_mut().filter_map(|servo| {
        let answer = servo.receive(packet)?;
        Some((answer, servo.damage()))
    });
    let mut answers: Vec<(Answer, u8)> = answers.collect();
    answers.sort_by_key(|(answer, _)| answer.turn);
    let mut crc = 0;
    for (turn, (mut answer, damage)) in answers.into_iter().enumerate() {
        if answer.is_linked {
            if usize::from(answer.turn) != turn {
                return;
            }
            crc = dynamixel::link(&mut answer.bytes, crc);
        }
        sent.delay_us += u64::from(answer.delay_us);
        sent.bytes.extend_from_slice(&answer.bytes);
        if let Some(last) = sent.bytes.last_mut() {
            *last ^= damage;
        }
    }
}
