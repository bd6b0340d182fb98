//! CAN1, polled.

use canopen::CanFrame;
use stm32f4xx_hal::pac::{self, CAN1, GPIOD, RCC};

use crate::clocks::CAN_HZ;

#[path = "../../../firmware/boards/f427/src/chip/can_registers.rs"]
mod can_registers;

/// Time quanta of a bit before and after the sample point, behind the first quantum, and of a
/// resynchronisation: as in the program of the board, sampled at 85.7 %.
const SEGMENT_1: u8 = 11;
const SEGMENT_2: u8 = 2;
const JUMP_WIDTH: u8 = 2;
const QUANTA: u32 = 1 + SEGMENT_1 as u32 + SEGMENT_2 as u32;

/// Bits of `MODER` and `AFRL` of the pins PD0 and PD1: alternate function 9.
const MODES: u32 = 0b1010;
const FUNCTIONS: u32 = 0x99;

/// The controller.
pub struct Can(CAN1);

impl Can {
    /// Joins the bus with this bit rate, and receives all frames.
    pub fn join(can: CAN1, rcc: &RCC, pins: &GPIOD, kbit_s: u16) -> Self {
        rcc.ahb1enr().modify(|_, w| w.gpioden().set_bit());
        rcc.apb1enr().modify(|_, w| w.can1en().set_bit());
        // The registers respond after two cycles (ES0206, section 2.2.13): a read takes longer.
        let _ = rcc.apb1enr().read();
        // SAFETY: the fields of the two pins; all others keep their reset values.
        unsafe {
            pins.afrl()
                .modify(|r, w| w.bits(r.bits() & !0xff | FUNCTIONS));
            pins.moder().modify(|r, w| w.bits(r.bits() & !0xf | MODES));
        }
        // One filter with a mask of zeros: all frames go to FIFO 0.
        if let Some(bank) = can.fb_iter().next() {
            // SAFETY: any bits make a filter.
            bank.fr1().write(|w| unsafe { w.bits(0) });
            // SAFETY: as above.
            bank.fr2().write(|w| unsafe { w.bits(0) });
        }
        // SAFETY: one bit for each bank.
        unsafe {
            can.fm1r().write(|w| w.bits(0));
            can.ffa1r().write(|w| w.bits(0));
            can.fs1r().write(|w| w.bits(1));
            can.fa1r().write(|w| w.bits(1));
        }
        can.fmr().modify(|_, w| w.finit().clear_bit());
        let can = Self(can);
        can.set_bit_rate(kbit_s);
        can
    }

    /// Leaves the bus and joins it with this bit rate.
    pub fn set_bit_rate(&self, kbit_s: u16) {
        let can = &self.0;
        can.mcr().write(|w| {
            w.sleep().clear_bit().inrq().set_bit();
            w.abom().set_bit().txfp().set_bit().rflm().set_bit()
        });
        while can.msr().read().inak().bit_is_clear() {}
        let bit_rate = u32::from(kbit_s) * 1000;
        let prescaler = CAN_HZ.checked_div(QUANTA * bit_rate).unwrap_or(3) as u16;
        // SAFETY: the fields hold one less than these numbers.
        can.btr().write(|w| unsafe {
            w.brp().bits(prescaler.saturating_sub(1));
            w.ts1().bits(SEGMENT_1 - 1).ts2().bits(SEGMENT_2 - 1);
            w.sjw().bits(JUMP_WIDTH - 1)
        });
        can.mcr().modify(|_, w| w.inrq().clear_bit());
    }

    /// The next received frame.
    pub fn receive(&self) -> Option<CanFrame> {
        let words = can_registers::received(&self.0)?;
        can_registers::release(&self.0);
        Some(can_registers::frame(&words))
    }

    /// Transmits frames of this source while a mailbox is free.
    pub fn transmit(&self, mut next: impl FnMut() -> Option<CanFrame>) {
        for mailbox in self.0.tx_iter() {
            if mailbox.tir().read().txrq().bit() {
                continue;
            }
            let Some(frame) = next() else { return };
            can_registers::request_transmission(mailbox, &frame);
        }
    }

    /// Whether all frames are transmitted.
    pub fn is_idle(&self) -> bool {
        (self.0.tx_iter()).all(|mailbox| mailbox.tir().read().txrq().bit_is_clear())
    }
}
