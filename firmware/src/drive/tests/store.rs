//! 1010h, 1011h and LSS over the flash.

use super::*;
use crate::parameters::{CONTROL, Parameter};
use crate::store::{EDGES, Stored, layout_hash};
use canopen::dictionary::{Address, Entry};
use canopen::{Abort, ParameterGroup};
use core::task::Poll;

const SAVE: u32 = u32::from_le_bytes(*b"save");
const LOAD: u32 = u32::from_le_bytes(*b"load");

/// Words of the parameters of the board; the values of objects follow.
const BOARD_WORDS: usize = CONTROL + Parameter::ALL.len();

fn reset(bench: &mut Bench) {
    bench.send(0, &[129, 1]);
    bench.steps(3);
}

/// Takes the device into the configuration state and gives it a node-ID.
fn lss_node_id(bench: &mut Bench, node_id: u8) {
    bench.send(0x7E5, &[4, 1, 0, 0, 0, 0, 0, 0]);
    bench.send(0x7E5, &[0x11, node_id, 0, 0, 0, 0, 0, 0]);
}

/// Has it store what LSS set; `error` is what it answers.
fn lss_store(bench: &mut Bench, error: u8) {
    bench.received.clear();
    bench.send(0x7E5, &[0x17, 0, 0, 0, 0, 0, 0, 0]);
    bench.steps(3);
    let answer = frame(0x7E4, &[0x17, error, 0, 0, 0, 0, 0, 0]);
    assert!(bench.received.contains(&answer), "{:?}", bench.received);
}

#[test]
fn saved_values_survive_a_reset_and_others_do_not() {
    let mut bench = Bench::new();
    bench.set_real(0x60FB, 1, 9.5);
    bench.set(0x6081, 0, 123_000, 4);
    bench.set(0x1017, 0, 700, 2);
    bench.set(0x1010, 1, SAVE, 4);
    bench.set(0x6081, 0, 1, 4);
    bench.set_real(0x60FB, 1, 7.0);
    reset(&mut bench);
    assert_eq!(f32::from_bits(bench.get(0x60FB, 1)), 9.5);
    assert_eq!(bench.get(0x6081, 0), 123_000);
    assert_eq!(bench.get(0x1017, 0), 700);
    bench.set(0x1011, 1, LOAD, 4);
    assert_eq!(bench.get(0x6081, 0), 123_000, "until the reset");
    reset(&mut bench);
    assert_eq!(bench.get(0x6081, 0), 300_000);
    assert_eq!(bench.get(0x1017, 0), 0);
    assert_eq!(f32::from_bits(bench.get(0x60FB, 1)), 8.0);
}

#[test]
fn parameter_groups_are_stored_separately() {
    let mut bench = Bench::new();
    bench.set(0x6081, 0, 123_000, 4);
    bench.set(0x1017, 0, 700, 2);
    bench.set(0x1010, 3, SAVE, 4);
    reset(&mut bench);
    assert_eq!((bench.get(0x6081, 0), bench.get(0x1017, 0)), (123_000, 0));
    bench.set(0x6081, 0, 5, 4);
    bench.set(0x1017, 0, 600, 2);
    bench.set(0x1010, 2, SAVE, 4);
    reset(&mut bench);
    assert_eq!((bench.get(0x6081, 0), bench.get(0x1017, 0)), (123_000, 600));
}

#[test]
fn a_failing_flash_is_reported() {
    let mut bench = Bench::new();
    bench.flash = Flash::Fails;
    assert_eq!(
        bench.try_set(0x1010, 1, SAVE, 4),
        Err(Abort::Hardware.code())
    );
    assert_eq!(
        bench.try_set(0x1010, 1, 1, 4),
        Err(Abort::Store.code()),
        "a wrong signature"
    );
}

#[test]
fn lss_stores_node_id_and_bit_rate_and_a_restore_keeps_them() {
    let mut bench = Bench::new();
    lss_node_id(&mut bench, 42);
    bench.send(0x7E5, &[0x13, 0, 2, 0, 0, 0, 0, 0]);
    lss_store(&mut bench, 0);
    bench.set(0x1011, 1, LOAD, 4);
    let bus = bench.actuator.device.drive.store.stored().board.bus;
    assert_eq!((bus.node_id, bus.bit_rate_kbit_s), (42, 500));
    bench.send(0x7E5, &[0x13, 0, 1, 0, 0, 0, 0, 0]);
    let refused = frame(0x7E4, &[0x13, 1, 0, 0, 0, 0, 0, 0]);
    assert!(bench.received.contains(&refused), "800 kbit/s");
    bench.send(0x7E5, &[0x15, 10, 0, 0, 0, 0, 0, 0]);
    bench.steps(10);
    assert_eq!(bench.actuator.device.drive.take_bit_rate(), Some(500));
}

