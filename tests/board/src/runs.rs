//! Runs of the emulated board.

use std::sync::OnceLock;

use virtual_board::run::{Finished, Firmware, Flow, Options, Script, View, run};

use crate::frames::{BoardFrame, Frame, Status, order};
use cross_build::plain_board_elf;

/// The board's program.
///
/// # Panics
/// If it does not build.
pub fn firmware() -> &'static Firmware {
    static FIRMWARE: OnceLock<Firmware> = OnceLock::new();
    FIRMWARE.get_or_init(|| Firmware::read(plain_board_elf()).expect("an ELF file"))
}

/// PWM periods in a control period.
pub const PERIODS: u64 = 4;

/// What is commanded: for a control period the frame that comes in before it.
pub type Schedule = fn(tick: u64) -> Option<Frame>;

/// Sends what a schedule says, two PWM periods before the control period.
pub struct Commander {
    schedule: Schedule,
    period: u64,
}

impl Commander {
    /// From the first control period on.
    pub fn new(schedule: Schedule) -> Self {
        Self {
            schedule,
            period: 0,
        }
    }
}

impl Script for Commander {
    fn at_edge(&mut self, view: &mut View<'_>) -> Flow {
        // Row 4 k is the start of control period k.
        if self.period % PERIODS == 2
            && let Some(frame) = (self.schedule)(self.period / PERIODS + 1)
        {
            let now_ns = view.now_ns();
            if let Some(port) = view.port(0) {
                port.send(now_ns, frame.on_the_wire());
            }
        }
        self.period += 1;
        Flow::On
    }
}

/// Commands 10 deg and back each second, after enabling.
pub fn to_and_fro(tick: u64) -> Option<Frame> {
    steps(tick, 10_000, 250)
}

/// Commands an angle and its opposite in turns of so many control periods, after enabling.
pub fn steps(tick: u64, mdeg: i32, turn: u64) -> Option<Frame> {
    let is_first = tick.checked_div(turn)?.is_multiple_of(2);
    match tick {
        0..30 => None,
        30 => Some(Frame::command(0, order::ENABLE)),
        _ => tick
            .is_multiple_of(5)
            .then(|| Frame::command(if is_first { mdeg } else { -mdeg }, order::NONE)),
    }
}

/// Runs a schedule, and asserts that the emulation had no gap.
///
/// # Panics
/// If it had, or the run does not come about.
pub fn run_schedule(options: Options, schedule: Schedule) -> Finished<Commander> {
    run_script(options, Commander::new(schedule))
}

/// The same with a script of its own.
///
/// # Panics
/// As above.
pub fn run_script<S: Script + 'static>(options: Options, script: S) -> Finished<S> {
    let finished = run(firmware(), options, script).expect("it runs");
    assert!(finished.gaps.is_empty(), "{}", finished.gaps);
    finished
}

/// Status frames of a run with their ends, ns.
pub fn statuses<S>(finished: &Finished<S>) -> Vec<(u64, Status)> {
    let frames = finished.trace.frames.iter();
    frames
        .filter_map(|sent| Some((sent.at_ns, Status::of(&sent.frame)?)))
        .collect()
}
