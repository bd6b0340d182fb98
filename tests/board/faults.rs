//! Faults of the table, provoked on the emulated board: told within their time, safe within theirs.

use board_tests::frames::{BoardFrame, Frame};
use board_tests::runs::{Schedule, run_schedule, statuses, steps, to_and_fro};
use firmware::faults::Fault as Told;
use firmware::parameters::BoardParameters;
use virtual_board::can::WireFault;
use virtual_board::faults::{Fault, MagnetState, Planned};
use virtual_board::plant::{Bridge, EncoderWire, Stuck};
use virtual_board::run::{Finished, Options};

/// In the middle of a control period; the shaft is on its way then.
const FROM_MS: u64 = 1102;

/// Beyond the table's times, which are those of the control step: a control period until it looks,
/// and the frame that tells.
const TELLING_MS: u64 = 5;

/// A fault of the board, and what provokes it.
pub struct Case {
    told: Told,
    /// From it on the fault's condition holds `delay_ms` later at the most.
    cause: fn() -> Planned,
    delay_ms: u64,
    pub schedule: Schedule,
}

const fn case(told: Told, cause: fn() -> Planned, delay_ms: u64) -> Case {
    Case {
        told,
        cause,
        delay_ms,
        schedule: to_and_fro,
    }
}

fn at(fault: Fault) -> Planned {
    Planned::at_ms(FROM_MS, fault)
}

/// Never at rest for as long as a stall takes.
fn restless(tick: u64) -> Option<Frame> {
    steps(tick, 10_000, 60)
}

/// Steps that do not leave the window of the following error.
fn gentle(tick: u64) -> Option<Frame> {
    steps(tick, 4_500, 250)
}

const CASES: [Case; 18] = [
    case(
        Told::EncoderInvalid,
        || {
            at(Fault::EncoderWire {
                line: EncoderWire::Data,
                stuck: Stuck::Low,
            })
        },
        0,
    ),
    case(
        Told::MagnetLost,
        || {
            at(Fault::Magnet {
                state: MagnetState::Lost,
            })
        },
        0,
    ),
    case(
        Told::MagnetWeak,
        || {
            at(Fault::Magnet {
                state: MagnetState::Marginal,
            })
        },
        0,
    ),
    case(Told::EncoderStuck, || at(Fault::EncoderFrozen), 0),
    case(
        Told::EncoderJump,
        || at(Fault::MagnetSlips { deg: 40.0 }),
        0,
    ),
    // 1.63 A.
    case(
        Told::OverCurrent,
        || at(Fault::CurrentSense { code: 4071 }),
        0,
    ),
    // 1 A, twice what it may be for long.
    Case {
        schedule: restless,
        ..case(Told::Overload, || at(Fault::CurrentSense { code: 3290 }), 0)
    },
    // The integrator has to drive the current up to that of a stall first.
    Case {
        schedule: gentle,
        ..case(Told::Stall, || at(Fault::Jam), 100)
    },
    case(Told::BridgeTripped, || at(Fault::BridgeTrip), 0),
    // The comparator sees the current at the end of a slot of the grid.
    case(
        Told::BridgeTripped,
        || at(Fault::MotorShort { ohm: 0.1 }),
        4,
    ),
    // The error has to grow to its window first.
    case(Told::FollowingError, || at(Fault::Jam), 300),
    case(Told::UnderVoltage, || at(Fault::Supply { volts: 3.8 }), 0),
    case(Told::OverVoltage, || at(Fault::Supply { volts: 8.0 }), 0),
    case(
        Told::OverTemperature,
        || at(Fault::Temperature { deg_c: 120.0 }),
        0,
    ),
    case(
        Told::MeasurementLost,
        || at(Fault::Temperature { deg_c: 250.0 }),
        0,
    ),
    case(Told::LoopOverrun, || at(Fault::StallCore).for_ms(14), 14),
    // Back at once: 32 frames that fail, then the time that the controller stays away.
    case(
        Told::BusOff,
        || {
            at(Fault::Can {
                wire: WireFault::Short,
            })
            .for_ms(20)
        },
        25,
    ),
    case(Told::WatchdogReset, || at(Fault::StallCore).for_ms(60), 60),
];

/// The first instant from which on the bridge stays off, ms.
fn safe_from_ms(rows: &[(u64, Bridge)]) -> u64 {
    let last_on = rows
        .iter()
        .rev()
        .find(|(_, bridge)| *bridge != Bridge::Coast);
    last_on.map_or(0, |(at_ns, _)| at_ns / 1_000_000)
}

/// What came of a run: the faults that were told with their times, ns, and what the bridge did.
pub struct Course {
    pub told: Vec<(u64, u8)>,
    pub bridges: Vec<(u64, Bridge)>,
}

