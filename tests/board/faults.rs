//! Faults of the table, provoked on the emulated board: each is reported by EMCY, and the bridge is
//! off, within the times of the table.

use board_tests::flips::{loop_flip, program_flip};
use board_tests::frames::{faults, write};
use board_tests::master::{Targets, driven, steps, to_and_fro};
use board_tests::program::run_master;
use firmware::faults::Fault as Reported;
use firmware::parameters::BoardParameters;
use virtual_board::can::WireFault;
use virtual_board::faults::{Fault, MagnetState, Planned};
use virtual_board::plant::{Bridge, EncoderWire, Stuck};
use virtual_board::run::{Finished, Options};
use virtual_board::trace::Row;

/// Instant of the fault, in the middle of a control period, while the shaft moves.
const FROM_MS: u64 = 1102;

/// In addition to the table's times, which count from the control step: a control period until the
/// step samples the condition, and the duration of the frame that reports it.
const REPORTING_MS: u64 = 5;

/// From a reset to the first control step, ms: most of it is the CRC of the program.
const START_MS: u64 = 10;

/// A fault of the board, and its cause.
struct Case {
    fault: Reported,
    /// The fault's condition is true at most `delay_ms` after the cause.
    cause: fn() -> Planned,
    delay_ms: u64,
    targets: Targets,
}

const fn case(fault: Reported, cause: fn() -> Planned, delay_ms: u64) -> Case {
    Case {
        fault,
        cause,
        delay_ms,
        targets: to_and_fro,
    }
}

fn at(fault: Fault) -> Planned {
    Planned::at_ms(FROM_MS, fault)
}

/// Steps that do not leave the window of the following error.
fn small_steps(tick: u64) -> i32 {
    steps(tick, 4_500, 250)
}

const CASES: [Case; 20] = [
    case(
        Reported::EncoderInvalid,
        || {
            at(Fault::EncoderWire {
                line: EncoderWire::Data,
                stuck: Stuck::Low,
            })
        },
        0,
    ),
    case(
        Reported::MagnetLost,
        || {
            at(Fault::Magnet {
                state: MagnetState::Lost,
            })
        },
        0,
    ),
    case(
        Reported::MagnetWeak,
        || {
            at(Fault::Magnet {
                state: MagnetState::Marginal,
            })
        },
        0,
    ),
    case(Reported::EncoderStuck, || at(Fault::EncoderFrozen), 0),
    case(
        Reported::EncoderJump,
        || at(Fault::MagnetSlips { deg: 40.0 }),
        0,
    ),
    // 2.04 A at 0.5 V/A.
    case(
        Reported::OverCurrent,
        || at(Fault::CurrentSense { code: 3314 }),
        0,
    ),
    // No current, once the integrator has raised the duty against the jam.
    case(
        Reported::CurrentImplausible,
        || at(Fault::CurrentSense { code: 2048 }),
        1000,
    ),
    // The integrator must first raise the current to that of a stall.
    Case {
        targets: small_steps,
        ..case(Reported::Stall, || at(Fault::Jam), 100)
    },
    case(Reported::BridgeTripped, || at(Fault::BridgeTrip), 0),
    // The comparator is updated with the current at the end of a slot of the grid.
    case(
        Reported::BridgeTripped,
        || at(Fault::MotorShort { ohm: 0.1 }),
        4,
    ),
    // The error must first grow to its window.
    case(Reported::FollowingError, || at(Fault::Jam), 300),
    case(
        Reported::UnderVoltage,
        || at(Fault::Supply { volts: 3.8 }),
        0,
    ),
    case(
        Reported::OverVoltage,
        || at(Fault::Supply { volts: 8.0 }),
        0,
    ),
    case(
        Reported::OverTemperature,
        || at(Fault::Temperature { deg_c: 120.0 }),
        0,
    ),
    case(
        Reported::MeasurementLost,
        || at(Fault::Temperature { deg_c: 250.0 }),
        0,
    ),
    case(
        Reported::LoopOverrun,
        || at(Fault::StallCore).for_ms(16),
        16,
    ),
    // The bus is restored at once: 32 failed frames, then the recovery time of the controller.
    case(
        Reported::BusOff,
        || {
            at(Fault::Can {
                wire: WireFault::Short,
            })
            .for_ms(20)
        },
        25,
    ),
    case(
        Reported::WatchdogReset,
        || at(Fault::StallCore).for_ms(60),
        60 + START_MS,
    ),
    case(Reported::DataCorrupt, || at(loop_flip()), 0),
    case(Reported::ProgramCorrupt, || at(program_flip()), 0),
];

