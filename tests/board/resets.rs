//! Behaviour of the board after each kind of reset.

use board_tests::frames::{
    Frame, faults, is_fault, is_operation_enabled, is_switch_on_disabled, start, statuswords,
};
use board_tests::master::{driven, to_and_fro};
use board_tests::program::run_master;
use virtual_board::faults::{Fault, Planned};
use virtual_board::plant::{Bridge, EncoderWire, Stuck};
use virtual_board::run::{Options, ResetCause};

const FAULT_MS: u64 = 1000;

/// The last control period with a target, shortly after the fault.
const LAST_TARGET: u64 = 260;

/// Results of a run with a reset.
struct Restart {
    causes: Vec<ResetCause>,
    /// Statuswords by the ends of their frames, ms.
    statuswords: Vec<(u64, u16)>,
    /// State of the bridge, by ms.
    bridges: Vec<(u64, Bridge)>,
}

/// Drives the shaft until the fault; then the master only starts the node, ten times a second.
fn frames(tick: u64) -> Vec<Frame> {
    match tick {
        ..LAST_TARGET => driven(tick, to_and_fro(tick)),
        _ if tick.is_multiple_of(25) => vec![start()],
        _ => Vec::new(),
    }
}

fn restart(fault: Planned) -> Restart {
    let options = Options {
        faults: vec![fault],
        ..Options::for_ms(1600)
    };
    let finished = run_master(options, frames);
    let ms = |ns: u64| ns / 1_000_000;
    let rows = finished.trace.rows.iter();
    Restart {
        causes: finished.resets.iter().map(|reset| reset.cause).collect(),
        bridges: rows.map(|row| (ms(row.at_ns), row.bridge)).collect(),
        statuswords: (statuswords(&finished).into_iter())
            .map(|(at_ns, word)| (ms(at_ns), word))
            .collect(),
    }
}

impl Restart {
    fn last_statusword(&self) -> u16 {
        self.statuswords.last().expect("the board reports").1
    }

    /// Asserts that the bridge is off from the reset on, and that the board sends statuswords again
    /// after its start.
    fn assert_off_and_reporting(&self, from_ms: u64) {
        let after = |ms: u64| ms > from_ms + 1;
        let mut bridges = self.bridges.iter().filter(|(ms, _)| after(*ms));
        assert!(bridges.all(|(_, bridge)| !matches!(bridge, Bridge::Driven { .. })));
        let last = self.last_statusword();
        assert!(!is_operation_enabled(last), "{last:04x}");
        let frames = self.statuswords.iter().filter(|(ms, _)| after(*ms));
        let count = frames.count();
        assert!(count > 50, "{count} statuswords after the reset");
    }
}

#[test]
fn the_reset_pin_switches_the_bridge_off_and_the_board_starts_again() {
    let restart = restart(Planned::at_ms(FAULT_MS, Fault::ResetPin));
    assert_eq!(restart.causes, [ResetCause::Pin]);
    restart.assert_off_and_reporting(FAULT_MS);
}

#[test]
fn a_stalled_core_is_reset_by_the_watchdog_and_the_board_reports_a_fault() {
    let stall = Planned::at_ms(FAULT_MS, Fault::StallCore).for_ms(60);
    let restart = restart(stall);
    assert_eq!(restart.causes.first(), Some(&ResetCause::Model("WWDG")));
    restart.assert_off_and_reporting(FAULT_MS + 60);
    assert!(is_fault(restart.last_statusword()));
}

#[test]
fn a_loss_of_the_supply_causes_a_power_on_reset() {
    let loss = Planned::at_ms(FAULT_MS, Fault::PowerLoss).for_ms(50);
    let restart = restart(loss);
    assert_eq!(restart.causes, [ResetCause::PowerOn]);
    restart.assert_off_and_reporting(FAULT_MS);
    assert!(is_switch_on_disabled(restart.last_statusword()));
}

#[test]
fn a_collapsed_supply_resets_the_board_which_starts_when_it_returns() {
    let sag = Planned::at_ms(FAULT_MS, Fault::Supply { volts: 3.0 }).for_ms(50);
    let restart = restart(sag);
    assert_eq!(restart.causes, [ResetCause::PowerOn]);
    restart.assert_off_and_reporting(FAULT_MS);
}

#[test]
fn an_encoder_that_starts_after_80_ms_delays_the_board_and_causes_no_fault() {
    // Until its first angle OCF is clear, as in a word of zeros.
    let starting = Fault::EncoderWire {
        line: EncoderWire::Data,
        stuck: Stuck::Low,
    };
    let ready_ms = |faults_of_run: Vec<Planned>| {
        let options = Options {
            faults: faults_of_run,
            ..Options::for_ms(400)
        };
        let finished = run_master(options, |tick| match tick {
            2 | 40 => vec![start()],
            _ => Vec::new(),
        });
        assert_eq!(faults(&finished), []);
        let mut words = statuswords(&finished).into_iter();
        let ready = words.find(|(_, word)| is_switch_on_disabled(*word));
        ready.expect("the board is initialised").0 / 1_000_000
    };
    let usual = ready_ms(Vec::new());
    let delayed = ready_ms(vec![Planned::at_ms(0, starting).for_ms(80)]);
    assert!(usual < 80, "{usual} ms");
    // A control period until the word is read, and the period of the statusword.
    assert!((80..80 + 4 + 20 + 1).contains(&delayed), "{delayed} ms");
}
