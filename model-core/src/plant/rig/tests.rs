use std::vec::Vec;

use crate::control::encoder_word::{EncoderCount, EncoderError, Magnet};
use crate::sensors::adc::AdcCode;
use crate::sensors::dividers::{leg_code, supply_code};

use super::*;

fn rig() -> Rig {
    Rig::try_new(&RigOptions::default()).unwrap()
}

/// PWM periods with this compare value, the last slot coasting as the board has it every fourth.
fn run(rig: &mut Rig, compare: i32, periods: u32) {
    for period in 0..periods {
        let bridge = Bridge::driven(compare);
        rig.advance(bridge, Slot::Head);
        let is_window = period % 4 == 3;
        rig.advance(if is_window { Bridge::Coast } else { bridge }, Slot::Tail);
    }
}

#[test]
fn the_legs_differ_by_the_back_emf_while_the_bridge_is_off() {
    let mut rig = rig();
    run(&mut rig, 40_000, 400);
    let back_emf_v = rig.reading().back_emf_v;
    assert!(back_emf_v > 3.0);
    let legs = rig.sense_legs(Bridge::Coast);
    assert_eq!(legs.a, leg_code((6.0 + back_emf_v) / 2.0));
    assert_eq!(legs.b, leg_code((6.0 - back_emf_v) / 2.0));
    let driven = rig.sense_legs(Bridge::driven(28_056));
    assert_eq!((driven.a, driven.b), (leg_code(3.0), leg_code(0.0)));
}

#[test]
fn a_word_is_read_behind_the_high_level_of_the_idle_line() {
    let mut rig = rig();
    let word = rig.sense().encoder;
    assert_eq!(word.bits() >> 23, 1);
    assert_eq!(word.bits() & 0x1f, 0);
    assert_eq!(word.word().read().unwrap().count, EncoderCount::new(0));
}

#[test]
fn no_broken_wire_of_the_encoder_gives_a_valid_word() {
    let mut rig = rig();
    for line in [Line::Data, Line::Clock, Line::Select] {
        for stuck in [Stuck::Low, Stuck::High] {
            rig.defects.encoder_wire = Some((line, stuck));
            assert!(
                rig.sense().encoder.word().read().is_err(),
                "{line:?} {stuck:?}"
            );
        }
    }
}

#[test]
fn a_flipped_bit_breaks_the_parity_and_a_lost_magnet_says_so() {
    let mut rig = rig();
    rig.defects.encoder_flipped = 1 << 9;
    assert_eq!(rig.sense().encoder.word().read(), Err(EncoderError::Parity));
    rig.defects = Defects {
        magnet: Some(Magnet::Lost),
        ..Defects::default()
    };
    assert!(rig.sense().encoder.word().read().is_err());
}

#[test]
fn a_frozen_encoder_repeats_itself_and_a_slipped_magnet_jumps() {
    let mut rig = rig();
    let first = rig.sense().encoder;
    rig.defects.is_encoder_frozen = true;
    run(&mut rig, 56_000, 100);
    assert_eq!(rig.sense().encoder, first);
    rig.defects.is_encoder_frozen = false;
    let free = rig.sense().encoder.word().read().unwrap().count.get();
    assert!(free > 10);
    rig.defects.magnet_slip_deg = 90.0;
    let slipped = rig.sense().encoder.word().read().unwrap().count.get();
    assert_eq!(slipped, free + 1024);
}

#[test]
fn a_short_draws_its_current_while_the_bridge_drives_and_none_while_it_is_off() {
    let mut rig = rig();
    rig.defects.motor_short_ohm = Some(1.0);
    rig.advance(Bridge::driven(56_000), Slot::Head);
    assert!(rig.bridge_current_a() > 6.0);
    rig.advance(Bridge::Coast, Slot::Tail);
    assert_eq!(rig.bridge_current_a(), 0.0);
}

#[test]
fn a_weak_source_sags_under_the_current() {
    let mut rig = rig();
    rig.defects.source_ohm = Some(1.0);
    rig.defects.is_jammed = true;
    run(&mut rig, 56_000, 7);
    // 6 V behind 1 ohm, 7.7 ohm of winding and 60 mA of board; a window every fourth period.
    let current_a = (6.0 - 0.06) / 8.7;
    assert!(
        (rig.supply_v() - (6.0 - 0.06 - current_a)).abs() < 0.02,
        "{}",
        rig.supply_v()
    );
}

#[test]
fn the_supply_pin_shows_the_load_of_the_on_time_whatever_its_share() {
    let mut rig = rig();
    rig.defects.source_ohm = Some(4.0);
    rig.defects.is_jammed = true;
    for compare in [28_056, -28_056] {
        for _ in 0..50 {
            rig.advance(Bridge::driven(compare), Slot::Head);
            rig.advance(Bridge::driven(compare), Slot::Tail);
        }
        rig.advance(Bridge::driven(compare), Slot::Head);
        // Half of the time the whole current flows.
        let drawn_a = rig.bridge_current_a().abs() + 0.06;
        assert!(drawn_a > 0.3);
        assert_eq!(rig.sense().supply, supply_code(6.0 - 4.0 * drawn_a));
        rig.advance(Bridge::Coast, Slot::Head);
        rig.advance(Bridge::Coast, Slot::Tail);
        assert_eq!(rig.sense().supply, supply_code(6.0 - 4.0 * 0.06));
    }
}

#[test]
fn heat_and_a_stuck_converter_show_in_the_codes() {
    let mut rig = rig();
    let cold = rig.sense().temperature;
    rig.defects.temperature_deg_c = Some(90.0);
    rig.defects.stuck_current = Some(AdcCode::MAX);
    let sensed = rig.sense();
    assert!(sensed.temperature < cold);
    assert_eq!(sensed.current, AdcCode::MAX);
}

#[test]
fn the_same_seed_senses_the_same_and_another_something_else() {
    let sense = |seed| {
        let mut rig = Rig::try_new(&RigOptions::realistic(seed)).unwrap();
        run(&mut rig, 20_000, 50);
        (0..20).map(|_| rig.sense()).collect::<Vec<_>>()
    };
    assert_eq!(sense(3), sense(3));
    assert_ne!(sense(3), sense(4));
}
