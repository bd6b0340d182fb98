extern crate std;

use canopen::CanFrame as Plain;
use embedded_can::ExtendedId;
use model_core::control::encoder_word::{EncoderCount, EncoderWord, Magnet};
use proptest::prelude::*;

use super::*;
use crate::{
    application::{Application, Samples},
    parameters::BoardParameters,
};

fn standard(id: u16, data: &[u8]) -> Plain {
    Plain::new(StandardId::new(id).unwrap(), data).unwrap()
}

#[test]
fn a_command_frame_is_an_angle_and_a_request() {
    let mut frames = Frames::new(5);
    // -90 deg are -90,000 mdeg.
    let mut data = (-90_000_i32).to_le_bytes().to_vec();
    data.push(1);
    let expected = Message::Command {
        order: Some(Order::Application(Request::Enable)),
        angle: Some(Angle::from_int(-90)),
    };
    assert_eq!(frames.receive(&standard(0x205, &data)), Some(expected));
    // Whoever stops does not command an angle, in a frame with or without one.
    data[4] = 3;
    let expected = Message::Command {
        order: Some(Order::Application(Request::QuickStop)),
        angle: None,
    };
    for data in [&data[..], &[3]] {
        assert_eq!(frames.receive(&standard(0x205, data)), Some(expected));
    }
    // Of another node.
    assert_eq!(frames.receive(&standard(0x206, &data)), None);
    assert_eq!(frames.malformed(), 0);
}

#[test]
fn every_known_request_is_understood_and_no_other() {
    let mut frames = Frames::new(1);
    for code in 0..=u8::MAX {
        let message = frames.receive(&standard(0x201, &[0, 0, 0, 0, code]));
        assert_eq!(message.is_some(), code <= 12, "{code}");
    }
    assert_eq!(frames.malformed(), 256 - 13);
}

#[test]
fn malformed_frames_are_ignored_and_counted() {
    let mut frames = Frames::new(1);
    let id = StandardId::new(0x201).unwrap();
    let malformed = [
        Plain::new(id, &[0; 4]).unwrap(),
        Plain::new(id, &[0; 8]).unwrap(),
        Plain::new(id, &[]).unwrap(),
        Plain::new_remote(id, 5).unwrap(),
        Plain::new(ExtendedId::new(0x201).unwrap(), &[0; 5]).unwrap(),
        standard(0x301, &[0; 7]),
        standard(0x301, &[4, 0, 0, 0, 0, 0, 0, 0]),
        Plain::new_remote(StandardId::new(0x301).unwrap(), 8).unwrap(),
    ];
    for (count, frame) in (1..).zip(malformed) {
        assert_eq!(frames.receive(&frame), None);
        assert_eq!(frames.malformed(), count);
    }
}

#[test]
fn telemetry_tells_angle_rate_state_and_what_was_measured() {
    let mut application = Application::new(BoardParameters::DEFAULT);
    let word = EncoderWord::of(EncoderCount::new(1024), Magnet::Steady);
    let outputs = application.step(&Samples::at_rest(word));
    let [motion, power, health] = Frames::new(0x7f).telemetry::<Plain>(&outputs);
    let motion = motion.unwrap();
    assert_eq!(motion.id(), Id::Standard(StandardId::new(0x1ff).unwrap()));
    // 90 deg, at rest, disabled, no fault.
    let angle = 90_000_i32.to_le_bytes();
    assert_eq!(motion.bytes()[..4], angle);
    assert_eq!(motion.bytes()[4..], [0, 0, 1, 0]);
    // 5998 mV.
    assert_eq!(power.unwrap().bytes(), [0, 0, 0, 0, 0, 0, 0x6e, 0x17]);
    // Tick 1, 25 deg C.
    assert_eq!(health.unwrap().bytes(), [1, 0, 0xc4, 0x09, 0, 0, 0, 0]);
}

#[test]
fn numbers_beyond_their_field_end_at_its_ends() {
    let mut application = Application::new(BoardParameters::DEFAULT);
    let word = EncoderWord::of(EncoderCount::new(0), Magnet::Steady);
    let mut outputs = application.step(&Samples::at_rest(word));
    outputs.telemetry.rate = model_core::control::units::rate(-5000.0);
    outputs.telemetry.current_ma = 40_000;
    outputs.telemetry.supply_mv = -3;
    outputs.telemetry.duty = Percent::from_int(-100);
    let [motion, power, _] = Frames::new(1).telemetry::<Plain>(&outputs);
    assert_eq!(motion.unwrap().bytes()[4..6], i16::MIN.to_le_bytes());
    let power = power.unwrap().bytes();
    assert_eq!(power[..2], i16::MAX.to_le_bytes());
    assert_eq!(power[4..6], (-10_000_i16).to_le_bytes());
    assert_eq!(power[6..], [0, 0]);
}

proptest! {
    #[test]
    fn no_frame_does_harm(id in 0u16..0x800, data in proptest::collection::vec(any::<u8>(), 0..9), node: u8) {
        let mut frames = Frames::new(node);
        let _ = frames.receive(&standard(id, &data));
    }

    #[test]
    fn an_access_comes_back_as_it_went(bytes: [u8; 8]) {
        match Access::of_bytes(bytes) {
            Some(access) => prop_assert_eq!(access.bytes(false), bytes),
            None => prop_assert!(bytes[0] > 3),
        }
    }
}
