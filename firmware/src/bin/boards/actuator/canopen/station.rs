//! The CANopen device with what surrounds it on the board.
//!
//! Its stages are functions that are not inlined, with names that a debugger or an emulator finds in the ELF: `gather`,
//! [`device_control`], [`communicate`].

use canopen::CanFrame;
use cortex_m::peripheral::DWT;
use firmware::{
    application::{Outputs, Samples},
    drive::{Device, StoredParameters},
};
use heapless::spsc::{Consumer, Producer};

use super::{setup, wanted::Wanted};
use crate::actuator::{
    slot::{Giver, Taker},
    ticks,
    vigil::Vigil,
};

/// Frames that may wait for the node: more than come in between two of its times, 3 ms apart, at 1 Mbit/s.
pub const RECEIVED: usize = 65;

/// Frames that may wait for the bus: a bus of 1 Mbit/s takes as many in 2 ms. What the node sends in its next turn waits
/// no longer behind them; a block of the SDO server, 127 frames, goes on as there is room.
pub const TO_SEND: usize = 17;

/// Core cycles of a turn after which the node takes no more frames, so that the turn ends before the next edge: the
/// longest that a frame takes, a reset of the node, is 70,000 (a millisecond has 168,000). An ordinary one takes 1,000: with
/// two turns a tick that is as many as a bus of 1 Mbit/s brings.
const LONGEST_INTAKE: u32 = 30_000;

/// Core cycles of a microsecond.
const CYCLES_PER_US: u32 = 168;

/// What the station hands over, and what it gets.
pub struct Queues {
    pub received: Consumer<'static, CanFrame, RECEIVED>,
    pub to_send: Producer<'static, CanFrame, TO_SEND>,
    pub outputs: Producer<'static, Outputs, 3>,
    pub wanted: Giver<Wanted>,
    pub save: Giver<StoredParameters>,
    pub saved: Taker<bool>,
}

/// Node, drive, and their neighbours on the board.
pub struct Station {
    device: &'static mut Device<'static>,
    vigil: Vigil,
    queues: Queues,
    /// What the controller was asked to let in.
    wanted: Wanted,
    /// The number of the last PWM period that the node knew of, and its time, us.
    now: (u32, u64),
}

/// One control period of the drive.
#[unsafe(no_mangle)]
#[inline(never)]
fn device_control(device: &mut Device<'static>, samples: &Samples) -> Outputs {
    device.control(samples)
}

/// What has come in, what has become due, what is to be sent.
#[unsafe(no_mangle)]
#[inline(never)]
fn communicate(station: &mut Station, now_us: u64) {
    let Station { device, queues, .. } = station;
    let began = DWT::cycle_count();
    while DWT::cycle_count().wrapping_sub(began) < LONGEST_INTAKE
        && let Some(frame) = queues.received.dequeue()
    {
        device.receive(&frame, now_us);
        send(device, queues);
    }
    device.communicate(now_us);
    send(device, queues);
}

/// As many frames as there is room for; the others wait in the node.
fn send(device: &mut Device<'static>, queues: &mut Queues) {
    while queues.to_send.ready()
        && let Some(frame) = device.transmit()
    {
        // There is room.
        let _ = queues.to_send.enqueue(frame);
    }
}

impl Station {
    /// A station whose controller lets in what is wanted.
    pub fn new(
        device: &'static mut Device<'static>,
        vigil: Vigil,
        queues: Queues,
        wanted: Wanted,
    ) -> Self {
        Self {
            device,
            vigil,
            queues,
            wanted,
            now: (0, 0),
        }
    }

    /// The control period itself.
    pub fn control(&mut self, samples: &mut Samples, tick: u32) -> Outputs {
        samples.missed_periods = self.vigil.begin(tick);
        device_control(self.device, samples)
    }

    /// The bridge has been told: hands over, and feeds the watchdog if every part is alive.
    pub fn end(&mut self, outputs: Outputs, is_late: bool) {
        if is_late {
            self.device.drive.was_late();
        }
        // The background is behind: the log has a gap.
        let _ = self.queues.outputs.enqueue(outputs);
        self.device.drive.diagnostics.starved_periods = self.vigil.end();
    }

    /// The node's turn, in the PWM period of this number. Whether there is something for the controller to do.
    pub fn communicate(&mut self, period: u32) -> bool {
        self.count();
        let now_us = self.time_us(period);
        communicate(self, now_us);
        self.save();
        self.set_up_controller();
        self.queues.to_send.len() > 0
    }

    /// The time of a PWM period whose number wraps.
    fn time_us(&mut self, period: u32) -> u64 {
        let (last, time_us) = self.now;
        // The number has 31 bits.
        let elapsed = period.wrapping_sub(last) & (u32::MAX >> 1);
        self.now = (period, time_us.wrapping_add(u64::from(elapsed) * 1000));
        self.now.1
    }

    fn count(&mut self) {
        let board = &mut self.device.drive.diagnostics;
        (board.receive_overflows, board.bus_offs) = setup::counts();
        board.longest_step_us = ticks::longest_step_cycles() / CYCLES_PER_US;
    }

    fn save(&mut self) {
        if let Some(done) = self.queues.saved.take() {
            self.device.drive.saved(done);
        }
        if self.queues.save.is_empty()
            && let Some(set) = self.device.drive.take_save()
        {
            self.queues.save.put_new(|| *set);
        }
    }

    fn set_up_controller(&mut self) {
        if let Some(kbit_s) = self.device.drive.take_bit_rate() {
            setup::ask_bit_rate(kbit_s);
        }
        let wanted = Wanted::of(self.device.node().identifiers());
        if wanted != self.wanted && self.queues.wanted.put(wanted) {
            self.wanted = wanted;
        }
    }
}
