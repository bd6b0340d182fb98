//! What the shaft does after a fault at the full rate, and under a load that the drive must hold.

use std::fs;
use std::path::Path;

use board_tests::flips::{loop_flip, program_flip};
use board_tests::frames::{Frame, control, faults, mode, start, velocity, write};
use board_tests::master::{ENABLED_TICK, driven};
use board_tests::program::run_master;
use firmware::faults::{Fault as Reported, Reaction, TABLE};

use firmware::parameters::BoardParameters;
use virtual_board::can::WireFault;
use virtual_board::faults::{Fault, MagnetState, MemoryLocation, Planned};
use virtual_board::plant::{BoardPlantOptions, Bridge, EncoderWire, Stuck};
use virtual_board::run::Options;
use virtual_board::trace::Row;

/// Instant of the fault: the shaft has its full rate.
const FROM_MS: u64 = 902;

/// Full rate without load: 283.6 deg/s less 3 % for friction and 5 % for the window without drive.
const FULL_RATE_DEG_S: f64 = 275.0;

/// Mechanical time constant of motor and gears, s, and their inertia at the output, kg m^2
/// (`model_core::plant::drivetrain`).
const BRAKING_S: f64 = 0.1318;
const INERTIA_KG_M2: f64 = 0.0232;

/// Inertia of a bare horn, kg m^2.
const BARE_KG_M2: f64 = 2e-6;

/// Inertia of the load, kg m^2: as much as motor and gears.
const LOAD_KG_M2: f64 = INERTIA_KG_M2;

/// The faults after which the motor brakes: none, or the default.
const COAST: u32 = 0;

/// Full rate from OPERATION ENABLED on, without position limits, by velocity demands at 50 Hz.
fn full_rate(tick: u64, brake_faults: Option<u32>) -> Vec<Frame> {
    match tick {
        20 => vec![start()],
        22 => vec![write(0x607D, 1, (-2_000_000_000_i32) as u32, 4)],
        24 => vec![write(0x607D, 2, 2_000_000_000, 4)],
        26 => brake_faults
            .map(|faults| write(0x2100, 25, faults, 4))
            .into_iter()
            .collect(),
        28 => vec![mode(0, 9)],
        30 => vec![control(0x06, 0)],
        32 => vec![control(0x07, 0)],
        34 => vec![control(0x0f, 0)],
        ENABLED_TICK.. if tick.is_multiple_of(5) => vec![velocity(0x0f, 400_000)],
        _ => Vec::new(),
    }
}

/// The shaft after the fault.
#[derive(Debug)]
struct Travel {
    /// The fault that was reported.
    number: Option<u16>,
    /// The way until it rests, deg, and the time, ms.
    deg: f64,
    rest_ms: u64,
    /// Resets of the board, and the share of the time after the fault in which the motor braked.
    resets: usize,
    braked: f64,
}

fn plant(load_kg_m2: f64) -> BoardPlantOptions {
    let mut plant = BoardPlantOptions::default();
    plant.drivetrain.gear_train.hard_stop_deg = 32_000.0;
    plant.drivetrain.gear_train.load_inertia_kg_m2 = load_kg_m2;
    plant
}

fn travel(
    fault: Fault,
    for_ms: Option<u64>,
    (load_kg_m2, observed_ms): (f64, u64),
    brakes: Option<u32>,
) -> Travel {
    let planned = Planned::at_ms(FROM_MS, fault);
    let options = Options {
        plant: plant(load_kg_m2),
        faults: vec![for_ms.map_or(planned.clone(), |ms| planned.for_ms(ms))],
        ..Options::for_ms(FROM_MS + observed_ms)
    };
    let finished = run_master(options, move |tick| full_rate(tick, brakes));
    let reported = faults(&finished).into_iter();
    let first = reported.map(|(_, number)| u16::from(number)).next();
    let rows = &finished.trace.rows;
    let at = |ms: u64| rows.partition_point(|row| row.at_ns < ms * 1_000_000);
    let begin: &Row = &rows[at(FROM_MS)];
    // Accelerating a load takes longer.
    let least = if load_kg_m2 > BARE_KG_M2 { 0.8 } else { 0.95 };
    assert!(begin.rate_deg_s > least * FULL_RATE_DEG_S, "{begin:?}");
    let moves = |row: &&Row| row.rate_deg_s.abs() > 1.0;
    let rest = rows.iter().rev().find(moves).expect("it moved");
    let after = &rows[at(FROM_MS)..];
    let braked = after.iter().filter(|row| row.bridge == Bridge::Brake);
    Travel {
        number: first,
        deg: rest.angle_deg - begin.angle_deg,
        rest_ms: (rest.at_ns - begin.at_ns) / 1_000_000,
        resets: finished.resets.len(),
        braked: braked.count() as f64 / after.len() as f64,
    }
}

