//! Frames out of the controller's registers, and into them.

use canopen::CanFrame;
use embedded_can::{Frame as _, Id};
use heapless::Deque;
use stm32f4xx_hal::pac::{CAN1, can1};

use crate::board::can_identifier::identifier;

/// Takes the next frame out of receive queue 0.
pub fn take(can: &CAN1) -> Option<CanFrame> {
    let queue = can.rfr(0);
    if queue.read().fmp().bits() == 0 {
        return None;
    }
    let mailbox = can.rx(0);
    let (id, length) = (mailbox.rir().read(), mailbox.rdtr().read());
    let [low, high] =
        [mailbox.rdlr().read().bits(), mailbox.rdhr().read().bits()].map(u32::to_le_bytes);
    let [a, b, c, d] = low;
    let [e, f, g, h] = high;
    let address = identifier(id.ide().bit(), id.stid().bits(), id.exid().bits());
    let frame = CanFrame::received(
        address,
        id.rtr().bit(),
        length.dlc().bits(),
        [a, b, c, d, e, f, g, h],
    );
    queue.write(|w| w.rfom().set_bit());
    Some(frame)
}

/// Fills free mailboxes with what waits for them.
pub fn fill<const N: usize>(can: &CAN1, waiting: &mut Deque<CanFrame, N>) {
    for mailbox in can.tx_iter() {
        if mailbox.tir().read().txrq().bit() {
            continue;
        }
        let Some(frame) = waiting.pop_front() else {
            return;
        };
        load(mailbox, &frame);
    }
}

/// Puts a frame into a free mailbox and asks for it to be sent.
fn load(mailbox: &can1::TX, frame: &CanFrame) {
    let [a, b, c, d, e, f, g, h] = frame.bytes();
    // SAFETY: any bits are data, and a length is at most 8.
    unsafe {
        mailbox.tdtr().write(|w| w.dlc().bits(frame.dlc() as u8));
        mailbox
            .tdlr()
            .write(|w| w.bits(u32::from_le_bytes([a, b, c, d])));
        mailbox
            .tdhr()
            .write(|w| w.bits(u32::from_le_bytes([e, f, g, h])));
    }
    // SAFETY: identifiers fit their fields.
    mailbox.tir().write(|w| unsafe {
        match frame.id() {
            Id::Standard(id) => w.stid().bits(id.as_raw()).ide().standard(),
            Id::Extended(id) => w
                .stid()
                .bits((id.as_raw() >> 18) as u16)
                .exid()
                .bits(id.as_raw() & 0x3_ffff)
                .ide()
                .extended(),
        };
        w.rtr().bit(frame.is_remote_frame()).txrq().set_bit()
    });
}
