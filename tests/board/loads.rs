//! Loads that pull at the shaft when a fault ends its drive: none runs away.

use board_tests::frames::faults;
use board_tests::master::driven;
use board_tests::program::run_master;
use virtual_board::faults::{Fault, Planned};
use virtual_board::plant::{BoardPlantOptions, EncoderWire, Stuck};
use virtual_board::run::Options;

/// The shaft rests at the target, and the load begins to pull; then the fault.
const LOADED_MS: u64 = 1_500;
const FROM_MS: u64 = 2_500;
const UNTIL_MS: u64 = 6_000;

/// Target, mdeg.
const TARGET_MDEG: i32 = 20_000;

/// Greatest rate of a shaft that a load turns, deg/s.
const RUNAWAY_DEG_S: f64 = 60.0;

/// Resistance, ohm, and torque per current at the shaft, N m/A, which is the back-EMF per rate, V
/// per rad/s.
const MOTOR_OHM: f64 = 7.7;
const MOTOR_NM_A: f64 = 1.1584;

/// Greatest mean voltage of the brake, at its greatest duty, over the supply.
const GREATEST_DUTY: f64 = 0.75 * 0.95;

/// The rate that the supply permits to oppose: `-e = i R - duty V`.
fn permitted_deg_s(fault: Option<&Fault>, nm: f64) -> f64 {
    let current_a = nm / MOTOR_NM_A;
    let supply_v = match fault {
        Some(Fault::Supply { volts }) => *volts,
        _ => 6.0,
    };
    let back_emf_v = current_a * MOTOR_OHM - GREATEST_DUTY * supply_v;
    (back_emf_v / MOTOR_NM_A).to_degrees().max(RUNAWAY_DEG_S)
}

/// From this angle on the shaft is at its stop, and rebounds.
const STOP_DEG: f64 = 170.0;

struct Case {
    name: &'static str,
    fault: Option<Fault>,
}

fn cases() -> Vec<Case> {
    let case = |name, fault| Case { name, fault };
    let broken = Fault::EncoderWire {
        line: EncoderWire::Data,
        stuck: Stuck::Low,
    };
    vec![
        case("the load alone", None),
        case("encoder lost", Some(broken)),
        case("encoder frozen", Some(Fault::EncoderFrozen)),
        case(
            "board at 120 deg C",
            Some(Fault::Temperature { deg_c: 120.0 }),
        ),
        case("supply of 3.8 V", Some(Fault::Supply { volts: 3.8 })),
        case("supply of 8 V", Some(Fault::Supply { volts: 8.0 })),
        case("soft supply, 3 ohm", Some(Fault::Source { ohm: 3.0 })),
        case(
            "current sense at zero",
            Some(Fault::CurrentSense { code: 2048 }),
        ),
        case("leg divider open", Some(Fault::LegSense { code: 0 })),
    ]
}

/// What a load has done to a shaft.
struct Outcome {
    /// The first fault: when it was reported, ms, and its number; 0 without one.
    reported: (u64, u8),
    /// The greatest rate between the crossing of the play and the stop, deg/s.
    fastest_deg_s: f64,
    /// Where the shaft is at the end, deg.
    end_deg: f64,
}

/// A drive with this target, a load and the fault of a case.
fn run(case: &Case, nm: f64, target_mdeg: i32) -> Outcome {
    let load = Planned::at_ms(LOADED_MS, Fault::Torque { nm });
    let fault = case.fault.clone().map(|it| Planned::at_ms(FROM_MS, it));
    let options = Options {
        plant: BoardPlantOptions::realistic(3),
        faults: [load].into_iter().chain(fault).collect(),
        ..Options::for_ms(UNTIL_MS)
    };
    let finished = run_master(options, move |tick| driven(tick, target_mdeg));
    let rows = finished.trace.rows.iter();
    let rows = rows.filter(|row| row.at_ns >= (LOADED_MS + 100) * 1_000_000);
    let free = rows.take_while(|row| row.angle_deg.abs() < STOP_DEG);
    let (at_ns, number) = faults(&finished).into_iter().next().unwrap_or((0, 0));
    Outcome {
        reported: (at_ns / 1_000_000, number),
        fastest_deg_s: free.map(|row| row.rate_deg_s.abs()).fold(0.0, f64::max),
        end_deg: finished.trace.rows.last().expect("rows").angle_deg,
    }
}

/// The drive is held where it was enabled, so that nothing but the load has ever turned the motor.
#[test]
fn no_load_runs_away_from_a_drive_that_has_never_moved() {
    let mut wrong = Vec::new();
    let cases = cases();
    // Without a current, or a back-EMF, its sign is not known, and the motor is shorted.
    let is_lowered = |case: &&Case| {
        !matches!(
            case.fault,
            None | Some(Fault::Source { .. } | Fault::CurrentSense { .. } | Fault::LegSense { .. })
        )
    };
    for case in cases.iter().filter(is_lowered) {
        for nm in [0.3, 0.5] {
            let fastest = run(case, nm, 0).fastest_deg_s;
            println!("{}, {nm} N m: {fastest:.0} deg/s", case.name);
            if fastest > permitted_deg_s(case.fault.as_ref(), nm) {
                wrong.push(format!("{}, {nm} N m: {fastest:.0} deg/s", case.name));
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn no_load_of_a_third_or_of_nearly_all_of_the_stall_torque_runs_away_at_a_fault() {
    println!(
        "| fault | load | reported | after | fastest | at the end |\n|---|---|---|---|---|---|"
    );
    let mut wrong = Vec::new();
    for case in cases() {
        for nm in [0.3, 0.5, 0.8] {
            let outcome = run(&case, nm, TARGET_MDEG);
            let (at_ms, number) = outcome.reported;
            let fastest = outcome.fastest_deg_s;
            println!(
                "| {} | {nm} N m | {number} | {} ms | {fastest:.0} deg/s | {:.0} deg |",
                case.name,
                at_ms as i64 - FROM_MS as i64,
                outcome.end_deg
            );
            // It does not carry the current: the board is reset.
            let is_too_soft = matches!(case.fault, Some(Fault::Source { .. })) && nm > 0.5;
            if !is_too_soft && fastest > permitted_deg_s(case.fault.as_ref(), nm) {
                wrong.push(format!("{}, {nm} N m: {fastest:.0} deg/s", case.name));
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}
