//! Tests of the slcan adapter at line level.

use canopen::CanFrame;
use canopen::slcan::{Adapter, Bus, SlcanLine, flags, parse_frame};
use proptest::prelude::*;

#[derive(Default)]
struct Wire {
    opened: Option<(Option<u16>, bool)>,
    sent: Vec<CanFrame>,
    room: usize,
    flags: u8,
}

impl Wire {
    fn new() -> Self {
        Self {
            room: 2,
            ..Self::default()
        }
    }
}

impl Bus for Wire {
    fn open(&mut self, kbit_s: Option<u16>, silent: bool) -> bool {
        self.opened = Some((kbit_s, silent));
        kbit_s != Some(10)
    }
    fn close(&mut self) {
        self.opened = None;
    }
    fn send(&mut self, frame: &CanFrame) -> bool {
        let fits = self.sent.len() < self.room;
        if fits {
            self.sent.push(*frame);
        }
        fits
    }
    fn flags(&mut self) -> u8 {
        std::mem::take(&mut self.flags)
    }
}

fn send_text(adapter: &mut Adapter, wire: &mut Wire, text: &str) -> String {
    let mut answer = Vec::new();
    for byte in text.bytes() {
        if let Some(text) = adapter.receive(byte, wire) {
            answer.extend_from_slice(text.as_bytes());
        }
    }
    String::from_utf8(answer).expect("ASCII")
}

fn frame(id: u32, data: &[u8]) -> CanFrame {
    let mut bytes = [0; 8];
    bytes[..data.len()].copy_from_slice(data);
    CanFrame::raw(id, false, false, data.len() as u8, bytes).expect("a frame")
}

#[test]
fn a_python_can_session_is_answered() {
    let (mut adapter, mut wire) = (Adapter::new(*b"A123"), Wire::new());
    assert_eq!(send_text(&mut adapter, &mut wire, "C\rS6\rO\r"), "\r\r\r");
    assert_eq!(wire.opened, Some((Some(500), false)));
    let sent = "t6058402F600001000000\rT1FFFFFFF0\r";
    assert_eq!(send_text(&mut adapter, &mut wire, sent), "z\rZ\r");
    assert_eq!(
        wire.sent[0],
        frame(0x605, &[0x40, 0x2F, 0x60, 0, 1, 0, 0, 0])
    );
    assert_eq!(
        send_text(&mut adapter, &mut wire, "V\rN\r\rF\r"),
        "V1013\rNA123\r\rF00\r"
    );
    assert_eq!(send_text(&mut adapter, &mut wire, "C\r"), "\r");
    assert_eq!(wire.opened, None);
}

#[test]
fn commands_invalid_in_the_present_state_are_answered_with_bel() {
    let (mut adapter, mut wire) = (Adapter::new(*b"0001"), Wire::new());
    let mut refused = |text: &str| {
        assert_eq!(send_text(&mut adapter, &mut wire, text), "\x07", "{text:?}");
    };
    for text in [
        "t1230\r",
        "F\r",
        "S9\r",
        "S\r",
        "x\r",
        "Z3\r",
        "M123\r",
        "m000000000\r",
        "S0O\r",
    ] {
        refused(text);
    }
    assert_eq!(send_text(&mut adapter, &mut wire, "S8\rL\r"), "\r\r");
    assert_eq!(wire.opened, Some((Some(1000), true)));
    for text in [
        "O\r",
        "L\r",
        "S6\r",
        "M00000000\r",
        "m00000000\r",
        "t1230\r",
    ] {
        assert_eq!(
            send_text(&mut adapter, &mut wire, text),
            "\x07",
            "{text:?} while it listens"
        );
    }
    assert!(wire.sent.is_empty());
    assert_eq!(
        send_text(&mut adapter, &mut wire, "C\rS0\rO\rF\r"),
        "\r\r\x07\x07",
        "the bus cannot be opened"
    );
}

#[test]
fn invalid_frames_are_refused() {
    let (mut adapter, mut wire) = (Adapter::new(*b"0001"), Wire::new());
    send_text(&mut adapter, &mut wire, "O\r");
    for line in [
        "t",
        "t12",
        "t1239",
        "t123912",
        "t8000",
        "T200000000",
        "t1231",
        "t12310",
        "t1231G0",
        "t12301",
    ] {
        assert_eq!(
            send_text(&mut adapter, &mut wire, &format!("{line}\r")),
            "\x07",
            "{line}"
        );
    }
    let long = "t1238".to_string() + &"0".repeat(500) + "\r";
    assert_eq!(send_text(&mut adapter, &mut wire, &long), "\x07");
    assert_eq!(
        send_text(&mut adapter, &mut wire, "r1238\rR000001238\r\n"),
        "z\rZ\r"
    );
    assert_eq!(wire.sent.len(), 2);
}

#[test]
fn queue_overflows_are_reported_once() {
    let (mut adapter, mut wire) = (Adapter::new(*b"0001"), Wire::new());
    send_text(&mut adapter, &mut wire, "O\r");
    assert_eq!(
        send_text(&mut adapter, &mut wire, "t1230\rt1230\rt1230\r"),
        "z\rz\r\x07"
    );
    adapter.line_lost();
    // The bus reports the full queue as well.
    wire.flags = flags::ERROR_PASSIVE | flags::TRANSMIT_FULL;
    assert_eq!(send_text(&mut adapter, &mut wire, "F\rF\r"), "F23\rF00\r");
}

