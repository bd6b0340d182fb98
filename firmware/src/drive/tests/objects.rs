//! The dictionary against what stands behind it.

use super::*;
use crate::dictionary::DICTIONARY;
use crate::parameters::{CONTROL, Meaning, Value};
use canopen::Abort;
use canopen::dictionary::{Access, DataType};
use proptest::prelude::*;

#[test]
fn every_object_can_be_read_and_no_address_is_unknown_to_the_drive() {
    let mut bench = Bench::new();
    for entry in DICTIONARY.entries() {
        let address = entry.address();
        let data_type = entry.data_type();
        if data_type == DataType::Domain || entry.access() == Access::Write {
            continue;
        }
        let read = bench.try_get(address.index, address.sub);
        let is_history = address.index == 0x1003 && address.sub > 0;
        assert!(read.is_ok() || is_history, "{address:?}: {read:x?}");
    }
    assert_eq!(bench.try_get(0x2032, 0), Err(Abort::NoData.code()));
}

#[test]
fn every_writable_object_takes_the_value_that_it_has() {
    let mut bench = Bench::new();
    for entry in DICTIONARY.entries() {
        let address = entry.address();
        let (index, sub) = (address.index, address.sub);
        let skipped = matches!(index, 0x1003 | 0x1010 | 0x1011 | 0x1400..0x1C00);
        if entry.access() != Access::ReadWrite || skipped {
            continue;
        }
        let value = bench.get(index, sub);
        let size = entry.data_type().size().expect("a number");
        bench.set(index, sub, value, size);
    }
}

/// Of every parameter of the board there is an object, and the dictionary's default, limits and names are its own.
#[test]
fn parameters_of_the_board_are_objects_with_their_defaults_and_ranges() {
    let mut bench = Bench::new();
    let mut seen = [false; BoardParameters::COUNT as usize];
    for entry in DICTIONARY.entries() {
        let address = entry.address();
        let Some(number) = numbers::number_of(address) else {
            continue;
        };
        seen[usize::from(number)] = true;
        let default = BoardParameters::DEFAULT.get(number).expect("a parameter");
        let expected = match default {
            Value::Real(value) => value.to_bits(),
            Value::Integer(value) => value as u32,
        };
        assert_eq!(
            bench.get(address.index, address.sub),
            expected,
            "{address:?}"
        );
        let meaning = BoardParameters::meaning(number).expect("known");
        let Meaning::Integer(row) = meaning else {
            assert!(usize::from(number) < CONTROL);
            continue;
        };
        assert_eq!(entry.default_value(0), row.default as u32, "{}", row.name);
        let size = entry.data_type().size().expect("a number");
        for (value, abort) in [
            (row.range.min.wrapping_sub(1), Abort::TooLow),
            (row.range.max.wrapping_add(1), Abort::TooHigh),
        ] {
            let is_u16 = size == 2;
            if is_u16 && !(0..=65_535).contains(&value)
                || value < 0
                    && row.range.min >= 0
                    && size == 4
                    && entry.data_type() == DataType::U32
            {
                continue;
            }
            let done = bench.try_set(address.index, address.sub, value as u32, size);
            assert_eq!(done, Err(abort.code()), "{} = {value}", row.name);
        }
    }
    // The source after a reset follows 2000h.
    seen[usize::from(numbers::SOURCE)] = true;
    let missing: Vec<_> = seen
        .iter()
        .enumerate()
        .filter(|(_, seen)| !**seen)
        .collect();
    assert!(missing.is_empty(), "{missing:?}");
}

#[test]
fn real_parameters_refuse_what_is_beyond_their_range_and_nan() {
    let mut bench = Bench::new();
    let mut refused = |index, sub, value: f32| bench.try_set(index, sub, value.to_bits(), 4);
    assert_eq!(refused(0x60FB, 1, 500.5), Err(Abort::TooHigh.code()));
    assert_eq!(refused(0x60FB, 1, -0.5), Err(Abort::TooLow.code()));
    assert_eq!(refused(0x60FB, 1, f32::NAN), Err(Abort::TooHigh.code()));
    // Without limits in the dictionary, as they are infinite: the application looks.
    assert_eq!(refused(0x60FB, 2, f32::NAN), Err(Abort::Value.code()));
    assert_eq!(refused(0x2010, 4, 0.5), Err(Abort::Value.code()));
}

#[test]
fn gains_change_while_enabled_and_protection_limits_and_identity_do_not() {
    let mut bench = Bench::enabled(8);
    bench.set_real(0x60FB, 1, 10.0);
    assert_eq!(f32::from_bits(bench.get(0x60FB, 1)), 10.0);
    let state = Err(Abort::DeviceState.code());
    assert_eq!(bench.try_set(0x2100, 8, 1_500, 4), state);
    assert_eq!(bench.try_set(0x2102, 1, 5, 4), state);
    assert_eq!(bench.try_set(0x607D, 1, 0, 4), state);
    assert_eq!(bench.try_set(0x6065, 0, 5_000, 4), state);
    assert_eq!(bench.try_set(0x2010, 3, 0, 4), state);
    assert_eq!(bench.try_set(0x2040, 1, 0, 4), state);
    bench.control(0);
    bench.set(0x2100, 8, 1_500, 4);
    assert_eq!(
        bench
            .device
            .drive
            .application()
            .parameters()
            .current
            .over_current_ma,
        1_500
    );
}

