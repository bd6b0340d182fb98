//! As many actuators as a bus can have, all of which send their process data, and a client that
//! receives all frames.

use std::{hint::black_box, time::Instant};

use canopen::{
    CanFrame, NodeId,
    slcan::{self, Adapter},
};
use host_sim::can::{
    bus::Bus,
    native_node::{CAPTURE_VALUES, NativeNode, PERIOD_US},
};

const NODES: u8 = 127;
/// Length of the measurement, control periods: 2 s.
const PERIODS: u64 = 500;

/// NMT: all nodes start.
const START: [u8; 8] = [1, 0, 0, 0, 0, 0, 0, 0];

/// The bus of the adapter, which sends nothing here.
struct Receiver;

impl slcan::Bus for Receiver {
    fn open(&mut self, _: Option<u16>, _: bool) -> bool {
        true
    }
    fn close(&mut self) {}
    fn send(&mut self, _: &CanFrame) -> bool {
        true
    }
    fn flags(&mut self) -> u8 {
        0
    }
}

/// Prints the time of the computer in that of the actuators.
pub fn print() {
    let mut buffers = vec![vec![0; CAPTURE_VALUES]; NODES.into()];
    let nodes = (1..=NODES).zip(&mut buffers).map(|(number, buffer)| {
        let id = NodeId::new(number);
        NativeNode::new(number.into(), id, &Default::default(), buffer).expect("a node")
    });
    let mut bus = Bus::new(nodes.collect());
    let mut adapter = Adapter::new(*b"0001");
    for byte in b"O\r" {
        adapter.receive(*byte, &mut Receiver);
    }
    let start = CanFrame::raw(0, false, false, 2, START).expect("a frame");
    bus.send(0, start, |_, _| {});
    let (begun, mut lines) = (Instant::now(), 0);
    for period in 1..=PERIODS {
        let now_us = period * PERIOD_US;
        bus.step(now_us, |_, frame| {
            let line = adapter.frame(frame, now_us);
            lines += usize::from(black_box(&line).is_some());
        });
    }
    let virtual_s = (PERIODS * PERIOD_US) as f64 / 1e6;
    let part = begun.elapsed().as_secs_f64() / virtual_s;
    assert!(
        lines as f64 > 250.0 * virtual_s * f64::from(NODES),
        "{lines} lines"
    );
    println!(
        "figure {NODES} actuators with process data at 250 Hz: part of a core = {:.0} %",
        100.0 * part
    );
}
