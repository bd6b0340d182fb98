//! Fuzzing of the device with CAN frames: plausible frames of a master, mutated and random frames.
//!
//! `STORM_FRAMES=10000000 cargo test --release -p firmware --test storm -- --nocapture` sets the
//! number of frames.

use canopen::CanFrame;
use embedded_can::Frame;
use firmware::actuator::Actuator;
use firmware::application::{BoardState, Samples, Start};
use firmware::dictionary::DICTIONARY;
use firmware::drive::StoredParameters;
use model_core::control::encoder_word::{EncoderCount, EncoderWord, Magnet};
use proptest::prelude::Rng;
use proptest::test_runner::{RngAlgorithm, TestRng};

/// Default number of frames.
const FRAMES: u64 = 60_000;

/// Number of frames between two checks of the device.
const CHECK_EVERY: u64 = 1_000;

struct Storm {
    random: TestRng,
    last: CanFrame,
}

impl Storm {
    fn new() -> Self {
        Self {
            random: TestRng::deterministic_rng(RngAlgorithm::ChaCha),
            last: CanFrame::raw(0, false, false, 0, [0; 8]).expect("a frame"),
        }
    }

    fn below(&mut self, end: u32) -> u32 {
        self.random.next_u32() % end
    }

    fn bytes(&mut self) -> [u8; 8] {
        self.random.next_u64().to_le_bytes()
    }

    /// A plausible frame of a master: an SDO request for an existing object, a PDO, NMT, SYNC, a
    /// heartbeat, LSS.
    fn plausible(&mut self) -> CanFrame {
        const COMMANDS: [u8; 16] = [
            0x40, 0x23, 0x27, 0x2B, 0x2F, 0x21, 0x60, 0x70, 0x00, 0x11, 0xA0, 0xA3, 0xA2, 0xC2,
            0xC6, 0x80,
        ];
        const OTHERS: [u32; 9] = [0, 0x80, 0x100, 0x201, 0x301, 0x401, 0x501, 0x764, 0x7E5];
        let mut data = self.bytes();
        if self.below(4) > 0 {
            let rows = DICTIONARY.entries();
            let address = rows[self.below(rows.len() as u32) as usize].address();
            data[0] = COMMANDS[self.below(16) as usize];
            [data[1], data[2]] = address.index.to_le_bytes();
            data[3] = address.sub;
            if self.below(2) == 0 {
                // Small numbers are more often within the limits.
                data[5..].fill(0);
            }
            return CanFrame::raw(0x601, false, false, 8, data).expect("a frame");
        }
        let id = OTHERS[self.below(9) as usize];
        let length = self.below(9) as u8;
        CanFrame::raw(id, false, false, length, data).expect("a frame")
    }

    /// The last frame with a bit, its length or its identifier changed.
    fn mutated(&mut self) -> CanFrame {
        let (mut id, mut extended) = self.last.raw_id();
        let (mut data, mut length) = (self.last.bytes(), self.last.dlc() as u8);
        match self.below(4) {
            0 => id ^= 1 << self.below(11),
            1 => length = self.below(9) as u8,
            2 => extended = !extended,
            _ => data[self.below(8) as usize] ^= 1 << self.below(8),
        }
        let remote = self.below(20) == 0;
        let id = if extended { id } else { id & 0x7FF };
        CanFrame::raw(id, extended, remote, length, data).expect("a frame")
    }

    fn any(&mut self) -> CanFrame {
        let (extended, remote) = (self.below(2) == 0, self.below(4) == 0);
        let id = self.random.next_u32() & if extended { 0x1FFF_FFFF } else { 0x7FF };
        let (length, data) = (self.below(9) as u8, self.bytes());
        CanFrame::raw(id, extended, remote, length, data).expect("a frame")
    }

    fn next(&mut self) -> CanFrame {
        self.last = match self.below(10) {
            0..6 => self.plausible(),
            6..9 => self.mutated(),
            _ => self.any(),
        };
        self.last
    }
}

struct Board<'a> {
    actuator: Actuator<'a>,
    now_us: u64,
    /// Remaining control periods of the flash operation.
    writing: u32,
    saves: u32,
}

impl Board<'_> {
    fn period(&mut self) {
        self.now_us += 4_000;
        let word = EncoderWord::of(EncoderCount::new(1024), Magnet::Steady);
        self.actuator.step(&Samples::at_rest(word), self.now_us);
        let drive = &mut self.actuator.device.drive;
        if drive.take_save().is_some() {
            self.writing = 7;
        }
        // The flash operation takes some periods, and every third one fails.
        self.writing = self.writing.saturating_sub(1);
        if self.writing == 1 {
            self.saves += 1;
            drive.saved(!self.saves.is_multiple_of(3));
        }
        let _ = drive.take_bit_rate();
    }

    fn exchange(&mut self, id: u32, data: [u8; 8], length: u8) -> Vec<CanFrame> {
        let frame = CanFrame::raw(id, false, false, length, data).expect("a frame");
        self.actuator.receive(&frame, self.now_us);
        let mut responses = Vec::new();
        while let Some(frame) = self.actuator.transmit() {
            responses.push(frame);
            assert!(
                responses.len() < 1_000,
                "the number of responses is limited"
            );
        }
        responses
    }

    /// Checks that after a reset by the master the device responds as after power-on, under the
    /// node-ID that LSS may have set.
    fn check(&mut self) {
        let parameters = self.actuator.device.drive.parameters();
        assert_eq!(parameters.check(), Ok(()));
        // During a change of the bit rate by LSS the device does not transmit.
        for _ in 0..40_000 {
            self.period();
            if !self.exchange(0, [129, 0, 0, 0, 0, 0, 0, 0], 2).is_empty() {
                break;
            }
        }
        let Some(node) = self.actuator.node().node_id() else {
            return;
        };
        self.period();
        let id = u32::from(node.get());
        let responses = self.exchange(0x600 + id, [0x40, 0, 0x10, 0, 0, 0, 0, 0], 8);
        let response = responses
            .iter()
            .find(|frame| frame.raw_id().0 == 0x580 + id);
        let response = response.expect("a response");
        assert_eq!(response.bytes(), [0x43, 0, 0x10, 0, 0x92, 0x01, 0x02, 0]);
        assert_ne!(
            self.actuator.device.drive.outputs().state,
            BoardState::FaultReaction
        );
    }
}

#[test]
fn random_frames_do_not_break_the_device_or_its_parameters() {
    let frames = std::env::var("STORM_FRAMES")
        .map_or(FRAMES, |text| text.parse().expect("a number of frames"));
    let (mut storm, mut sent, mut devices) = (Storm::new(), 0, 0);
    while sent < frames {
        // A device without a node-ID after LSS is replaced by a new one.
        let mut buffer = [0; 400];
        let mut board = Board {
            actuator: Actuator::new(StoredParameters::DEFAULT, Start::default(), &mut buffer, 0),
            now_us: 0,
            writing: 0,
            saves: 0,
        };
        devices += 1;
        while sent < frames && board.actuator.node().node_id().is_some() {
            board.actuator.receive(&storm.next(), board.now_us);
            sent += 1;
            while board.actuator.transmit::<CanFrame>().is_some() {}
            if storm.below(4) == 0 {
                board.period();
            }
            if sent % CHECK_EVERY == 0 {
                board.check();
            }
        }
    }
    println!("{sent} frames, {devices} devices");
}
