//! The update of a node, against the bootloader's own server.

use std::collections::VecDeque;
use std::io;
use std::time::Duration;

use bootloader::layout::STM32F427;
use bootloader::waiting::{DICTIONARY, Waiting};
use bootloader::{
    ACTUATOR_BOARD, Bootloader, DEVELOPMENT_KEY, Flash, FlashError, Header, Key, Outcome, Policy,
    ReadFlash, Version,
};
use canopen::{CanFrame, Node, NodeId};
use embedded_can::Frame;
use firmware::drive::{Device, Slots, StoredParameters, UpdateOrder};
use host_sim::can::link::Link;
use host_sim::can::update::{UpdateError, update};
use program_image::signed::{Description, development_key, sign};

/// A flash of 2 MiB in memory.
struct Memory(Vec<u8>);

/// Its first address.
const BASE: u32 = 0x0800_0000;

impl ReadFlash for Memory {
    fn bytes(&self, address: u32, length: u32) -> &[u8] {
        let start = (address - BASE) as usize;
        &self.0[start..start + length as usize]
    }
}

impl Flash for Memory {
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

/// What runs on a board.
enum Running {
    Bootloader(Box<(Node<0, 0>, Waiting<'static, Memory, Key>)>),
    Program(Box<Device<'static>>),
}

/// A board on a bus that loses every so many frames.
struct Board {
    running: Running,
    /// Identity of the program that runs after the installation.
    next: u32,
    /// The image that a program has staged.
    staged: Vec<i32>,
    answers: VecDeque<CanFrame>,
    frames: usize,
    loses: usize,
    /// Frames to the board until the bus is cut.
    cut_after: usize,
    now_us: u64,
}

/// Identity of the program before the update.
const OLD: u32 = 7;

/// A program of this identity behind a bootloader.
fn program(identity: u32) -> Running {
    let buffer = Box::leak(Box::new([0; 40 << 10]));
    let mut device = Device::with_node_id(StoredParameters::DEFAULT, buffer, 0, NodeId::new(5));
    let version = Version::parse("1.2.2").expect("a version");
    device.drive.set_slots(Slots {
        identity,
        version,
        policy: Policy {
            hardware: ACTUATOR_BOARD,
            floor: version,
        },
        capacity: STM32F427.slot.size(),
        outcome: Outcome::None,
        is_confirmed: true,
        staged: None,
    });
    Running::Program(Box::new(device))
}

impl Board {
    /// A board that waits for an image.
    fn waiting(loses: usize, next: u32) -> Self {
        let flash = Box::leak(Box::new(Memory(vec![u8::MAX; 2 << 20])));
        let bootloader = Bootloader {
            flash,
            layout: &STM32F427,
            hardware: ACTUATOR_BOARD,
            verifier: DEVELOPMENT_KEY,
        };
        let mut waiting = Waiting::new(bootloader, 1);
        let node = Node::new(&DICTIONARY, NodeId::new(5), &mut waiting, 0);
        Self::of(Running::Bootloader(Box::new((node, waiting))), loses, next)
    }

    fn of(running: Running, loses: usize, next: u32) -> Self {
        let mut board = Self {
            running,
            next,
            staged: Vec::new(),
            answers: VecDeque::new(),
            frames: 0,
            loses,
            cut_after: usize::MAX,
            now_us: 0,
        };
        board.collect();
        board.answers.clear();
        board
    }

    fn collect(&mut self) {
        let mut next = || match &mut self.running {
            Running::Bootloader(waits) => waits.0.transmit(&mut waits.1),
            Running::Program(device) => device.transmit(),
        };
        while let Some(frame) = next() {
            self.answers.push_back(frame);
        }
    }

    /// A control period; returns whether the board restarts.
    fn step(&mut self) -> bool {
        self.now_us += 4_000;
        match &mut self.running {
            Running::Bootloader(waits) => {
                waits.0.tick(0, &mut waits.1);
                waits.1.is_requested()
            }
            Running::Program(device) => {
                device.communicate(self.now_us);
                let drive = &mut device.drive;
                match drive.take_update() {
                    Some(UpdateOrder::Stage { buffer, length }) => {
                        self.staged = buffer[..length as usize / 4].to_vec();
                        drive.staged(buffer, Ok(()));
                    }
                    Some(UpdateOrder::Install(_)) => drive.requested(true),
                    Some(UpdateOrder::Confirm(_)) => drive.confirmed(true),
                    None => {}
                }
                drive.step_update()
            }
        }
    }
}

impl Link for Board {
    fn send(&mut self, frame: &CanFrame) -> io::Result<()> {
        if self.frames >= self.cut_after {
            return Err(io::ErrorKind::BrokenPipe.into());
        }
        self.frames += 1;
        // The first frame of a block is never lost, nor the last: the protocol has a time-out for
        // these.
        let first = frame.data()[0];
        let is_within = (2..127).contains(&first);
        if is_within && self.frames.is_multiple_of(self.loses) {
            return Ok(());
        }
        match &mut self.running {
            Running::Bootloader(waits) => waits.0.receive(frame, 0, &mut waits.1),
            Running::Program(device) => device.receive(frame, self.now_us),
        }
        self.collect();
        Ok(())
    }

    fn receive(&mut self, _: Duration) -> io::Result<Option<CanFrame>> {
        for _ in 0..100 {
            if self.step() {
                self.running = program(self.next);
            }
            self.collect();
            if let Some(answer) = self.answers.pop_front() {
                return Ok(Some(answer));
            }
        }
        Ok(None)
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

/// Loads an image into a board that waits for one; returns the bytes that were confirmed one after
/// the other.
fn load(image: &[u8], loses: usize) -> Result<Vec<usize>, UpdateError> {
    let header = Header::read(image).expect("an image");
    let mut confirmed = Vec::new();
    let mut board = Board::waiting(loses, header.identity());
    update(&mut board, 5, (&header, image), &mut |bytes| {
        confirmed.push(bytes)
    })?;
    assert!(matches!(board.running, Running::Program(_)));
    Ok(confirmed)
}

/// Loads an image into a program that drives, after which the program of this identity runs.
fn replace(image: &[u8], next: u32) -> Result<Vec<i32>, UpdateError> {
    let header = Header::read(image).expect("an image");
    let mut board = Board::of(program(OLD), usize::MAX, next);
    update(&mut board, 5, (&header, image), &mut |_| {})?;
    Ok(board.staged)
}

#[test]
fn a_program_that_runs_takes_the_image_of_the_next_one() {
    let image = image(ACTUATOR_BOARD);
    let identity = Header::read(&image).expect("an image").identity();
    let staged = replace(&image, identity).expect("the image fits");
    let bytes: Vec<u8> = staged.iter().flat_map(|word| word.to_le_bytes()).collect();
    assert_eq!(bytes, image);
    let rolled_back = replace(&image, OLD);
    assert!(
        matches!(rolled_back, Err(UpdateError::RolledBack(5))),
        "{rolled_back:?}"
    );
}

/// The bus is cut at each part of the download; afterwards the client is started again, once before
/// the node has noticed and once after.
#[test]
fn an_update_that_was_cut_off_continues_where_it_ended() {
    let image = image(ACTUATOR_BOARD);
    let header = Header::read(&image).expect("an image");
    let mut continued = 0;
    for cut_after in (0..800).step_by(60) {
        for pause_periods in [0, 300] {
            for is_waiting in [false, true] {
                let mut board = if is_waiting {
                    Board::waiting(usize::MAX, header.identity())
                } else {
                    Board::of(program(OLD), usize::MAX, header.identity())
                };
                board.cut_after = cut_after;
                let cut = update(&mut board, 5, (&header, &image), &mut |_| {});
                let cut = cut.expect_err("the bus is cut");
                assert!(!cut.is_refusal(), "{cut}");
                (board.cut_after, board.frames) = (usize::MAX, 0);
                for _ in 0..pause_periods {
                    assert!(!board.step());
                }
                board.answers.clear();
                let mut reported = Vec::new();
                let mut progress = |bytes| reported.push(bytes);
                update(&mut board, 5, (&header, &image), &mut progress).expect("the rest");
                let staged: Vec<u8> = board.staged.iter().flat_map(|w| w.to_le_bytes()).collect();
                // The bootloader has checked the image.
                assert!(
                    is_waiting || staged == image,
                    "cut after {cut_after} frames"
                );
                assert!(matches!(board.running, Running::Program(_)));
                assert_eq!(reported.last(), Some(&image.len()));
                let segments = image.len().div_ceil(7);
                if cut_after > 300 {
                    continued += 1;
                    // The other frames are requests before and after the download.
                    let saved = segments.saturating_sub(board.frames);
                    assert!(saved + 60 > cut_after.min(segments), "{saved}, {cut_after}");
                }
            }
        }
    }
    assert!(continued > 30, "{continued}");
}

#[test]
fn a_program_without_a_bootloader_takes_no_image() {
    let image = image(ACTUATOR_BOARD);
    let header = Header::read(&image).expect("an image");
    let mut board = Board::of(program(0), usize::MAX, 0);
    let refused = update(&mut board, 5, (&header, &image), &mut |_| {});
    assert!(
        matches!(refused, Err(UpdateError::NoBootloader(5))),
        "{refused:?}"
    );
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
