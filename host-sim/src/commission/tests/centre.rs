//! The middle of the range becomes position 0.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use model_core::plant::board::{BoardPlantOptions, Defects};

use super::bench::{LIMITS, client_within};
use super::saved::START;
use crate::can::client::{Client, ClientError};
use crate::commission::{CommissionError, Findings, Kept, Limits, centre, measure, write};

/// A range on one side, and its middle, mdeg.
const ASIDE: Limits = Limits {
    range_mdeg: Some((-50_000, 20_000)),
    ..LIMITS
};
const MIDDLE_MDEG: i64 = -15_000;

/// Two counts of the encoder, by which a shaft without a load moves when the drive holds it, mdeg.
const COUNTS_MDEG: i64 = 176;

/// A bench, and what is measured within [`ASIDE`]; `polarity` is 607Eh.
fn measured(polarity: u8) -> (Client, Findings) {
    let options = BoardPlantOptions::another_servo(3);
    let mut client = client_within(&options, Defects::default(), 50.0);
    client
        .write("607E", &polarity.to_string())
        .expect("the drive is off");
    let kept = Kept::of(&mut client).expect("values");
    let found = measure(&mut client, &ASIDE).expect("a good bench");
    kept.restore(&mut client).expect("the drive is off");
    (client, found)
}

fn integers<const N: usize>(client: &mut Client, objects: [&str; N]) -> [i64; N] {
    objects.map(|object| client.integer(object).expect("an integer"))
}

#[test]
fn a_restart_keeps_the_middle_with_both_polarities_of_positions() {
    for (polarity, sign) in [(0, 1), (0x80, -1)] {
        let (mut client, mut found) = measured(polarity);
        let [angle] = integers(&mut client, ["6064"]);
        centre(&mut client, &ASIDE, &mut found).expect("the shaft rests");
        write(&mut client, &found).expect("it saves");
        client.manage(0x81).expect("a reset");
        client.pause(START).expect("a start");
        let read = integers(&mut client, ["2041:3", "607D:1", "607D:2", "6098", "607C"]);
        let [origin, low, high, others @ ..] = read;
        assert!(
            (sign * origin + MIDDLE_MDEG).abs() <= COUNTS_MDEG,
            "{origin}"
        );
        assert_eq!(high - low, 70_000);
        assert!((high - 35_000).abs() <= COUNTS_MDEG, "{high}");
        assert_eq!(others, [0, 0]);
        let [moved] = integers(&mut client, ["6064"]).map(|now| now - angle);
        assert!((moved - sign * origin).abs() <= COUNTS_MDEG, "{moved}");
        // By the new positions it is the same servo, whose shaft keeps its range.
        let limits = Limits {
            range_mdeg: Some(found.range_mdeg),
            ..LIMITS
        };
        let mut again = measure(&mut client, &limits).expect("a good bench");
        for (first, second) in found.estimates().iter().zip(again.estimates()) {
            let ((name, .., first), (.., second)) = (first, second);
            let error = first.standard_error.hypot(second.standard_error);
            let z = (first.value - second.value) / error;
            assert!(z.abs() < 3.0, "{name}: {first:?}, {second:?}");
        }
        // And again, where a homing of before is attained.
        again.range_mdeg = (-30_000, 20_000);
        centre(&mut client, &ASIDE, &mut again).expect("the shaft rests");
        let [shift] = integers(&mut client, ["2041:3"]).map(|now| sign * (now - origin));
        assert!((shift - 5_000).abs() <= COUNTS_MDEG, "{shift}");
    }
}

#[test]
fn an_interrupt_before_the_homing_leaves_all_as_before() {
    let (mut client, mut found) = measured(0);
    let objects = ["6060", "6072", "607C", "6098", "607D:1", "607D:2", "2041:3"];
    let before = integers(&mut client, objects);
    let kept = Kept::of(&mut client).expect("values");
    let interrupt = Arc::new(AtomicBool::new(true));
    let centred = client.supervised(
        interrupt,
        |client| centre(client, &ASIDE, &mut found),
        Client::quick_stop,
    );
    let error = centred.expect_err("an interrupt");
    assert!(
        matches!(error, CommissionError::Client(ClientError::Interrupted)),
        "{error}"
    );
    kept.restore(&mut client).expect("the drive is off");
    assert_eq!(integers(&mut client, objects), before);
}

#[test]
fn behind_the_homing_the_range_of_before_is_restored_by_the_new_positions() {
    for (polarity, sign) in [(0, 1), (0x80, -1)] {
        let (mut client, mut found) = measured(polarity);
        let kept = Kept::of(&mut client).expect("values");
        let [high, origin] = integers(&mut client, ["607D:2", "2041:3"]);
        centre(&mut client, &ASIDE, &mut found).expect("the shaft rests");
        let error = kept.restore(&mut client).expect_err("another origin");
        assert!(error.to_string().contains("2041h:3"), "{error}");
        let [new_high, new_origin] = integers(&mut client, ["607D:2", "2041:3"]);
        assert_eq!(new_high - high, sign * (new_origin - origin));
    }
}

#[test]
fn a_range_that_a_restart_does_not_find_again_is_refused() {
    let (mut client, mut found) = measured(0);
    found.range_mdeg = (100_000, 180_000);
    let error = centre(&mut client, &ASIDE, &mut found).expect_err("half a turn");
    assert!(error.to_string().contains("2010h:3"), "{error}");
    assert_eq!(integers(&mut client, ["2041:3"]), [0]);
}
