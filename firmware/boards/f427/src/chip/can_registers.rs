//! Frames in the registers of the CAN controller.

use super::pac::{CAN1, can1};
use canopen::CanFrame;
use embedded_can::{ExtendedId, Frame as _, Id, StandardId};

/// Takes the next frame out of receive FIFO 0.
pub fn receive(can: &CAN1) -> Option<CanFrame> {
    let fifo = can.rfr(0);
    if fifo.read().fmp().bits() == 0 {
        return None;
    }
    let mailbox = can.rx(0);
    let (id, length) = (mailbox.rir().read(), mailbox.rdtr().read());
    let [low, high] =
        [mailbox.rdlr().read().bits(), mailbox.rdhr().read().bits()].map(u32::to_le_bytes);
    let [a, b, c, d] = low;
    let [e, f, g, h] = high;
    let frame = CanFrame::received(
        identifier(id.ide().bit(), id.stid().bits(), id.exid().bits()),
        id.rtr().bit(),
        length.dlc().bits(),
        [a, b, c, d, e, f, g, h],
    );
    fifo.write(|w| w.rfom().set_bit());
    Some(frame)
}

/// An identifier from the fields of its register: 11 bits of base and 18 bits of extension.
fn identifier(is_extended: bool, base: u16, extension: u32) -> Id {
    let base = base & 0x7ff;
    if is_extended {
        let raw = u32::from(base) << 18 | extension & 0x3_ffff;
        Id::Extended(ExtendedId::new(raw).unwrap_or(ExtendedId::ZERO))
    } else {
        Id::Standard(StandardId::new(base).unwrap_or(StandardId::ZERO))
    }
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
