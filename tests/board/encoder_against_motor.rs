//! An encoder that does not show what the motor does: the shaft is held or stopped before it is 5
//! deg off.

use board_tests::frames::{angles_cdeg, faults};
use board_tests::master::{Master, driven, to_and_fro};
use board_tests::program::run_script;
use firmware::faults::Fault as Reported;
use virtual_board::faults::{Fault, Planned};
use virtual_board::plant::{BoardPlantOptions, EncoderWire, Stuck};
use virtual_board::run::Options;

/// The shaft rests at the target.
const FROM_MS: u64 = 2_000;

const UNTIL_MS: u64 = 5_000;

/// Target, mdeg.
const TARGET_MDEG: i32 = 20_000;

/// A magnet that slips at a constant rate, deg/s, in steps of a control period.
fn drift(rate_deg_s: f64) -> Vec<Planned> {
    let periods = (UNTIL_MS - FROM_MS) / 4;
    let slip = |period: u64| {
        let deg = rate_deg_s * period as f64 * 0.004;
        let slip = Planned::at_ms(FROM_MS + 4 * period, Fault::MagnetSlips { deg });
        Planned {
            for_ns: Some(3_990_000),
            ..slip
        }
    };
    (1..periods).map(slip).collect()
}

/// A magnet that slips by this angle while the encoder's data are lost for 12 ms.
fn slip_in_a_gap(deg: f64) -> Vec<Planned> {
    let data = Fault::EncoderWire {
        line: EncoderWire::Data,
        stuck: Stuck::Low,
    };
    let gap = Planned::at_ns(FROM_MS * 1_000_000 + 500_000, data);
    let gap = Planned {
        for_ns: Some(11_900_000),
        ..gap
    };
    vec![gap, slip(FROM_MS + 1, deg)]
}

fn slip(at_ms: u64, deg: f64) -> Planned {
    Planned::at_ms(at_ms, Fault::MagnetSlips { deg })
}

/// A frozen word in which a bit of the count is inverted for a control period each 80 ms.
fn flicker() -> Vec<Planned> {
    let frozen = Planned::at_ms(FROM_MS, Fault::EncoderFrozen);
    let inverted = |at_ms| {
        let bits = Fault::EncoderBits { mask: 65 };
        Planned::at_ns(at_ms * 1_000_000 + 500_000, bits).for_ms(4)
    };
    let flips = (FROM_MS..UNTIL_MS).step_by(80).map(inverted);
    [frozen].into_iter().chain(flips).collect()
}

/// What goes wrong while the shaft is held.
struct Case {
    name: &'static str,
    faults: Vec<Planned>,
    /// Time to the report, ms; a motor that creeps from rest takes longer.
    detected_ms: u64,
    reported: &'static [Reported],
}

fn cases() -> Vec<Case> {
    let case = |name, faults, detected_ms, reported| Case {
        name,
        faults,
        detected_ms,
        reported,
    };
    let jump: &[Reported] = &[Reported::EncoderJump];
    let implausible: &[Reported] = &[Reported::EncoderImplausible, Reported::EncoderStuck];
    vec![
        case("drift of 4 deg/s", drift(4.0), 1_200, implausible),
        case("drift of -5 deg/s", drift(-5.0), 800, implausible),
        case("drift of 20 deg/s", drift(20.0), 250, implausible),
        case("drift of -100 deg/s", drift(-100.0), 60, implausible),
        case("slip of 2 deg", vec![slip(FROM_MS, 2.0)], 30, jump),
        case("slip of -45 deg", vec![slip(FROM_MS, -45.0)], 30, jump),
        case("slip of 23 deg in a gap", slip_in_a_gap(23.0), 30, jump),
        case(
            "frozen word",
            vec![Planned::at_ms(FROM_MS, Fault::EncoderFrozen)],
            2_500,
            implausible,
        ),
        case("frozen word that flickers", flicker(), 2_500, implausible),
    ]
}

#[test]
fn the_shaft_is_never_5_deg_off_at_an_encoder_that_slips_drifts_or_freezes() {
    println!("| fault | reported | after | off by at most |\n|---|---|---|---|");
    let mut wrong = Vec::new();
    for case in cases() {
        let options = Options {
            plant: BoardPlantOptions::realistic(3),
            faults: case.faults,
            ..Options::for_ms(UNTIL_MS)
        };
        let finished = run_script(options, Master::new(|tick| driven(tick, TARGET_MDEG)));
        let first = faults(&finished).into_iter().next();
        let (at_ns, number) = first.unwrap_or((0, 0));
        let after_ms = (at_ns / 1_000_000).saturating_sub(FROM_MS);
        let rows = finished.trace.rows.iter();
        let rows: Vec<_> = rows
            .filter(|row| row.at_ns >= FROM_MS * 1_000_000)
            .collect();
        let off = rows
            .iter()
            .map(|row| (row.angle_deg - rows[0].angle_deg).abs());
        let off_deg = off.fold(0.0, f64::max);
        println!(
            "| {} | {number} | {after_ms} ms | {off_deg:.1} deg |",
            case.name
        );
        let is_reported = case
            .reported
            .iter()
            .any(|it| it.number() == u16::from(number));
        if !is_reported || after_ms > case.detected_ms || off_deg > 5.0 {
            wrong.push(case.name);
        }
    }
    assert!(wrong.is_empty(), "{wrong:?}");
}

/// A word with stale last bits has the wrong parity, or an alarm, or the angle that it would have
/// had.
#[test]
fn a_late_clock_of_the_encoder_stops_the_shaft_and_gives_no_wrong_angle() {
    let options = Options {
        plant: BoardPlantOptions::realistic(3),
        faults: vec![Planned::at_ms(FROM_MS, Fault::EncoderClockLate)],
        ..Options::for_ms(UNTIL_MS)
    };
    let finished = run_script(options, Master::new(|tick| driven(tick, to_and_fro(tick))));
    let (at_ns, number) = faults(&finished)[0];
    let expected = [Reported::EncoderInvalid, Reported::MagnetLost];
    let numbers = expected.map(Reported::number);
    assert!(numbers.contains(&number.into()), "{number}");
    let after_ms = at_ns / 1_000_000 - FROM_MS;
    // It stays valid while the shaft is at rest: half of the counts have the stale bit.
    assert!(after_ms < 1_100, "{after_ms} ms");
    for (at_ns, cdeg) in angles_cdeg(&finished) {
        let row = finished.trace.rows.iter().find(|row| row.at_ns >= at_ns);
        let Some(row) = row.filter(|_| at_ns < FROM_MS * 1_000_000 + after_ms * 1_000_000) else {
            break;
        };
        let off_deg = (row.angle_deg - f64::from(cdeg) / 100.0).abs();
        assert!(off_deg < 5.0, "{off_deg} deg at {at_ns} ns");
    }
    let after = finished.trace.rows.iter().filter(|row| row.at_ns > at_ns);
    let angles: Vec<_> = after.map(|row| row.angle_deg).collect();
    let travel_deg = angles.iter().map(|deg| (deg - angles[0]).abs());
    assert!(travel_deg.fold(0.0, f64::max) < 20.0, "{angles:?}");
}
