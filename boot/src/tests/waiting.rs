//! The CANopen of a board without an image, by its frames.

use std::{vec, vec::Vec};

use canopen::{CanFrame, Node, NodeId};
use embedded_can::{Frame, StandardId};

use super::{
    images::{HARDWARE, image, key},
    model::{Model, SMALL},
};
use crate::{
    install::{Bootloader, Cause, Decision},
    waiting::{DICTIONARY, Waiting},
};

/// A device with node-ID 1 and its SDO client.
struct Bus<'a> {
    node: Node<0, 0>,
    board: Waiting<'a, Model, crate::signature::Key>,
}

fn bootloader(flash: &mut Model) -> Bootloader<'_, Model, crate::signature::Key> {
    Bootloader {
        flash,
        layout: &SMALL,
        hardware: HARDWARE,
        verifier: key(),
    }
}

impl<'a> Bus<'a> {
    fn new(flash: &'a mut Model) -> Self {
        let mut board = Waiting::new(bootloader(flash), 77);
        let mut node = Node::new(&DICTIONARY, NodeId::new(1), &mut board, 0);
        let boot_up: CanFrame = node.transmit(&mut board).expect("a boot-up");
        assert_eq!(boot_up.raw_id(), (0x701, false));
        Self { node, board }
    }

    fn send(&mut self, data: [u8; 8]) {
        let id = StandardId::new(0x601).expect("11 bits");
        let frame = CanFrame::new(id, &data).expect("eight bytes");
        self.node.receive(&frame, 0, &mut self.board);
    }

    /// Sends a request and returns the response.
    fn request(&mut self, data: [u8; 8]) -> Vec<u8> {
        self.send(data);
        self.node.tick(1000, &mut self.board);
        let answer: CanFrame = self.node.transmit(&mut self.board).expect("a response");
        assert_eq!(answer.raw_id(), (0x581, false));
        answer.data().to_vec()
    }

    fn read(&mut self, index: u16, sub: u8) -> u32 {
        let [low, high] = index.to_le_bytes();
        let answer = self.request([0x40, low, high, sub, 0, 0, 0, 0]);
        u32::from_le_bytes(answer[4..].try_into().expect("four bytes"))
    }

    /// Downloads by blocks; returns the last response.
    fn download(&mut self, content: &[u8]) -> Vec<u8> {
        let [a, b, c, d] = (content.len() as u32).to_le_bytes();
        let begun = self.request([0xc2, 0x50, 0x1f, 1, a, b, c, d]);
        if begun[0] != 0xa4 {
            return begun;
        }
        let segments = content.len().div_ceil(7);
        for (number, segment) in content.chunks(7).enumerate() {
            let is_last = number + 1 == segments;
            let mut data = [0; 8];
            data[0] = (number % 127 + 1) as u8 | if is_last { 0x80 } else { 0 };
            data[1..=segment.len()].copy_from_slice(segment);
            if is_last || number % 127 == 126 {
                assert_eq!(self.request(data)[0], 0xa2);
            } else {
                self.send(data);
            }
        }
        let unused = (segments * 7 - content.len()) as u8;
        self.request([0xc1 | unused << 2, 0, 0, 0, 0, 0, 0, 0])
    }
}

/// Of the LSS master: identifier and requests (CiA 305).
const LSS: u16 = 0x7e5;
const CONFIGURATION: [u8; 8] = [0x04, 1, 0, 0, 0, 0, 0, 0];
const STORE: [u8; 8] = [0x17, 0, 0, 0, 0, 0, 0, 0];

impl Bus<'_> {
    /// A request of the LSS master; returns the response.
    fn lss(&mut self, data: [u8; 8]) -> Vec<u8> {
        let id = StandardId::new(LSS).expect("11 bits");
        let frame = CanFrame::new(id, &data).expect("eight bytes");
        self.node.receive(&frame, 1000, &mut self.board);
        self.node.tick(1000, &mut self.board);
        let answer: Option<CanFrame> = self.node.transmit(&mut self.board);
        answer.map_or_else(Vec::new, |answer| answer.data().to_vec())
    }
}

#[test]
fn lss_stores_node_id_and_bit_rate_of_the_bootloader() {
    let mut flash = Model::new();
    let before = bootloader(&mut flash).state();
    let mut bus = Bus::new(&mut flash);
    bus.lss(CONFIGURATION);
    assert_eq!(bus.lss([0x11, 42, 0, 0, 0, 0, 0, 0])[..2], [0x11, 0]);
    // 800 kbit/s, which the board does not have.
    assert_eq!(bus.lss([0x13, 0, 1, 0, 0, 0, 0, 0])[..2], [0x13, 1]);
    assert_eq!(bus.lss(STORE)[..2], [0x17, 0]);
    let after = bootloader(&mut flash).state();
    assert_eq!(after.bus.node_id, 42);
    assert_eq!(after.bus.kbit_s, before.bus.kbit_s);
    let mut bus = Bus::new(&mut flash);
    bus.lss(CONFIGURATION);
    assert_eq!(bus.lss([0x13, 0, 3, 0, 0, 0, 0, 0])[..2], [0x13, 0]);
    assert_eq!(bus.lss(STORE)[..2], [0x17, 0]);
    let after = bootloader(&mut flash).state();
    assert_eq!(after.bus.kbit_s, 250);
}

