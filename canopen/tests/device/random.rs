//! Random and nearly valid frames: the node does not panic and still responds.

use canopen::CanFrame;
use proptest::prelude::*;

use crate::bench::Bench;

/// Identifiers that the node receives, and any others.
fn identifier() -> impl Strategy<Value = u32> {
    prop_oneof![
        8 => Just(0x605_u32),
        2 => prop::sample::select(vec![0x000_u32, 0x080, 0x100, 0x205, 0x305, 0x185, 0x285, 0x7E5, 0x705, 0x709]),
        1 => 0..0x800_u32,
    ]
}

/// Bytes in which commands, indices and sub-indices of existing objects are likely.
fn payload() -> impl Strategy<Value = [u8; 8]> {
    let command = prop_oneof![
        3 => prop::sample::select(vec![
            0x23_u8, 0x2B, 0x2F, 0x21, 0x40, 0x60, 0x70, 0x00, 0x10, 0x01, 0xA0, 0xA4, 0xA1, 0xA2,
            0xA3, 0xC0, 0xC2, 0xC6, 0xC1, 0x80, 0x81, 0x04, 0x11, 0x13, 0x15, 0x51,
        ]),
        1 => any::<u8>(),
    ];
    let index = prop_oneof![
        4 => prop::sample::select(crate::dictionary::DICTIONARY.entries().iter().map(|row| row.address()).collect::<Vec<_>>()),
        1 => (any::<u16>(), any::<u8>()).prop_map(|(index, sub)| canopen::dictionary::Address::new(index, sub)),
    ];
    (command, index, any::<[u8; 4]>(), 0..8_u8).prop_map(|(command, address, rest, small)| {
        let [low, high] = address.index.to_le_bytes();
        let [a, b, c, d] = if small < 4 {
            [small, 0, 0, rest[0] & 0xC0]
        } else {
            rest
        };
        [command, low, high, address.sub, a, b, c, d]
    })
}

#[derive(Clone, Debug)]
enum Step {
    Frame(CanFrame),
    Wait(u64),
}

fn step() -> impl Strategy<Value = Step> {
    let frame = (identifier(), any::<u8>(), 0..=8_u8, payload()).prop_filter_map(
        "a frame",
        |(id, kind, length, data)| {
            let length = if kind < 200 { 8 } else { length };
            CanFrame::raw(id, kind == 255, kind == 254, length, data).map(Step::Frame)
        },
    );
    prop_oneof![20 => frame, 1 => (0..2_000_000_u64).prop_map(Step::Wait)]
}

/// After reset communication node 5 boots up and responds.
fn still_answers(mut bench: Bench) {
    bench.run_ms(2_000);
    let id = bench.node.node_id().map_or(5, canopen::NodeId::get);
    bench.send(0, &[129, id]);
    let id = bench.node.node_id().expect("a node-ID");
    // LSS may have changed the bit rate with a long delay.
    bench.wait_us(200_000_000);
    bench.wait_us(200_000_000);
    let answer = bench.send(0x600 + u16::from(id.get()), &[0x40, 0, 0x10, 0, 0, 0, 0, 0]);
    assert!(
        answer.contains(&(
            0x580 + u32::from(id.get()),
            vec![0x43, 0, 0x10, 0, 0x92, 1, 2, 0]
        )),
        "{answer:?}"
    );
}

fn run(steps: Vec<Step>) -> Result<(), TestCaseError> {
    let mut bench = Bench::operational();
    bench.device.domain = vec![1; 100];
    for step in steps {
        match step {
            // LSS may leave the node without a node-ID, which this test does not cover.
            Step::Frame(frame) if embedded_can::Frame::data(&frame).starts_with(&[0x11, 255]) => {}
            Step::Frame(frame) => drop(bench.receive(&frame)),
            Step::Wait(time_us) => drop(bench.wait_us(time_us)),
        }
        let limit = |sub| bench.device.number(0x607D, sub) as i64;
        prop_assert!(limit(1) <= limit(2));
        prop_assert!(bench.device.number(0x2000, 0) <= 2);
        prop_assert!((bench.device.number(0x2001, 0) as i64).abs() <= 1000);
        let real = f32::from_bits(bench.device.number(0x2003, 0) as u32);
        prop_assert!(real.abs() <= 1.5);
    }
    still_answers(bench);
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn random_frames_do_not_disable_the_node(steps in prop::collection::vec(step(), 1..300)) {
        run(steps)?;
    }
}
