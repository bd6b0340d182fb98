//! The objects of the dictionary and the values behind them.

use super::*;
use crate::dictionary::{DICTIONARY, Location, location};
use crate::measure::MotorConstants;
use crate::parameters::{
    BoardParameters, CONTROL, ModelSettings, ObjectValue, Parameter, tests::ends_of_range,
};
use canopen::Abort;
use canopen::dictionary::{Access, DataType};
use proptest::prelude::*;

#[test]
fn every_object_can_be_read() {
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
fn every_writable_object_accepts_its_present_value() {
    let mut bench = Bench::new();
    for entry in DICTIONARY.entries() {
        let address = entry.address();
        let (index, sub) = (address.index, address.sub);
        // Those with a signature, PDOs, and 1F51h, which nothing staged refuses.
        let skipped = matches!(index, 0x1003 | 0x1010 | 0x1011 | 0x1400..0x1C00 | 0x1f51);
        if entry.access() != Access::ReadWrite || skipped {
            continue;
        }
        let value = bench.get(index, sub);
        let size = entry.data_type().size().expect("a number");
        bench.set(index, sub, value, size);
    }
}

/// Every parameter and every stored value has an object, with default and range of its declaration.
#[test]
fn each_stored_value_is_an_object_with_its_default_and_range() {
    let mut bench = Bench::new();
    let mut control = [false; CONTROL];
    let mut parameters = [false; Parameter::ALL.len()];
    let mut values = [false; ObjectValue::ALL.len()];
    let mut out_of_range = 0;
    for entry in DICTIONARY.entries() {
        let address = entry.address();
        let default = match location(entry) {
            Location::Control(row) => {
                control[row] = true;
                let default = BoardParameters::DEFAULT.control.get(row);
                default.expect("a control parameter").to_bits()
            }
            Location::Parameter(parameter) => {
                parameters[parameter as usize] = true;
                BoardParameters::DEFAULT.word(parameter)
            }
            Location::Value(value) => {
                values[value as usize] = true;
                ObjectValues::DEFAULT.word(value)
            }
            _ => continue,
        };
        let size = entry.data_type().size().expect("a number");
        let mask = u32::MAX >> (32 - 8 * u32::from(size));
        if entry.access() == Access::Write {
            assert_eq!(
                bench.try_get(address.index, address.sub),
                Err(Abort::WriteOnly.code())
            );
        } else {
            assert_eq!(
                bench.get(address.index, address.sub),
                default & mask,
                "{address:?}"
            );
        }
        let Location::Parameter(parameter) = location(entry) else {
            continue;
        };
        assert_eq!(entry.access(), Access::ReadWrite);
        assert_eq!(entry.default_value(0), default, "{address:?}");
        let (min, max) = ends_of_range(default as i32, |value| {
            let mut parameters = BoardParameters::DEFAULT;
            parameters.set_word(parameter, value as u32);
            parameters.is_in_range(parameter)
        });
        for (value, abort) in [
            (min.wrapping_sub(1), Abort::TooLow),
            (max.wrapping_add(1), Abort::TooHigh),
        ] {
            let fits = match entry.data_type() {
                DataType::U16 => (0..=65_535).contains(&value),
                DataType::U32 => value >= 0,
                _ => true,
            };
            if fits {
                let done = bench.try_set(address.index, address.sub, value as u32, size);
                assert_eq!(done, Err(abort.code()), "{parameter:?} = {value}");
                out_of_range += 1;
            }
        }
    }
    // The source after a reset follows 2000h.
    parameters[Parameter::CommandSource as usize] = true;
    assert_eq!(control, [true; CONTROL]);
    assert_eq!(parameters, [true; Parameter::ALL.len()]);
    assert_eq!(values, [true; ObjectValue::ALL.len()]);
    assert!(out_of_range > 70, "{out_of_range}");
}

#[test]
fn real_parameters_refuse_nan_and_values_beyond_their_range() {
    let mut bench = Bench::new();
    let mut refused = |index, sub, value: f32| bench.try_set(index, sub, value.to_bits(), 4);
    assert_eq!(refused(0x60FB, 1, 500.5), Err(Abort::TooHigh.code()));
    assert_eq!(refused(0x60FB, 1, -0.5), Err(Abort::TooLow.code()));
    assert_eq!(refused(0x60FB, 1, f32::NAN), Err(Abort::TooHigh.code()));
    // Infinite limits are not in the dictionary: the application checks.
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
            .actuator
            .device
            .drive
            .parameters()
            .current
            .over_current_ma,
        1_500
    );
}