/// Least current of the brake over that of the shorted motor: a duty of -75 % against at most the
/// supply adds three quarters of it; less the window in which the back-EMF is measured, 175 us in 4
/// ms.
const OPPOSED: f64 = 1.75 * (1.0 - 0.175 / 4.0);

/// The way of a shaft at the full rate until its reaction begins, and then against `current` times
/// the current of the shorted motor with this inertia, deg.
fn braked_deg(begin_ms: u64, current: f64, load_kg_m2: f64) -> f64 {
    let braking_s = BRAKING_S * (1.0 + load_kg_m2 / INERTIA_KG_M2) / current;
    FULL_RATE_DEG_S * (begin_ms as f64 / 1e3 + braking_s)
}

/// When the shaft decelerates at the latest after the cause of the fault, ms, and with which
/// multiple of the current of the shorted motor. After a quick stop it has the rest of its way to
/// brake.
fn reaction(reported: Reported) -> (u64, f64) {
    let parameters = BoardParameters::DEFAULT;
    match reported.reaction() {
        // A PWM period until the duty is in force.
        Reaction::StopByBackEmf => (u64::from(reported.detected_ms(&parameters)) + 1, OPPOSED),
        _ => (u64::from(reported.safe_ms(&parameters)), 1.0),
    }
}

/// A fault at the full rate, its cause, and for how long the cause lasts, ms.
type Case = (Reported, Fault, Option<u64>);

/// Faults after which the motor brakes, at once or after a quick stop.
fn braking_cases() -> Vec<Case> {
    let broken = Fault::EncoderWire {
        line: EncoderWire::Data,
        stuck: Stuck::Low,
    };
    let magnet = |state| Fault::Magnet { state };
    let supply = |volts| Fault::Supply { volts };
    let board = |deg_c| Fault::Temperature { deg_c };
    let short = Fault::Can {
        wire: WireFault::Short,
    };
    vec![
        (Reported::EncoderInvalid, broken, None),
        (Reported::MagnetLost, magnet(MagnetState::Lost), None),
        (Reported::MagnetWeak, magnet(MagnetState::Marginal), None),
        (Reported::EncoderStuck, Fault::EncoderFrozen, None),
        (
            Reported::EncoderJump,
            Fault::MagnetSlips { deg: 40.0 },
            None,
        ),
        (Reported::UnderVoltage, supply(3.8), None),
        (Reported::OverVoltage, supply(8.0), None),
        (Reported::OverTemperature, board(120.0), None),
        (Reported::MeasurementLost, board(250.0), None),
        (Reported::LoopOverrun, Fault::StallCore, Some(16)),
        (Reported::BusOff, short, Some(20)),
        (Reported::WatchdogReset, Fault::StallCore, Some(60)),
        (Reported::DataCorrupt, loop_flip(), None),
        (Reported::ProgramCorrupt, program_flip(), None),
    ]
}

/// Faults of the bridge, after which the motor coasts.
fn coasting_cases() -> Vec<Case> {
    vec![
        // 2.04 A.
        (
            Reported::OverCurrent,
            Fault::CurrentSense { code: 3314 },
            None,
        ),
        (Reported::BridgeTripped, Fault::BridgeTrip, None),
    ]
}

/// Times after which a shaft rests that brakes or coasts, ms.
const BRAKED_MS: u64 = 3_000;
const COASTED_MS: u64 = 9_000;

