//! The behaviour with the default values of the dictionary, without any configuration.

extern crate std;

use canopen::dictionary::{Address, Entry};
use canopen::{Abort, Application, CanFrame, Node, NodeId};
use embedded_can::{Frame, StandardId};
use std::vec::Vec;

use super::DICTIONARY;

fn frame(id: u16, data: &[u8]) -> CanFrame {
    CanFrame::new(StandardId::new(id).expect("11 bits"), data).expect("at most 8 bytes")
}

/// Records every write; reads zeros.
#[derive(Default)]
struct Recorder(Vec<(Address, u64)>);

impl Application for Recorder {
    fn read(&mut self, _: &Entry) -> Result<u64, Abort> {
        Ok(0)
    }
    fn write(&mut self, entry: &Entry, value: u64) -> Result<(), Abort> {
        self.0.push((entry.address(), value));
        Ok(())
    }
}

fn operational() -> (Node<4, 4>, Recorder) {
    let mut app = Recorder::default();
    let mut node = Node::new(&DICTIONARY, NodeId::new(1), &mut app, 0);
    while node.transmit::<CanFrame>(&mut app).is_some() {}
    node.receive(&frame(0, &[1, 1]), 0, &mut app);
    (node, app)
}

#[test]
fn two_telemetry_pdos_come_at_250_hz_and_a_status_at_50_hz() {
    let (mut node, mut app) = operational();
    let mut seen = Vec::new();
    for tick in 1..=250 {
        node.tick(tick * 4_000, &mut app);
        while let Some(frame) = node.transmit::<CanFrame>(&mut app) {
            seen.push((frame.raw_id().0, frame.dlc()));
        }
    }
    let count = |wanted| seen.iter().filter(|frame| **frame == wanted).count();
    assert_eq!(count((0x181, 8)), 250);
    assert_eq!(count((0x281, 8)), 250);
    assert_eq!(count((0x381, 5)), 50);
    assert_eq!(seen.len(), 550);
}

#[test]
fn each_default_command_has_the_controlword_as_in_cia_402() {
    let (mut node, mut app) = operational();
    node.receive(&frame(0x201, &[6, 0]), 0, &mut app);
    node.receive(&frame(0x301, &[7, 0, 9]), 0, &mut app);
    node.receive(&frame(0x401, &[0x0F, 0, 0x10, 0x27, 0, 0]), 0, &mut app);
    node.receive(
        &frame(0x501, &[0x1F, 0, 0xFF, 0xFF, 0xFF, 0xFF]),
        0,
        &mut app,
    );
    let expected = [
        (0x6040, 6),
        (0x6040, 7),
        (0x6060, 9),
        (0x6040, 15),
        (0x607A, 10_000),
        (0x6040, 31),
        (0x60FF, u64::MAX),
    ];
    assert_eq!(
        app.0,
        expected.map(|(index, value)| (Address::new(index, 0), value))
    );
}

#[test]
fn every_default_mapping_can_be_used() {
    for number in 0..4 {
        for (communication, mapping) in [(0x1400, 0x1600), (0x1800, 0x1A00)] {
            let address = |base: u16, sub| Address::new(base + number, sub);
            assert!(DICTIONARY.find(address(communication, 1)).is_ok());
            let value = |address| {
                let row = DICTIONARY.find(address).expect("an entry");
                row.default_value(1)
            };
            let count = value(address(mapping, 0));
            let bits = (1..=count as u8).map(|sub| {
                let word = value(address(mapping, sub));
                let mapped = Address::new((word >> 16) as u16, (word >> 8) as u8);
                let size = DICTIONARY
                    .find(mapped)
                    .expect("an object")
                    .data_type()
                    .size();
                assert_eq!(
                    size.map(u32::from),
                    Some(word as u8 as u32 / 8),
                    "{mapped:?}"
                );
                word as u8 as u32
            });
            assert!(bits.sum::<u32>() <= 64);
        }
    }
}

#[test]
fn supported_modes_and_device_type_are_those_of_the_profile() {
    let value = |index, sub| {
        DICTIONARY
            .find(Address::new(index, sub))
            .map(|row| row.default_value(1))
    };
    assert_eq!(value(0x6502, 0), Ok(canopen::cia402::Mode::SUPPORTED));
    assert_eq!(value(0x1000, 0).map(|device| device & 0xFFFF), Ok(402));
}
