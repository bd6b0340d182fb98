//! What a reset does to the board, whatever its cause.

use board_tests::frames::Status;
use board_tests::runs::{run_schedule, statuses, to_and_fro};
use virtual_board::faults::{Fault, Planned};
use virtual_board::plant::Bridge;
use virtual_board::run::{Options, ResetCause};

const FAULT_MS: u64 = 1000;

/// Frames of the board, by their ends, ns.
type Statuses = Vec<(u64, Status)>;

/// What the bridge did, by ms.
type Bridges = Vec<(u64, Bridge)>;

fn restart(fault: Planned) -> (Vec<ResetCause>, Statuses, Bridges) {
    let options = Options {
        faults: vec![fault],
        ..Options::for_ms(1600)
    };
    let finished = run_schedule(options, |tick| to_and_fro(tick).filter(|_| tick < 260));
    let causes = finished.resets.iter().map(|reset| reset.cause).collect();
    let bridges = finished.trace.rows.iter();
    let bridges = bridges
        .map(|row| (row.at_ns / 1_000_000, row.bridge))
        .collect();
    (causes, statuses(&finished), bridges)
}

/// From the reset on the bridge is off, and the board reports itself again.
fn comes_back_off(statuses: &[(u64, Status)], bridges: &[(u64, Bridge)], from_ms: u64) {
    let after = |ms: u64| ms > from_ms + 1;
    assert!(
        bridges
            .iter()
            .filter(|(ms, _)| after(*ms))
            .all(|(_, bridge)| *bridge == Bridge::Coast)
    );
    let (_, last) = statuses.last().expect("it reports");
    assert_ne!(last.state, 2, "{last:?}");
    let frames = statuses.iter().filter(|(ns, _)| after(ns / 1_000_000));
    assert!(frames.count() > 50, "it hardly reports");
}

#[test]
fn the_reset_pin_switches_the_bridge_off_and_the_board_starts_anew() {
    let (causes, statuses, bridges) = restart(Planned::at_ms(FAULT_MS, Fault::ResetPin));
    assert_eq!(causes, [ResetCause::Pin]);
    comes_back_off(&statuses, &bridges, FAULT_MS);
}

#[test]
fn a_core_that_stands_still_is_reset_by_the_watchdog_and_the_board_says_so() {
    let stall = Planned::at_ms(FAULT_MS, Fault::StallCore).for_ms(60);
    let (causes, statuses, bridges) = restart(stall);
    assert_eq!(causes.first(), Some(&ResetCause::Model("IWDG")));
    comes_back_off(&statuses, &bridges, FAULT_MS + 60);
    assert_eq!(
        statuses.last().map(|(_, status)| status.state),
        Some(5),
        "a fault"
    );
}

#[test]
fn a_loss_of_the_supply_starts_the_board_from_power_on() {
    let loss = Planned::at_ms(FAULT_MS, Fault::PowerLoss).for_ms(50);
    let (causes, statuses, bridges) = restart(loss);
    assert_eq!(causes, [ResetCause::PowerOn]);
    comes_back_off(&statuses, &bridges, FAULT_MS);
    assert_eq!(
        statuses.last().map(|(_, status)| status.state),
        Some(1),
        "disabled"
    );
}

#[test]
fn a_supply_that_collapses_lets_go_of_the_board_and_takes_it_up_again() {
    let sag = Planned::at_ms(FAULT_MS, Fault::Supply { volts: 3.0 }).for_ms(50);
    let (causes, statuses, bridges) = restart(sag);
    assert_eq!(causes, [ResetCause::PowerOn]);
    comes_back_off(&statuses, &bridges, FAULT_MS);
}
