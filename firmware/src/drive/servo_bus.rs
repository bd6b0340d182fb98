//! The actuator as a servo on a serial bus: another front end of the drive, with the control table
//! of a servo of Feetech's STS series or a Dynamixel of the X series.
//!
//! ```text
//! bytes ── Line ── Receiver ── Server ── registers ── exchange ── Drive
//! ```
//!
//! Bytes are received, and answered, above the communication ([`ServoBus::receive`],
//! [`ServoBus::elapsed`]); the communication exchanges the registers with the drive
//! ([`ServoBus::exchange`]). While the bus is in use it alone commands the drive: CANopen reads,
//! sets parameters, and may end the motion.

mod dynamixel;
mod feetech;
mod line;
mod motor;
mod trajectory;

use core::{mem::MaybeUninit, task::Poll};
use servo_bus::{Answer, EEPROM, Framing, Memory, Receiver};

use self::{
    dynamixel::Dynamixel,
    feetech::Feetech,
    line::Line,
    motor::{Demand, Sensed},
};
use super::{Drive, StoredParameters};
use crate::{control_loop::PERIOD_US, interface::BoardState, timing::periods};

pub use self::{
    line::Elapsed,
    motor::{Maker, Model},
};

/// A servo whose registers the bus reads and writes.
trait Servo {
    /// How its protocol delimits packets.
    type Framing: Framing;

    /// Carries out a packet; returns the answer.
    fn receive(&mut self, packet: &[u8]) -> Option<Answer>;

    /// Its registers.
    fn memory(&self) -> &Memory;

    /// The bit rate of its table, bit/s.
    fn bit_rate(&self) -> u32;

    /// Takes what was measured, after so many control periods, and what the bus has commanded;
    /// returns what the drive has to do.
    fn exchange(&mut self, sensed: &Sensed, periods: u32) -> Demand;
}

/// A servo, and the packets of its protocol.
#[derive(Debug)]
struct Station<S: Servo> {
    servo: S,
    receiver: Receiver<S::Framing>,
}

impl<S: Servo> Station<S> {
    fn new(servo: S) -> Self {
        Self {
            servo,
            receiver: Receiver::default(),
        }
    }

    fn receive(&mut self, byte: u8, line: &mut Line) {
        self.receiver.push(byte);
        while let Some(packet) = self.receiver.next_packet() {
            let answer = self.servo.receive(packet);
            line.packet(answer);
        }
    }
}

/// Stores what the table keeps without power once it has not changed for a while.
#[derive(Debug)]
struct Keeper {
    kept: [u8; EEPROM],
    /// What changes now, and the control periods since its last change.
    changed: [u8; EEPROM],
    age: u32,
    /// Control periods until the next save may begin.
    pause: u32,
}

/// Control periods after which what has changed is stored: a client writes several registers.
const SETTLED: u32 = periods(100) as u32;

/// Control periods between two saves: a client that changes a register again and again wears the
/// flash, of 10,000 erasures for two sets, no sooner than after a day.
const PAUSE: u32 = periods(5_000) as u32;

impl Keeper {
    fn of(memory: &Memory) -> Self {
        Self {
            kept: *memory.eeprom(),
            changed: *memory.eeprom(),
            age: 0,
            pause: 0,
        }
    }

    fn keep(&mut self, memory: &Memory, drive: &mut Drive<'_>, (model, passed): (Model, u32)) {
        self.pause = self.pause.saturating_sub(passed);
        if self.age < SETTLED || self.pause > 0 {
            let is_same = self.changed == *memory.eeprom();
            self.changed = *memory.eeprom();
            let waits = is_same && self.changed != self.kept;
            self.age = if waits {
                self.age.saturating_add(passed)
            } else {
                0
            };
            return;
        }
        // A save that fails is not repeated: the flash is worn or broken.
        if drive.keep_registers(model, &self.changed).is_ready() {
            (self.kept, self.age, self.pause) = (self.changed, 0, PAUSE);
        }
    }
}

/// The servo of this board.
#[derive(Debug)]
enum Kind {
    Feetech(Station<Feetech>),
    Dynamixel(Station<Dynamixel>),
}

impl Kind {
    fn receive(&mut self, byte: u8, line: &mut Line) {
        match self {
            Self::Feetech(station) => station.receive(byte, line),
            Self::Dynamixel(station) => station.receive(byte, line),
        }
    }

    /// Discards a part of a packet.
    fn discard(&mut self) {
        match self {
            Self::Feetech(station) => station.receiver.discard(),
            Self::Dynamixel(station) => station.receiver.discard(),
        }
    }

    fn memory(&self) -> &Memory {
        match self {
            Self::Feetech(station) => station.servo.memory(),
            Self::Dynamixel(station) => station.servo.memory(),
        }
    }

    fn exchange(&mut self, sensed: &Sensed, periods: u32) -> Demand {
        match self {
            Self::Feetech(station) => station.servo.exchange(sensed, periods),
            Self::Dynamixel(station) => station.servo.exchange(sensed, periods),
        }
    }
}

