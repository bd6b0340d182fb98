use std::vec::Vec;

use crate::control::encoder_word::{EncoderCount, EncoderError, Magnet};
use crate::sensors::adc::AdcCode;
use crate::sensors::dividers::leg_code;

use super::*;

mod winding_current;

fn plant() -> BoardPlant {
    BoardPlant::try_new(&BoardPlantOptions::default()).unwrap()
}

/// PWM periods with this compare value, every fourth of them with the coast window.
fn run(plant: &mut BoardPlant, compare: i32, periods: u32) {
    for period in 0..periods {
        let bridge = Bridge::driven(compare);
        for slot in Slot::ALL {
            let is_window = period % 4 == 3 && matches!(slot, Slot::Legs | Slot::Edge);
            let state = if is_window { Bridge::Coast } else { bridge };
            plant.advance(state, slot, bridge.current_instant());
        }
    }
}

fn coast(plant: &mut BoardPlant) {
    for slot in Slot::ALL {
        plant.advance(Bridge::Coast, slot, Bridge::Coast.current_instant());
    }
}

#[test]
fn the_legs_differ_by_the_back_emf_while_the_bridge_is_off() {
    let mut plant = plant();
    run(&mut plant, 40_000, 400);
    let back_emf_v = plant.reading().back_emf_v;
    assert!(back_emf_v > 3.0);
    let Legs { a, b } = plant.sensed().legs;
    // Within a code of rounding and what the sampling capacitor carries over: 0.2 % of at most
    // 1.7 V at the pin, 4 codes.
    let differ = |code: AdcCode, volts| leg_code(volts).bits().abs_diff(code.bits());
    assert!(differ(a, (6.0 + back_emf_v) / 2.0) <= 5, "{a:?}");
    assert!(differ(b, (6.0 - back_emf_v) / 2.0) <= 5, "{b:?}");
}

#[test]
fn a_leg_is_at_a_rail_while_a_diode_conducts() {
    // A reversal from full rate: the current of a stall and the back-EMF add up.
    let mut plant = plant();
    run(&mut plant, 56_000, 500);
    run(&mut plant, -56_000, 4);
    let Legs { a, b } = plant.sensed().legs;
    // A negative current leaves leg A at the supply and a diode, and leg B below ground.
    assert!(a > leg_code(6.0), "{a:?}");
    assert!(b < leg_code(0.05), "{b:?}");
}

#[test]
fn a_stall_at_full_duty_leaves_the_legs_at_half_the_supply() {
    let mut plant = plant();
    plant.defects.is_jammed = true;
    run(&mut plant, 56_000, 40);
    let Legs { a, b } = plant.sensed().legs;
    let volts = |code: AdcCode| code.pin_v() / crate::sensors::dividers::LEG_DIVIDER;
    // 77 us of conduction leave 98 us = 14.7 time constants to settle.
    assert!((volts(a) - 3.0).abs() < 0.02 && (volts(b) - 3.0).abs() < 0.02);
}

#[test]
fn a_word_is_read_behind_the_high_level_of_the_idle_line() {
    let mut plant = plant();
    run(&mut plant, 0, 1);
    let word = plant.sensed().encoder;
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
            run(&mut plant, 0, 1);
            assert!(
                plant.sensed().encoder.word().read().is_err(),
                "{line:?} {stuck:?}"
            );
        }
    }
}

#[test]
fn a_flipped_bit_breaks_the_parity_and_a_lost_magnet_says_so() {
    let mut plant = plant();
    plant.defects.encoder_flipped = 1 << 9;
    run(&mut plant, 0, 1);
    assert_eq!(
        plant.sensed().encoder.word().read(),
        Err(EncoderError::Parity)
    );
    plant.defects = Defects {
        magnet: Some(Magnet::Lost),
        ..Defects::default()
    };
    run(&mut plant, 0, 1);
    assert!(plant.sensed().encoder.word().read().is_err());
}