/// Whether the motor coasts, is shorted or is driven against its motion.
fn is_braked(row: &Row) -> bool {
    match row.bridge {
        Bridge::Coast | Bridge::Brake => true,
        Bridge::Driven { is_positive, .. } => is_positive == (row.rate_deg_s < 0.0),
    }
}

/// Instant from which the motor is no longer driven but braked, ms.
fn safe_from_ms(rows: &[Row]) -> u64 {
    let last_on = rows.iter().rev().find(|row| !is_braked(row));
    last_on.map_or(0, |row| row.at_ns / 1_000_000)
}

fn run(options: Options, targets: Targets) -> Finished<impl Sized> {
    run_master(options, move |tick| driven(tick, targets(tick)))
}

/// The number of the first fault, and the times until it was reported and until the motor was no
/// longer driven, ms.
fn provoke(case: &Case) -> (u8, u64, u64) {
    let options = Options {
        faults: vec![(case.cause)()],
        ..Options::for_ms(FROM_MS + 2600)
    };
    let finished = run(options, case.targets);
    let mut faults = faults(&finished).into_iter();
    let first = faults.find(|(at_ns, _)| at_ns / 1_000_000 >= FROM_MS);
    let (at_ns, number) = first.unwrap_or_else(|| panic!("{:?} is not reported", case.fault));
    let since = |ms: u64| ms.saturating_sub(FROM_MS);
    let safe_ms = safe_from_ms(&finished.trace.rows);
    (number, since(at_ns / 1_000_000), since(safe_ms))
}

#[test]
fn every_provoked_fault_is_an_emergency_and_safe_within_its_times() {
    let parameters = BoardParameters::DEFAULT;
    println!("| fault | reported after | limit | safe after | limit |");
    println!("|---|---|---|---|---|");
    let mut wrong = Vec::new();
    for case in &CASES {
        let (number, reported_ms, safe_ms) = provoke(case);
        let detected_ms = u64::from(case.fault.detected_ms(&parameters));
        let limits = [
            detected_ms + case.delay_ms + REPORTING_MS,
            u64::from(case.fault.safe_ms(&parameters)) + case.delay_ms + REPORTING_MS,
        ];
        println!(
            "| {:?} | {reported_ms} ms | {} ms | {safe_ms} ms | {} ms |",
            case.fault, limits[0], limits[1]
        );
        let is_right = u16::from(number) == case.fault.number();
        if !is_right || reported_ms > limits[0] || safe_ms > limits[1] {
            wrong.push(format!(
                "{:?}: reported {number} after {reported_ms} ms, safe after {safe_ms} ms",
                case.fault
            ));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// The end of the EMCY of the first fault, ns. Asserts that it is the expected fault.
fn first_fault<S>(finished: &Finished<S>, expected: Reported) -> u64 {
    let faults = faults(finished);
    let (at_ns, number) = faults.first().expect("a fault is reported");
    assert_eq!(u16::from(*number), expected.number());
    *at_ns
}

#[test]
fn without_commands_the_board_stops_the_drive() {
    let last_tick = 275;
    let finished = run_master(Options::for_ms(2000), move |tick| {
        let is_sent = tick <= last_tick;
        let frames = is_sent.then(|| driven(tick, to_and_fro(tick)));
        frames.unwrap_or_default()
    });
    let at_ns = first_fault(&finished, Reported::CommandTimeout);
    // The first control period begins about 10 ms after power-on.
    let after_ms = at_ns / 1_000_000 - 4 * last_tick;
    assert!((100..120).contains(&after_ms), "{after_ms}");
    assert!(
        safe_from_ms(&finished.trace.rows) < 1700,
        "the motor is not driven"
    );
}

/// The under-voltage limit of the test below, mV.
const LEAST_MV: u32 = 5000;

/// The supply gives (6 - 5.3) V/1.5 ohm - 60 mA = 407 mA from where its current is limited: with
/// d^2 V = R i a duty of 0.77, which makes 0.53 A in the motor, 0.61 N m.
#[test]
fn a_supply_that_drops_under_load_limits_the_torque_and_is_no_under_voltage() {
    for (nm, expected) in [(0.5, None), (0.75, Some(Reported::FollowingError))] {
        let mut options = Options {
            faults: vec![at(Fault::Torque { nm })],
            ..Options::for_ms(FROM_MS + 3000)
        };
        options.plant.supply.source_resistance_ohm = 1.5;
        // Constant target.
        let finished = run_master(options, |tick| match tick {
            25 => vec![write(0x2100, 18, LEAST_MV, 4)],
            _ => driven(tick, 0),
        });
        let first = faults(&finished)
            .first()
            .map(|(_, number)| u16::from(*number));
        assert_eq!(first, expected.map(Reported::number), "{nm} N m");
    }
}