#[test]
fn relations_between_parameters_are_checked() {
    let mut bench = Bench::new();
    let crossed = Err(Abort::MaximumBelowMinimum.code());
    assert_eq!(bench.try_set(0x607D, 1, 60_001, 4), crossed);
    assert_eq!(
        bench.try_set(0x2100, 18, 8_000, 4),
        crossed,
        "under- above over-voltage"
    );
    assert_eq!(bench.try_set(0x2001, 4, 1_600, 4), crossed);
    assert_eq!(
        bench.try_set(0x2100, 10, 1_600, 4),
        Ok(()),
        "equal to the over-current"
    );
    // Allowed by the range and the dictionary's relation, but the lower half range would be empty.
    let other = Err(Abort::Incompatible.code());
    assert_eq!(bench.try_set(0x2001, 4, 1_500, 4), other);
    assert_eq!(
        bench.try_set(0x2102, 2, 750, 4),
        other,
        "a bit rate that the board does not have"
    );
}

#[test]
fn undefined_modes_and_signals_are_refused() {
    let mut bench = Bench::new();
    let none = Err(Abort::Value.code());
    assert_eq!(bench.try_set(0x6060, 0, 2, 1), none);
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
fn the_loop_knows_the_motor_of_object_2011h() {
    for (sub, value) in [(1, 9.0), (2, 0.005), (3, 200.0), (8, 2e-3)] {
        let mut bench = Bench::new();
        bench.set_real(0x2011, sub, value);
        let drive = &bench.actuator.device.drive;
        let motor = drive.messages.parameters.unverified().motor;
        assert_eq!(motor, MotorConstants::of(&drive.values.model), "{sub}");
        assert_ne!(motor, MotorConstants::of(&ModelSettings::DEFAULT), "{sub}");
    }
}

#[test]
fn measurements_have_their_units() {
    let mut bench = Bench::enabled(9);
    // A large inductance: the current is constant within a PWM period.
    bench.set_real(0x2011, 8, 1.0);
    bench.set(0x60FF, 0, 100_000, 4);
    for _ in 0..100 {
        // The bus voltage of `at_rest` is 5,998 mV; 250 mA flow.
        bench.step_with(|samples| {
            samples.current = Some(model_core::sensors::adc::AdcCode::new(2203))
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
fn the_model_follows_its_motor_and_has_a_residual_with_another_motor() {
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
            worst = worst.max(bench.actuator.device.drive.model.residual_deg().abs());
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

    /// Whatever a master writes, the present parameters are valid together, and nothing panics.
    #[test]
    fn no_write_leaves_invalid_parameters(
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
        let drive = &bench.actuator.device.drive;
        prop_assert_eq!(drive.parameters().check(), Ok(()));
        let (low, high) = drive.messages.parameters.unverified().axis.position_limits.expect("limits");
        prop_assert!(low <= high);
    }
}

#[test]
fn velocities_and_accelerations_of_a_profile_are_at_least_one_unit() {
    let mut bench = Bench::new();
    for index in [0x607F, 0x6081, 0x6083, 0x6084, 0x6085] {
        let before = bench.get(index, 0);
        assert_eq!(bench.try_set(index, 0, 0, 4), Err(0x0609_0032), "{index:x}");
        assert_eq!(bench.get(index, 0), before);
        assert_eq!(bench.try_set(index, 0, 1, 4), Ok(()), "{index:x}");
    }
}

#[test]
fn the_selected_source_of_commands_is_read_back() {
    let mut bench = Bench::new();
    for source in [1, 0] {
        bench.set(0x2000, 0, source, 1);
        bench.step();
        assert_eq!(bench.get(0x2000, 0), source);
    }
}
