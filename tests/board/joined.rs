//! Two boards on one bus: the same ELF twice, each by its own number.

use board_tests::frames::{BoardFrame, Frame, Status, order};
use board_tests::runs::firmware;
use firmware::parameters::BoardParameters;
use virtual_board::can::{self, Id};
use virtual_board::faults::{Fault, Planned};
use virtual_board::run::{Finished, Flow, Joined, Options, Script, View, join, run};

/// The second board has its number by then, ms.
const JOINED_MS: u64 = 1500;
const END_MS: u64 = 3500;

/// What is commanded to each, deg.
const ANGLES_DEG: [i32; 2] = [10, -20];

/// Somebody at port 0 of a board, by the milliseconds of the run.
struct Desk(fn(ms: u64) -> Vec<can::Frame>);

impl Script for Desk {
    fn at_edge(&mut self, view: &mut View<'_>) -> Flow {
        let now_ns = view.now_ns();
        let frames = (self.0)(now_ns / 1_000_000);
        if let Some(port) = view.port(0) {
            frames
                .into_iter()
                .for_each(|frame| port.send(now_ns, frame));
        }
        Flow::On
    }
}

/// Alone, the second board is given its number, which it keeps over a reset.
fn number_two(ms: u64) -> Vec<can::Frame> {
    let number = (0..BoardParameters::COUNT).find(|number| {
        BoardParameters::meaning(*number).is_some_and(|known| known.name() == "node_id")
    });
    let frame = match ms {
        100 => Frame::write(number.expect("it has a number"), 2),
        150 => Frame::command(0, order::SAVE),
        _ => return Vec::new(),
    };
    vec![frame.on_the_wire()]
}

/// Both are enabled and commanded from the desk of the first.
fn command_both(ms: u64) -> Vec<can::Frame> {
    if ms < JOINED_MS + 100 || !ms.is_multiple_of(20) {
        return Vec::new();
    }
    let first = ms < JOINED_MS + 120;
    let frame = |node: u16| {
        let order = if first { order::ENABLE } else { order::NONE };
        let [a, b, c, d] = (ANGLES_DEG[usize::from(node) - 1] * 1000).to_le_bytes();
        can::Frame::data_frame(Id::Standard(0x200 + node), &[a, b, c, d, order])
    };
    vec![frame(1), frame(2)]
}

fn boards() -> [Finished<Joined<Desk>>; 2] {
    let options = Options {
        ports_bit_s: vec![1_000_000; 2],
        ..Options::for_ms(END_MS)
    };
    let reset = Options {
        faults: vec![Planned::at_ms(1300, Fault::ResetPin)],
        ..options.clone()
    };
    let mut joints = join(2, 1, JOINED_MS * 1_000_000).into_iter();
    let mut start = |options: Options, script| {
        let joint = joints.next().expect("one for each");
        let script = Joined {
            script: Desk(script),
            joint,
        };
        std::thread::spawn(move || run(firmware(), options, script).expect("it runs"))
    };
    let threads = [start(options, command_both), start(reset, number_two)];
    threads.map(|thread| thread.join().expect("no panic"))
}

/// The last status of a node on a board's wire.
fn last(finished: &Finished<Joined<Desk>>, node: u32) -> Status {
    let frames = finished.trace.frames.iter().rev();
    let mut of_node = frames.filter(|sent| sent.frame.id.value() == 0x180 + node);
    let mut frame = of_node.next().expect("it reports").frame;
    frame.id = Id::Standard(0x181);
    Status::of(&frame).expect("a status")
}

#[test]
fn two_boards_on_one_bus_answer_and_move_by_their_own_numbers() {
    let boards = boards();
    for finished in &boards {
        assert!(finished.gaps.is_empty(), "{}", finished.gaps);
        for (node, deg) in (1..).zip(ANGLES_DEG) {
            let status = last(finished, node);
            assert_eq!(
                (status.state, status.fault),
                (2, 0),
                "node {node}: {status:?}"
            );
            let off_mdeg = (status.mdeg - deg * 1000).abs();
            assert!(off_mdeg < 200, "node {node}: {status:?}");
        }
    }
    // Twice the same, however the threads take turns.
    let hashes = |boards: &[Finished<_>; 2]| [0, 1].map(|board| boards[board].trace.hash());
    assert_eq!(hashes(&boards), hashes(&self::boards()));
}
