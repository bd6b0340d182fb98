//! The communication board's slcan commands, at its pins.

use board_tests::comm::{Client, one_per_ms, run_client, run_comm_script};
use virtual_board::can::{BitTiming, Frame, Id, Outcome, Port, Sent};
use virtual_board::run::{CommView, Flow, SerialScript, SharedBus};

/// The responses to commands, one per millisecond, on a bus with a port at 500 kbit/s.
fn responses(commands: &[&str]) -> Vec<String> {
    let ports = vec![Port::at_rate(500_000)];
    let ms = 10 + commands.len() as u64;
    let run = run_client(ports, one_per_ms(commands), ms);
    run.client.lines().into_iter().map(|(_, l)| l).collect()
}

/// According to LAWICEL's manual of the CANUSB (version 1.0D, 2011), and to what python-can's
/// `slcanBus` expects.
#[test]
fn every_command_has_the_response_of_a_lawicel_adapter() {
    let dialogue = [
        ("\r", ""),
        ("V\r", "V1013"),
        ("N\r", "N0001"),
        ("F\r", "BEL"), // only while open
        ("t1230\r", "BEL"),
        ("S9\r", "BEL"),
        ("S5\r", ""),
        ("S6\r", ""),
        ("M00000000\r", ""),
        ("mFFFFFFFF\r", ""),
        ("Z0\r", ""),
        ("O\r", ""),
        ("O\r", "BEL"), // twice
        ("S6\r", "BEL"),
        ("M00000000\r", "BEL"),
        ("t1232AABB\r", "z"),
        ("T123456783010203\r", "Z"),
        ("r1234\r", "z"),
        ("R123456780\r", "Z"),
        ("t12\r", "BEL"),
        ("t8000\r", "BEL"),
        ("hello\r", "BEL"),
        ("F\r", "F00"),
        ("C\r", ""),
        ("C\r", ""),
        ("L\r", ""),
        ("t1230\r", "BEL"), // listen-only
        ("C\r", ""),
        ("Z1\r", ""),
        ("Z2\r", ""),
    ];
    let commands = dialogue.map(|(command, _)| command);
    assert_eq!(responses(&commands), dialogue.map(|(_, answer)| answer));
}

fn delivered(log: &[Sent], sender: usize) -> Vec<Frame> {
    let by_it = |sent: &&Sent| sent.sender == sender && sent.outcome == Outcome::Delivered;
    log.iter().filter(by_it).map(|sent| sent.frame).collect()
}

#[test]
fn frames_of_every_kind_pass_unchanged_in_both_directions() {
    let frames = [
        Frame::data_frame(Id::Standard(0x7ff), &[1, 2, 3, 4, 5, 6, 7, 0xfe]),
        Frame::data_frame(Id::Standard(0), &[]),
        Frame::data_frame(Id::Extended(0x1abc_def0), &[0xaa, 0x55]),
        Frame::remote_frame(Id::Standard(0x123), 8),
        Frame::remote_frame(Id::Extended(0x1fff_ffff), 0),
    ];
    let lines = [
        "t7FF801020304050607FE",
        "t0000",
        "T1ABCDEF02AA55",
        "r1238",
        "R1FFFFFFF0",
    ];
    let mut port = Port::at_rate(500_000);
    for (ms, frame) in (20..).zip(frames) {
        port.send(ms * 1_000_000, frame);
    }
    let mut plan = one_per_ms(&["S6\r", "O\r"]);
    plan.extend(
        (30..)
            .zip(lines)
            .map(|(ms, line)| (ms * 1000, format!("{line}\r").into())),
    );
    let run = run_client(vec![port], plan, 40);
    let received = run.client.lines();
    let between = |from_ms: u64, to_ms: u64| {
        let inside = received
            .iter()
            .filter(|(at_ns, _)| (from_ms * 1_000_000..to_ms * 1_000_000).contains(at_ns));
        inside.map(|(_, line)| line.as_str()).collect::<Vec<_>>()
    };
    assert_eq!(between(20, 30), lines);
    assert_eq!(between(30, 40), ["z", "z", "Z", "z", "Z"]);
    assert_eq!(delivered(&run.log, 0), frames);
}