/// Travel and time until rest of a fault, bare and with the load.
fn travels((_, fault, for_ms): &Case, brakes: bool) -> [Travel; 2] {
    let observed_ms = if brakes { BRAKED_MS } else { COASTED_MS };
    let of = |load| travel(fault.clone(), *for_ms, (load, observed_ms), None);
    [of(BARE_KG_M2), of(LOAD_KG_M2)]
}

/// Numbers of the row of `docs/faults.md` that begins with this fault: deg, ms, deg, ms.
fn documented(reported: Reported) -> Vec<f64> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/faults.md");
    let text = fs::read_to_string(path).expect("the page");
    let (_, section) = text.split_once("## Travel until rest").expect("a section");
    let begin = format!("| {} |", reported.number());
    let row = section.lines().find(|line| line.starts_with(&begin));
    let cells = row.unwrap_or_default().split('|').skip(3);
    let number = |cell: &str| cell.split_whitespace().next().and_then(|n| n.parse().ok());
    cells.filter_map(number).collect()
}

/// Whether the page states these values: within 2 deg and 20 ms, by which a change of the program
/// moves the instants of its steps against that of the fault.
fn is_documented(reported: Reported, travels: &[Travel; 2]) -> bool {
    let values = travels.each_ref().map(|t| [t.deg, t.rest_ms as f64]);
    let stated = documented(reported);
    let differences = stated.iter().zip(values.as_flattened());
    stated.len() == 4
        && differences
            .zip([2.0, 20.0, 2.0, 20.0])
            .all(|((a, b), tolerance)| (a - b).abs() <= tolerance)
}

fn name(reported: Reported) -> &'static str {
    TABLE[usize::from(reported.number()) - 1].name
}

