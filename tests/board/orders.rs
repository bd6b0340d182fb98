//! Orders that take more than a control period, and what comes in between.

use board_tests::frames::{BoardFrame, Frame, order};
use board_tests::runs::{run_script, statuses};
use virtual_board::can;
use virtual_board::faults::{Fault, Planned};
use virtual_board::run::{Flow, Options, Script, View};

const SHAPE: u8 = 128;
const START_EXCITATION: u8 = 9;
const STOP_EXCITATION: u8 = 10;

/// Sends these frames in these milliseconds.
struct Desk(fn(ms: u64) -> Vec<Frame>);

impl Script for Desk {
    fn at_edge(&mut self, view: &mut View<'_>) -> Flow {
        let now_ns = view.now_ns();
        if let Some(port) = view.port(0) {
            for frame in (self.0)(now_ns / 1_000_000) {
                port.send(now_ns, frame.on_the_wire());
            }
        }
        Flow::On
    }
}

fn gain(value: f32) -> Frame {
    Frame::write(0, value.to_bits())
}

/// A save onto the blank page; then three within the erase of the next one, and a loss of the supply after all
/// of them.
fn saves(ms: u64) -> Vec<Frame> {
    let save = Frame::command(0, order::SAVE);
    match ms {
        100 => vec![gain(8.5), save],
        900 => vec![gain(8.6), save],
        920 => vec![gain(9.0), save],
        940 => vec![gain(7.0), save],
        3600 => vec![Frame::read(0)],
        _ => Vec::new(),
    }
}

#[test]
fn the_last_of_three_saves_within_an_erase_is_what_a_power_cycle_leaves() {
    let options = Options {
        faults: vec![Planned::at_ms(3400, Fault::PowerLoss).for_ms(50)],
        ..Options::for_ms(3700)
    };
    let finished = run_script(options, Desk(saves));
    let is_answer = |frame: &can::Frame| frame.id.value() == 0x381;
    let mut answers = finished.trace.frames.iter().rev();
    let answer = answers
        .find(|sent| is_answer(&sent.frame))
        .expect("an answer");
    let [operation, number, _, _, value @ ..] = answer.frame.data;
    assert_eq!((operation, number), (0, 0));
    assert_eq!(f32::from_bits(u32::from_le_bytes(value)), 7.0);
}

/// A pulse of 5 deg that is started, and stopped in the same control period.
fn start_and_stop(ms: u64) -> Vec<Frame> {
    let order = |order| Frame::command(0, order);
    match ms {
        150 => vec![order(order::ENABLE)],
        160 => vec![Frame::write(SHAPE, 0)],
        200 => vec![order(START_EXCITATION), order(STOP_EXCITATION)],
        1000 => vec![order(START_EXCITATION)],
        _ if ms.is_multiple_of(20) => vec![order(order::NONE)],
        _ => Vec::new(),
    }
}

#[test]
fn a_stop_in_the_control_period_of_the_start_calls_the_excitation_off() {
    let finished = run_script(Options::for_ms(1400), Desk(start_and_stop));
    let furthest = |from_ms: u64, until_ms: u64| {
        let told = statuses(&finished).into_iter();
        let within = told.filter(|(at_ns, _)| (from_ms..until_ms).contains(&(at_ns / 1_000_000)));
        within.map(|(_, status)| status.mdeg.abs()).max()
    };
    assert!(furthest(200, 1000) < Some(500), "{:?}", furthest(200, 1000));
    // It would have moved.
    assert!(
        furthest(1000, 1400) > Some(4000),
        "{:?}",
        furthest(1000, 1400)
    );
}
