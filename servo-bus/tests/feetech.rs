//! The examples of *Servo SCS Communication Protocol* (doc.feetech.cn, sections 4.1 to 4.9), and
//! the rules of the memory tables.

use servo_bus::feetech::{Event, Instruction, Packet, Server};
use servo_bus::tables::{SCS0009, STS3215, sts};

fn servo(id: u8) -> Server {
    Server::new(&STS3215, id)
}

fn bytes(text: &str) -> Vec<u8> {
    let parse = |byte| u8::from_str_radix(byte, 16).expect("hexadecimal");
    text.split_whitespace().map(parse).collect()
}

#[track_caller]
fn check(servo: &mut Server, instruction: &str, answer: &str) {
    let answered = servo.receive(&bytes(instruction));
    let answered = answered.map_or(Vec::new(), |answer| answer.bytes.to_vec());
    assert_eq!(answered, bytes(answer));
}

#[test]
fn examples_1_to_6_of_the_manual_have_its_answers() {
    let mut one = servo(1);
    check(&mut one, "FF FF 01 02 01 FB", "FF FF 01 02 00 FC");
    one.memory.set(sts::PRESENT_POSITION, 1304);
    check(
        &mut one,
        "FF FF 01 04 02 38 02 BE",
        "FF FF 01 04 00 18 05 DD",
    );
    let mut other = servo(7);
    check(&mut other, "FF FF FE 04 03 05 01 F4", "");
    assert_eq!(other.memory.get(sts::ID), 1);
    check(
        &mut one,
        "FF FF 01 09 03 2A 00 08 00 00 E8 03 D5",
        "FF FF 01 02 00 FC",
    );
    let goals = |servo: &Server| {
        [sts::GOAL_POSITION, sts::GOAL_TIME, sts::GOAL_VELOCITY].map(|f| servo.memory.get(f))
    };
    assert_eq!(goals(&one), [2048, 0, 1000]);
    let mut ten = servo(10);
    check(
        &mut ten,
        "FF FF 0A 09 04 2A 00 08 00 00 E8 03 CB",
        "FF FF 0A 02 00 F3",
    );
    assert_eq!(
        (goals(&ten), ten.memory.get(sts::REGISTERED)),
        ([0, 0, 0], 1)
    );
    check(&mut ten, "FF FF FE 02 05 FA", "");
    assert_eq!(
        (goals(&ten), ten.memory.get(sts::REGISTERED)),
        ([2048, 0, 1000], 0)
    );
}

#[test]
fn examples_7_and_8_write_and_read_several_servos_in_one_instruction() {
    let write = "FF FF FE 20 83 2A 06 01 00 08 00 00 E8 03 02 00 08 00 00 E8 03 03 00 08 00 00 E8 03 \
                 04 00 08 00 00 E8 03 58";
    for id in 1..=5 {
        let mut servo = servo(id);
        check(&mut servo, write, "");
        let expected = if id == 5 { 0 } else { 2048 };
        assert_eq!(servo.memory.get(sts::GOAL_POSITION), expected, "{id}");
    }
    let read = "FF FF FE 06 82 38 08 01 02 36";
    let present = [
        (1, 2048, 30, "FF FF 01 0A 00 00 08 00 00 00 00 79 1E 55"),
        (2, 2047, 35, "FF FF 02 0A 00 FF 07 00 00 00 00 77 23 53"),
    ];
    for (id, position, temperature, answer) in present {
        let mut servo = servo(id);
        servo.memory.set(sts::PRESENT_POSITION, position);
        servo
            .memory
            .set(sts::PRESENT_VOLTAGE, 123 - 2 * i32::from(id));
        servo.memory.set(sts::PRESENT_TEMPERATURE, temperature);
        let answered = servo.receive(&bytes(read)).expect("an answer");
        assert_eq!(
            (answered.turn, answered.bytes.to_vec()),
            (id - 1, bytes(answer))
        );
    }
}

#[test]
fn examples_9_to_11_reset_the_turns_and_calibrate() {
    let mut servo = servo(1);
    check(&mut servo, "FF FF 01 02 0A F2", "FF FF 01 02 00 FC");
    assert_eq!(servo.take_event(), Some(Event::ResetTurns));
    check(&mut servo, "FF FF 01 02 0B F1", "FF FF 01 02 00 FC");
    assert_eq!(servo.take_event(), Some(Event::Calibrate(2048)));
    check(&mut servo, "FF FF 01 04 0B 00 04 EB", "FF FF 01 02 00 FC");
    assert_eq!(servo.take_event(), Some(Event::Calibrate(1024)));
}

