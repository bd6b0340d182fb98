//! Emulated actuator boards as servos on one serial bus, in real time.
//!
//! Each board runs its ELF in its own thread. A CAN bus, on which they are the only stations, keeps
//! them in step.

use std::collections::VecDeque;
use std::sync::atomic::AtomicBool;
use std::sync::mpsc::Receiver;
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;

use firmware::drive::ServoMaker;
use host_sim::can::node_fault::{Change, Fault};
use host_sim::servo_bus::{Fault as ServoFault, OfServo};
use model_core::plant::board::BoardPlantOptions;
use virtual_board::run::{Flow, Options, Script, SharedBus, View};

use super::bootloader::Keeper;
use super::line::STARTED_NS;
use super::programs::{Interface, Programs};
use super::servo_line::ServoLine;
use super::transport::Transport;
use super::{StopOnDrop, distributed, joined, options, run_board};

/// Time between two packets of the rehearsal, ns: more than an answer takes at 57,600 bit/s.
const REHEARSAL_NS: u64 = 10_000_000;

/// Runs a board for each of these plants, with IDs from 1, until `stop` is set; calls `ready` once
/// they have started. The faults are applied as they come.
///
/// # Errors
/// Those of the emulator.
pub fn serve_servos(
    programs: &Programs,
    plants: &[BoardPlantOptions],
    faults: Receiver<ServoFault>,
    transport: Box<dyn Transport>,
    ready: Box<dyn FnOnce() + Send>,
    stop: &Arc<AtomicBool>,
) -> Result<(), String> {
    let count = plants.len();
    let faults = faults.into_iter();
    let faults = distributed(faults.flat_map(move |fault| on_boards(fault, count)), count);
    let line = Arc::new(Mutex::new(ServoLine::new(transport, count)));
    let connections = SharedBus::new(Vec::new(), count)
        .in_real_time()
        .connections();
    let mut lead = Some(Lead {
        rehearsal: rehearsal(programs.interface, count),
        next_ns: STARTED_NS,
        ready: Some(ready),
    });
    thread::scope(|scope| {
        let mut boards = Vec::new();
        for ((index, plant), (faults, connection)) in plants
            .iter()
            .enumerate()
            .zip(faults.into_iter().zip(connections))
        {
            let (line, lead) = (Arc::clone(&line), lead.take());
            let run = move || {
                let _stop_on_end = StopOnDrop(stop);
                let number = index as u8 + 1;
                let program = programs.of(number).ok_or("an actuator is not emulated")?;
                let options = Options {
                    polls_at_stops: true,
                    ..options(programs, program, number, plant)?
                };
                let script = ServoBoard {
                    keeper: Keeper::new((program, number), faults, stop),
                    line,
                    index,
                    lead,
                };
                let script = run_board((program, number), options, script, connection, stop)?;
                script.keeper.into_result()
            };
            boards.push(scope.spawn(run));
        }
        joined(boards)
    })
}

/// The faults of boards that a fault of a servo is; none if a board has no such fault.
pub fn on_boards(fault: ServoFault, count: usize) -> Vec<Fault> {
    let (nodes, change) = match fault {
        ServoFault::Supply(volts) => (1..=count, Change::Supply(volts)),
        ServoFault::Of(node, OfServo::Jam(is_jammed)) => (node..=node, Change::Jam(is_jammed)),
        ServoFault::Of(node, OfServo::Load(torque_nm)) => (node..=node, Change::Load(torque_nm)),
        ServoFault::Of(_, OfServo::Absent(_) | OfServo::Corrupt(_) | OfServo::Id(_)) => {
            return Vec::new();
        }
    };
    nodes.map(|node| Fault { node, change }).collect()
}

/// A board on the line.
struct ServoBoard {
    keeper: Keeper,
    line: Arc<Mutex<ServoLine>>,
    /// Its place on the line.
    index: usize,
    /// What the first board does for all.
    lead: Option<Lead>,
}

/// Serves the client, once the boards have answered to each packet of a rehearsal: the emulator
/// translates a program when it is first executed, which takes longer than clients wait.
struct Lead {
    rehearsal: VecDeque<Vec<u8>>,
    /// Instant of the next packet, ns.
    next_ns: u64,
    /// Called behind the rehearsal.
    ready: Option<Box<dyn FnOnce() + Send>>,
}

