//! Gaps of the bus and other bit rates: what is sent first afterwards, and what the node disturbs.

use board_tests::frames::{Frame, from_wire, standard, to_wire, write};
use board_tests::master::{driven, to_and_fro};
use board_tests::program::{run_master, run_script};
use virtual_board::can::{Outcome, WireFault};
use virtual_board::faults::{Fault, Planned};
use virtual_board::run::{Finished, Flow, Options, Script, View};

/// Frames of the board that were delivered, with their ends, ns.
fn delivered<S>(finished: &Finished<S>) -> impl Iterator<Item = (u64, Frame)> {
    let frames = finished.trace.frames.iter();
    let own = frames.filter(|sent| sent.sender == 0 && sent.outcome == Outcome::Delivered);
    own.map(|sent| (sent.at_ns, from_wire(&sent.frame)))
}

/// Control periods from the sample of a TPDO 2, whose sample counter is 2007h:1, to its end, plus a
/// constant.
fn age(at_ns: u64, frame: &Frame) -> i64 {
    let [.., low, high, _, _] = frame.bytes();
    (at_ns / 4_000_000) as i64 - i64::from(u16::from_le_bytes([low, high]))
}

#[test]
fn after_a_gap_emergencies_come_first_and_telemetry_is_new() {
    for (wire, ms) in [(WireFault::Open, 300), (WireFault::Short, 50)] {
        let end_ns = (1_000 + ms) * 1_000_000;
        let options = Options {
            faults: vec![Planned::at_ms(1_000, Fault::Can { wire }).for_ms(ms)],
            ..Options::for_ms(2_000)
        };
        let finished = run_master(options, |tick| match tick {
            // Bus-off does not end OPERATIONAL.
            15 => vec![write(0x1029, 1, 1, 1)],
            _ => driven(tick, to_and_fro(tick)),
        });
        let frames: Vec<(u64, Frame)> = delivered(&finished).collect();
        let telemetry = |from_ns: u64| {
            let mut frames = frames.iter().filter(move |(at_ns, _)| *at_ns > from_ns);
            let (at_ns, frame) = frames.find(|(_, frame)| frame.raw_id().0 == 0x281)?;
            Some((*at_ns, age(*at_ns, frame)))
        };
        let (_, usual) = telemetry(500_000_000).expect("telemetry before the gap");
        let (at_ns, first) = telemetry(end_ns).expect("telemetry behind the gap");
        assert!(
            first - usual <= 2,
            "{wire:?}: {} control periods old",
            first - usual
        );
        // Behind bus-off the longest wait is that of the second try, 20 ms, with its listening.
        let wait_ms = (at_ns - end_ns) / 1_000_000;
        assert!(wait_ms < 60, "{wire:?}: {wait_ms} ms");
        let behind = frames.iter().filter(|(at_ns, _)| *at_ns > end_ns);
        let ids: Vec<u32> = behind.map(|(_, frame)| frame.raw_id().0).collect();
        let pdo = ids.iter().position(|id| (0x181..0x581).contains(id));
        let emergency = ids.iter().position(|id| *id == 0x81);
        assert!(emergency < pdo && emergency.is_some(), "{wire:?}: {ids:x?}");
    }
}

/// A station that sends a frame to another one in each PWM period, from one period on.
struct Talking {
    periods: u64,
    from: u64,
}

impl Script for Talking {
    fn at_edge(&mut self, view: &mut View<'_>) -> Flow {
        self.periods += 1;
        let now_ns = view.now_ns();
        if let Some(port) = view.port(0).filter(|_| self.periods >= self.from) {
            port.send(now_ns, to_wire(&standard(0x321, &[1, 2, 3, 4])));
        }
        Flow::Continue
    }
}

/// A second and a half on a bus with two more stations at this rate, of which one talks from a
/// period on.
fn beside(bit_s: u32, from: u64) -> Finished<Talking> {
    let options = Options {
        ports_bit_s: vec![bit_s; 2],
        ..Options::for_ms(1_500)
    };
    run_script(options, Talking { periods: 0, from })
}

#[test]
fn a_node_of_another_bit_rate_disturbs_no_frame_and_sends_none() {
    for bit_s in [125_000, 250_000, 500_000, 800_000] {
        let finished = beside(bit_s, 1);
        let frames = &finished.trace.frames;
        assert!(frames.len() > 1_000, "{bit_s}");
        let all_delivered = frames.iter().all(|sent| sent.outcome == Outcome::Delivered);
        assert!(
            all_delivered && frames.iter().all(|sent| sent.sender != 0),
            "{bit_s}"
        );
    }
}

#[test]
fn a_node_that_starts_on_a_silent_bus_of_another_rate_gives_way_to_its_traffic() {
    let finished = beside(500_000, 400);
    let own = finished.trace.frames.iter().filter(|sent| sent.sender == 0);
    // The boot-up fails 32 times until bus-off; 10, 20, 40, 80, 160 and 320 ms later again, each
    // after 10 ms in silent mode.
    let tries = own.clone().count();
    assert!((32..=6 * 32).contains(&tries), "{tries}");
    let (traffic_ns, end_ns) = (400_000_000, 1_500_000_000);
    assert!(own.clone().all(|sent| sent.at_ns < traffic_ns));
    let others = finished.trace.frames.iter().filter(|sent| sent.sender != 0);
    let mut others = others.filter(|sent| (traffic_ns..end_ns).contains(&sent.at_ns));
    assert!(others.all(|sent| sent.outcome == Outcome::Delivered));
}

#[test]
fn a_node_takes_part_in_the_traffic_of_a_lone_master() {
    let options = Options {
        ports_bit_s: vec![1_000_000],
        ..Options::for_ms(200)
    };
    let script = Talking {
        periods: 0,
        from: 1,
    };
    let finished = run_script(options, script);
    let (at_ns, boot_up) = delivered(&finished).next().expect("a boot-up");
    assert_eq!(boot_up, standard(0x701, &[0]));
    assert!(at_ns < 20_000_000, "{at_ns} ns");
}
