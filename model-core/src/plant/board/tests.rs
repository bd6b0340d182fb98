use std::vec::Vec;

use crate::control::encoder_word::{EncoderCount, EncoderError, Magnet};
use crate::sensors::adc::AdcCode;
use crate::sensors::dividers::{leg_code, supply_code};

use super::*;

fn plant() -> BoardPlant {
    BoardPlant::try_new(&BoardPlantOptions::default()).unwrap()
}

/// PWM periods with this compare value, the last slot coasting as the board has it every fourth.
fn run(plant: &mut BoardPlant, compare: i32, periods: u32) {
    for period in 0..periods {
        let bridge = Bridge::driven(compare);
        plant.advance(bridge, Slot::Head);
        let is_window = period % 4 == 3;
        plant.advance(if is_window { Bridge::Coast } else { bridge }, Slot::Tail);
    }
}

#[test]
fn the_legs_differ_by_the_back_emf_while_the_bridge_is_off() {
    let mut plant = plant();
    run(&mut plant, 40_000, 400);
    let back_emf_v = plant.reading().back_emf_v;
    assert!(back_emf_v > 3.0);
    let legs = plant.sense_legs(Bridge::Coast);
    assert_eq!(legs.a, leg_code((6.0 + back_emf_v) / 2.0));
    assert_eq!(legs.b, leg_code((6.0 - back_emf_v) / 2.0));
    let driven = plant.sense_legs(Bridge::driven(28_056));
    assert_eq!((driven.a, driven.b), (leg_code(3.0), leg_code(0.0)));
}

#[test]
fn a_word_is_read_behind_the_high_level_of_the_idle_line() {
    let mut plant = plant();
    let word = plant.sense().encoder;
    assert_eq!(word.bits() >> 23, 1);
    assert_eq!(word.bits() & 0x1f, 0);
    assert_eq!(word.word().read().unwrap().count, EncoderCount::new(0));
}

#[test]
fn no_broken_wire_of_the_encoder_gives_a_valid_word() {
    let mut plant = plant();
    for line in [EncoderWire::Data, EncoderWire::Clock, EncoderWire::Select] {
        for stuck in [Stuck::Low, Stuck::High] {
            plant.defects.encoder_wire = Some((line, stuck));
            assert!(
                plant.sense().encoder.word().read().is_err(),
                "{line:?} {stuck:?}"
            );
        }
    }
}

#[test]
fn a_flipped_bit_breaks_the_parity_and_a_lost_magnet_says_so() {
    let mut plant = plant();
    plant.defects.encoder_flipped = 1 << 9;
    assert_eq!(
        plant.sense().encoder.word().read(),
        Err(EncoderError::Parity)
    );
    plant.defects = Defects {
        magnet: Some(Magnet::Lost),
        ..Defects::default()
    };
    assert!(plant.sense().encoder.word().read().is_err());
}

#[test]
fn a_frozen_encoder_repeats_itself_and_a_slipped_magnet_jumps() {
    let mut plant = plant();
    let first = plant.sense().encoder;
    plant.defects.is_encoder_frozen = true;
    run(&mut plant, 56_000, 100);
    assert_eq!(plant.sense().encoder, first);
    plant.defects.is_encoder_frozen = false;
    let free = plant.sense().encoder.word().read().unwrap().count.get();
    assert!(free > 10);
    plant.defects.magnet_slip_deg = 90.0;
    let slipped = plant.sense().encoder.word().read().unwrap().count.get();
    assert_eq!(slipped, free + 1024);
}

#[test]
fn a_short_draws_its_current_while_the_bridge_drives_and_none_while_it_is_off() {
    let mut plant = plant();
    plant.defects.motor_short_ohm = Some(1.0);
    plant.advance(Bridge::driven(56_000), Slot::Head);
    assert!(plant.bridge_current_a() > 6.0);
    plant.advance(Bridge::Coast, Slot::Tail);
    assert_eq!(plant.bridge_current_a(), 0.0);
}

#[test]
fn a_weak_source_sags_under_the_current() {
    let mut plant = plant();
    plant.defects.source_ohm = Some(1.0);
    plant.defects.is_jammed = true;
    run(&mut plant, 56_000, 7);
    // 6 V behind 1 ohm, 7.7 ohm of winding and 60 mA of board; a window every fourth period.
    let current_a = (6.0 - 0.06) / 8.7;
    assert!(
        (plant.supply_v() - (6.0 - 0.06 - current_a)).abs() < 0.02,
        "{}",
        plant.supply_v()
    );
}

#[test]
fn the_supply_pin_shows_the_load_of_the_on_time_whatever_its_share() {
    let mut plant = plant();
    plant.defects.source_ohm = Some(4.0);
    plant.defects.is_jammed = true;
    for compare in [28_056, -28_056] {
        for _ in 0..50 {
            plant.advance(Bridge::driven(compare), Slot::Head);
            plant.advance(Bridge::driven(compare), Slot::Tail);
        }
        plant.advance(Bridge::driven(compare), Slot::Head);
        // Half of the time the whole current flows.
        let drawn_a = plant.bridge_current_a().abs() + 0.06;
        assert!(drawn_a > 0.3);
        assert_eq!(plant.sense().supply, supply_code(6.0 - 4.0 * drawn_a));
        plant.advance(Bridge::Coast, Slot::Head);
        plant.advance(Bridge::Coast, Slot::Tail);
        assert_eq!(plant.sense().supply, supply_code(6.0 - 4.0 * 0.06));
    }
}

#[test]
fn heat_and_a_stuck_converter_show_in_the_codes() {
    let mut plant = plant();
    let cold = plant.sense().temperature;
    plant.defects.temperature_deg_c = Some(90.0);
    plant.defects.stuck_current = Some(AdcCode::MAX);
    let sensed = plant.sense();
    assert!(sensed.temperature < cold);
    assert_eq!(sensed.current, AdcCode::MAX);
}

#[test]
fn the_same_seed_senses_the_same_and_another_something_else() {
    let sense = |seed| {
        let mut plant = BoardPlant::try_new(&BoardPlantOptions::realistic(seed)).unwrap();
        run(&mut plant, 20_000, 50);
        (0..20).map(|_| plant.sense()).collect::<Vec<_>>()
    };
    assert_eq!(sense(3), sense(3));
    assert_ne!(sense(3), sense(4));
}
