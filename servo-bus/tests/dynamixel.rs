//! The examples of <https://emanual.robotis.com/docs/en/dxl/protocol2/>, and the rules of the
//! control tables of the X series.

use servo_bus::dynamixel::{Error, Event, Packet, Server, encode, link};
use servo_bus::tables::{XL330_M288, XM430_W350, x};
use servo_bus::{BROADCAST, Bytes, Field};

fn servo(id: u8) -> Server {
    let mut servo = Server::new(&XM430_W350, id);
    // Those of the examples are XM430-W210.
    servo.memory.set(x::MODEL_NUMBER, 1030);
    servo.memory.set(x::FIRMWARE_VERSION, 38);
    servo
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

const DONE: &str = "FF FF FD 00 01 04 00 55 00 A1 0C";

#[test]
fn ping_read_and_write_are_as_in_the_examples() {
    let mut one = servo(1);
    let identity = "FF FF FD 00 01 07 00 55 00 06 04 26 65 5D";
    check(&mut one, "FF FF FD 00 01 03 00 01 19 4E", identity);
    let broadcast = "FF FF FD 00 FE 03 00 01 31 42";
    check(&mut one, broadcast, identity);
    check(
        &mut servo(2),
        broadcast,
        "FF FF FD 00 02 07 00 55 00 06 04 26 6F 6D",
    );
    one.memory.set(x::PRESENT_POSITION, 166);
    check(
        &mut one,
        "FF FF FD 00 01 07 00 02 84 00 04 00 1D 15",
        "FF FF FD 00 01 08 00 55 00 A6 00 00 00 8C C0",
    );
    check(
        &mut one,
        "FF FF FD 00 01 09 00 03 74 00 00 02 00 00 CA 89",
        DONE,
    );
    assert_eq!(one.memory.get(x::GOAL_POSITION), 512);
}

#[test]
fn a_registered_write_acts_at_the_action_as_in_the_examples() {
    let mut servo = servo(1);
    check(
        &mut servo,
        "FF FF FD 00 01 09 00 04 68 00 C8 00 00 00 AE 8E",
        DONE,
    );
    assert_eq!(
        (
            servo.memory.get(x::GOAL_VELOCITY),
            servo.memory.get(x::REGISTERED_INSTRUCTION)
        ),
        (0, 1)
    );
    let action = "FF FF FD 00 01 03 00 05 02 CE";
    check(&mut servo, action, DONE);
    assert_eq!(
        (
            servo.memory.get(x::GOAL_VELOCITY),
            servo.memory.get(x::REGISTERED_INSTRUCTION)
        ),
        (200, 0)
    );
    assert_eq!(
        error_of(&mut servo, &bytes(action)),
        Error::Instruction as u8
    );
}

#[test]
fn resets_reboot_clear_and_backup_are_as_in_the_examples() {
    let mut servo = servo(1);
    servo.memory.store(x::BAUD_RATE, 3);
    check(&mut servo, "FF FF FD 00 01 04 00 06 01 A1 E6", DONE);
    assert_eq!(
        (servo.memory.get(x::BAUD_RATE), servo.memory.get(x::ID)),
        (1, 1)
    );
    assert_eq!(servo.take_event(), Some(Event::Restart));
    check(&mut servo, "FF FF FD 00 01 03 00 08 2F 4E", DONE);
    assert_eq!(servo.take_event(), Some(Event::Restart));
    check(
        &mut servo,
        "FF FF FD 00 01 08 00 10 01 44 58 4C 22 B1 DC",
        DONE,
    );
    assert_eq!(servo.take_event(), Some(Event::ResetTurns));
    let (back_up, restore) = (
        "FF FF FD 00 01 08 00 20 01 43 54 52 4C 16 F5",
        // The example has 92 in place of 9E, which is not the CRC of its bytes.
        "FF FF FD 00 01 08 00 20 02 43 54 52 4C 9E F5",
    );
    servo.memory.store(x::HOMING_OFFSET, -77);
    check(&mut servo, back_up, DONE);
    servo.memory.store(x::HOMING_OFFSET, 5);
    check(&mut servo, restore, DONE);
    assert_eq!(servo.memory.get(x::HOMING_OFFSET), -77);
    servo.memory.set(x::TORQUE_ENABLE, 1);
    assert_eq!(error_of(&mut servo, &bytes(back_up)), Error::Result as u8);
}

#[test]
fn several_servos_are_read_and_written_as_in_the_examples() {
    let (mut one, mut two) = (servo(1), servo(2));
    one.memory.set(x::PRESENT_POSITION, 166);
    two.memory.set(x::PRESENT_POSITION, 2079);
    let read = "FF FF FD 00 FE 09 00 82 84 00 04 00 01 02 CE FA";
    check(
        &mut one,
        read,
        "FF FF FD 00 01 08 00 55 00 A6 00 00 00 8C C0",
    );
    check(
        &mut two,
        read,
        "FF FF FD 00 02 08 00 55 00 1F 08 00 00 BA BE",
    );
    let write = "FF FF FD 00 FE 11 00 83 74 00 04 00 01 96 00 00 00 02 AA 00 00 00 82 87";
    let bulk_write = "FF FF FD 00 FE 10 00 93 01 20 00 02 00 A0 00 02 1F 00 01 00 50 B7 68";
    for servo in [&mut one, &mut two] {
        check(servo, write, "");
        check(servo, bulk_write, "");
    }
    assert_eq!(
        (
            one.memory.get(x::GOAL_POSITION),
            two.memory.get(x::GOAL_POSITION)
        ),
        (150, 170)
    );
    assert_eq!(
        (
            one.memory.get(x::MAX_VOLTAGE_LIMIT),
            two.memory.get(x::TEMPERATURE_LIMIT)
        ),
        (160, 80)
    );
    one.memory.set(x::PRESENT_INPUT_VOLTAGE, 119);
    two.memory.set(x::PRESENT_TEMPERATURE, 36);
    let bulk = "FF FF FD 00 FE 0D 00 92 01 90 00 02 00 02 92 00 01 00 1A 05";
    check(&mut one, bulk, "FF FF FD 00 01 06 00 55 00 77 00 C3 69");
    check(&mut two, bulk, "FF FF FD 00 02 05 00 55 00 24 8B A9");
}

/// The packet that servos send together; the examples do not need a CRC of the instruction that is
/// right: that of the fast bulk read is not.
fn together(id: [u8; 3], set: [(Field, i32); 3], instruction: u8, parameters: &[u8]) -> Vec<u8> {
    let packet = encode(0xFE, instruction, &[parameters]);
    let mut crc = 0;
    let mut all = Vec::new();
    for (turn, (id, (field, value))) in id.into_iter().zip(set).enumerate() {
        let mut servo = servo(id);
        servo.memory.set(field, value);
        let mut answer = servo.receive(&packet).expect("an answer");
        assert_eq!((usize::from(answer.turn), answer.is_linked), (turn, true));
        crc = link(&mut answer.bytes, crc);
        all.extend_from_slice(&answer.bytes);
    }
    all
}

#[test]
fn fast_reads_have_one_packet_of_all_as_in_the_examples() {
    let position = |value| (x::PRESENT_POSITION, value);
    let sync = together(
        [3, 7, 4],
        [position(166), position(2079), position(1023)],
        0x8A,
        &[0x84, 0, 4, 0, 3, 7, 4],
    );
    assert_eq!(
        sync,
        bytes(
            "FF FF FD 00 FE 19 00 55 00 03 A6 00 00 00 84 08 00 07 1F 08 00 00 16 CA 00 04 FF 03 00 00 D1 9E"
        )
    );
    let set = [
        position(166),
        (x::PRESENT_PWM, 421),
        (x::PRESENT_TEMPERATURE, 31),
    ];
    let items = [3, 0x84, 0, 4, 0, 7, 0x7C, 0, 2, 0, 4, 0x92, 0, 1, 0];
    let bulk = together([3, 7, 4], set, 0x9A, &items);
    assert_eq!(
        bulk,
        bytes("FF FF FD 00 FE 14 00 55 00 03 A6 00 00 00 67 A4 00 07 A5 01 24 74 00 04 1F D9 C1")
    );
}

fn error_of(servo: &mut Server, packet: &[u8]) -> u8 {
    let answer = servo.receive(packet).expect("an answer");
    Packet::try_new(&answer.bytes).expect("a packet").body()[1]
}

fn written(servo: &mut Server, address: u16, data: &[u8]) -> u8 {
    error_of(servo, &encode(1, 3, &[&address.to_le_bytes(), data]))
}

#[test]
fn refused_writes_have_the_manuals_error_numbers_and_change_nothing() {
    let mut servo = servo(1);
    let before = servo.memory.clone();
    let cases: [(u16, &[u8], Error); 9] = [
        (132, &[0; 4], Error::Access),
        (700, &[0], Error::Access),
        (116, &[0; 2], Error::DataLength),
        (117, &[0; 3], Error::DataLength),
        (64, &[2], Error::DataRange),
        (11, &[2], Error::DataRange),
        // One beyond the limits of position, velocity and PWM.
        (116, &[0, 0x10, 0, 0], Error::DataLimit),
        (104, &[0x5F, 1, 0, 0], Error::DataLimit),
        // The first of two registers is right.
        (102, &[1, 0, 0x5F, 1, 0, 0], Error::DataLimit),
    ];
    for (address, data, error) in cases {
        assert_eq!(written(&mut servo, address, data), error as u8, "{address}");
        let (mut one, mut other) = ([0; 662], [0; 662]);
        servo.memory.read(0, &mut one);
        before.read(0, &mut other);
        assert_eq!(one, other, "{address}");
    }
    servo.memory.set(x::TORQUE_ENABLE, 1);
    assert_eq!(written(&mut servo, 11, &[3]), Error::Access as u8);
}

#[test]
fn an_expired_watchdog_refuses_goals_until_it_is_cleared() {
    let mut servo = servo(1);
    servo.memory.set(x::BUS_WATCHDOG, -1);
    assert_eq!(
        written(&mut servo, 104, &[1, 0, 0, 0]),
        Error::DataRange as u8
    );
    assert_eq!(written(&mut servo, 98, &[5]), Error::DataRange as u8);
    assert_eq!(written(&mut servo, 98, &[0]), 0);
    assert_eq!(written(&mut servo, 104, &[1, 0, 0, 0]), 0);
}

#[test]
fn a_shutdown_has_the_alert_bit_and_only_a_reboot_ends_it() {
    let mut servo = servo(1);
    servo.memory.set(x::HARDWARE_ERROR_STATUS, 0x20);
    assert_eq!(written(&mut servo, 64, &[1]), 0x80 | Error::Access as u8);
    assert_eq!(written(&mut servo, 64, &[0]), 0x80);
    check(&mut servo, "FF FF FD 00 01 03 00 08 2F 4E", DONE);
    assert_eq!(written(&mut servo, 64, &[1]), 0);
}

#[test]
fn indirect_data_are_the_registers_that_their_addresses_name() {
    for table in [&XL330_M288, &XM430_W350] {
        let mut servo = Server::new(table, 1);
        let (pointers, data, _) = table.indirect[0];
        // The manual's second example: the goal position behind data 2 to 5.
        for index in 0..4 {
            let address = (116 + index).to_owned();
            assert_eq!(
                written(&mut servo, pointers + 2 + 2 * index, &address.to_le_bytes()),
                0
            );
        }
        assert_eq!(written(&mut servo, data + 1, &[0, 4, 0, 0]), 0);
        assert_eq!(servo.memory.get(x::GOAL_POSITION), 1024);
        let mut read = [0; 4];
        servo.memory.read(data + 1, &mut read);
        assert_eq!(read, [0, 4, 0, 0]);
        // A part of it, and an address of the EEPROM.
        assert_eq!(
            written(&mut servo, data + 1, &[0, 4]),
            Error::DataLength as u8
        );
        assert_eq!(
            written(&mut servo, pointers, &[7, 0]),
            Error::DataRange as u8
        );
    }
}

#[test]
fn bytes_that_look_like_a_header_are_stuffed_and_restored() {
    let data = [0xFF, 0xFF, 0xFD, 0xFD, 0xFF, 0xFF, 0xFD];
    let packet = encode(1, 3, &[&data]);
    assert_eq!(
        packet[8..17],
        [0xFF, 0xFF, 0xFD, 0xFD, 0xFD, 0xFF, 0xFF, 0xFD, 0xFD]
    );
    let body: Bytes = Packet::try_new(&packet).expect("a packet").body();
    assert_eq!(body[1..], data);
}

#[test]
fn a_write_that_moves_its_own_pointers_to_a_refusal_changes_nothing() {
    let mut servo = Server::new(&XL330_M288, 1);
    let (pointers, data, number) = XL330_M288.indirect[0];
    // The LED, which may be written, and the state of the backup, which may not.
    let [led, backup] = [65u16, 147].map(u16::to_le_bytes);
    assert_eq!(written(&mut servo, pointers, &led), 0);
    let mut write = backup.repeat(usize::from(number));
    assert_eq!(pointers + write.len() as u16, data);
    write.push(1);
    assert_eq!(written(&mut servo, pointers, &write), Error::Access as u8);
    let mut read = [0; 2];
    servo.memory.read(pointers, &mut read);
    assert_eq!((read, servo.memory.get(x::LED)), (led, 0));
}

#[test]
fn a_fast_read_of_more_than_an_answer_holds_has_none() {
    let mut servo = servo(1);
    for (length, answers) in [(700u16, true), (701, false)] {
        let parameters: [&[u8]; 3] = [&[0, 0], &length.to_le_bytes(), &[1]];
        let answer = servo.receive(&encode(BROADCAST, 0x8A, &parameters));
        assert_eq!(answer.is_some(), answers, "{length}");
    }
}

#[test]
fn the_return_level_and_the_secondary_id_suppress_answers() {
    let mut servo = servo(1);
    servo.memory.set(x::SECONDARY_ID, 5);
    let packet = encode(5, 3, &[&[65, 0, 1]]);
    assert!(servo.receive(&packet).is_none());
    assert_eq!(servo.memory.get(x::LED), 1);
    for (level, expected) in [
        (0, [true, false, false]),
        (1, [true, true, false]),
        (2, [true; 3]),
    ] {
        servo.memory.set(x::STATUS_RETURN_LEVEL, level);
        let packets = [
            encode(1, 1, &[]),
            encode(1, 2, &[&[65, 0, 1, 0]]),
            encode(1, 3, &[&[65, 0, 0]]),
        ];
        assert_eq!(
            packets.map(|packet| servo.receive(&packet).is_some()),
            expected
        );
    }
}
