//! Frames at the whole device: `cargo +nightly fuzz run --fuzz-dir tests/fuzz frames`.
//!
//! The input is a sequence of frames: two bytes of identifier (bit 15: 29 bits, bit 14: remote,
//! bits 11 to 13: control periods that pass first), a length, and the data.
#![no_main]

use canopen::CanFrame;
use firmware::application::{Samples, Start};
use firmware::drive::{Device, Set};
use libfuzzer_sys::fuzz_target;
use model_core::control::encoder_word::{EncoderCount, EncoderWord, Magnet};

fuzz_target!(|input: &[u8]| {
    let mut buffer = [0; 80];
    let mut device = Device::new(StoredParameters::DEFAULT, Start::default(), &mut buffer, 0);
    let word = EncoderWord::of(EncoderCount::new(0), Magnet::Steady);
    let (mut rest, mut now_us) = (input, 0);
    while let [low, high, length, after @ ..] = rest {
        let head = u16::from_le_bytes([*low, *high]);
        for _ in 0..head >> 11 & 7 {
            now_us += 4_000;
            device.step(&Samples::at_rest(word), now_us);
            if device.drive.take_save().is_some() {
                device.drive.saved(true);
            }
        }
        let used = after.len().min(usize::from(length % 9));
        let mut data = [0; 8];
        data[..used].copy_from_slice(&after[..used]);
        let (extended, remote) = (head & 1 << 15 != 0, head & 1 << 14 != 0);
        let frame = CanFrame::raw(u32::from(head & 0x7FF), extended, remote, length % 9, data);
        device.receive(&frame.expect("11 bits and at most 8 bytes"), now_us);
        let talk = std::iter::from_fn(|| device.transmit::<CanFrame>()).take(1_000).count();
        assert!(talk < 1_000, "it does not talk for ever");
        rest = &after[used..];
    }
    assert_eq!(device.drive.application().parameters().check(), Ok(()));
});
