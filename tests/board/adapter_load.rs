//! The communication board on a fully loaded bus.

use board_tests::comm::{Client, Talk, one_each_ms, run_desk, talk};
use virtual_board::can::{Frame, Id, Outcome, Port};
use virtual_board::run::SharedBus;

/// The bus is fully loaded from here on, ms.
const FROM_MS: u64 = 20;

/// Loads the bus fully with frames made from their number, at this rate and with these time stamps.
fn full_bus(
    bit_s: u32,
    digit: u8,
    stamps: u8,
    count: u32,
    frame: fn(u32) -> Frame,
    ms: u64,
) -> Talk {
    let mut port = Port::at_rate(bit_s);
    for number in 0..count {
        port.send(FROM_MS * 1_000_000, frame(number));
    }
    let mut plan = one_each_ms(&[
        format!("S{digit}\r"),
        format!("Z{stamps}\r"),
        "O\r".to_owned(),
    ]);
    plan.push(((ms - 5) * 1000, b"F\r".to_vec()));
    talk(vec![port, Port::at_rate(bit_s)], plan, ms)
}

/// Numbers of the received frames, from the data of their lines.
fn numbers(talk: &Talk, head: &str, stamp_digits: usize) -> Vec<u32> {
    let lines = talk.client.lines();
    let frames = lines.iter().filter_map(|(_, line)| line.strip_prefix(head));
    frames
        .map(|rest| {
            let data = &rest[..rest.len() - stamp_digits];
            u32::from_str_radix(&data[data.len() - 8..], 16).expect("a number")
        })
        .collect()
}

fn flags(talk: &Talk) -> String {
    let lines = talk.client.lines();
    let flags = lines.iter().rev().find(|(_, line)| line.starts_with('F'));
    flags.expect("it answers").1.clone()
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
fn load_permille(talk: &Talk, bit_ns: u64) -> u64 {
    let sent: Vec<_> = (talk.log.iter()).filter(|sent| sent.sender == 1).collect();
    let [first, .., last] = &sent[..] else {
        panic!("a full bus");
    };
    let bits = sent[1..]
        .iter()
        .map(|sent| u64::from(sent.frame.bits_on_the_wire() + 3));
    1000 * bits.sum::<u64>() * bit_ns / (last.at_ns - first.at_ns)
}

#[test]
fn nothing_is_lost_of_a_full_bus_at_500_kbit_s_not_even_with_the_longest_lines() {
    const COUNT: u32 = 2000;
    let ms = FROM_MS + 650;
    for (stamps, digits, head) in [(0, 0, "T155555558"), (2, 8, "T155555558")] {
        let talk = full_bus(500_000, 6, stamps, COUNT, long_extended, ms);
        let came = numbers(&talk, head, digits);
        assert!(came.iter().copied().eq(0..COUNT), "{} came", came.len());
        assert_eq!(flags(&talk), "F00");
        assert_eq!(load_permille(&talk, 2000), 1000);
    }
}

#[test]
fn nothing_is_lost_of_a_full_bus_at_1_mbit_s_without_stamps() {
    const COUNT: u32 = 4000;
    let talk = full_bus(1_000_000, 8, 0, COUNT, long_standard, FROM_MS + 600);
    let came = numbers(&talk, "t5558", 0);
    assert!(came.iter().copied().eq(0..COUNT), "{} came", came.len());
    assert_eq!(flags(&talk), "F00");
    assert_eq!(load_permille(&talk, 1000), 1000);
}

/// Frames with the number alone and a time stamp of eight digits: more than the line can carry.
#[test]
fn what_the_line_cannot_carry_is_told_and_what_comes_is_whole() {
    const COUNT: u32 = 6000;
    let short = |number: u32| Frame::data_frame(Id::Standard(0x555), &number.to_be_bytes());
    let talk = full_bus(1_000_000, 8, 2, COUNT, short, FROM_MS + 600);
    let came = numbers(&talk, "t5554", 8);
    assert_eq!(load_permille(&talk, 1000), 1000);
    // 22 characters of 10 bits at 2,000,000 baud for each frame.
    let most = (came.len() as u64) * 110;
    assert!(
        came.len() < COUNT as usize && most > 400_000,
        "{}",
        came.len()
    );
    assert!(came.is_sorted_by(|a, b| a < b), "in order, none twice");
    assert_eq!(
        flags(&talk),
        "F01",
        "frames were lost, as the line did not take them"
    );
    // Each line is one that was sent, and the board has gone on to the end.
    let lines = talk.client.lines();
    assert!(
        lines
            .iter()
            .all(|(_, line)| matches!(line.len(), 0 | 3 | 21)),
        "whole lines"
    );
    let last = came.last().expect("some came");
    assert!(*last > COUNT - 600, "{last}: it recovers by itself");
}

/// In real time boards synchronise rarely: several frames begin and end in between.
#[test]
fn in_real_time_too_every_frame_comes_once() {
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
    let client = Client::new(one_each_ms(&["S8\r", "O\r"]));
    let finished = run_desk(&bus, client, FROM_MS + 220);
    let lines = finished.script.lines();
    let frames = lines
        .iter()
        .filter_map(|(_, line)| line.strip_prefix("t5554"));
    let came = frames.map(|data| u32::from_str_radix(data, 16).expect("a number"));
    assert!(came.eq(0..COUNT));
}

/// Frames that a client sends at its line rate are sent on the bus, or refused at once.
#[test]
fn a_client_that_sends_faster_than_the_bus_carries_is_told_frame_by_frame() {
    const COUNT: usize = 3000;
    let frame = |number: usize| format!("t5558{number:016X}\r").into_bytes();
    let mut plan = one_each_ms(&["S6\r", "O\r"]);
    plan.push((FROM_MS * 1000, (0..COUNT).flat_map(frame).collect()));
    plan.push((FROM_MS * 1000 + 400_000, b"F\r".to_vec()));
    let talk = talk(vec![Port::at_rate(500_000)], plan, FROM_MS + 800);
    let lines = talk.client.lines();
    let count = |text: &str| lines.iter().filter(|(_, line)| line == text).count();
    let sent = talk
        .log
        .iter()
        .filter(|sent| sent.outcome == Outcome::Delivered);
    let numbers: Vec<_> = sent
        .map(|sent| u64::from_be_bytes(sent.frame.data))
        .collect();
    assert_eq!(count("z") + count("BEL"), COUNT);
    assert_eq!(numbers.len(), count("z"), "what was taken was sent");
    assert!(numbers.is_sorted_by(|a, b| a < b));
    assert!(count("BEL") > 0);
    assert_eq!(flags(&talk), "F02", "the queue to the bus was full");
}