/// The actuator on a servo bus.
#[derive(Debug)]
pub struct ServoBus {
    kind: Kind,
    line: Line,
    keeper: Keeper,
    model: Model,
    /// The control period of the last exchange.
    tick: u32,
    /// Faults are to be acknowledged once the reaction to them has ended.
    acknowledges: bool,
}

impl ServoBus {
    /// The servo that these parameters select; `None` without one.
    ///
    /// ```
    /// use firmware::drive::{ServoBus, ServoModel, StoredParameters};
    ///
    /// assert!(ServoBus::new(&StoredParameters::DEFAULT).is_none());
    /// let set = StoredParameters::DEFAULT.with_servo_bus(ServoModel::Sts3215, 1);
    /// let mut servo = ServoBus::new(&set).unwrap();
    /// assert_eq!(servo.bit_rate(), 1_000_000);
    /// // A ping is answered after the return delay of the table, 500 us.
    /// assert_eq!(servo.receive(&[0xFF, 0xFF, 1, 2, 1, 0xFB]), Some(500));
    /// ```
    pub fn new(stored: &StoredParameters) -> Option<Self> {
        let model = stored.servo_bus_model()?;
        let registers = &stored.registers;
        let mut memory = Memory::new(model.table());
        if registers.model == model as u8 {
            memory.load(&registers.eeprom);
        }
        Some(Self {
            line: Line::default(),
            keeper: Keeper::of(&memory),
            kind: match model.maker() {
                Maker::Feetech => Kind::Feetech(Station::new(Feetech::new(memory))),
                Maker::Robotis => Kind::Dynamixel(Station::new(Dynamixel::new(memory))),
            },
            model,
            tick: 0,
            acknowledges: false,
        })
    }

    /// As [`ServoBus::new`], in this memory.
    // Not inlined: its temporaries, as large as the servo, stay out of the caller's stack frame.
    #[inline(never)]
    pub fn new_in<'a>(
        memory: &'a mut MaybeUninit<Self>,
        stored: &StoredParameters,
    ) -> Option<&'a mut Self> {
        Self::new(stored).map(|servo| memory.write(servo))
    }

    /// The bit rate of the line, bit/s. It may change behind each answer.
    pub fn bit_rate(&self) -> u32 {
        match &self.kind {
            Kind::Feetech(station) => station.servo.bit_rate(),
            Kind::Dynamixel(station) => station.servo.bit_rate(),
        }
    }

    /// Takes bytes of the line, of the master or of other servos, up to a pause of the line.
    /// Returns after how many microseconds [`ServoBus::elapsed`] is to be called, if no byte comes
    /// before.
    pub fn receive(&mut self, bytes: &[u8]) -> Option<u32> {
        for byte in bytes {
            self.line.hear(*byte);
            self.kind.receive(*byte, &mut self.line);
        }
        self.line.wait_us()
    }

    /// The time of [`ServoBus::receive`] has elapsed without a byte.
    pub fn elapsed(&mut self) -> Elapsed {
        let elapsed = self.line.elapsed();
        if elapsed == Elapsed::Silence {
            self.kind.discard();
        }
        elapsed
    }

    /// Writes the answer that is to be transmitted into a buffer, and returns its length: 0 if it
    /// does not fit.
    pub fn take_answer(&mut self, buffer: &mut [u8]) -> usize {
        // A part of the packet that it continues is the part of no other one.
        self.kind.discard();
        self.line.take_answer(buffer)
    }

    /// Exchanges the registers with the drive. To be called in each communication cycle.
    pub fn exchange(&mut self, drive: &mut Drive<'_>) {
        drive.is_on_servo_bus = true;
        if drive.outputs.state == BoardState::Initialising {
            return;
        }
        let tick = drive.outputs.telemetry.tick;
        let periods = tick.wrapping_sub(core::mem::replace(&mut self.tick, tick));
        let periods = periods.min(MOST_PERIODS);
        let sensed = Sensed::of(drive);
        let demand = self.kind.exchange(&sensed, periods);
        self.acknowledges |= demand.acknowledges;
        self.acknowledges &= !sensed.faults.is_empty();
        if self.acknowledges && drive.acknowledge() {
            self.acknowledges = false;
        }
        drive.carry_out(&demand, periods > 0);
        let memory = self.kind.memory();
        self.keeper.keep(memory, drive, (self.model, periods));
    }
}

/// Control periods between two exchanges that count: more are those of the start.
const MOST_PERIODS: u32 = periods(20) as u32;

impl Drive<'_> {
    /// Stores the registers of the servo bus; to be called repeatedly until it is ready.
    fn keep_registers(
        &mut self,
        model: Model,
        eeprom: &[u8; EEPROM],
    ) -> Poll<Result<(), canopen::Abort>> {
        let client = super::store::StoreClient::ServoBus;
        self.store.save(client, |set| {
            set.registers = super::stored::ServoRegisters {
                model: model as u8,
                eeprom: *eeprom,
            };
        })
    }
}
