//! A board without an image that may run: it takes one from the bus.

use bootloader::waiting::{DICTIONARY, Waiting};
use bootloader::{Bootloader, Key};
use canopen::{Node, NodeId};
use crc::{CRC_32_ISO_HDLC, Crc, NoTable};
use stm32f4xx_hal::{
    pac::{CAN1, CorePeripherals, GPIOD, RCC},
    signature::Uid,
};

use crate::{
    can::Can,
    clocks::{self, Clock},
    flash::BlockingFlash,
    restart,
};

/// Serves the bus until the installation of an image is requested, then restarts.
pub fn run(bootloader: Bootloader<'_, BlockingFlash, Key>, rcc: RCC, pins: GPIOD, can: CAN1) -> ! {
    clocks::start(&rcc);
    let Some(mut core) = CorePeripherals::take() else {
        restart();
    };
    let mut clock = Clock::start(&mut core.DCB, &mut core.DWT);
    let bus = bootloader.state().bus;
    let can = Can::join(can, &rcc, &pins, bus.kbit_s);
    let mut board = Waiting::new(bootloader, serial_number());
    let node_id = NodeId::new(bus.node_id);
    let mut node = Node::<0, 0>::new(&DICTIONARY, node_id, &mut board, 0);
    loop {
        while let Some(frame) = can.receive() {
            node.receive(&frame, clock.now_us(), &mut board);
        }
        node.tick(clock.now_us(), &mut board);
        if let Some(kbit_s) = board.take_bit_rate() {
            can.set_bit_rate(kbit_s);
        }
        can.transmit(|| node.transmit(&mut board));
        if board.is_requested() && can.is_idle() {
            restart();
        }
    }
}

/// The serial number of the program of the board: a hash of the unique ID.
fn serial_number() -> u32 {
    // SAFETY: the ID is twelve bytes of read-only memory that is always accessible.
    let id: &[u8; 12] = unsafe { &*core::ptr::from_ref(Uid::get()).cast() };
    Crc::<u32, NoTable>::new(&CRC_32_ISO_HDLC).checksum(id)
}
