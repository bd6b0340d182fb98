//! The communication board on a fully loaded bus.

use board_tests::comm::{Client, ClientRun, one_per_ms, run_client, run_comm_script};
use virtual_board::can::{Frame, Id, Outcome, Port};
use virtual_board::run::SharedBus;

/// The bus is fully loaded from here on, ms.
const FROM_MS: u64 = 20;

/// Loads the bus fully with numbered frames, at this bit rate and with these time stamps.
fn full_bus(
    bit_s: u32,
    digit: u8,
    stamps: u8,
    count: u32,
    frame: fn(u32) -> Frame,
    ms: u64,
) -> ClientRun {
    let mut port = Port::at_rate(bit_s);
    for number in 0..count {
        port.send(FROM_MS * 1_000_000, frame(number));
    }
    let mut plan = one_per_ms(&[
        format!("S{digit}\r"),
        format!("Z{stamps}\r"),
        "O\r".to_owned(),
    ]);
    plan.push(((ms - 5) * 1000, b"F\r".to_vec()));
    run_client(vec![port, Port::at_rate(bit_s)], plan, ms)
}

/// Numbers of the received frames, from the data of their lines.
fn numbers(run: &ClientRun, head: &str, stamp_digits: usize) -> Vec<u32> {
    let lines = run.client.lines();
    let frames = lines.iter().filter_map(|(_, line)| line.strip_prefix(head));
    frames
        .map(|rest| {
            let data = &rest[..rest.len() - stamp_digits];
            u32::from_str_radix(&data[data.len() - 8..], 16).expect("a number")
        })
        .collect()
}

fn flags(run: &ClientRun) -> String {
    let lines = run.client.lines();
    let flags = lines.iter().rev().find(|(_, line)| line.starts_with('F'));
    flags.expect("a response to F").1.clone()
}

/// Eight bytes, the number in the last four, with as few stuff bits as possible.
fn long_standard(number: u32) -> Frame {
    let [a, b, c, d] = number.to_be_bytes();
    Frame::data_frame(Id::Standard(0x555), &[0x55, 0x55, 0x55, 0x55, a, b, c, d])
}

fn long_extended(number: u32) -> Frame {
    Frame {
        id: Id::Extended(0x1555_5555),
        ..long_standard(number)
    }
}

/// Load of the bus between the first and the last frame, in thousandths.
fn load_permille(run: &ClientRun, bit_ns: u64) -> u64 {
    let sent: Vec<_> = (run.log.iter()).filter(|sent| sent.sender == 1).collect();
    let [first, .., last] = &sent[..] else {
        panic!("a full bus");
    };
    let bits = sent[1..]
        .iter()
        .map(|sent| u64::from(sent.frame.bits_on_the_wire() + 3));
    1000 * bits.sum::<u64>() * bit_ns / (last.at_ns - first.at_ns)
}

#[test]
fn no_frame_is_lost_on_a_full_bus_at_500_kbit_s_even_with_the_longest_lines() {
    const COUNT: u32 = 2000;
    let ms = FROM_MS + 650;
    for (stamps, digits, head) in [(0, 0, "T155555558"), (2, 8, "T155555558")] {
        let run = full_bus(500_000, 6, stamps, COUNT, long_extended, ms);
        let received = numbers(&run, head, digits);
        assert!(
            received.iter().copied().eq(0..COUNT),
            "{} received",
            received.len()
        );
        assert_eq!(flags(&run), "F00");
        assert_eq!(load_permille(&run, 2000), 1000);
    }
}

#[test]
fn no_frame_is_lost_on_a_full_bus_at_1_mbit_s_without_time_stamps() {
    const COUNT: u32 = 4000;
    let run = full_bus(1_000_000, 8, 0, COUNT, long_standard, FROM_MS + 600);
    let received = numbers(&run, "t5558", 0);
    assert!(
        received.iter().copied().eq(0..COUNT),
        "{} received",
        received.len()
    );
    assert_eq!(flags(&run), "F00");
    assert_eq!(load_permille(&run, 1000), 1000);
}