#[test]
fn received_frames_have_the_selected_timestamp() {
    let (mut adapter, mut wire) = (Adapter::new(*b"0001"), Wire::new());
    let line = |adapter: &Adapter, now_us| {
        let text = adapter.frame(&frame(0x181, &[0xAB]), now_us)?;
        Some(String::from_utf8(text.as_bytes().to_vec()).expect("ASCII"))
    };
    assert_eq!(line(&adapter, 0), None, "closed");
    send_text(&mut adapter, &mut wire, "O\r");
    assert_eq!(line(&adapter, 0).as_deref(), Some("t1811AB\r"));
    send_text(&mut adapter, &mut wire, "Z1\r");
    assert_eq!(line(&adapter, 60_002_000).as_deref(), Some("t1811AB0002\r"));
    send_text(&mut adapter, &mut wire, "Z2\r");
    assert_eq!(
        line(&adapter, 3_600_000_015).as_deref(),
        Some("t1811AB0000000F\r")
    );
    let hour_us = "t1811ABD693A3FF\r";
    assert_eq!(line(&adapter, 3_599_999_999).as_deref(), Some(hour_us));
    send_text(&mut adapter, &mut wire, "Z0\r");
    assert_eq!(line(&adapter, 7).as_deref(), Some("t1811AB\r"));
}

#[test]
fn acceptance_filters_select_as_an_sja1000_does() {
    let (mut adapter, mut wire) = (Adapter::new(*b"0001"), Wire::new());
    // Filter 1 accepts 201h with a first byte of 5xh, filter 2 301h data frames with any data.
    let first = 0x201 << 5 | 0x5;
    let second = 0x301 << 5;
    let code = first << 16 | second;
    let setting = format!("M{code:08X}\rm0010000F\rO\r");
    assert_eq!(send_text(&mut adapter, &mut wire, &setting), "\r\r\r");
    let hears = |frame: CanFrame| adapter.frame(&frame, 0).is_some();
    assert!(hears(frame(0x201, &[0x5F])) && !hears(frame(0x201, &[0x6F])));
    assert!(hears(frame(0x301, &[0x6F])) && !hears(frame(0x302, &[0x6F])));
    assert!(!hears(
        CanFrame::raw(0x301, false, true, 0, [0; 8]).expect("a frame")
    ));
}

#[test]
fn each_filter_compares_the_upper_16_of_29_bits() {
    let (mut adapter, mut wire) = (Adapter::new(*b"0001"), Wire::new());
    // 0x1234 and 0xABCD are bits 28 to 13.
    let setting = "M1234ABCD\rm00000000\rO\r";
    assert_eq!(send_text(&mut adapter, &mut wire, setting), "\r\r\r");
    let hears = |upper: u32, lower: u32| {
        let id = upper << 13 | lower;
        let frame = CanFrame::raw(id, true, false, 0, [0; 8]).expect("a frame");
        adapter.frame(&frame, 0).is_some()
    };
    assert!(hears(0x1234, 0) && hears(0x1234, 0x1FFF));
    assert!(hears(0xABCD, 0) && hears(0xABCD, 0x1FFF));
    assert!(!hears(0x1235, 0) && !hears(0xABCC, 0) && !hears(0xABFD, 0));
}

#[test]
fn the_bits_of_the_answer_to_f_are_those_of_a_canusb() {
    use flags::{ARBITRATION_LOST, BUS_ERROR, ERROR_PASSIVE, ERROR_WARNING, OVERRUN};
    use flags::{RECEIVE_FULL, TRANSMIT_FULL};
    let bits = [
        RECEIVE_FULL,
        TRANSMIT_FULL,
        ERROR_WARNING,
        OVERRUN,
        ERROR_PASSIVE,
        ARBITRATION_LOST,
        BUS_ERROR,
    ];
    assert_eq!(bits.map(u8::trailing_zeros), [0, 1, 2, 3, 5, 6, 7]);
}

#[test]
fn a_disconnected_client_closes_the_bus_and_resets_all_settings() {
    let (mut adapter, mut wire) = (Adapter::new(*b"0001"), Wire::new());
    send_text(&mut adapter, &mut wire, "Z1\rO\rt12");
    adapter.disconnect(&mut wire);
    assert_eq!(wire.opened, None);
    assert_eq!(send_text(&mut adapter, &mut wire, "O\r"), "\r");
    let text = adapter.frame(&frame(1, &[]), 5_000).expect("open");
    assert_eq!(text.as_bytes(), b"t0010\r");
}

proptest! {
    #[test]
    fn every_frame_is_recovered_from_its_line(
        id in 0u32..1 << 29, extended: bool, remote: bool, length in 0u8..=8, data: [u8; 8]
    ) {
        let id = if extended { id } else { id & 0x7FF };
        let frame = CanFrame::raw(id, extended, remote, length, data).expect("a frame");
        let text = SlcanLine::frame(&frame);
        let line = text.as_bytes().strip_suffix(b"\r").expect("CR");
        prop_assert_eq!(parse_frame(line), Some(frame));
    }

    #[test]
    fn random_bytes_send_only_valid_frames(
        bytes in proptest::collection::vec(prop_oneof![any::<u8>(), proptest::sample::select(b"tTrRSOLCFZMm0189AF\r".as_slice())], 0..400)
    ) {
        let (mut adapter, mut wire) = (Adapter::new(*b"0001"), Wire::new());
        wire.room = usize::MAX;
        let mut answers = 0;
        for byte in &bytes {
            answers += usize::from(adapter.receive(*byte, &mut wire).is_some());
        }
        prop_assert_eq!(answers, bytes.iter().filter(|byte| **byte == b'\r').count(), "one answer per command");
        // Ends an incomplete line.
        send_text(&mut adapter, &mut wire, "\r");
        prop_assert_eq!(send_text(&mut adapter, &mut wire, "C\rV\r"), "\rV1013\r");
    }
}
