//! Two boards on one bus: the same ELF twice, each with its own node-ID.

use board_tests::chain::saved;
use board_tests::frames::{control, is_operation_enabled, standard, to_wire};
use board_tests::program::firmware;
use firmware::drive::StoredParameters;
use virtual_board::can::{Port, Sent};
use virtual_board::run::{Attachments, Finished, Flow, Options, Script, SharedBus, View, run_with};

/// Start of the controlwords that enable both drives, ms.
const ENABLED_MS: u64 = 100;
const END_MS: u64 = 2000;

/// Target of each node, deg.
const ANGLES_DEG: [i32; 2] = [10, -20];

/// The master: starts all nodes, then commands both at the same instant, every 20 ms.
fn master() -> Port {
    let mut port = Port::at_rate(1_000_000);
    port.send(80_000_000, to_wire(&standard(0, &[1, 0])));
    let words = [0x06, 0x07].into_iter().chain(std::iter::repeat(0x0f));
    for (ms, word) in (ENABLED_MS..END_MS).step_by(20).zip(words) {
        for (node, deg) in (1..).zip(ANGLES_DEG) {
            let data = control(word, deg * 1000).bytes();
            let frame = standard(0x400 + node, &data[..6]);
            port.send(ms * 1_000_000, to_wire(&frame));
        }
    }
    port
}

fn idle() -> impl Script {
    |_: &mut View<'_>| Flow::Continue
}

/// Runs both boards and returns the frames that were on the bus.
fn boards() -> Vec<Sent> {
    let bus = SharedBus::new(vec![master()], 2);
    let start = |(node_id, connection)| {
        let mut parameters = StoredParameters::DEFAULT;
        parameters.board.bus.node_id = node_id;
        let options = Options {
            contents: vec![saved(&parameters)],
            ..Options::for_ms(END_MS)
        };
        let attachments = Attachments {
            bus: Some(connection),
            ..Attachments::default()
        };
        std::thread::spawn(move || {
            let finished: Finished<_> =
                run_with(firmware(), options, idle(), attachments).expect("the run succeeds");
            assert!(finished.gaps.is_empty(), "{}", finished.gaps);
        })
    };
    let threads: Vec<_> = (1..).zip(bus.connections()).map(start).collect();
    for thread in threads {
        thread.join().expect("no panic");
    }
    bus.take_log()
}

/// The data of the last frame with this identifier.
fn last(log: &[Sent], id: u32) -> [u8; 8] {
    let mut with_id = log.iter().rev().filter(|sent| sent.frame.id.value() == id);
    with_id.next().expect("a frame").frame.data
}

#[test]
fn two_boards_on_one_bus_respond_and_move_under_their_own_node_ids() {
    let log = boards();
    for (node, deg) in (1..).zip(ANGLES_DEG) {
        let [.., a, b] = last(&log, 0x280 + node);
        let statusword = u16::from_le_bytes([a, b]);
        assert!(
            is_operation_enabled(statusword),
            "node {node}: {statusword:04x}"
        );
        let [a, b, ..] = last(&log, 0x180 + node);
        let cdeg = i32::from(i16::from_le_bytes([a, b]));
        assert!((cdeg - deg * 100).abs() < 20, "node {node}: {cdeg}");
    }
    // Both send two PDOs in each control period. During the first frames both have one pending: the
    // lower identifier wins the arbitration, and the other follows without a gap.
    let pairs: Vec<_> = (log.windows(2))
        .filter(|pair| pair[0].frame.id.value() == 0x281 && pair[1].frame.id.value() == 0x282)
        .collect();
    assert!(pairs.len() > 400, "{}", pairs.len());
    for pair in pairs {
        let bits = pair[1].frame.bits_on_the_wire() + 3;
        assert_eq!(pair[1].at_ns - pair[0].at_ns, u64::from(bits) * 1000);
    }
    // A second run has the same frames, independently of the scheduling of the threads.
    assert_eq!(log, boards());
}