#[test]
fn a_set_is_restored_from_its_words_and_invalid_words_are_refused() {
    let mut set = StoredParameters::DEFAULT;
    set.board.bus.node_id = 17;
    let mut page = StoredParameters::ZEROS;
    let words = &mut page[..StoredParameters::ZEROS.len() - EDGES];
    set.write(words);
    assert_eq!(StoredParameters::read(words), Some(set));
    for number in [CONTROL, BOARD_WORDS - 1, BOARD_WORDS] {
        let valid = words[number];
        words[number] = u32::MAX;
        assert_eq!(
            StoredParameters::read(words),
            None,
            "word {number} is out of its range"
        );
        words[number] = valid;
    }
    assert_eq!(StoredParameters::read(words), Some(set));
    assert_eq!(StoredParameters::read(&words[..20]), None);
}

#[test]
fn an_aborted_save_does_not_answer_the_next_one() {
    let mut bench = Bench::new();
    bench.writes_for = 20;
    let save = [0x23, 0x10, 0x10, 1, b's', b'a', b'v', b'e'];
    bench.set(0x6081, 0, 111, 4);
    bench.send(0x601, &save);
    bench.steps(3);
    // The client aborts after a timeout, changes a value and saves again while the flash is busy.
    bench.send(0x601, &[0x80, 0x10, 0x10, 1, 0, 0, 4, 5]);
    bench.set(0x6081, 0, 222, 4);
    bench.send(0x601, &save);
    bench.steps(80);
    reset(&mut bench);
    assert_eq!(bench.get(0x6081, 0), 222);
    // A restore behind an abandoned save restores.
    bench.send(0x601, &save);
    bench.steps(3);
    bench.send(0x601, &[0x80, 0x10, 0x10, 1, 0, 0, 4, 5]);
    bench.steps(40);
    bench.send(0x601, &[0x23, 0x11, 0x10, 1, b'l', b'o', b'a', b'd']);
    bench.steps(40);
    reset(&mut bench);
    assert_eq!(bench.get(0x6081, 0), 300_000);
}

#[test]
fn simultaneous_saves_of_lss_and_sdo_both_succeed() {
    let mut bench = Bench::new();
    bench.writes_for = 5;
    lss_node_id(&mut bench, 42);
    bench.set(0x1017, 0, 700, 2);
    bench.send(0x601, &[0x23, 0x10, 0x10, 2, b's', b'a', b'v', b'e']);
    bench.received.clear();
    bench.send(0x7E5, &[0x17, 0, 0, 0, 0, 0, 0, 0]);
    bench.steps(40);
    let count = |id| {
        bench
            .received
            .iter()
            .filter(|frame| frame.raw_id().0 == id)
            .count()
    };
    assert_eq!((count(0x7E4), count(0x581)), (1, 1));
    let stored = &bench.actuator.device.drive.store;
    let heartbeat_ms = stored
        .stored()
        .communication(canopen::dictionary::Address::new(0x1017, 0));
    assert_eq!(
        (stored.stored().board.bus.node_id, heartbeat_ms),
        (42, Some(700))
    );
}

#[test]
fn a_failed_save_leaves_the_stored_values_unchanged() {
    let mut bench = Bench::new();
    bench.set(0x6081, 0, 111, 4);
    bench.set(0x1010, 1, SAVE, 4);
    bench.flash = Flash::Fails;
    bench.set(0x6081, 0, 222, 4);
    let refused = Err(Abort::Hardware.code());
    assert_eq!(bench.try_set(0x1010, 1, SAVE, 4), refused);
    assert_eq!(bench.try_set(0x1011, 1, LOAD, 4), refused);
    reset(&mut bench);
    assert_eq!(bench.get(0x6081, 0), 111);
}

#[test]
fn a_save_keeps_the_node_id_that_lss_stored() {
    let mut bench = Bench::new();
    lss_node_id(&mut bench, 42);
    bench.send(0x7E5, &[0x13, 0, 2, 0, 0, 0, 0, 0]);
    bench.send(0x7E5, &[0x17, 0, 0, 0, 0, 0, 0, 0]);
    bench.steps(5);
    assert_eq!((bench.get(0x2102, 1), bench.get(0x2102, 2)), (42, 500));
    bench.set(0x1010, 1, SAVE, 4);
    let bus = bench.actuator.device.drive.store.stored().board.bus;
    assert_eq!((bus.node_id, bus.bit_rate_kbit_s), (42, 500));
}

