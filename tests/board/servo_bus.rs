//! The board as a servo on the serial bus, at USART1 of both chips.

use board_tests::chain::saved;
use board_tests::program::run_script;
use firmware::drive::{ServoMaker, ServoModel, StoredParameters};
use servo_bus::tables::{sts, x};
use servo_bus::{Field, Order, dynamixel, feetech};
use virtual_board::board::ChipKind;
use virtual_board::run::{Flow, Options, Script, View};

/// Time of a byte at 1 Mbit/s, ns.
const BYTE_NS: u64 = 10_000;

/// A master: what it sends at these PWM edges, ms, and each byte that it receives, with its end.
struct Bus {
    requests: Vec<(u64, Vec<u8>)>,
    edges: u64,
    sent_ns: Vec<u64>,
    received: Vec<(u64, u8)>,
    angle_deg: f64,
}

impl Script for Bus {
    fn at_edge(&mut self, view: &mut View<'_>) -> Flow {
        self.edges += 1;
        self.angle_deg = view.row.angle_deg;
        let now_ns = view.now_ns();
        let line = view.servo_bus().expect("a line");
        if let Some((_, bytes)) = self.requests.iter().find(|(ms, _)| *ms == self.edges) {
            line.send(now_ns, bytes);
            self.sent_ns.push(now_ns);
        }
        Flow::Continue
    }

    fn at_poll(&mut self, view: &mut View<'_>) -> Flow {
        let line = view.servo_bus().expect("a line");
        self.received.extend(line.take_received());
        Flow::Continue
    }
}

impl Bus {
    /// The answer to each request: the end of its first byte, and its bytes.
    fn answers(&self) -> Vec<(u64, Vec<u8>)> {
        let ends = self.sent_ns.iter().skip(1).copied().chain([u64::MAX]);
        let answer = |(from, to): (&u64, u64)| {
            let within = |(at, _): &&(u64, u8)| (*from..to).contains(at);
            let bytes: Vec<_> = self.received.iter().filter(within).collect();
            let first_ns = bytes.first().map_or(0, |(at, _)| *at);
            (first_ns, bytes.iter().map(|(_, byte)| *byte).collect())
        };
        self.sent_ns.iter().zip(ends).map(answer).collect()
    }
}

/// The board as this servo, with the ID 1, for some time.
fn run(model: ServoModel, ms: u64, requests: Vec<(u64, Vec<u8>)>) -> Bus {
    let chip = match model.maker() {
        ServoMaker::Feetech => ChipKind::F427,
        ServoMaker::Robotis => ChipKind::H743,
    };
    let options = Options {
        chip,
        contents: vec![saved(&StoredParameters::DEFAULT.with_servo_bus(model, 1))],
        polls_at_stops: true,
        ..Options::for_ms(ms)
    };
    let bus = Bus {
        requests,
        edges: 0,
        sent_ns: Vec::new(),
        received: Vec::new(),
        angle_deg: 0.0,
    };
    run_script(options, bus).script
}

fn write(model: ServoModel, field: Field, value: i32) -> Vec<u8> {
    let data = field.encode(value, Order::Little);
    let (data, address) = (
        &data[..usize::from(field.size)],
        field.address.to_le_bytes(),
    );
    match model.maker() {
        ServoMaker::Feetech => feetech::encode(1, 3, &[&address[..1], data].concat()).to_vec(),
        ServoMaker::Robotis => dynamixel::encode(1, 3, &[&address, data]).to_vec(),
    }
}

/// How long behind a ping of 10 bits a byte the first bit of its answer begins, ns: least and most.
/// The table is set up by requests before.
fn latency(model: ServoModel, byte_ns: u64, before: Vec<Vec<u8>>) -> (u64, u64) {
    let (ping, answer) = match model.maker() {
        ServoMaker::Feetech => (feetech::encode(1, 1, &[]), feetech::encode(1, 0, &[])),
        ServoMaker::Robotis => {
            let identity = [0, 0xB0, 0x04, 46];
            (
                dynamixel::encode(1, 1, &[]),
                dynamixel::encode(1, 0x55, &[&identity]),
            )
        }
    };
    let count = before.len();
    let mut requests: Vec<_> = (0..)
        .zip(before)
        .map(|(at, it)| (100 + 40 * at, it))
        .collect();
    // In each of the four PWM periods, beside steps of the loop and cycles of the communication.
    requests.extend((0..120).map(|index| (260 + 3 * index, ping.to_vec())));
    let bus = run(model, 700, requests);
    let request_ns = ping.len() as u64 * byte_ns;
    let (mut least, mut most) = (u64::MAX, 0);
    for ((first_ns, bytes), sent_ns) in bus.answers().iter().zip(&bus.sent_ns).skip(count) {
        assert_eq!(bytes[..], answer[..], "{model:?} at {sent_ns} ns");
        let latency_ns = first_ns - byte_ns - sent_ns - request_ns;
        (least, most) = (least.min(latency_ns), most.max(latency_ns));
    }
    println!(
        "{model:?}, {byte_ns} ns a byte: answers begin {least} to {most} ns behind the request"
    );
    (least, most)
}

