//! The update of a node, against the bootloader's own server.

use std::collections::VecDeque;
use std::io;
use std::time::Duration;

use bootloader::layout::STM32F427;
use bootloader::waiting::{DICTIONARY, Waiting};
use bootloader::{
    ACTUATOR_BOARD, Bootloader, DEVELOPMENT_KEY, Flash, FlashError, Header, Key, Version,
};
use canopen::{CanFrame, Node, NodeId};
use embedded_can::Frame;
use host_sim::can::link::Link;
use host_sim::can::update::{UpdateError, update};
use program_image::signed::{Description, development_key, sign};

/// A flash of 2 MiB in memory.
struct Memory(Vec<u8>);

/// Its first address.
const BASE: u32 = 0x0800_0000;

impl Flash for Memory {
    fn bytes(&self, address: u32, length: u32) -> &[u8] {
        let start = (address - BASE) as usize;
        &self.0[start..start + length as usize]
    }

    fn erase(&mut self, sector: u8) -> Result<(), FlashError> {
        let regions = [STM32F427.slot, STM32F427.staging, STM32F427.backup];
        let sectors = regions.into_iter().flat_map(|region| region.sectors);
        let mut sectors = sectors.chain(&STM32F427.records);
        let found = sectors
            .find(|found| found.number == sector)
            .ok_or(FlashError)?;
        let start = (found.start - BASE) as usize;
        self.0[start..start + found.size as usize].fill(u8::MAX);
        Ok(())
    }

    fn program(&mut self, address: u32, word: u32) -> Result<(), FlashError> {
        let start = (address - BASE) as usize;
        for (byte, value) in self.0[start..start + 4].iter_mut().zip(word.to_le_bytes()) {
            *byte &= value;
        }
        Ok(())
    }
}

/// A board that waits for an image, on a bus that loses every so many frames.
struct Board {
    node: Node<0, 0>,
    waiting: Waiting<'static, Memory, Key>,
    answers: VecDeque<CanFrame>,
    frames: usize,
    loses: usize,
}

impl Board {
    fn new(loses: usize) -> Self {
        let flash = Box::leak(Box::new(Memory(vec![u8::MAX; 2 << 20])));
        let bootloader = Bootloader {
            flash,
            layout: &STM32F427,
            hardware: ACTUATOR_BOARD,
            verifier: DEVELOPMENT_KEY,
        };
        let mut waiting = Waiting::new(bootloader, 1);
        let node = Node::new(&DICTIONARY, NodeId::new(5), &mut waiting, 0);
        let mut board = Self {
            node,
            waiting,
            answers: VecDeque::new(),
            frames: 0,
            loses,
        };
        board.collect();
        board.answers.clear();
        board
    }

    fn collect(&mut self) {
        while let Some(frame) = self.node.transmit(&mut self.waiting) {
            self.answers.push_back(frame);
        }
    }
}

impl Link for Board {
    fn send(&mut self, frame: &CanFrame) -> io::Result<()> {
        self.frames += 1;
        // The first frame of a block is never lost, nor the last: the protocol has a time-out for
        // these.
        let first = frame.data()[0];
        let is_within = (2..127).contains(&first);
        if is_within && self.frames.is_multiple_of(self.loses) {
            return Ok(());
        }
        self.node.receive(frame, 0, &mut self.waiting);
        self.node.tick(0, &mut self.waiting);
        self.collect();
        if self.waiting.is_requested() {
            let id = embedded_can::StandardId::new(0x705).expect("11 bits");
            let boot_up = CanFrame::new(id, &[0]).expect("one byte");
            self.answers.push_back(boot_up);
        }
        Ok(())
    }

    fn receive(&mut self, _: Duration) -> io::Result<Option<CanFrame>> {
        Ok(self.answers.pop_front())
    }
}

fn image(hardware: u32) -> Vec<u8> {
    let program: Vec<u8> = (0..5_003_u32).map(|at| (at * 7 % 251) as u8).collect();
    let description = Description {
        hardware,
        version: Version::parse("1.2.3").expect("a version"),
        replaces: None,
    };
    sign(&program, &description, &development_key())
}

/// Loads an image into a board; returns the bytes that were confirmed one after the other.
fn load(image: &[u8], loses: usize) -> Result<Vec<usize>, UpdateError> {
    let header = Header::read(image).expect("an image");
    let mut confirmed = Vec::new();
    let mut board = Board::new(loses);
    update(&mut board, 5, (&header, image), &mut |bytes| {
        confirmed.push(bytes)
    })?;
    assert!(board.waiting.is_requested());
    Ok(confirmed)
}

#[test]
fn an_image_is_loaded_block_by_block_and_its_installation_is_requested() {
    let image = image(ACTUATOR_BOARD);
    let confirmed = load(&image, usize::MAX).expect("the image fits");
    let block = 127 * 7;
    let expected = (1..).map(|blocks| (blocks * block).min(image.len()));
    let count = image.len().div_ceil(block);
    assert_eq!(confirmed, expected.take(count).collect::<Vec<_>>());
}

#[test]
fn segments_that_are_lost_are_sent_again() {
    let image = image(ACTUATOR_BOARD);
    let confirmed = load(&image, 50).expect("the image arrives");
    assert_eq!(confirmed.last(), Some(&image.len()));
    assert!(confirmed.len() > image.len().div_ceil(127 * 7));
}

#[test]
fn an_image_for_other_hardware_is_not_loaded_and_a_forged_one_is_refused_by_the_board() {
    let other = load(&image(ACTUATOR_BOARD + 1), usize::MAX);
    assert!(
        matches!(other, Err(UpdateError::Hardware { found: 0x5341, .. })),
        "{other:?}"
    );
    let mut forged = image(ACTUATOR_BOARD);
    *forged.last_mut().expect("a program") ^= 1;
    let refused = load(&forged, usize::MAX).expect_err("refused");
    assert!(refused.is_refusal(), "{refused}");
    assert!(refused.to_string().contains("not signed"), "{refused}");
}
