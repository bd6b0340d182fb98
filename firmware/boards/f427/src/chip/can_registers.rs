//! Frames in the registers of the CAN controller.

use super::pac::{CAN1, can1};
use canopen::CanFrame;
use embedded_can::{ExtendedId, Frame as _, Id, StandardId};

/// Bits of CAN_RIR (RM0090, 32.9.3): an identifier of 29 bits, and a remote frame.
const EXTENDED: u32 = 1 << 2;
const REMOTE: u32 = 1 << 1;

/// The registers RIR, RDTR, RDLR and RDHR of the oldest frame in receive FIFO 0.
pub fn received(can: &CAN1) -> Option<[u32; 4]> {
    if can.rfr(0).read().fmp().bits() == 0 {
        return None;
    }
    let mailbox = can.rx(0);
    Some([
        mailbox.rir().read().bits(),
        mailbox.rdtr().read().bits(),
        mailbox.rdlr().read().bits(),
        mailbox.rdhr().read().bits(),
    ])
}

/// Removes the oldest frame from receive FIFO 0.
pub fn release(can: &CAN1) {
    can.rfr(0).write(|w| w.rfom().set_bit());
}

/// The frame in these registers.
pub fn frame([head, length, low, high]: &[u32; 4]) -> CanFrame {
    let id = if head & EXTENDED != 0 {
        Id::Extended(ExtendedId::new(head >> 3).unwrap_or(ExtendedId::ZERO))
    } else {
        Id::Standard(StandardId::new((head >> 21) as u16).unwrap_or(StandardId::ZERO))
    };
    let [a, b, c, d] = low.to_le_bytes();
    let [e, f, g, h] = high.to_le_bytes();
    let length_code = (length & 0xf) as u8;
    CanFrame::received(
        id,
        head & REMOTE != 0,
        length_code,
        [a, b, c, d, e, f, g, h],
    )
}

/// Writes a frame into a free mailbox and requests its transmission.
pub fn request_transmission(mailbox: &can1::TX, frame: &CanFrame) {
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
