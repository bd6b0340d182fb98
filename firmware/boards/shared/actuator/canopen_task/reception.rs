//! The frames of a call of the CANopen device: the received ones are processed, process data twice,
//! and those to be transmitted are queued.

use canopen::{CanFrame, Node};
use cortex_m::peripheral::DWT;
use drivers::can::ReceivedFrame;
use embedded_can::{Frame as _, Id, StandardId};
use firmware::{
    drive::{Device, RPDOS, TPDOS},
    timing::CALL_PERIODS,
};
use heapless::Vec;
use task_queues::Consumer;

use super::{
    super::{
        bus_status,
        queues::{DeviceEnds, ReceivedFrames},
        sealed::Restored,
        timing::{CORE_HZ, PWM_HZ, PWM_PERIODS},
    },
    CanopenTask,
};
use crate::peripherals::Can;

/// Core cycles after which a call processes no further received frames. An ordinary frame takes
/// 1,000 cycles, and the process data of a call, which it processes twice, 22,000: two calls process
/// as many frames as a bus of 1 Mbit/s carries.
const INTAKE_CYCLES: u32 = 50_000;

/// Most frames of a call that are processed twice, before the others: one for each RPDO, and a SYNC.
const REPEATED_FRAMES: usize = RPDOS + 1;

/// Core cycles of the longest frame without a reset or of the process data of a call, and of a call
/// beside its frames with the interrupts that preempt it: bounds (`docs/emulated-board.md`).
const LONGEST_FRAME_CYCLES: u32 = 60_000;
const REST_CYCLES: u32 = 50_000;

/// Core cycles of a call whose first frame is a reset: it takes no other frame.
const RESET_CALL_CYCLES: u32 = 166_000;

// The last call ends before the last PWM period, whose sampling instants it would delay.
const _: () = {
    let available = (PWM_PERIODS - 1 - CALL_PERIODS[1]) * (CORE_HZ / PWM_HZ);
    assert!(INTAKE_CYCLES + LONGEST_FRAME_CYCLES + REST_CYCLES < available);
    assert!(RESET_CALL_CYCLES < available);
};

/// Processes received frames and due events, and queues the frames to be transmitted. `start` is the
/// number of core cycles at which process data were taken from the queue; no frame that resets is
/// taken after them.
#[unsafe(no_mangle)]
#[inline(never)]
pub(super) fn communicate(task: &mut CanopenTask, now_us: u64, start: Option<u32>) {
    let CanopenTask { device, queues, .. } = task;
    let device = device.get();
    let mut is_first = start.is_none();
    let start = start.unwrap_or_else(DWT::cycle_count);
    while DWT::cycle_count().wrapping_sub(start) < INTAKE_CYCLES
        && queues
            .received
            .peek()
            .is_some_and(|next| is_first || !is_reset(&next.unchecked::<Can>()))
        && let Some(received) = queues.received.dequeue()
    {
        is_first = false;
        match received.intact::<Can>() {
            Some(frame) => device.receive(&frame, now_us),
            None => bus_status::count_lost_frame(),
        }
        queue_frames(device, queues);
    }
    device.communicate(now_us);
    queue_frames(device, queues);
}

/// Processes the received process data before the next other frame, twice from the same state;
/// returns whether both make the same commands. A register that changes during one of both, or an
/// instruction that is not executed, makes others.
#[unsafe(no_mangle)]
#[inline(never)]
pub(super) fn receive_twice(task: &mut CanopenTask, now_us: u64) -> bool {
    let CanopenTask {
        device: sealed,
        part_seals,
        queues,
        ..
    } = task;
    let device = sealed.get();
    let frames = take_process_data(device.node(), &mut queues.received);
    receive_process_data(device, &frames, now_us);
    let commands = device.command_state();
    match sealed.restore() {
        Restored::Intact => {}
        Restored::Corrupt => return false,
        Restored::Absent => return true,
    }
    let device = sealed.get();
    if receive_process_data(device, &frames, now_us) < frames.len() {
        bus_status::count_lost_frame();
    }
    // Before the comparison, which notices what changes until here; the seal notices the rest.
    part_seals.renew_commands(device);
    let is_same = device.command_state() == commands;
    queue_frames(device, queues);
    is_same
}

/// Takes the process data before the next other frame from the queue, up to a second SYNC: the TPDOs
/// that the first one requests are not queued before all these frames have been processed.
fn take_process_data(
    node: &Node<RPDOS, TPDOS>,
    received: &mut Consumer<ReceivedFrames>,
) -> Vec<ReceivedFrame, REPEATED_FRAMES> {
    let mut frames: Vec<ReceivedFrame, REPEATED_FRAMES> = Vec::new();
    let mut has_sync = false;
    while !frames.is_full()
        && let Some(next) = received.peek().map(ReceivedFrame::unchecked::<Can>)
        && is_process_data(&next)
    {
        let is_sync = node.is_sync(next.id());
        if is_sync && has_sync {
            break;
        }
        has_sync |= is_sync;
        // There is one, and room for it.
        let _ = received.dequeue().map(|frame| frames.push(frame));
    }
    frames
}

/// Processes those of these frames that have not changed since their reception; returns their
/// number.
#[unsafe(no_mangle)]
#[inline(never)]
fn receive_process_data(
    device: &mut Device<'static>,
    frames: &[ReceivedFrame],
    now_us: u64,
) -> usize {
    let intact = frames.iter().filter_map(ReceivedFrame::intact::<Can>);
    intact.map(|frame| device.receive(&frame, now_us)).count()
}

/// Whether a frame is process data or a SYNC, and no service: not NMT, SDO, the heartbeat of another
/// node or LSS, whose identifiers no other object may have (CiA 301, 7.3.5, restricted CAN-IDs).
pub(super) fn is_process_data(frame: &CanFrame) -> bool {
    match frame.id() {
        Id::Standard(id) => !matches!(id.as_raw(), 0 | 0x600..=0x67F | 0x700..),
        Id::Extended(_) => true,
    }
}

/// Whether an NMT frame resets the node or its communication (CiA 301, 7.3.2.2.1), which takes as
/// long as all frames of a turn: it begins a turn of its own.
fn is_reset(frame: &CanFrame) -> bool {
    frame.id() == Id::Standard(StandardId::ZERO) && matches!(frame.data(), [0x81 | 0x82, ..])
}

/// Queues as many frames as there is room for; the others remain in the node. An EMCY goes before
/// all process data: if some waits it is discarded, also from the mailboxes, and sampled again.
// Inlined, or a reset of the node takes 3,000 cycles longer.
#[inline(always)]
fn queue_frames(device: &mut Device<'static>, queues: &mut DeviceEnds) {
    while queues.to_transmit.has_room()
        && queues.process_data.has_room()
        && let Some(frame) = device.transmit::<CanFrame>()
    {
        // There is room.
        let _ = if device.node().is_process_data(frame.id()) {
            queues.process_data.enqueue(frame)
        } else {
            if device.node().is_emergency(frame.id()) && queues.process_data.has_waiting() {
                bus_status::request_discard();
            }
            queues.to_transmit.enqueue(frame)
        };
    }
}
