//! Any bytes: no panic, no register out of its range, and no change without a packet whose check
//! value is right.

use proptest::prelude::*;
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::Rng;
use servo_bus::tables::{SCS0009, STS3215, XL330_M288, XM430_W350};
use servo_bus::{Answer, Framing, Memory, Receiver, Table, dynamixel, feetech};

/// Bytes of the seeded stream of each protocol.
const STREAM_BYTES: usize = 10_000_000;

/// A server of either protocol.
trait Servo {
    type Framing: Framing;
    fn new(table: &'static Table) -> Self;
    fn receive(&mut self, packet: &[u8]) -> Option<Answer>;
    fn memory(&mut self) -> &mut Memory;
    /// Whether a packet's check value is right, computed otherwise than in the crate.
    fn is_right(packet: &[u8]) -> bool;
    /// A packet with these contents.
    fn packet(id: u8, code: u8, parameters: &[u8]) -> Vec<u8>;
    const CODES: &'static [u8];
}

impl Servo for feetech::Server {
    type Framing = feetech::Framing;
    fn new(table: &'static Table) -> Self {
        Self::new(table, 1)
    }
    fn receive(&mut self, packet: &[u8]) -> Option<Answer> {
        self.receive(packet)
    }
    fn memory(&mut self) -> &mut Memory {
        &mut self.memory
    }
    fn is_right(packet: &[u8]) -> bool {
        let sum: u32 = packet[2..].iter().map(|byte| u32::from(*byte)).sum();
        sum % 256 == 255 && usize::from(packet[3]) == packet.len() - 4
    }
    fn packet(id: u8, code: u8, parameters: &[u8]) -> Vec<u8> {
        feetech::encode(id, code, parameters).to_vec()
    }
    const CODES: &'static [u8] = &[1, 2, 3, 4, 5, 6, 8, 9, 10, 11, 0x82, 0x83, 0x7F];
}

impl Servo for dynamixel::Server {
    type Framing = dynamixel::Framing;
    fn new(table: &'static Table) -> Self {
        Self::new(table, 1)
    }
    fn receive(&mut self, packet: &[u8]) -> Option<Answer> {
        self.receive(packet)
    }
    fn memory(&mut self) -> &mut Memory {
        &mut self.memory
    }
    /// The remainder of the whole packet, its CRC with the high byte first, is 0.
    fn is_right(packet: &[u8]) -> bool {
        let (body, sum) = packet.split_at(packet.len() - 2);
        let mut remainder = 0u32;
        for byte in body.iter().chain([&sum[1], &sum[0]]) {
            for bit in (0..8).rev() {
                remainder = remainder << 1 | u32::from(byte >> bit & 1);
                if remainder & 0x1_0000 != 0 {
                    remainder ^= 0x1_8005;
                }
            }
        }
        remainder == 0
    }
    fn packet(id: u8, code: u8, parameters: &[u8]) -> Vec<u8> {
        dynamixel::encode(id, code, &[parameters]).to_vec()
    }
    const CODES: &'static [u8] = &[
        1, 2, 3, 4, 5, 6, 8, 16, 32, 0x82, 0x83, 0x8A, 0x92, 0x93, 0x9A, 0x55, 0x7F,
    ];
}

fn image(memory: &Memory) -> [u8; 662] {
    let mut bytes = [0; 662];
    memory.read(0, &mut bytes);
    bytes
}

/// Feeds bytes, and checks what they change.
fn feed<S: Servo>(servo: &mut S, receiver: &mut Receiver<S::Framing>, bytes: &[u8]) {
    for byte in bytes {
        receiver.push(*byte);
        while let Some(packet) = receiver.next_packet() {
            assert!(S::is_right(packet), "{packet:x?}");
            if let Some(answer) = servo.receive(packet).filter(|answer| !answer.is_linked) {
                assert!(S::is_right(&answer.bytes), "{packet:x?}");
            }
        }
    }
    let memory = servo.memory();
    for register in memory.table().registers {
        let value = memory.get(register.field);
        assert!(
            (register.min..=register.max).contains(&value),
            "{}: {value}",
            register.name
        );
    }
}

/// A packet with random contents, among them those that write.
fn packet<S: Servo>(random: &mut Pcg64Mcg) -> Vec<u8> {
    let mut below = |end: u32| (random.next_u32() % end) as u8;
    let (id, code) = (
        [1, 1, 0xFE, 2][usize::from(below(4))],
        S::CODES[usize::from(below(S::CODES.len() as u32))],
    );
    let parameters: Vec<u8> = (0..below(12))
        .map(|_| [below(256), below(140), below(5)][usize::from(below(3))])
        .collect();
    S::packet(id, code, &parameters)
}