#[test]
fn after_a_fault_at_the_full_rate_the_shaft_rests_within_its_braking_distance() {
    let mut wrong = Vec::new();
    let cases = braking_cases().into_iter().map(|case| (case, true));
    for (case, brakes) in cases.chain(coasting_cases().into_iter().map(|case| (case, false))) {
        let (reported, _, for_ms) = &case;
        let travels = travels(&case, brakes);
        let [bare, loaded] = &travels;
        println!(
            "| {} | {} | {:.0} deg | {} ms | {:.0} deg | {} ms |",
            reported.number(),
            name(*reported),
            bare.deg,
            bare.rest_ms,
            loaded.deg,
            loaded.rest_ms
        );
        // A control period until the step sees the condition.
        let (reaction_ms, current) = reaction(*reported);
        let begin_ms = reaction_ms + for_ms.unwrap_or(0) + 4;
        for (travel, load) in travels.iter().zip([BARE_KG_M2, LOAD_KG_M2]) {
            let bound = braked_deg(begin_ms, current, load);
            if travel.number != Some(reported.number()) || brakes && travel.deg > bound {
                wrong.push(format!("{reported:?}: {travel:?}, bound {bound:.0} deg"));
            }
        }
        if !is_documented(*reported, &travels) {
            wrong.push(format!("{reported:?}: not in docs/faults.md"));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// The first instruction of the control step is `push`; with this bit inverted it is `pop`, which
/// jumps to an address that is none of the program's.
const PUSH_TO_POP: u32 = 11;

/// Longest time from a step that fails to the brake of the next start, ms: the independent
/// watchdog, and the start.
const RESTART_MS: u64 = 48 + 15;

#[test]
fn a_program_whose_flash_makes_each_control_step_fail_brakes_before_it() {
    let place = MemoryLocation::Symbol("first_copy".into());
    let flip = Fault::FlipFlash {
        place,
        bit: PUSH_TO_POP,
    };
    for load in [BARE_KG_M2, LOAD_KG_M2] {
        let stopped = travel(flip.clone(), None, (load, BRAKED_MS), None);
        println!("{stopped:?}");
        // A control period until the step.
        let bound = braked_deg(4 + RESTART_MS, 1.0, load);
        assert!(stopped.deg < bound, "{stopped:?}, bound {bound:.0} deg");
        // The step has failed again and again, each time after a second of braking.
        assert!(stopped.resets >= 2, "{stopped:?}");
        let share = 1000.0 / (1000 + 4 + RESTART_MS) as f64;
        assert!(stopped.braked > share, "{stopped:?}, least {share:.2}");
    }
}

/// From -55 deg to 55 deg, and at [`FROM_MS`] on the way this controlword, or silence.
fn stopped_on_the_way(tick: u64, controlword: Option<u16>) -> Vec<Frame> {
    // 180 ms of the way: the shaft has 200 deg/s and more.
    let turn_tick = (FROM_MS - 180) / 4;
    match (tick * 4 < FROM_MS, controlword) {
        (true, _) if tick < turn_tick => driven(tick, -55_000),
        (true, _) => driven(tick, 55_000),
        (false, Some(word)) => vec![control(word, 55_000)],
        (false, None) => Vec::new(),
    }
}

#[test]
fn a_stop_on_the_way_to_a_far_target_brakes_the_shaft() {
    // A rate loop with the time constant 1/7.1 s, as that of the default gains, needs 31 deg from
    // 220 deg/s; the timeout of commands passes first. A shaft that coasts needs 350 deg.
    for (word, waited_s) in [(Some(0x02), 0.0), (Some(0x07), 0.0), (None, 0.104)] {
        let options = Options::for_ms(FROM_MS + 2000);
        let finished = run_master(options, move |tick| stopped_on_the_way(tick, word));
        let rows = &finished.trace.rows;
        let begin = &rows[rows.partition_point(|row| row.at_ns < FROM_MS * 1_000_000)];
        assert!(begin.rate_deg_s > 150.0, "{begin:?}");
        let end = rows.last().expect("rows");
        let way = end.angle_deg - begin.angle_deg;
        println!("{word:?}: {way:.1} deg from {:.0} deg/s", begin.rate_deg_s);
        assert!(
            way < begin.rate_deg_s * (1.0 / 7.1 + waited_s),
            "{word:?}: {way} deg"
        );
        assert!(end.rate_deg_s.abs() < 1.0, "{end:?}");
    }
}

#[test]
fn without_the_brake_a_shaft_travels_more_than_twice_as_far() {
    let (_, broken, _) = braking_cases().remove(0);
    let observed = (BARE_KG_M2, COASTED_MS);
    let coasting = travel(broken, None, observed, Some(COAST));
    println!("coasting: {:.0} deg, {} ms", coasting.deg, coasting.rest_ms);
    assert!(
        coasting.deg > 2.0 * braked_deg(21, 1.0, BARE_KG_M2),
        "{coasting:?}"
    );
}

#[test]
fn a_torque_of_a_third_of_the_stall_torque_is_held_without_a_fault() {
    let options = Options {
        faults: vec![Planned::at_ms(FROM_MS, Fault::Torque { nm: 0.3 })],
        ..Options::for_ms(FROM_MS + 4000)
    };
    let finished = run_master(options, |tick| driven(tick, 0));
    assert_eq!(faults(&finished), []);
    let last = finished.trace.rows.last().expect("rows");
    // The integrator has removed the deflection.
    assert!(last.angle_deg.abs() < 1.0, "{last:?}");
}

#[test]
fn a_stall_at_full_duty_is_not_taken_for_a_stuck_encoder() {
    let options = Options {
        faults: vec![Planned::at_ms(FROM_MS, Fault::Jam)],
        ..Options::for_ms(FROM_MS + 2000)
    };
    // The protections that a stall triggers are disabled by their times.
    let finished = run_master(options, |tick| match tick {
        22 => vec![write(0x2100, 11, 60_000, 4)],
        24 => vec![write(0x2100, 14, 60_000, 4)],
        26 => vec![write(0x2100, 17, 60_000, 4)],
        _ => driven(tick, if tick < 225 { 0 } else { 60_000 }),
    });
    assert_eq!(faults(&finished), []);
    let full = |row: &&Row| row.current_a > 0.75;
    let stalled = finished.trace.rows.iter().filter(full).count();
    assert!(stalled > 1000, "{stalled} PWM periods at the stall current");
}
