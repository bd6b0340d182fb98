//! A device with few objects, whose application does no more than it has to.

use std::task::Poll;

use canopen::dictionary::{Access, Address, DataType, Dictionary, Entry, Mapping};
use canopen::{Abort, Application, CanFrame, Node, NodeId};
use embedded_can::Frame;

use crate::bench::data_frame;

const ENTRIES: &[Entry] = &[
    Entry::new(0x1003, 0, DataType::U8, Access::ReadWrite),
    Entry::new(0x1003, 1, DataType::U32, Access::Read),
    Entry::new(0x1003, 2, DataType::U32, Access::Read),
    Entry::new(0x1010, 0, DataType::U8, Access::Const).value(1),
    Entry::new(0x1010, 1, DataType::U32, Access::ReadWrite).value(1),
    Entry::new(0x1011, 0, DataType::U8, Access::Const).value(1),
    Entry::new(0x1011, 1, DataType::U32, Access::ReadWrite).value(1),
    Entry::new(0x1017, 0, DataType::U16, Access::ReadWrite).value(0),
    // Without a transmission type.
    Entry::new(0x1400, 0, DataType::U8, Access::Const).value(1),
    Entry::new(0x1400, 1, DataType::U32, Access::ReadWrite).value_with_node_id(0x200),
    Entry::new(0x1600, 0, DataType::U8, Access::ReadWrite).value(1),
    Entry::new(0x1600, 1, DataType::U32, Access::ReadWrite).value(0x2001_0010),
    Entry::new(0x2001, 0, DataType::U16, Access::ReadWrite)
        .mappable(Mapping::Both)
        .guarded(),
    Entry::new(0x2005, 0, DataType::VisibleString, Access::ReadWrite).value(32),
    Entry::new(0x2010, 0, DataType::Domain, Access::ReadWrite),
];

const DICTIONARY: Dictionary = match Dictionary::try_new(ENTRIES, &[], &[]) {
    Ok(dictionary) => dictionary,
    Err(_) => panic!("invalid object dictionary"),
};

/// One number.
struct Number(u64);

impl Application for Number {
    fn read(&mut self, _: &Entry) -> Result<u64, Abort> {
        Ok(self.0)
    }

    fn write(&mut self, _: &Entry, value: u64) -> Result<(), Abort> {
        self.0 = value;
        Ok(())
    }
}

/// More PDOs than the dictionary has.
type SmallNode = Node<2, 1>;

/// A node in PRE-OPERATIONAL.
fn node(app: &mut Number) -> SmallNode {
    let mut node = Node::new(&DICTIONARY, NodeId::new(5), app, 0);
    let boot_up: CanFrame = node.transmit(app).expect("boot-up");
    assert_eq!(boot_up.raw_id(), (0x705, false));
    node
}

/// The response to a request of a client.
fn sdo(node: &mut SmallNode, app: &mut Number, request: [u8; 8]) -> [u8; 8] {
    node.receive(&data_frame(0x605, &request), 0, app);
    let answer: CanFrame = node.transmit(app).expect("an answer");
    assert_eq!(answer.raw_id(), (0x585, false));
    answer.bytes()
}

#[test]
fn an_application_that_supports_no_more_refuses_each_service_by_its_abort_code() {
    let app = &mut Number(0);
    let node = &mut node(app);
    let no_data = [0x24, 0, 0, 8];
    let unsupported = [0, 0, 1, 6];
    let hardware = [0, 0, 6, 6];
    for (request, code) in [
        ([0x40, 5, 0x20, 0, 0, 0, 0, 0], no_data),
        ([0x23, 5, 0x20, 0, 1, 2, 3, 4], unsupported),
        ([0x40, 0x10, 0x20, 0, 0, 0, 0, 0], no_data),
        ([0x21, 0x10, 0x20, 0, 9, 0, 0, 0], unsupported),
        ([0x23, 0x10, 0x10, 1, b's', b'a', b'v', b'e'], hardware),
        ([0x23, 0x11, 0x10, 1, b'l', b'o', b'a', b'd'], hardware),
    ] {
        let answer = sdo(node, app, request);
        assert_eq!((answer[0], &answer[4..]), (0x80, &code[..]), "{request:x?}");
    }
    // Neither a stored value nor a write protection.
    let answer = sdo(node, app, [0x40, 0x17, 0x10, 0, 0, 0, 0, 0]);
    assert_eq!(answer, [0x4B, 0x17, 0x10, 0, 0, 0, 0, 0]);
    let answer = sdo(node, app, [0x2B, 1, 0x20, 0, 7, 0, 0, 0]);
    assert_eq!((answer[0], app.0), (0x60, 7));
}