/// Records the bit timing while the bus is opened at one rate after the other.
struct Rates {
    client: Client,
    seen: Vec<(u64, u32)>,
}

impl SerialScript for Rates {
    fn at_poll(&mut self, view: &mut CommView<'_>) -> Flow {
        const BTR: u64 = 0x4000_641c;
        let timing = BitTiming::from_btr(view.register(BTR), 40_000_000);
        let silent = view.register(BTR) >> 31;
        let bit_ps = timing.map_or(0, |timing| timing.bit_ps);
        if self.seen.last() != Some(&(bit_ps, silent)) {
            self.seen.push((bit_ps, silent));
        }
        self.client.at_poll(view)
    }
}

#[test]
fn every_bit_rate_is_exact_and_listen_only_mode_is_silent() {
    let mut commands = Vec::new();
    for digit in 0..9 {
        commands.extend([format!("S{digit}\r"), "O\r".to_owned(), "C\r".to_owned()]);
    }
    commands.push("L\r".to_owned());
    let script = Rates {
        client: Client::new(one_per_ms(&commands)),
        seen: Vec::new(),
    };
    let bus = SharedBus::new(Vec::new(), 1);
    let mut seen = run_comm_script(&bus, script, 40).script.seen;
    // The reset value of the register is faster than any bus.
    seen.retain(|(bit_ps, _)| *bit_ps >= 1_000_000);
    let kbit_s = canopen::slcan::KBIT_S.map(|kbit_s| (1_000_000_000 / u64::from(kbit_s), 0));
    assert_eq!(&seen[..9], kbit_s);
    assert_eq!(&seen[9..], [(1_000_000, 1)]);
}

#[test]
fn stamps_count_milliseconds_and_microseconds() {
    let mut port = Port::at_rate(1_000_000);
    for ms in [20, 25, 40, 45] {
        port.send(ms * 1_000_000, Frame::data_frame(Id::Standard(1), &[]));
    }
    let mut plan = one_per_ms(&["S8\r", "Z1\r", "O\r"]);
    plan.push((30_000, b"Z2\r".to_vec()));
    let run = run_client(vec![port], plan, 50);
    let lines = run.client.lines();
    let stamps = lines
        .iter()
        .filter_map(|(_, line)| line.strip_prefix("t0010"));
    let stamps: Vec<_> = stamps
        .map(|stamp| {
            (
                stamp.len(),
                i64::from_str_radix(stamp, 16).expect("a number"),
            )
        })
        .collect();
    let [(4, a_ms), (4, b_ms), (8, c_us), (8, d_us)] = stamps[..] else {
        panic!("{stamps:?}");
    };
    assert_eq!((b_ms - a_ms, d_us - c_us), (5, 5_000));
    // The board's clock starts within a millisecond of its supply.
    assert!((20 - a_ms).abs() <= 1, "{a_ms}");
}

#[test]
fn missing_acknowledgements_set_the_error_flags_and_the_bus_can_be_closed() {
    let commands = [
        "S8\r", "O\r", "t1230\r", "\r", "\r", "F\r", "C\r", "O\r", "F\r",
    ];
    let run = run_client(Vec::new(), one_per_ms(&commands), 20);
    let lines: Vec<_> = run.client.lines().into_iter().map(|(_, l)| l).collect();
    // Error warning, error passive, bus error; after the bus was opened again, only the error
    // counters remain.
    assert_eq!(lines, ["", "", "z", "", "", "FA4", "", "", "F24"]);
}

#[test]
fn a_line_with_a_damaged_or_lost_byte_is_discarded() {
    // Longer than the board's receive buffer: a sequence of empty lines would not overrun it.
    let long = "x".repeat(3000) + "\rV\r";
    let run = run_client(Vec::new(), one_per_ms(&[long]), 40);
    let lines: Vec<_> = run.client.lines().into_iter().map(|(_, l)| l).collect();
    assert_eq!(lines, ["BEL", "V1013"]);
}
