//! Bytes at the slcan adapter.
#![no_main]

use canopen::CanFrame;
use canopen::slcan::{Adapter, Bus, SlcanLine, parse_frame};
use libfuzzer_sys::fuzz_target;

struct Wire;

impl Bus for Wire {
    fn open(&mut self, _: Option<u16>, _: bool) -> bool {
        true
    }
    fn close(&mut self) {}
    fn send(&mut self, frame: &CanFrame) -> bool {
        // Every transmitted frame encodes to a line that parses to the same frame.
        let text = SlcanLine::frame(frame);
        let line = text.as_bytes().strip_suffix(b"\r").expect("an end");
        assert_eq!(parse_frame(line), Some(*frame));
        true
    }
    fn flags(&mut self) -> u8 {
        0
    }
}

fuzz_target!(|input: &[u8]| {
    let mut adapter = Adapter::new(*b"0001");
    let lines = input.iter().filter(|byte| **byte == b'\r').count();
    let answers = input.iter().filter_map(|byte| adapter.receive(*byte, &mut Wire));
    assert_eq!(answers.count(), lines, "one answer for each line");
    let _ = parse_frame(input);
});
