//! Two boards on one bus: the same ELF twice, each by its own number.

use board_tests::chain::saved;
use board_tests::frames::{Status, order};
use board_tests::runs::firmware;
use firmware::parameters::BoardParameters;
use virtual_board::can::{Frame, Id, Port, Sent};
use virtual_board::run::{Company, Finished, Flow, Options, Script, SharedBus, View, run_with};

/// Both are enabled here, ms.
const ENABLED_MS: u64 = 100;
const END_MS: u64 = 2000;

/// What is commanded to each, deg.
const ANGLES_DEG: [i32; 2] = [10, -20];

/// Somebody at the bus: both are enabled and commanded in the same instant, every 20 ms.
fn desk() -> Port {
    let mut port = Port::at_rate(1_000_000);
    for ms in (ENABLED_MS..END_MS).step_by(20) {
        for (node, deg) in (1..).zip(ANGLES_DEG) {
            let order = if ms == ENABLED_MS {
                order::ENABLE
            } else {
                order::NONE
            };
            let [a, b, c, d] = (deg * 1000).to_le_bytes();
            let frame = Frame::data_frame(Id::Standard(0x200 + node), &[a, b, c, d, order]);
            port.send(ms * 1_000_000, frame);
        }
    }
    port
}

fn nothing() -> impl Script {
    |_: &mut View<'_>| Flow::On
}

/// Runs both boards; what was on the bus.
fn boards() -> Vec<Sent> {
    let bus = SharedBus::new(vec![desk()], 2);
    let start = |(node_id, end)| {
        let mut parameters = BoardParameters::DEFAULT;
        parameters.bus.node_id = node_id;
        let options = Options {
            contents: vec![saved(&parameters)],
            ..Options::for_ms(END_MS)
        };
        let company = Company {
            bus: Some(end),
            ..Company::default()
        };
        std::thread::spawn(move || {
            let finished: Finished<_> =
                run_with(firmware(), options, nothing(), company).expect("it runs");
            assert!(finished.gaps.is_empty(), "{}", finished.gaps);
        })
    };
    let threads: Vec<_> = (1..).zip(bus.ends()).map(start).collect();
    for thread in threads {
        thread.join().expect("no panic");
    }
    bus.take_log()
}

/// The last status of a node.
fn last(log: &[Sent], node: u32) -> Status {
    let mut of_node = (log.iter().rev()).filter(|sent| sent.frame.id.value() == 0x180 + node);
    let mut frame = of_node.next().expect("it reports").frame;
    frame.id = Id::Standard(0x181);
    Status::of(&frame).expect("a status")
}

#[test]
fn two_boards_on_one_bus_answer_and_move_by_their_own_numbers() {
    let log = boards();
    for (node, deg) in (1..).zip(ANGLES_DEG) {
        let status = last(&log, node);
        assert_eq!(
            (status.state, status.fault),
            (2, 0),
            "node {node}: {status:?}"
        );
        let off_mdeg = (status.mdeg - deg * 1000).abs();
        assert!(off_mdeg < 200, "node {node}: {status:?}");
    }
    // Both report in the same instant: the lower identifier goes first, and no bit of time is lost between them.
    let pairs: Vec<_> = (log.windows(2))
        .filter(|pair| pair[0].frame.id.value() == 0x181 && pair[1].sender != pair[0].sender)
        .collect();
    assert!(pairs.len() > 400, "{}", pairs.len());
    for pair in pairs {
        let bits = pair[1].frame.bits_on_the_wire() + 3;
        assert_eq!(pair[1].at_ns - pair[0].at_ns, u64::from(bits) * 1000);
    }
    // Twice the same, however the threads take turns.
    assert_eq!(log, boards());
}