#[test]
fn stored_identifiers_follow_the_node_id_unless_they_were_changed() {
    let mut bench = Bench::new();
    bench.set(0x1401, 1, 0x8000_0301, 4);
    bench.set(0x1401, 1, 0x355, 4);
    bench.set(0x1010, 1, SAVE, 4);
    let mut set = *bench.actuator.device.drive.store.stored();
    set.board.bus.node_id = 2;
    let buffer = Box::leak(Box::new([0; 80]));
    let mut device = Device::new(set, buffer, 0);
    let _boot_up = device.transmit::<CanFrame>();
    let mut read = |index: u16, sub| {
        let [low, high] = index.to_le_bytes();
        device.receive(&frame(0x602, &[0x40, low, high, sub, 0, 0, 0, 0]), 0);
        let answer: CanFrame = device.transmit().expect("an answer");
        let [_, _, _, _, a, b, c, d] = answer.bytes();
        u32::from_le_bytes([a, b, c, d])
    };
    assert_eq!(read(0x1400, 1), 0x202);
    assert_eq!(read(0x1401, 1), 0x355);
    assert_eq!(read(0x1802, 1), 0x4000_0382);
    assert_eq!(read(0x1014, 0), 0x82);
}

#[test]
fn an_enabled_drive_keeps_its_identity_against_lss() {
    // LSS has changed the node-ID while the drive was disabled.
    let mut bench = Bench::new();
    lss_node_id(&mut bench, 42);
    bench.set(0x6060, 0, 1, 1);
    bench.enable();
    lss_store(&mut bench, 2);
    assert_eq!(
        bench.actuator.device.drive.store.stored().board.bus.node_id,
        1
    );
    // While it is enabled.
    let mut bench = Bench::enabled(1);
    lss_node_id(&mut bench, 42);
    let refused = frame(0x7E4, &[0x11, 255, 0, 0, 0, 0, 0, 0]);
    assert!(bench.received.contains(&refused));
    lss_store(&mut bench, 0);
    assert_eq!(
        bench.actuator.device.drive.store.stored().board.bus.node_id,
        1
    );
}

/// Records which communication parameters the server stores by 1010h.
#[derive(Default)]
struct Recorder(Vec<Address>);

impl canopen::Application for Recorder {
    fn read(&mut self, _: &Entry) -> Result<u64, Abort> {
        Err(Abort::NoObject)
    }

    fn write(&mut self, _: &Entry, _: u64) -> Result<(), Abort> {
        Err(Abort::NoObject)
    }

    fn store(
        &mut self,
        _: ParameterGroup,
        communication: &mut dyn Iterator<Item = (Address, u32)>,
    ) -> Poll<Result<(), Abort>> {
        self.0 = communication.map(|(address, _)| address).collect();
        Poll::Ready(Ok(()))
    }
}

#[test]
fn each_communication_parameter_of_the_server_has_its_position_in_the_stored_set() {
    let mut app = Recorder::default();
    let node_id = canopen::NodeId::new(1);
    let mut node = canopen::Node::<4, 4>::new(&crate::dictionary::DICTIONARY, node_id, &mut app, 0);
    let boot_up = node.transmit::<CanFrame>(&mut app);
    assert!(boot_up.is_some());
    let save = [0x23, 0x10, 0x10, 1, b's', b'a', b'v', b'e'];
    node.receive(&frame(0x601, &save), 0, &mut app);
    let entries = &crate::dictionary::COMMUNICATION_ENTRIES;
    let addresses: Vec<_> = entries.iter().map(|entry| entry.address()).collect();
    assert!(addresses.len() > 50, "{}", addresses.len());
    assert_eq!(app.0, addresses);
}

#[test]
fn the_layout_hash_changes_with_order_name_and_type_of_any_stored_value() {
    let layout = stored::LAYOUT;
    let hash = layout_hash(&layout);
    assert_eq!(hash, StoredParameters::LAYOUT);
    for at in 0..layout.len() {
        let mut reordered = layout;
        reordered.swap(at, (at + 1) % layout.len());
        assert_ne!(layout_hash(&reordered), hash, "word {at} moved");
        let mut renamed = layout;
        renamed[at].name = "another_name";
        assert_ne!(layout_hash(&renamed), hash, "word {at} renamed");
        let mut retyped = layout;
        retyped[at].data_type = "i64";
        assert_ne!(layout_hash(&retyped), hash, "word {at} with another type");
    }
    assert_ne!(layout_hash(&layout[1..]), hash);
}