#[test]
fn an_answer_begins_within_100_us_and_the_return_delay() {
    let sts = ServoModel::Sts3215;
    let no_delay = |model, field| write(model, field, 0);
    let (_, most) = latency(sts, BYTE_NS, vec![no_delay(sts, sts::RETURN_DELAY_TIME)]);
    assert!(most < 100_000, "{most} ns");
    let xl = ServoModel::Xl330M288;
    // The third and the fifth of the XL330's rates: 1 and 3 Mbit/s.
    for (rate, byte_ns) in [(3, BYTE_NS), (5, BYTE_NS / 3)] {
        let before = vec![
            write(xl, x::BAUD_RATE, rate),
            no_delay(xl, x::RETURN_DELAY_TIME),
        ];
        let (_, most) = latency(xl, byte_ns, before);
        assert!(most < 100_000, "{most} ns");
    }
    let (least, most) = latency(sts, BYTE_NS, vec![]);
    // 250 times 2 us.
    assert!(least > 500_000 && most < 600_000, "{least} to {most} ns");
}

#[test]
fn long_packets_at_3_mbit_s_are_received_whole() {
    let xl = ServoModel::Xl330M288;
    // To the registers from 84 on of another servo and of this one, 400 bytes.
    let others: Vec<u8> = (2..100).flat_map(|id| [id, 1, 2]).collect();
    let gain = |value: u16| {
        let own = [1, value as u8, (value >> 8) as u8];
        dynamixel::encode(0xFE, 0x83, &[&[84, 0, 2, 0], &others, &own]).to_vec()
    };
    let read = dynamixel::encode(1, 2, &[&[84, 0, 2, 0]]).to_vec();
    let mut requests = vec![(100, write(xl, x::BAUD_RATE, 5))];
    for index in 0..40 {
        requests.push((150 + 11 * u64::from(index), gain(1000 + index)));
        requests.push((155 + 11 * u64::from(index), read.clone()));
    }
    let bus = run(xl, 700, requests);
    let values = bus
        .answers()
        .into_iter()
        .filter(|(_, bytes)| bytes.len() == 13);
    let values = values.map(|(_, bytes)| u16::from_le_bytes([bytes[9], bytes[10]]));
    assert_eq!(values.collect::<Vec<_>>(), (1000..1040).collect::<Vec<_>>());
}

#[test]
fn a_goal_turns_the_shaft_and_is_held() {
    for model in ServoModel::ALL {
        let is_feetech = model.maker() == ServoMaker::Feetech;
        let (goal, enable, present) = if is_feetech {
            (
                sts::GOAL_POSITION,
                sts::TORQUE_ENABLE,
                sts::PRESENT_POSITION,
            )
        } else {
            (x::GOAL_POSITION, x::TORQUE_ENABLE, x::PRESENT_POSITION)
        };
        let address = present.address.to_le_bytes();
        let read = if is_feetech {
            feetech::encode(1, 2, &[address[0], 2]).to_vec()
        } else {
            dynamixel::encode(1, 2, &[&address, &[4, 0]]).to_vec()
        };
        // 30 deg.
        let requests = vec![
            (150, write(model, enable, 1)),
            (200, write(model, goal, 2389)),
            (1_400, read),
        ];
        let bus = run(model, 1_500, requests);
        let answers = bus.answers();
        let from = if is_feetech { 5 } else { 9 };
        let bytes = &answers[2].1[from..][..usize::from(present.size)];
        let position = present.decode(bytes, Order::Little);
        assert!(position.abs_diff(2389) <= 3, "{model:?}: {position}");
        // Three steps of the encoder.
        assert!(
            (bus.angle_deg - 30.0).abs() < 0.27,
            "{model:?}: {}",
            bus.angle_deg
        );
    }
}

#[test]
fn a_new_bit_rate_is_in_effect_behind_its_answer() {
    let ping = feetech::encode(1, 1, &[]).to_vec();
    let rate = write(ServoModel::Sts3215, sts::BAUD_RATE, 6);
    let bus = run(ServoModel::Sts3215, 300, vec![(150, rate), (200, ping)]);
    let spacing = |from: usize| bus.received[from + 1].0 - bus.received[from].0;
    assert_eq!(bus.received.len(), 12);
    assert_eq!(spacing(0), BYTE_NS);
    // 57,600 bit/s: ten bits of 173.6 us, by a divider of 84 MHz that is a whole number.
    let expected_ns = 10 * 1_000_000_000 / 57_600;
    assert!(spacing(6).abs_diff(expected_ns) < expected_ns / 1000);
}
