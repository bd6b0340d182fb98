//! Several servos on one line answer in turn.

use ::servo_bus::{dynamixel, feetech};

use super::*;

/// Servos on one line: the answers in their order, each heard by all others.
fn on_a_line(servos: &mut [ServoBus], request: &[u8]) -> Vec<u8> {
    let (mut line, mut buffer) = (Vec::new(), [0; 1024]);
    let mut waits: Vec<Option<u32>> = servos.iter_mut().map(|it| it.receive(request)).collect();
    loop {
        let next = (0..servos.len()).filter(|at| waits[*at].is_some());
        let Some(next) = next.min_by_key(|at| waits[*at]) else {
            return line;
        };
        let passed = waits[next].unwrap_or(0);
        waits.iter_mut().flatten().for_each(|wait| *wait -= passed);
        match servos[next].elapsed() {
            Elapsed::Wait(us) => waits[next] = Some(us),
            Elapsed::Silence => waits[next] = None,
            Elapsed::Transmit => {
                let length = servos[next].take_answer(&mut buffer);
                line.extend_from_slice(&buffer[..length]);
                for at in 0..servos.len() {
                    waits[at] = match at == next {
                        true => None,
                        false => servos[at].receive(&buffer[..length]),
                    };
                }
            }
        }
    }
}

fn line(model: ServoModel, ids: &[u8]) -> Vec<ServoBus> {
    let of = |id: &u8| ServoBus::new(&StoredParameters::DEFAULT.with_servo_bus(model, *id));
    ids.iter().map(|id| of(id).expect("a servo")).collect()
}

#[test]
fn servos_answer_in_turn_also_where_one_is_missing() {
    let mut servos = line(ServoModel::Sts3215, &[1, 2, 4]);
    let read = feetech::encode(0xFE, 0x82, &[5, 1, 4, 3, 1, 2]);
    // Time for a servo before it that is missing, us.
    let waits = servos.iter_mut().map(|it| it.receive(&read));
    assert_eq!(waits.collect::<Vec<_>>(), [2_000, 2_000, 500].map(Some));
    let mut servos = line(ServoModel::Sts3215, &[1, 2, 4]);
    let expected = [4, 1, 2].map(|id| feetech::encode(id, 0, &[id]).to_vec());
    assert_eq!(on_a_line(&mut servos, &read), expected.concat());
    let ping = feetech::encode(0xFE, 1, &[]);
    let expected = [1, 2, 4].map(|id| feetech::encode(id, 0, &[]).to_vec());
    assert_eq!(on_a_line(&mut servos, &ping), expected.concat());
}

#[test]
fn a_fast_read_is_one_packet_of_all_servos_and_ends_at_one_that_is_missing() {
    let mut servos = line(ServoModel::Xl330M288, &[1, 2, 3]);
    let read = |ids: &[u8]| dynamixel::encode(0xFE, 0x8A, &[&[7, 0, 1, 0], ids]);
    let bytes = on_a_line(&mut servos, &read(&[2, 1, 3]));
    let packet = dynamixel::Packet::try_new(&bytes).expect("one packet");
    // Status, then error, ID and value of each, with a CRC between them.
    let body = packet.body();
    assert_eq!(
        (body[0], &body[1..4], &body[6..9]),
        (0x55, &[0, 2, 2][..], &[0, 1, 1][..])
    );
    assert_eq!(body[11..14], [0, 3, 3]);
    // Longer than an instruction, again and again: nothing of a packet remains.
    let long = dynamixel::encode(0xFE, 0x8A, &[&[124, 0, 24, 0], &[1, 2, 3]]);
    for _ in 0..3 {
        let bytes = on_a_line(&mut servos, &long);
        assert!(dynamixel::Packet::try_new(&bytes).is_some());
        assert_eq!(bytes.len(), 8 + 3 * (2 + 24 + 2));
    }
    // ID 9 is missing: the servo behind it has nothing to continue.
    let bytes = on_a_line(&mut servos, &read(&[2, 9, 3]));
    assert_eq!(bytes[8..11], [0, 2, 2]);
    assert_eq!(bytes.len(), 8 + 3 + 2);
}