impl Course {
    /// Of a finished run.
    pub fn of<S>(finished: &Finished<S>, told: Vec<(u64, u8)>) -> Self {
        let rows = finished.trace.rows.iter();
        Self {
            told,
            bridges: rows.map(|row| (row.at_ns, row.bridge)).collect(),
        }
    }
}

/// The number of the fault, and after how many ms it was told and safe.
fn provoke(case: &Case, run: impl Fn(Options, &Case) -> Course) -> (u8, u64, u64) {
    let options = Options {
        faults: vec![(case.cause)()],
        ..Options::for_ms(FROM_MS + 2600)
    };
    let course = run(options, case);
    let mut told = course.told.iter();
    let first = told.find(|(at_ns, _)| at_ns / 1_000_000 >= FROM_MS);
    let (at_ns, number) = first.unwrap_or_else(|| panic!("{:?} is not told", case.told));
    let since = |ms: u64| ms.saturating_sub(FROM_MS);
    let safe_ms = safe_from_ms(&course.bridges);
    (*number, since(at_ns / 1_000_000), since(safe_ms))
}

/// Provokes all faults of the table, and prints what came of each.
pub fn provoke_all(run: impl Fn(Options, &Case) -> Course) {
    let parameters = BoardParameters::DEFAULT;
    println!("| fault | told after | limit | safe after | limit |");
    println!("|---|---|---|---|---|");
    let mut wrong = Vec::new();
    for case in &CASES {
        let (number, told_ms, safe_ms) = provoke(case, &run);
        let detected_ms = u64::from(case.told.detected_ms(&parameters));
        let limits = [
            detected_ms + case.delay_ms + TELLING_MS,
            u64::from(case.told.safe_ms(&parameters)) + case.delay_ms + TELLING_MS,
        ];
        println!(
            "| {:?} | {told_ms} ms | {} ms | {safe_ms} ms | {} ms |",
            case.told, limits[0], limits[1]
        );
        let is_right = u16::from(number) == case.told.number();
        if !is_right || told_ms > limits[0] || safe_ms > limits[1] {
            wrong.push(format!(
                "{:?}: told {number} after {told_ms} ms, safe after {safe_ms} ms",
                case.told
            ));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn every_provoked_fault_is_told_and_safe_within_its_times() {
    provoke_all(|options, case| {
        let finished = run_schedule(options, case.schedule);
        let told = statuses(&finished).into_iter();
        let told = told.filter(|(_, status)| status.fault != 0);
        Course::of(
            &finished,
            told.map(|(ns, status)| (ns, status.fault)).collect(),
        )
    });
}

#[test]
fn without_commands_the_board_stops_by_itself() {
    let options = Options::for_ms(2000);
    let last_tick = 275;
    let schedule = |tick| to_and_fro(tick).filter(|_: &Frame| tick <= 275);
    let finished = run_schedule(options, schedule);
    let told = statuses(&finished);
    let (at_ns, status) = told
        .iter()
        .find(|(_, status)| status.fault != 0)
        .expect("it is told");
    assert_eq!(u16::from(status.fault), Told::CommandTimeout.number());
    // The tick is some 6 ms after power-on.
    let after_ms = at_ns / 1_000_000 - 4 * last_tick;
    assert!((100..120).contains(&after_ms), "{after_ms}");
}

/// What the supply has to be at the least, where its sag is looked at, mV.
const LEAST_MV: u32 = 5600;

/// Sets that limit, then holds still.
fn hold(tick: u64) -> Option<Frame> {
    let number = || {
        let mut numbers = 0..BoardParameters::COUNT;
        let name = |number| BoardParameters::meaning(number).map(|known| known.name().to_owned());
        numbers.find(|number| name(*number).as_deref() == Some("under_voltage_mv"))
    };
    match tick {
        20 => Some(Frame::write(number().expect("it has a number"), LEAST_MV)),
        _ => steps(tick, 0, 250),
    }
}

#[test]
fn a_supply_that_gives_way_under_the_load_alone_is_seen() {
    let mut options = Options {
        faults: vec![at(Fault::Torque { nm: 0.7 })],
        ..Options::for_ms(FROM_MS + 500)
    };
    // 6 V behind 1.5 ohm.
    options.rig.supply.source_resistance_ohm = 1.5;
    let finished = run_schedule(options, hold);
    let told = statuses(&finished);
    let (at_ns, status) = (told.iter())
        .find(|(_, status)| status.fault != 0)
        .expect("it is told");
    assert_eq!(u16::from(status.fault), Told::UnderVoltage.number());
    // While the bridge is open, as in the window, it is enough: rows are from the ends of the periods.
    let rows = finished.trace.rows.iter();
    let open_v = (rows.filter(|row| row.at_ns < *at_ns))
        .map(|row| row.supply_v)
        .fold(f64::INFINITY, f64::min);
    println!(
        "told at {} ms; without load it was {open_v:.2} V",
        at_ns / 1_000_000
    );
    assert!(open_v > f64::from(LEAST_MV) / 1e3, "{open_v}");
}