/// Frames with only the number and a time stamp of eight digits exceed the rate of the line.
#[test]
fn frames_beyond_the_line_rate_are_reported_lost_and_the_others_are_undamaged() {
    const COUNT: u32 = 6000;
    let short = |number: u32| Frame::data_frame(Id::Standard(0x555), &number.to_be_bytes());
    let run = full_bus(1_000_000, 8, 2, COUNT, short, FROM_MS + 600);
    let received = numbers(&run, "t5554", 8);
    assert_eq!(load_permille(&run, 1000), 1000);
    // 22 characters of 10 bits at 2,000,000 baud for each frame.
    let most = (received.len() as u64) * 110;
    assert!(
        received.len() < COUNT as usize && most > 400_000,
        "{}",
        received.len()
    );
    assert!(
        received.is_sorted_by(|a, b| a < b),
        "in order, without duplicates"
    );
    assert_eq!(
        flags(&run),
        "F01",
        "frames were lost because the line is too slow"
    );
    // Every line is complete, and the board forwards frames until the end.
    let lines = run.client.lines();
    assert!(
        lines
            .iter()
            .all(|(_, line)| matches!(line.len(), 0 | 3 | 21)),
        "complete lines"
    );
    let last = received.last().expect("some received");
    assert!(*last > COUNT - 600, "{last}: the board did not recover");
}

/// In real time boards synchronise rarely: several frames begin and end between two
/// synchronisations.
#[test]
fn in_real_time_every_frame_is_received_exactly_once() {
    const COUNT: u32 = 1500;
    let frame = |number: u32| Frame::data_frame(Id::Standard(0x555), &number.to_be_bytes());
    let mut port = Port::at_rate(1_000_000);
    for number in 0..COUNT {
        port.send(
            FROM_MS * 1_000_000 + 137_000 * u64::from(number),
            frame(number),
        );
    }
    let bus = SharedBus::new(vec![port, Port::at_rate(1_000_000)], 1).in_real_time();
    let client = Client::new(one_per_ms(&["S8\r", "O\r"]));
    let finished = run_comm_script(&bus, client, FROM_MS + 220);
    let lines = finished.script.lines();
    let frames = lines
        .iter()
        .filter_map(|(_, line)| line.strip_prefix("t5554"));
    let received = frames.map(|data| u32::from_str_radix(data, 16).expect("a number"));
    assert!(received.eq(0..COUNT));
}

/// Frames that a client sends at its line rate are sent on the bus, or refused at once.
#[test]
fn each_frame_of_a_client_that_sends_faster_than_the_bus_is_sent_or_refused() {
    const COUNT: usize = 3000;
    let frame = |number: usize| format!("t5558{number:016X}\r").into_bytes();
    let mut plan = one_per_ms(&["S6\r", "O\r"]);
    plan.push((FROM_MS * 1000, (0..COUNT).flat_map(frame).collect()));
    plan.push((FROM_MS * 1000 + 400_000, b"F\r".to_vec()));
    let run = run_client(vec![Port::at_rate(500_000)], plan, FROM_MS + 800);
    let lines = run.client.lines();
    let count = |text: &str| lines.iter().filter(|(_, line)| line == text).count();
    let sent = run
        .log
        .iter()
        .filter(|sent| sent.outcome == Outcome::Delivered);
    let numbers: Vec<_> = sent
        .map(|sent| u64::from_be_bytes(sent.frame.data))
        .collect();
    assert_eq!(count("z") + count("BEL"), COUNT);
    assert_eq!(numbers.len(), count("z"), "every accepted frame was sent");
    assert!(numbers.is_sorted_by(|a, b| a < b));
    assert!(count("BEL") > 0);
    assert_eq!(flags(&run), "F02", "the queue to the bus was full");
}
