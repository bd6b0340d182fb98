//! A client at a line with answers of its own.

use std::collections::VecDeque;
use std::io::{self, ErrorKind, Read, Write};

use super::*;

/// After each packet that is sent, the next of these bytes arrive.
#[derive(Default)]
struct Script {
    answers: VecDeque<Vec<u8>>,
    arrived: VecDeque<u8>,
}

impl Read for Script {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        match self.arrived.read(bytes)? {
            0 => Err(ErrorKind::WouldBlock.into()),
            length => Ok(length),
        }
    }
}

impl Write for Script {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.arrived
            .extend(self.answers.pop_front().unwrap_or_default());
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Line for Script {
    fn discard(&mut self) -> io::Result<()> {
        self.arrived.clear();
        Ok(())
    }
}

fn client<const N: usize>(answers: [Vec<u8>; N]) -> Client {
    Client {
        bus: "sts:script".to_owned(),
        line: Box::new(Script {
            answers: answers.into(),
            arrived: VecDeque::new(),
        }),
        framed: Framed::Feetech(Box::default()),
        answer: ANSWER,
    }
}

/// The answer of the servo 1 with these data.
fn answer(data: &[u8]) -> Vec<u8> {
    feetech::encode(1, 0, data).to_vec()
}

#[test]
fn a_late_answer_is_not_that_to_the_next_packet() {
    // Two at once, and a part of one.
    let late = [answer(&[1]), answer(&[2]), answer(&[3])].concat();
    let mut client = client([late[..late.len() - 1].to_vec(), answer(&[4])]);
    let read = [1, 4].map(|_| client.read_bytes(1, 40, 1).expect("an answer"));
    assert_eq!(read, [[1], [4]]);
}

#[test]
fn packets_that_a_damaged_one_has_delayed_are_all_looked_at() {
    // What claims to be longer ends with the answer, and holds one of another servo.
    let other = feetech::encode(2, 0, &[9]);
    let mut bytes = [&[0xFF, 0xFF, 1, 16, 0][..], &other, &answer(&[5])].concat();
    bytes.resize(20, 0);
    let mut client = client([bytes]);
    assert_eq!(client.read_bytes(1, 40, 1).expect("an answer"), [5]);
}

#[test]
fn a_sync_read_lacks_only_what_was_not_answered() {
    // In any order; one answer is too short.
    let answers = [(3, &[7, 8][..]), (1, &[5, 6]), (4, &[9])];
    let bytes = answers.map(|(id, data)| feetech::encode(id, 0, data).to_vec());
    let read = client([bytes.concat()]).sync_read(&[1, 2, 3, 4], 56, 2);
    let expected = [Some(vec![5, 6]), None, Some(vec![7, 8]), None];
    assert_eq!(read.expect("a bus"), expected);
}

#[test]
fn an_unknown_model_has_the_table_of_its_series() {
    for (end, number, name) in [
        (0, [9, 3], "sts3215"),
        (0, [0x09, 0x0B], "sts3250"),
        (0, [5, 4], "sts3215"),
        (1, [5, 4], "scs0009"),
        (1, [9, 3], "scs0009"),
    ] {
        let mut client = client([answer(&[end]), answer(&number)]);
        let table = client.table(1).expect("a table");
        assert_eq!(table.name, name, "{end} {number:?}");
    }
}