#[test]
fn related_parameters_are_held_to_each_other() {
    let mut bench = Bench::new();
    let crossed = Err(Abort::MaximumBelowMinimum.code());
    assert_eq!(bench.try_set(0x607D, 1, 60_001, 4), crossed);
    assert_eq!(
        bench.try_set(0x2100, 18, 7_000, 4),
        crossed,
        "under- above over-voltage"
    );
    assert_eq!(bench.try_set(0x2001, 4, 1_600, 4), crossed);
    assert_eq!(
        bench.try_set(0x2100, 10, 1_600, 4),
        Ok(()),
        "equal to the over-current"
    );
    // Allowed by the limits and the relation, but no half is left for its angles.
    let other = Err(Abort::Incompatible.code());
    assert_eq!(bench.try_set(0x2001, 4, 1_500, 4), other);
    assert_eq!(
        bench.try_set(0x2102, 2, 750, 4),
        other,
        "a bit rate that the board has not"
    );
}

#[test]
fn values_that_name_something_must_name_something() {
    let mut bench = Bench::new();
    let none = Err(Abort::Value.code());
    assert_eq!(bench.try_set(0x6060, 0, 6, 1), none);
    assert_eq!(bench.try_set(0x2031, 1, 200, 1), none);
    bench.set(0x2031, 1, 255, 1);
    assert_eq!(
        bench.try_set(0x2020, 1, 1, 1),
        Err(Abort::DeviceState.code()),
        "without power"
    );
}

#[test]
fn an_excitation_beyond_the_position_limits_is_refused() {
    let mut bench = Bench::enabled(1);
    bench.set(0x2020, 4, 60_001, 4);
    let refused = Err(Abort::Incompatible.code());
    assert_eq!(bench.try_set(0x2020, 1, 1, 1), refused);
    bench.set(0x2020, 4, 59_000, 4);
    assert_eq!(bench.try_set(0x2020, 1, 1, 1), Ok(()));
    bench.set(0x2020, 1, 0, 1);
    // Eight lines of 10 deg.
    bench.set(0x2020, 3, 9, 4);
    bench.set(0x2020, 4, 10_000, 4);
    assert_eq!(bench.try_set(0x2020, 1, 1, 1), refused);
}

#[test]
fn measurements_have_their_units() {
    let mut bench = Bench::enabled(9);
    bench.set(0x60FF, 0, 100_000, 4);
    for _ in 0..100 {
        // The bus voltage of `at_rest` is 5,998 mV; half an ampere flows.
        bench.step_with(|samples| {
            samples.current = Some(model_core::sensors::adc::AdcCode::new(2360))
        });
        bench.set(0x60FF, 0, 100_000, 4);
    }
    let signed = |bench: &mut Bench, index, sub| bench.get(index, sub) as i16;
    let current = i32::from(signed(&mut bench, 0x2004, 0));
    assert!((240..260).contains(&current), "{current} mA");
    assert_eq!(
        i32::from(signed(&mut bench, 0x6078, 0)),
        current * 1000 / 500
    );
    assert_eq!(bench.get(0x6079, 0), 5_998);
    assert_eq!(signed(&mut bench, 0x2006, 0), 250);
    let duty = f64::from(signed(&mut bench, 0x2002, 0)) * 1e-4;
    let volts = f64::from(signed(&mut bench, 0x2005, 0)) * 1e-3;
    assert!((volts - duty * 5.998).abs() < 0.02, "{volts} V at {duty}");
    let angle = bench.angle_mdeg();
    assert!((i32::from(signed(&mut bench, 0x2008, 1)) * 10 - angle).abs() < 1_000);
    let rate = i32::from(signed(&mut bench, 0x2008, 2)) * 100;
    assert!((70_000..130_000).contains(&rate), "{rate} mdeg/s");
    assert_eq!(bench.get(0x2007, 2) / 4_000 % 65_536, bench.get(0x2007, 1));
}

#[test]
fn the_model_follows_the_motor_that_it_describes_and_tells_one_that_it_does_not() {
    let mut bench = Bench::new();
    bench.set(0x2010, 2, 1, 1);
    // The plant is linear: 283.6 deg/s at 6 V and 0.1318 s, without friction.
    bench.set_real(0x2011, 6, 0.0);
    bench.set(0x6060, 0, 1, 1);
    bench.enable();
    let residual = |bench: &mut Bench| {
        bench.set(0x607A, 0, 40_000, 4);
        bench.control(0x1F);
        let mut worst = 0.0_f32;
        for _ in 0..80 {
            bench.step();
            worst = worst.max(bench.device.drive.model.residual_deg().abs());
        }
        bench.control(0x0F);
        bench.set(0x607A, 0, 0, 4);
        bench.control(0x1F);
        bench.steps(200);
        bench.control(0x0F);
        worst
    };
    let right = residual(&mut bench);
    bench.set_real(0x2011, 4, 0.0464);
    let wrong = residual(&mut bench);
    assert!(
        right < 2.0 && wrong > 2.0 * right,
        "{right} and {wrong} deg"
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Whatever a master writes, the parameters in force go together, and nothing panics.
    #[test]
    fn no_write_leaves_parameters_that_do_not_go_together(
        writes in proptest::collection::vec((0..DICTIONARY.entries().len(), any::<u32>(), 0..6u32), 1..60)
    ) {
        let mut bench = Bench::new();
        for (at, value, small) in writes {
            let entry = &DICTIONARY.entries()[at];
            let address = entry.address();
            let is_store = matches!(address.index, 0x1010 | 0x1011);
            if let Some(size) = entry.data_type().size().filter(|size| *size <= 4 && !is_store) {
                let value = if small == 0 { value } else { value % (10 * small) };
                let _ = bench.try_set(address.index, address.sub, value, size);
            }
            bench.step();
        }
        let drive = &bench.device.drive;
        prop_assert_eq!(drive.application().parameters().check(), Ok(()));
        let (low, high) = drive.axis_parameters.position_limits.expect("limits");
        prop_assert!(low <= high);
    }
}
