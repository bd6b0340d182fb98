//! The steps of the CAN controller and the bus.

use canopen::CanFrame;
use drivers::can::{AcceptedIds, CanPort, Mode};
use embedded_can::{Frame as _, Id, StandardId};
use firmware::bring_up::{NOT_MEASURED, REPETITIONS};

use super::bench::{Bench, PERIODS_PER_MS};
use crate::peripherals::Can;

/// Bit rate, kbit/s: the default of the board.
const KBIT_S: u16 = 1_000;

/// The frames have the identifier of the lowest priority, which CANopen does not use.
const IDENTIFIER: StandardId = StandardId::MAX;

/// Time for a frame, ms: a bus in use lets it through.
const FRAME_MS: u32 = 20;

/// Time to leave and to join the bus, ms.
const JOIN_MS: u32 = 100;

/// Frames that come back in the loop inside the controller.
pub fn looped_back(bench: &mut Bench) -> i32 {
    let Some(can) = bench.can.take() else {
        return NOT_MEASURED;
    };
    let accepted = [(Id::Standard(IDENTIFIER), false)];
    let (mut port, mut receiver, _) = Can::new(can, &AcceptedIds::new(accepted.into_iter()));
    let count = if join(bench, &mut port, Mode::LoopBack) {
        exchanged(bench, &mut port, |_, frame| {
            receiver
                .receive()
                .is_some_and(|received| received == *frame)
        })
    } else {
        0
    };
    bench.port = Some(port);
    count
}

/// Frames that another node acknowledges.
pub fn acknowledged(bench: &mut Bench) -> i32 {
    let Some(mut port) = bench.port.take() else {
        return NOT_MEASURED;
    };
    port.take_transmitted();
    let count = if join(bench, &mut port, Mode::Full) {
        exchanged(bench, &mut port, |port, _| port.take_transmitted() > 0)
    } else {
        0
    };
    port.abort(1);
    port.leave();
    count
}

/// Leaves the bus and joins it in a mode.
fn join(bench: &mut Bench, port: &mut Can, mode: Mode) -> bool {
    port.leave();
    for _ in 0..JOIN_MS * PERIODS_PER_MS {
        bench.next_period();
        if port.has_left() {
            port.join(KBIT_S, mode);
            bench.next_period();
            return true;
        }
    }
    false
}

/// Sends frames one by one, and counts those that have arrived in their time; the first that has
/// not ends it.
fn exchanged(
    bench: &mut Bench,
    port: &mut Can,
    mut has_arrived: impl FnMut(&mut Can, &CanFrame) -> bool,
) -> i32 {
    for number in 0..REPETITIONS {
        let Some(frame) = CanFrame::new(IDENTIFIER, &number.to_le_bytes()) else {
            return NOT_MEASURED;
        };
        port.put(0, &frame);
        let arrived = (0..FRAME_MS * PERIODS_PER_MS).any(|_| {
            bench.next_period();
            has_arrived(port, &frame)
        });
        if !arrived {
            return number;
        }
    }
    REPETITIONS
}