fn mutate(bytes: &mut Vec<u8>, random: &mut Pcg64Mcg) {
    let place = random.next_u32() as usize % bytes.len();
    match random.next_u32() % 4 {
        0 => bytes[place] ^= 1 << (random.next_u32() % 8),
        1 => drop(bytes.remove(place)),
        2 => bytes.insert(place, random.next_u32() as u8),
        _ => bytes.truncate(place),
    }
}

fn mutated_streams<S: Servo>(table: &'static Table) {
    let mut random = Pcg64Mcg::new(0x5e77_0b05);
    let (mut servo, mut receiver) = (S::new(table), Receiver::default());
    let mut fed = 0;
    while fed < STREAM_BYTES {
        let mut bytes = packet::<S>(&mut random);
        let times = random.next_u32() % 3;
        for _ in 0..times {
            if !bytes.is_empty() {
                mutate(&mut bytes, &mut random);
            }
        }
        feed(&mut servo, &mut receiver, &bytes);
        fed += bytes.len().max(1);
        // A new ID would end the test.
        let id = table
            .registers
            .iter()
            .find(|register| register.name == "id")
            .expect("an ID");
        servo.memory().store(id.field, 1);
    }
}

#[test]
fn ten_million_mutated_bytes_write_nothing_that_is_not_valid() {
    std::thread::scope(|scope| {
        scope.spawn(|| mutated_streams::<feetech::Server>(&STS3215));
        scope.spawn(|| mutated_streams::<dynamixel::Server>(&XM430_W350));
    });
}

/// A damaged write that is not repaired by chance changes nothing, and the packet behind it is
/// found.
fn damage<S: Servo>(table: &'static Table, place: usize, flip: u8, write: &[u8], ping: &[u8]) {
    let (mut servo, mut receiver) = (S::new(table), Receiver::default());
    let mut damaged = write.to_vec();
    let place = place % damaged.len();
    damaged[place] ^= flip;
    let before = image(servo.memory());
    feed(&mut servo, &mut receiver, &damaged);
    assert_eq!(image(servo.memory()), before);
    // More than the longest packet that the damaged length can announce.
    let mut answers = 0;
    for byte in ping.iter().cycle().take(1100) {
        receiver.push(*byte);
        while let Some(packet) = receiver.next_packet() {
            answers += usize::from(servo.receive(packet).is_some());
        }
    }
    assert!(answers > 0);
}

proptest! {
    #[test]
    fn any_bytes_leave_every_register_in_its_range(bytes in proptest::collection::vec(any::<u8>(), 0..2000)) {
        for table in [&STS3215, &SCS0009] {
            feed(&mut <feetech::Server as Servo>::new(table), &mut Receiver::default(), &bytes);
        }
        for table in [&XL330_M288, &XM430_W350] {
            feed(&mut <dynamixel::Server as Servo>::new(table), &mut Receiver::default(), &bytes);
        }
    }

    #[test]
    fn any_parameters_leave_every_register_in_its_range(
        code in any::<u8>(), parameters in proptest::collection::vec(any::<u8>(), 0..250)
    ) {
        for table in [&STS3215, &SCS0009] {
            let packet = feetech::encode(1, code, &parameters);
            feed(&mut <feetech::Server as Servo>::new(table), &mut Receiver::default(), &packet);
        }
        for table in [&XL330_M288, &XM430_W350] {
            let packet = dynamixel::encode(1, code, &[&parameters]);
            feed(&mut <dynamixel::Server as Servo>::new(table), &mut Receiver::default(), &packet);
        }
    }

    #[test]
    fn a_flipped_byte_makes_a_write_void(place in any::<usize>(), flip in 1..=u8::MAX, value in any::<[u8; 2]>()) {
        let [low, high] = value;
        let write = feetech::encode(1, 3, &[42, low, high]);
        damage::<feetech::Server>(&STS3215, place, flip, &write, &feetech::encode(1, 1, &[]));
        let write = dynamixel::encode(1, 3, &[&[100, 0, low, high & 1]]);
        damage::<dynamixel::Server>(&XM430_W350, place, flip, &write, &dynamixel::encode(1, 1, &[]));
    }
}
