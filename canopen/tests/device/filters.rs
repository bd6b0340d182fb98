//! Acceptance filtering: the node needs only the identifiers that it lists.

use canopen::CanFrame;
use embedded_can::{ExtendedId, Id, StandardId};

use crate::bench::Bench;

fn standard(id: u16) -> Id {
    StandardId::new(id).expect("11 bits").into()
}

fn identifiers(bench: &Bench) -> Vec<(Id, bool)> {
    bench.node.identifiers().collect()
}

/// A node with COB-IDs other than the defaults.
fn reconfigured() -> Bench {
    let mut bench = Bench::operational();
    for (index, sub, value) in [
        (0x1005, 0, 0x2000_0090),
        (0x1012, 0, 0x190),
        (0x1012, 0, 0x8000_0190),
        (0x1016, 2, 9 << 16 | 500),
        (0x1401, 1, 0x8000_0301),
        (0x1401, 1, 0x2012_3456),
        (0x1800, 1, 0xC000_0185),
        (0x1800, 1, 0x0000_01A1),
    ] {
        let done = bench.write_u32(index, sub, value);
        assert_eq!(done, Ok(()), "{index:x}:{sub} = {value:x}");
    }
    bench
}

#[test]
fn the_identifiers_follow_the_configured_cob_ids() {
    let bench = reconfigured();
    let far = |id| Id::Extended(ExtendedId::new(id).expect("29 bits"));
    let mut found = identifiers(&bench);
    let mut expected = vec![
        (standard(0x7E5), false),
        (standard(0), false),
        (standard(0x605), false),
        (far(0x90), false),
        (standard(0x190), false),
        (standard(0x709), false),
        (standard(0x205), false),
        (far(0x12_3456), false),
        (standard(0x1A1), true),
    ];
    let key = |(id, remote): &(Id, bool)| format!("{id:?} {remote}");
    found.sort_by_key(key);
    expected.sort_by_key(key);
    assert_eq!(found, expected);
}

#[test]
fn a_node_without_a_node_id_receives_lss_only() {
    let identifiers = identifiers(&Bench::powered_on(None));
    assert!(identifiers.contains(&(standard(0x7E5), false)));
    assert!(!identifiers.contains(&(standard(0), false)));
}

/// Sends a frame outside the listed identifiers: the node neither changes nor responds.
fn is_ignored(bench: &mut Bench, frame: &CanFrame) {
    let before = format!("{:?}", bench.node);
    let answers = bench.receive(frame);
    assert!(answers.is_empty(), "{frame:?}: {answers:x?}");
    assert_eq!(format!("{:?}", bench.node), before, "{frame:?}");
}

#[test]
fn a_frame_outside_the_identifiers_changes_nothing() {
    let mut bench = reconfigured();
    let identifiers = identifiers(&bench);
    let number = |id: &Id| match id {
        Id::Standard(id) => (u32::from(id.as_raw()), false),
        Id::Extended(id) => (id.as_raw(), true),
    };
    let named: Vec<_> = identifiers.iter().map(|(id, r)| (number(id), *r)).collect();
    // All 11-bit identifiers; of the 29-bit identifiers those with the services' 11-bit values and
    // the neighbours of the configured one.
    let ids = (0..0x800).flat_map(|id| [(id, false), (id, true)]);
    let ids = ids.chain([(0x12_3455, true), (0x12_3457, true)]);
    let mut ignored = 0;
    for id in ids {
        for remote in [false, true] {
            if named.contains(&(id, remote)) {
                continue;
            }
            for (length, data) in [(8, [0x40; 8]), (2, [1, 5, 0, 0, 0, 0, 0, 0]), (0, [0; 8])] {
                let frame = CanFrame::raw(id.0, id.1, remote, length, data).expect("a frame");
                is_ignored(&mut bench, &frame);
                ignored += 1;
            }
        }
    }
    assert!(ignored > 24_000, "{ignored}");
}

#[test]
fn the_list_reaches_the_last_tpdo_of_any_number_of_pdos() {
    use canopen::{Node, NodeId, SERVICE_IDENTIFIERS, dictionary::Address};
    // LSS, NMT, SDO, SYNC and TIME, and eight producers of heartbeats.
    assert_eq!(SERVICE_IDENTIFIERS, 5 + 8);
    let mut device = crate::device::Device::new();
    device.stored.insert(Address::new(0x1801, 1), 0x285);
    let dictionary = &crate::dictionary::DICTIONARY;
    let last = (standard(0x285), true);
    let node = Node::<1, 2>::new(dictionary, NodeId::new(5), &mut device, 0);
    assert!(node.identifiers().any(|accepted| accepted == last));
    let node = Node::<0, 2>::new(dictionary, NodeId::new(5), &mut device, 0);
    assert!(node.identifiers().any(|accepted| accepted == last));
}