#[test]
fn a_frozen_encoder_repeats_itself_and_a_slipped_magnet_jumps() {
    let mut plant = plant();
    let first = plant.sensed().encoder;
    plant.defects.is_encoder_frozen = true;
    run(&mut plant, 56_000, 100);
    assert_eq!(plant.sensed().encoder, first);
    plant.defects.is_encoder_frozen = false;
    plant.defects.is_jammed = true;
    run(&mut plant, 0, 1);
    let free = plant.sensed().encoder.word().read().unwrap().count.get();
    assert!(free > 10);
    plant.defects.magnet_slip_deg = 90.0;
    run(&mut plant, 0, 1);
    let slipped = plant.sensed().encoder.word().read().unwrap().count.get();
    assert_eq!(slipped, free + 1024);
}

#[test]
fn a_short_draws_its_current_through_the_return_while_the_bridge_drives_and_none_while_it_is_off() {
    let mut plant = plant();
    plant.defects.motor_short_ohm = Some(1.0);
    run(&mut plant, 56_000, 1);
    assert!(plant.return_peak_a() > 6.0 && plant.motor_current_a() > 6.0);
    coast(&mut plant);
    assert_eq!((plant.return_peak_a(), plant.motor_current_a()), (0.0, 0.0));
}

#[test]
fn the_trip_does_not_see_the_current_that_circulates_in_the_off_time() {
    let mut plant = plant();
    run(&mut plant, 56_000, 500);
    run(&mut plant, 0, 1);
    // 5.7 V of back-EMF behind 7.7 ohm.
    assert!(plant.motor_current_a() < -0.5);
    assert_eq!(plant.return_peak_a(), 0.0);
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
fn the_capacitor_of_the_supply_discharges_and_charges_with_its_time_constant() {
    // 4 ohm, 470 uF: 1.88 ms; beside 7.7 ohm of winding 1.24 ms.
    let mut plant = plant();
    plant.defects.source_ohm = Some(4.0);
    plant.defects.is_jammed = true;
    let settled_v = (6.0 - 4.0 * 0.06) * 7.7 / 11.7;
    let mut last_v = 6.0;
    for period in 1..=3 {
        run(&mut plant, 56_000, 1);
        let expected_v = settled_v + (6.0 - settled_v) * libm::exp(-f64::from(period) / 1.237);
        // The current follows the voltage a slot, 0.3 ms, later, and after 0.13 ms at first.
        let error_v = (plant.supply_v() - expected_v).abs();
        assert!(error_v < 0.3, "{period} ms: {} V", plant.supply_v());
        assert!(plant.supply_v() < last_v);
        last_v = plant.supply_v();
    }
    let charged_v = 6.0 - 4.0 * 0.06;
    run(&mut plant, 0, 1);
    let from_v = plant.supply_v();
    run(&mut plant, 0, 2);
    let expected_v = charged_v + (from_v - charged_v) * libm::exp(-2.0 / 1.88);
    assert!(
        (plant.supply_v() - expected_v).abs() < 0.01,
        "{}",
        plant.supply_v()
    );
}

#[test]
fn heat_and_a_stuck_converter_show_in_the_codes() {
    let mut plant = plant();
    let cold = plant.sensed().temperature;
    plant.defects.temperature_deg_c = Some(90.0);
    plant.defects.stuck_current = Some(AdcCode::MAX);
    plant.defects.stuck_leg = Some(AdcCode::new(7));
    run(&mut plant, 0, 1);
    let sensed = plant.sensed();
    assert!(sensed.temperature < cold);
    assert_eq!(sensed.current, AdcCode::MAX);
    assert_eq!(sensed.legs.a, AdcCode::new(7));
}

#[test]
fn the_same_seed_gives_the_same_samples_and_another_seed_others() {
    let samples = |seed| {
        let mut plant = BoardPlant::try_new(&BoardPlantOptions::realistic(seed)).unwrap();
        let mut samples = Vec::new();
        for _ in 0..70 {
            run(&mut plant, 20_000, 1);
            samples.push(plant.sensed());
        }
        samples
    };
    assert_eq!(samples(3), samples(3));
    assert_ne!(samples(3), samples(4));
}
