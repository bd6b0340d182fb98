//! The board with the other chip goes on after faults of its bus and its bridge, and after a reset.

use board_tests::frames::{from_wire, write};
use board_tests::master::{driven, to_and_fro};
use board_tests::program::run_master;
use virtual_board::board::ChipKind;
use virtual_board::can::{Outcome, WireFault};
use virtual_board::faults::{Fault, Planned};
use virtual_board::plant::Bridge;
use virtual_board::run::Options;

/// Frames of the board with this identifier that were delivered, as their ends, ms.
fn delivered(options: Options, id: u32) -> Vec<u64> {
    let finished = run_master(options, |tick| match tick {
        // Bus-off does not end OPERATIONAL.
        15 => vec![write(0x1029, 1, 1, 1)],
        _ => driven(tick, to_and_fro(tick)),
    });
    let frames = finished.trace.frames.iter();
    let own = frames.filter(|sent| sent.sender == 0 && sent.outcome == Outcome::Delivered);
    own.filter(|sent| from_wire(&sent.frame).raw_id().0 == id)
        .map(|sent| sent.at_ns / 1_000_000)
        .collect()
}

fn options(faults: Vec<Planned>) -> Options {
    Options {
        chip: ChipKind::H743,
        faults,
        ..Options::for_ms(1_500)
    }
}

#[test]
fn telemetry_returns_after_bus_off_and_a_bus_without_listeners() {
    const TELEMETRY: u32 = 0x281;
    for (wire, ms) in [(WireFault::Short, 50), (WireFault::Open, 200)] {
        let fault = Planned::at_ms(1_000, Fault::Can { wire }).for_ms(ms);
        let times = delivered(options(vec![fault]), TELEMETRY);
        let gap = times
            .windows(2)
            .map(|pair| (pair[1] - pair[0], pair[0]))
            .max();
        let (gap, before) = gap.expect("telemetry");
        // The last frame before is that of one of the last two control periods.
        assert!(
            (992..1_004).contains(&before),
            "{wire:?}: the gap begins at {before} ms"
        );
        // Behind bus-off the longest wait is that of the second try, 20 ms, with its listening.
        assert!((ms..ms + 68).contains(&gap), "{wire:?}: {gap} ms");
    }
}

#[test]
fn a_reset_starts_the_node_again() {
    const BOOT_UP: u32 = 0x701;
    let times = delivered(
        options(vec![Planned::at_ms(1_000, Fault::ResetPin)]),
        BOOT_UP,
    );
    let starts: Vec<u64> = times
        .into_iter()
        .filter(|ms| *ms < 60 || (1_000..1_080).contains(ms))
        .collect();
    assert_eq!(starts.len(), 2, "{starts:?}");
}

#[test]
fn a_trip_opens_the_bridge() {
    let trip = Planned::at_ms(1_000, Fault::BridgeTrip).for_ms(3);
    let finished = run_master(options(vec![trip]), |tick| driven(tick, to_and_fro(tick)));
    let is_driven = |from: u64, to: u64| {
        let range = from * 1_000_000..to * 1_000_000;
        let rows = finished
            .trace
            .rows
            .iter()
            .filter(|row| range.contains(&row.at_ns));
        rows.filter(|row| row.bridge != Bridge::Coast).count()
    };
    assert!(is_driven(900, 998) > 50);
    assert_eq!(is_driven(1_002, 1_500), 0);
}
