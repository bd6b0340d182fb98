use super::super::{BitTiming, ErrorState, Id};
use super::*;

fn frame(id: u16) -> Frame {
    Frame::data_frame(Id::Standard(id), &[1, 2, 3])
}

fn station(offer: Option<Frame>) -> Option<Station> {
    Some(Station {
        timing: BitTiming::at_rate(1_000_000),
        state: ErrorState::Active,
        offer,
        is_silent: false,
        needs_acknowledge: true,
    })
}

fn outcome(stations: &[Option<Station>]) -> Option<(usize, Outcome)> {
    arbitrate(stations, WireFault::None, false).map(|t| (t.sender, t.outcome))
}

#[test]
fn the_lowest_identifier_wins_and_others_acknowledge() {
    let stations = [
        station(Some(frame(5))),
        station(Some(frame(3))),
        station(None),
    ];
    assert_eq!(outcome(&stations), Some((1, Outcome::Delivered)));
    assert_eq!(outcome(&[station(None)]), None);
}

#[test]
fn a_frame_without_an_active_receiver_is_not_acknowledged() {
    let mut silent = station(None);
    silent.as_mut().unwrap().is_silent = true;
    let stations = [station(Some(frame(5))), silent, None];
    assert_eq!(outcome(&stations), Some((0, Outcome::Unacknowledged)));
    let mut looped = station(Some(frame(5)));
    looped.as_mut().unwrap().needs_acknowledge = false;
    assert_eq!(outcome(&[looped]), Some((0, Outcome::Delivered)));
}

#[test]
fn a_station_with_another_bit_rate_destroys_frames_until_it_is_error_passive() {
    let mut slow = station(None);
    slow.as_mut().unwrap().timing = BitTiming::at_rate(500_000);
    let sender = station(Some(frame(5)));
    assert_eq!(
        outcome(&[sender, slow]),
        Some((0, Outcome::Disturbed(Some(1))))
    );
    slow.as_mut().unwrap().state = ErrorState::Passive;
    assert_eq!(outcome(&[sender, slow]), Some((0, Outcome::Unacknowledged)));
    assert_eq!(
        outcome(&[sender, slow, station(None)]),
        Some((0, Outcome::Delivered))
    );
}

#[test]
fn two_frames_with_one_identifier_and_different_data_destroy_each_other() {
    let other = Frame::data_frame(Id::Standard(5), &[9]);
    let stations = [station(Some(frame(5))), station(Some(other))];
    assert_eq!(outcome(&stations), Some((0, Outcome::Disturbed(None))));
}

#[test]
fn a_shorted_wire_carries_no_dominant_bit() {
    let stations = [station(Some(frame(5))), station(None)];
    let transfer = arbitrate(&stations, WireFault::Short, false).unwrap();
    assert_eq!(transfer.outcome, Outcome::BitError);
    assert_eq!(transfer.outcome_ns(), 15_000);
}

#[test]
fn a_frame_takes_its_stuffed_bits_and_the_next_waits_for_the_intermission() {
    let mut wire = Wire::new(vec![Port::at_rate(1_000_000)]);
    let (ends_ns, transfer) = wire.start(100, &[station(Some(frame(0x123)))]).unwrap();
    assert_eq!(
        ends_ns,
        100 + u64::from(transfer.frame.bits_on_the_wire()) * 1000
    );
    assert_eq!(wire.next_ns(200, true), Some(ends_ns));
    assert!(wire.finish(ends_ns - 1, 1).is_none());
    assert!(wire.finish(ends_ns, 1).is_some());
    assert_eq!(wire.next_ns(ends_ns, true), Some(ends_ns + 3000));
    assert!(
        wire.start(ends_ns + 2999, &[station(Some(frame(1)))])
            .is_none()
    );
    assert_eq!(wire.ports[0].take_received(), [(ends_ns, frame(0x123))]);
}

#[test]
fn a_port_sends_a_frame_at_its_time_and_does_not_receive_it() {
    let mut wire = Wire::new(vec![Port::at_rate(1_000_000), Port::at_rate(1_000_000)]);
    wire.ports[0].send(5_000, frame(7));
    assert_eq!(wire.next_ns(0, false), Some(5_000));
    assert!(wire.start(4_999, &[None]).is_none());
    let (ends_ns, transfer) = wire.start(5_000, &[None]).unwrap();
    assert_eq!((transfer.sender, transfer.outcome), (1, Outcome::Delivered));
    wire.finish(ends_ns, 1).unwrap();
    assert_eq!(wire.ports[0].queued(), 0);
    assert!(wire.ports[0].take_received().is_empty());
    assert_eq!(wire.ports[1].take_received().len(), 1);
    assert_eq!(wire.take_log().len(), 1);
}

#[test]
fn an_open_wire_disconnects_the_ports() {
    let mut wire = Wire::new(vec![Port::at_rate(1_000_000)]);
    wire.fault = WireFault::Open;
    let (ends_ns, transfer) = wire.start(0, &[station(Some(frame(1)))]).unwrap();
    assert_eq!(transfer.outcome, Outcome::Unacknowledged);
    wire.finish(ends_ns, 1).unwrap();
    assert!(wire.ports[0].take_received().is_empty());
}

#[test]
fn noise_destroys_the_configured_number_of_frames() {
    let mut wire = Wire::new(vec![Port::at_rate(1_000_000)]);
    wire.noise = 1;
    let (ends_ns, transfer) = wire.start(0, &[station(Some(frame(1)))]).unwrap();
    assert_eq!(transfer.outcome, Outcome::Disturbed(None));
    wire.finish(ends_ns, 1).unwrap();
    let next_ns = wire.next_ns(ends_ns, true).unwrap();
    let (_, transfer) = wire.start(next_ns, &[station(Some(frame(1)))]).unwrap();
    assert_eq!(transfer.outcome, Outcome::Delivered);
}
