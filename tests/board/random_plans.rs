//! Random plans of faults: sensors that lie, loads that pull, supplies that sag, each at rest, in a
//! motion of each kind of mode, and while the parameters are saved. `FAULT_PLANS` is the number of
//! plans natively, `FAULT_PLANS_EMULATED` that of the emulated board. During an update the loop is
//! that of a drive at rest, bit for bit (`whole_update.rs`).

mod plan;

use std::collections::BTreeMap;
use std::env;

use board_tests::frames::{fault, faults};
use board_tests::master::TICK_RATE_HZ;
use board_tests::native::NativeBoard;
use board_tests::program::run_master;
use model_core::time::UPDATE_PERIOD_NS;
use rayon::iter::{IntoParallelIterator as _, ParallelIterator as _};
use virtual_board::faults::Planned;
use virtual_board::plant::BoardPlantOptions;
use virtual_board::run::Options;

use self::plan::{Plan, State, UNTIL_MS};

/// A shaft that is further off than this, deg, for longer than this, s, without a fault is not
/// controlled.
const OFF_DEG: f64 = 5.0;
const OFF_S: f64 = 0.5;

/// Greatest rate of a shaft that a load turns after a fault, deg/s. It decelerates for 300 ms.
const RUNAWAY_DEG_S: f64 = 60.0;
const DECELERATED_MS: u64 = 300;

/// The shaft at a PWM edge.
struct Shaft {
    at_ns: u64,
    angle_deg: f64,
    rate_deg_s: f64,
}

/// A run: the shaft, and the first fault with its time, ns.
struct Motion {
    shaft: Vec<Shaft>,
    fault: Option<(u64, u8)>,
}

/// A tick of the master.
const TICK_NS: u64 = 1_000_000_000 / TICK_RATE_HZ as u64;

fn plant() -> BoardPlantOptions {
    BoardPlantOptions::realistic(3)
}

fn emulated(state: State, faults_planned: Vec<Planned>) -> Motion {
    let options = Options {
        plant: plant(),
        faults: faults_planned,
        ..Options::for_ms(UNTIL_MS)
    };
    let finished = run_master(options, move |tick| state.frames(tick));
    let shaft = finished.trace.rows.iter().map(|row| Shaft {
        at_ns: row.at_ns,
        angle_deg: row.angle_deg,
        rate_deg_s: row.rate_deg_s,
    });
    Motion {
        shaft: shaft.collect(),
        fault: faults(&finished).into_iter().next(),
    }
}

fn native(state: State, faults_planned: Vec<Planned>) -> Motion {
    let mut board = NativeBoard::new(&plant()).with_faults(faults_planned);
    let mut first = None;
    for tick in 0..UNTIL_MS * 1_000_000 / TICK_NS {
        let sent = board.frames.len();
        board.tick(&state.frames(tick));
        let raised = board.frames[sent..].iter().find_map(fault);
        first = first.or(raised.map(|number| ((tick + 1) * TICK_NS, number)));
    }
    let shaft = (1..)
        .zip(board.motion())
        .map(|(edge, (angle_deg, rate_deg_s))| Shaft {
            at_ns: edge * UPDATE_PERIOD_NS,
            angle_deg,
            rate_deg_s,
        });
    Motion {
        shaft: shaft.collect(),
        fault: first,
    }
}

/// What the shaft did that it must not do.
fn judge(run: impl Fn(State, Vec<Planned>) -> Motion, state: State, plan: Plan) -> Option<String> {
    // Where the sensors are right, a load may hinder the motion.
    let expected = match (state, plan.sensors.is_empty()) {
        (State::Held | State::Saving, _) => Some(run(state, Vec::new())),
        // A torque controls no angle.
        (State::Torque, _) | (_, true) => None,
        (_, false) => Some(run(state, plan.loads.clone())),
    };
    let found = run(state, [plan.loads, plan.sensors].concat());
    let fault_ns = found.fault.map_or(u64::MAX, |(at_ns, _)| at_ns);
    let mut off_ms = 0;
    let expected = expected.iter().flat_map(|it| &it.shaft);
    for (row, expected) in found.shaft.iter().zip(expected) {
        let is_off = (row.angle_deg - expected.angle_deg).abs() > OFF_DEG;
        let counts = is_off && row.at_ns < fault_ns;
        off_ms = if counts { off_ms + 1 } else { 0 };
        if f64::from(off_ms) > OFF_S * 1e3 {
            let at_ms = row.at_ns / 1_000_000;
            return Some(format!("more than 5 deg off at {at_ms} ms without a fault"));
        }
    }
    // Faults 6 and 8 coast: the bridge may be defective.
    let number = found.fault.map_or(0, |(_, number)| number);
    if matches!(number, 6 | 8) {
        return None;
    }
    let begin_ns = fault_ns.saturating_add(DECELERATED_MS * 1_000_000);
    let after = found.shaft.iter().filter(|row| row.at_ns > begin_ns);
    // At the mechanical stop the surface rebounds.
    let free = after.take_while(|row| row.angle_deg.abs() < 175.0);
    let fastest = free.map(|row| row.rate_deg_s.abs()).fold(0.0, f64::max);
    (fastest > RUNAWAY_DEG_S).then(|| format!("{fastest:.0} deg/s after fault {number}"))
}

/// Kind of a plan, and what the shaft did in it that it must not do.
fn outcome(
    run: impl Fn(State, Vec<Planned>) -> Motion,
    number: u64,
) -> (&'static str, Option<String>) {
    let (state, plan) = plan::draw(number);
    let kind = plan.kind;
    let exception = judge(run, state, plan);
    (
        kind,
        exception.map(|it| format!("plan {number}, {state:?}: {it}")),
    )
}

/// Prints how many plans of each kind there were, and asserts that none has an exception.
fn assert_none(outcomes: Vec<(&'static str, Option<String>)>) {
    let mut kinds = BTreeMap::<_, (u32, u32)>::new();
    for (kind, exception) in &outcomes {
        let (plans, exceptions) = kinds.entry(kind).or_default();
        *plans += 1;
        *exceptions += u32::from(exception.is_some());
    }
    println!("| kind | plans | exceptions |\n|---|---|---|");
    for (kind, (plans, exceptions)) in &kinds {
        println!("| {kind} | {plans} | {exceptions} |");
    }
    let exceptions: Vec<_> = outcomes.into_iter().filter_map(|(_, it)| it).collect();
    assert!(exceptions.is_empty(), "{exceptions:#?}");
}

fn count(variable: &str, default: u64) -> u64 {
    env::var(variable).map_or(default, |text| text.parse().expect("a number"))
}

#[test]
fn no_plan_lets_the_shaft_go_without_a_fault_or_run_away_after_it() {
    let numbers = 0..count("FAULT_PLANS_EMULATED", 30);
    assert_none(numbers.map(|number| outcome(emulated, number)).collect());
}

#[test]
fn no_plan_does_so_natively() {
    let numbers = 0..count("FAULT_PLANS", 500);
    let outcomes = numbers
        .into_par_iter()
        .map(|number| outcome(native, number));
    assert_none(outcomes.collect());
}