impl Lead {
    fn serve(&mut self, line: &mut ServoLine, now_ns: u64) {
        if self.ready.is_some() && now_ns >= self.next_ns {
            self.next_ns = now_ns + REHEARSAL_NS;
            let packet = self.rehearsal.pop_front();
            line.rehearse(packet.as_deref());
            if packet.is_none()
                && let Some(ready) = self.ready.take()
            {
                ready();
            }
        }
        if self.ready.is_none() {
            line.serve_client(now_ns);
        }
    }
}

/// A ping, and a read of the first two registers, of each servo.
fn rehearsal(interface: Interface, count: usize) -> VecDeque<Vec<u8>> {
    let packets = |id: u8| match interface {
        Interface::ServoBus(model) if model.maker() == ServoMaker::Robotis => [
            dynamixel(&[id, 3, 0, 1]),
            dynamixel(&[id, 7, 0, 2, 0, 0, 2, 0]),
        ],
        _ => [feetech(&[id, 2, 1]), feetech(&[id, 4, 2, 0, 2])],
    };
    (1..=count as u8).flat_map(packets).collect()
}

/// A packet with header and check sum.
fn feetech(body: &[u8]) -> Vec<u8> {
    let sum = body.iter().fold(0, |sum: u8, byte| sum.wrapping_add(*byte));
    [&[0xFF, 0xFF], body, &[!sum]].concat()
}

/// The same with header and CRC.
fn dynamixel(body: &[u8]) -> Vec<u8> {
    let packet = [&[0xFF, 0xFF, 0xFD, 0], body].concat();
    let crc = servo_bus::dynamixel::crc(0, &packet);
    [&packet[..], &crc.to_le_bytes()].concat()
}

impl ServoBoard {
    fn exchange(&mut self, view: &mut View<'_>) {
        let now_ns = view.now_ns();
        let Some(serial) = view.servo_bus() else {
            return;
        };
        let sent = serial.take_received();
        let sent: Vec<u8> = sent.into_iter().map(|(_, byte)| byte).collect();
        // A board that panicked ends all others; the line has no state between two calls.
        let mut line = self.line.lock().unwrap_or_else(PoisonError::into_inner);
        line.send(now_ns, self.index, &sent, serial.queued());
        if let Some(lead) = &mut self.lead {
            lead.serve(&mut line, now_ns);
        }
        let heard = line.take(self.index);
        drop(line);
        serial.send(now_ns, &heard);
    }
}

impl Script for ServoBoard {
    fn at_edge(&mut self, view: &mut View<'_>) -> Flow {
        self.keeper.at_edge(view)
    }

    /// At every stop of the run, which the threads reach at least each 200 us.
    fn at_poll(&mut self, view: &mut View<'_>) -> Flow {
        self.exchange(view);
        self.keeper.at_poll(view)
    }
}

#[cfg(test)]
mod tests {
    use firmware::drive::ServoModel;

    use super::*;

    #[test]
    fn the_rehearsal_has_the_packets_of_the_manuals() {
        let of = |model| rehearsal(Interface::ServoBus(model), 1);
        assert_eq!(of(ServoModel::Sts3215)[0], [0xFF, 0xFF, 1, 2, 1, 0xFB]);
        let ping = [0xFF, 0xFF, 0xFD, 0, 1, 3, 0, 1, 0x19, 0x4E];
        assert_eq!(of(ServoModel::Xl330M288)[0], ping);
    }

    #[test]
    fn a_supply_is_that_of_all_boards_and_a_jam_that_of_one() {
        let of = |line: &str| on_boards(line.parse().expect("a fault"), 3);
        let nodes: Vec<_> = of("supply 5.5").iter().map(|fault| fault.node).collect();
        assert_eq!(nodes, [1, 2, 3]);
        let change = Change::Jam(true);
        assert_eq!(of("2 jam"), [Fault { node: 2, change }]);
        assert!(of("1 vanish").is_empty());
    }
}