#[test]
fn an_application_without_domains_refuses_each_access_to_one() {
    let (app, domain) = (&mut Number(0), Address::new(0x2010, 0));
    assert_eq!(app.domain_size(domain), Err(Abort::NoData));
    assert_eq!(app.domain_read(domain, 0, &mut [0]), Err(Abort::NoData));
    let refused = Err(Abort::UnsupportedAccess);
    assert_eq!(app.domain_begin(domain, None), refused);
    assert_eq!(app.domain_write(domain, 0, &[0]), refused);
    assert_eq!(app.domain_end(domain, 1), Poll::Ready(refused));
}

#[test]
fn an_application_without_bit_rates_and_storage_refuses_those_of_lss() {
    let app = &mut Number(0);
    let node = &mut node(app);
    let lss = |node: &mut SmallNode, app: &mut Number, request: [u8; 8]| {
        node.receive(&data_frame(0x7E5, &request), 0, app);
        node.tick(0, app);
        let answer: Option<CanFrame> = node.transmit(app);
        answer.map(|answer| answer.bytes())
    };
    assert_eq!(lss(node, app, [4, 1, 0, 0, 0, 0, 0, 0]), None);
    let refused = |command| Some([command, 1, 0, 0, 0, 0, 0, 0]);
    assert_eq!(lss(node, app, [0x13, 0, 2, 0, 0, 0, 0, 0]), refused(0x13));
    assert_eq!(lss(node, app, [0x17, 0, 0, 0, 0, 0, 0, 0]), refused(0x17));
}

#[test]
fn the_history_shows_as_many_errors_as_the_dictionary_has() {
    let app = &mut Number(0);
    let node = &mut node(app);
    for code in 0x1000..0x1004 {
        let error = canopen::Emergency::new(canopen::ErrorCode(code), 0);
        node.raise(error, app);
    }
    let answer = sdo_after_emcys(node, app, [0x40, 3, 0x10, 0, 0, 0, 0, 0]);
    assert_eq!(answer, [0x4F, 3, 0x10, 0, 2, 0, 0, 0]);
}

/// The response of the SDO server, behind EMCYs.
fn sdo_after_emcys(node: &mut SmallNode, app: &mut Number, request: [u8; 8]) -> [u8; 8] {
    node.receive(&data_frame(0x605, &request), 0, app);
    let mut frames = std::iter::from_fn(|| node.transmit::<CanFrame>(app));
    let answer = frames.find(|frame| frame.raw_id() == (0x585, false));
    answer.expect("an answer").bytes()
}

#[test]
fn an_rpdo_without_a_transmission_type_is_event_driven() {
    let app = &mut Number(0);
    let node = &mut node(app);
    node.receive(&data_frame(0, &[1, 5]), 0, app);
    node.receive(&data_frame(0x205, &[9, 0]), 0, app);
    assert_eq!(app.0, 9);
}

#[test]
fn a_pdo_without_objects_in_the_dictionary_is_not_valid() {
    let app = &mut Number(0);
    let node = &mut node(app);
    // Neither RPDO 2 nor TPDO 1: NMT is the only one with identifier 0.
    let nmt = node.identifiers().filter(|(id, _)| {
        let zero: embedded_can::Id = embedded_can::StandardId::ZERO.into();
        *id == zero
    });
    assert_eq!(nmt.count(), 1);
    assert!(!node.identifiers().any(|(_, remote)| remote));
}

#[test]
fn frames_keep_their_identifier_and_length() {
    let far = embedded_can::ExtendedId::new(0x123).expect("29 bits");
    let near = embedded_can::StandardId::new(0x123).expect("11 bits");
    let remote = CanFrame::new_remote(far, 8).expect("eight bytes");
    assert!(remote.is_extended() && remote.is_remote_frame() && remote.dlc() == 8);
    assert_eq!(CanFrame::new_remote(far, 9), None);
    let data = CanFrame::new(near, &[1, 2]).expect("two bytes");
    assert!(!data.is_extended() && !data.is_remote_frame());
    assert_eq!(data.bytes(), [1, 2, 0, 0, 0, 0, 0, 0]);
}

#[test]
fn the_position_of_an_object_is_that_in_the_list_of_entries() {
    for (at, entry) in DICTIONARY.entries().iter().enumerate() {
        assert_eq!(DICTIONARY.position(entry.address()), Some(at));
    }
    assert_eq!(DICTIONARY.position(Address::new(0x2001, 1)), None);
    let with_node_id = DICTIONARY.entries().iter().filter(|e| e.has_node_id());
    let addresses: Vec<_> = with_node_id.map(Entry::address).collect();
    assert_eq!(addresses, [Address::new(0x1400, 1)]);
}
