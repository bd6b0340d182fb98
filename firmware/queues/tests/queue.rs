//! A queue has the behaviour of `VecDeque`, also between threads.
#![allow(unsafe_code, reason = "each test has queues of its own")]

use std::{collections::VecDeque, thread};

use proptest::{prelude::*, strategy::ValueTree};
use task_queues::{Channel, channel};

channel!(Numbers: [u64; 8]);
channel!(Between: [u64; 64]);

/// More operations than a position has values.
const OPERATIONS: usize = 300_000;

#[test]
fn a_queue_yields_what_was_written_in_order_and_refuses_more_than_its_capacity() {
    // SAFETY: the only call for this queue.
    let (mut producer, mut consumer) = unsafe { Numbers::split() };
    let mut model = VecDeque::new();
    let mut runner = proptest::test_runner::TestRunner::deterministic();
    let writes = prop::collection::vec(any::<bool>(), OPERATIONS);
    let writes = writes.new_tree(&mut runner).expect("operations").current();
    for (number, is_write) in (0..).zip(writes) {
        if is_write {
            let has_room = model.len() < 8;
            assert_eq!(producer.has_room(), has_room);
            assert_eq!(producer.enqueue(number).is_ok(), has_room);
            if has_room {
                model.push_back(number);
            }
        } else {
            assert_eq!(consumer.peek(), model.front());
            assert_eq!(consumer.dequeue(), model.pop_front());
        }
        assert_eq!(producer.has_waiting(), !model.is_empty());
        assert!(producer.is_intact() && consumer.is_intact());
    }
}

#[test]
fn elements_pass_from_one_thread_to_another_one_complete_and_in_order() {
    // SAFETY: the only call for this queue.
    let (mut producer, mut consumer) = unsafe { Between::split() };
    let writer = thread::spawn(move || {
        for number in 0..OPERATIONS as u64 {
            while producer.enqueue(number).is_err() {
                assert!(producer.is_intact());
                thread::yield_now();
            }
        }
    });
    for expected in 0..OPERATIONS as u64 {
        let number = loop {
            match consumer.dequeue() {
                Some(number) => break number,
                None => thread::yield_now(),
            }
            assert!(consumer.is_intact());
        };
        assert_eq!(number, expected);
    }
    writer.join().expect("the writer ends");
}