#[test]
fn the_lock_decides_whether_a_write_outlives_a_restart_and_recovery_keeps_the_id() {
    let mut servo = servo(3);
    // P := 16, with the lock closed, open; then a restart.
    let write_p = "FF FF 03 04 03 15 10 D0";
    for (lock, left) in [(1, 32), (0, 16)] {
        servo.memory.set(sts::LOCK, lock);
        check(&mut servo, write_p, "FF FF 03 02 00 FA");
        assert_eq!(servo.memory.get(sts::P_COEFFICIENT), 16);
        check(&mut servo, "FF FF 03 02 08 F2", "FF FF 03 02 00 FA");
        assert_eq!(servo.memory.get(sts::P_COEFFICIENT), left);
        assert_eq!(servo.take_event(), Some(Event::Restart));
    }
    check(&mut servo, "FF FF 03 02 06 F4", "FF FF 03 02 00 FA");
    assert_eq!(servo.memory.get(sts::P_COEFFICIENT), 32);
    assert_eq!(servo.memory.get(sts::ID), 3);
}

#[test]
fn the_response_level_suppresses_answers_but_those_to_ping_and_read() {
    let mut servo = servo(1);
    servo.memory.set(sts::RESPONSE_LEVEL, 0);
    check(&mut servo, "FF FF 01 04 03 15 10 D2", "");
    check(&mut servo, "FF FF 01 02 01 FB", "FF FF 01 02 00 FC");
    check(
        &mut servo,
        "FF FF 01 04 02 15 01 E2",
        "FF FF 01 03 00 10 EB",
    );
}

#[test]
fn a_value_out_of_range_and_a_register_to_read_keep_their_values() {
    let mut servo = servo(1);
    // Mode 4; position 1000 to the present position.
    check(&mut servo, "FF FF 01 04 03 21 04 D2", "FF FF 01 02 00 FC");
    check(
        &mut servo,
        "FF FF 01 05 03 38 E8 03 D3",
        "FF FF 01 02 00 FC",
    );
    assert_eq!(servo.memory.get(sts::OPERATING_MODE), 0);
    assert_eq!(servo.memory.get(sts::PRESENT_POSITION), 0);
}

#[test]
fn magnitudes_have_their_sign_in_the_bit_of_the_table() {
    let mut servo = servo(1);
    for (field, value, raw) in [
        (sts::HOMING_OFFSET, -2047, [0xFF, 0x0F]),
        (sts::GOAL_VELOCITY, -1000, [0xE8, 0x83]),
        (sts::PRESENT_LOAD, -500, [0xF4, 0x05]),
    ] {
        servo.memory.set(field, value);
        let mut read = [0; 2];
        servo.memory.read(field.address, &mut read);
        assert_eq!((read, servo.memory.get(field)), (raw, value));
    }
}

#[test]
fn servos_with_potentiometers_have_the_high_byte_first() {
    let mut servo = Server::new(&SCS0009, 1);
    check(
        &mut servo,
        "FF FF 01 04 02 03 02 F3",
        "FF FF 01 04 00 05 04 F1",
    );
    check(
        &mut servo,
        "FF FF 01 05 03 2A 01 FF CC",
        "FF FF 01 02 00 FC",
    );
    assert_eq!(servo.memory.get(servo_bus::tables::scs::GOAL_POSITION), 511);
}

#[test]
fn parameters_that_do_not_fit_are_no_instruction() {
    for (code, parameters) in [
        (1, &[0][..]),
        (2, &[1]),
        (3, &[5]),
        (0x83, &[42, 2, 1, 0]),
        (0x83, &[42, 0, 1]),
        (0x82, &[56, 8]),
        (0x55, &[]),
    ] {
        let packet = servo_bus::feetech::encode(1, code, parameters);
        let packet = Packet::try_new(&packet).expect("a packet");
        assert_eq!(Instruction::parse(packet), None, "{code:x} {parameters:?}");
    }
}