#[test]
fn lss_switches_the_bit_rate_of_the_bootloader_after_the_switch_delay() {
    let mut flash = Model::new();
    let mut bus = Bus::new(&mut flash);
    bus.lss(CONFIGURATION);
    assert_eq!(bus.lss([0x13, 0, 4, 0, 0, 0, 0, 0])[..2], [0x13, 0]);
    bus.lss([0x15, 10, 0, 0, 0, 0, 0, 0]);
    bus.node.tick(10_000, &mut bus.board);
    assert_eq!(bus.board.take_bit_rate(), None);
    bus.node.tick(12_000, &mut bus.board);
    assert_eq!(bus.board.take_bit_rate(), Some(125));
    assert_eq!(bus.board.take_bit_rate(), None, "once");
}

const START: [u8; 8] = [0x2f, 0x51, 0x1f, 1, 1, 0, 0, 0];

#[test]
fn an_empty_board_takes_an_image_and_starts_it() {
    let mut flash = Model::new();
    assert_eq!(bootloader(&mut flash).start(Cause::PowerOn), Decision::Wait);
    let mut bus = Bus::new(&mut flash);
    assert_eq!(bus.read(0x1018, 2), HARDWARE);
    assert_eq!(bus.read(0x1018, 4), 77);
    assert_eq!(bus.read(0x1f51, 1) & 0xff, 0);
    assert_eq!(bus.request(START)[0], 0x80, "there is nothing to start");
    assert_eq!(bus.download(&image(1))[0], 0xa1);
    assert_eq!(bus.read(0x1f57, 1), 0);
    assert_ne!(bus.read(0x1f56, 1), 0);
    assert!(!bus.board.is_requested());
    assert_eq!(bus.request(START)[0], 0x60);
    assert!(bus.board.is_requested());
    let decision = bootloader(&mut flash).start(Cause::Restart);
    assert_eq!(decision, Decision::Run { is_trial: true });
}

#[test]
fn a_download_that_was_broken_off_continues_at_its_last_whole_word() {
    let image = image(1);
    for segments in [1, 73, 74, 80] {
        let mut flash = Model::new();
        let mut bus = Bus::new(&mut flash);
        let [a, b, c, d] = (image.len() as u32).to_le_bytes();
        assert_eq!(bus.request([0xc2, 0x50, 0x1f, 1, a, b, c, d])[0], 0xa4);
        for (number, segment) in image.chunks(7).take(segments).enumerate() {
            let mut data = [0; 8];
            data[0] = number as u8 + 1;
            data[1..].copy_from_slice(segment);
            bus.send(data);
        }
        bus.send([0x80, 0x50, 0x1f, 1, 0, 0, 0, 0]);
        let written = bus.read(0x2104, 2);
        assert_eq!(written as usize, (7 * segments) & !3);
        assert_eq!(bus.request(START)[0], 0x80, "it is not whole");
        let [a, b, c, d] = written.to_le_bytes();
        let continued = bus.request([0x23, 0x04, 0x21, 3, a, b, c, d]);
        let has_header = written >= 512;
        assert_eq!(continued[0], if has_header { 0x60 } else { 0x80 });
        assert_eq!(bus.read(0x2104, 1) != 0, has_header);
        let from = if has_header { written as usize } else { 0 };
        assert_eq!(bus.download(&image[from..])[0], 0xa1, "{segments}");
        assert_eq!(bus.read(0x2104, 2) as usize, image.len());
        assert_eq!(bus.request(START)[0], 0x60);
    }
}

#[test]
fn the_beginning_of_an_image_is_not_completed_by_other_bytes() {
    let mut flash = Model::new();
    let mut bus = Bus::new(&mut flash);
    let content = image(1);
    let [a, b, c, d] = (content.len() as u32).to_le_bytes();
    bus.request([0xc2, 0x50, 0x1f, 1, a, b, c, d]);
    for (number, segment) in content.chunks(7).take(80).enumerate() {
        let mut data = [0; 8];
        data[0] = number as u8 + 1;
        data[1..].copy_from_slice(segment);
        bus.send(data);
    }
    bus.send([0x80, 0x50, 0x1f, 1, 0, 0, 0, 0]);
    assert_eq!(bus.request([0x23, 0x04, 0x21, 3, 0x30, 2, 0, 0])[0], 0x60);
    let mut rest = content[560..].to_vec();
    rest[9] ^= 1;
    assert_eq!(bus.download(&rest)[0], 0x80);
    assert_eq!(bus.read(0x1f57, 1), 1 << 1);
    assert_eq!((bus.read(0x2104, 1), bus.read(0x2104, 2)), (0, 0));
    assert_eq!(bus.request(START)[0], 0x80);
}

#[test]
fn an_image_that_does_not_fit_is_reported_in_the_flash_status() {
    let mut flash = Model::new();
    let mut bus = Bus::new(&mut flash);
    let mut damaged = image(1);
    damaged[530] ^= 4;
    assert_eq!(bus.download(&damaged)[0], 0x80);
    assert_eq!(bus.read(0x1f57, 1), 1 << 1);
    assert_eq!(bus.request(START)[0], 0x80);
    assert_eq!(bus.download(&vec![0; 769])[0], 0x80, "longer than the slot");
    assert_eq!(
        bus.download(&image(1))[0],
        0xa1,
        "a further download is possible"
    );
    assert_eq!(bus.read(0x1f57, 1), 0);
}
