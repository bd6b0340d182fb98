use super::*;
use proptest::prelude::*;

/// Of a control period of 4 ms.
type Demand = Ramp<4000>;

proptest! {
    #[test]
    fn a_long_division_is_that_of_64_bits(numerator: u64, drop in 0..63u32, divisor: u32, less in 0..32u32) {
        let (numerator, divisor) = (numerator >> drop, divisor >> less);
        let expected = numerator.checked_div(u64::from(divisor)).unwrap_or(0);
        prop_assert_eq!(divide_long(numerator, divisor), expected);
        let nearly = u32::MAX - (divisor & 0x1FFFF);
        prop_assert_eq!(divide_long(numerator, nearly), numerator / u64::from(nearly));
    }

    #[test]
    fn a_division_by_digits_is_the_division_of_64_bits(
        numerator in -i64::MAX..i64::MAX, drop in 0..63u32, divisor in 1..=u32::MAX, short in 1..1u32 << 17
    ) {
        let numerator = numerator >> drop;
        for divisor in [divisor, short, 1_000, 4_000, 1_000_000] {
            prop_assert_eq!(divide(numerator, divisor), numerator / i64::from(divisor));
        }
    }
}

#[test]
fn positions_are_rounded_to_the_nearest_unit_at_both_ends_too() {
    let position = |position| {
        Demand {
            position,
            velocity: 0,
        }
        .position()
    };
    let millionths = [-600_000, -400_000, 0, 400_000, 600_000];
    assert_eq!(millionths.map(position), [-1, 0, 0, 0, 1]);
    for end in [i32::MIN, i32::MAX] {
        assert_eq!(position(i64::from(end) * UNIT), end);
        assert_eq!(Demand::moving(0, end).velocity(), end);
    }
    // The points of a smooth profile may begin beyond it.
    let beyond = Demand::at(0).at_fine(i64::from(i32::MAX) * UNIT + 1_200 * UNIT);
    assert_eq!(beyond.position(), i32::MAX);
}

#[test]
fn any_velocity_of_32_bits_is_reached() {
    let mut ramp = Ramp::<2>::at(0);
    for velocity in [i32::MAX, -5_000_000, -i32::MAX] {
        ramp.set_velocity(velocity);
        assert_eq!(ramp.velocity(), velocity);
    }
}

#[test]
fn a_target_a_unit_away_is_not_reached_at_once() {
    let limits = Limits {
        velocity: 100,
        acceleration: 1000,
        deceleration: 1000,
    };
    for target in [1, -1] {
        assert!(!Demand::at(0).to_position(target, &limits));
    }
    let reaches = |position| {
        let mut ramp = Demand {
            position,
            velocity: 0,
        };
        ramp.to_position(1, &limits)
    };
    // A target less than half a unit away is reached.
    assert_eq!(
        [500_000, 500_001, 1_499_999, 1_500_000].map(reaches),
        [false, true, true, false]
    );
    assert!(Demand::at(1).to_position(1, &limits));
}

#[test]
fn square_roots_are_exact_beside_every_square() {
    for root in 0..1_u32 << 16 {
        let square = root * root;
        let neighbours = [square.saturating_sub(1), square, square + 1, square + root];
        for value in neighbours.into_iter().chain([square + 2 * root]) {
            assert_eq!(square_root(value), value.isqrt(), "{value}");
        }
    }
    assert_eq!(square_root(u32::MAX), u16::MAX.into());
}

#[test]
fn a_trapezoidal_profile_takes_the_time_of_the_closed_form() {
    // 60 deg at 300 deg/s and 3000 deg/s^2: v/a + s/v = 0.1 s + 0.2 s.
    let limits = Limits {
        velocity: 300_000,
        acceleration: 3_000_000,
        deceleration: 3_000_000,
    };
    let mut ramp = Demand::at(0);
    let mut periods = 0;
    while !ramp.to_position(60_000, &limits) {
        periods += 1;
    }
    assert_eq!(ramp, Ramp::at(60_000));
    // The velocity changes at the start of a period, which saves half a period at each end.
    assert_eq!(periods, 75 - 1, "0.3 s in periods of 4 ms");
}

#[test]
fn velocity_ramps_use_acceleration_to_speed_up_and_deceleration_to_slow_down() {
    let limits = Limits {
        velocity: 1000,
        acceleration: 1000,
        deceleration: 2000,
    };
    let mut ramp = Ramp::<1000>::at(0);
    let mut until = |target: i32| {
        (1..).find(|_| {
            ramp.to_velocity(target, &limits);
            ramp.velocity() == target
        })
    };
    assert_eq!(until(500), Some(500));
    assert_eq!(until(0), Some(250));
    assert_eq!(until(-100), Some(100));
    assert_eq!(until(100), Some(50 + 100), "down to zero, then up");
}

#[test]
fn nothing_overflows_at_the_ends_of_the_range() {
    let limits = Limits {
        velocity: u32::MAX,
        acceleration: u32::MAX,
        deceleration: u32::MAX,
    };
    fn run<const PERIOD_US: u32>(limits: &Limits) {
        let mut ramp = Ramp::<PERIOD_US>::at(i32::MIN);
        for _ in 0..100 {
            ramp.to_position(i32::MAX, limits);
            ramp.to_velocity(i32::MIN, limits);
            ramp.interpolate(i32::MAX, 0, u32::MAX);
            ramp.set_velocity(i32::MIN);
            assert!(Ramp::<PERIOD_US>::stopping_velocity(u32::MAX, 0) >= 0);
        }
    }
    run::<2>(&limits);
    run::<4_000>(&limits);
    run::<65_535>(&limits);
}

#[test]
fn an_acceleration_of_0_counts_as_1() {
    assert_eq!([0, 1, 2].map(velocity_change::<4_000>), [4, 4, 8]);
    assert_eq!([0, 1, 7].map(velocity_change::<333>), [1, 1, 2]);
}

#[test]
fn the_braking_velocity_is_exact_at_the_ends_of_its_range() {
    let longest = u64::from(u32::MAX) * UNIT as u64;
    for step in [1, u64::from(u32::MAX), u64::from(u32::MAX) * 65] {
        braking_velocity_is_exact::<2>(longest, step).unwrap();
        braking_velocity_is_exact::<65_535>(longest, step).unwrap();
    }
    // A step of more than 32 bits in a short period.
    braking_velocity_is_exact::<80>(2_430_607_891_616, 78_536_544_832).unwrap();
}

/// Calls a function with one of these periods, us: powers of two of milliseconds, other whole
/// milliseconds, and others.
macro_rules! with_period {
    ($of:expr, $function:ident($($argument:expr),*)) => {
        match $of % 7 {
            0 => $function::<16>($($argument),*),
            1 => $function::<333>($($argument),*),
            2 => $function::<1_000>($($argument),*),
            3 => $function::<3_000>($($argument),*),
            4 => $function::<4_000>($($argument),*),
            5 => $function::<16_000>($($argument),*),
            _ => $function::<19_997>($($argument),*),
        }
    };
}

fn braking_velocity_is_exact<const PERIOD_US: u32>(
    distance: u64,
    step: u64,
) -> Result<(), TestCaseError> {
    let travel = distance * 1000 / u64::from(PERIOD_US);
    // The greatest k with d k (k + 1)/2 <= travel.
    let exact = ((u128::from(travel) * 8 / step as u128 + 1).isqrt() - 1) / 2;
    let saved = step as u128 * exact * (exact + 1) / 2;
    let velocity = (u128::from(travel) + saved) / (exact + 1);
    prop_assert_eq!(
        braking_velocity::<PERIOD_US>(distance, step),
        velocity as i64
    );
    Ok(())
}

fn stops_within<const PERIOD_US: u32>(
    distance: u32,
    deceleration: u32,
) -> Result<(), TestCaseError> {
    let velocity = Ramp::<PERIOD_US>::stopping_velocity(distance, deceleration);
    let (v, a, t) = (
        f64::from(velocity),
        f64::from(deceleration),
        f64::from(PERIOD_US) * 1e-6,
    );
    // The step of the velocity is a whole number of units.
    let way = v * t + v * v / (2.0 * a);
    prop_assert!(way <= f64::from(distance) + v * 1e-6 * t + 1.0 / a + v / a);
    Ok(())
}

fn ends_within<const PERIOD_US: u32>(
    (start, target): (i32, i32),
    limits: Limits,
) -> Result<(), TestCaseError> {
    let mut ramp = Ramp::<PERIOD_US>::at(start);
    let (low, high) = (start.min(target), start.max(target));
    for period in 0.. {
        let before = ramp.velocity;
        if ramp.to_position(target, &limits) {
            break;
        }
        prop_assert!(period < 30_000_000 / PERIOD_US * 10);
        let faster = ramp.velocity.abs() > before.abs();
        let rate = if faster {
            limits.acceleration
        } else {
            limits.deceleration
        };
        prop_assert!((ramp.velocity - before).abs() <= velocity_change::<PERIOD_US>(rate));
        prop_assert!(ramp.velocity.unsigned_abs() <= u64::from(limits.velocity) * 1000);
        prop_assert!((low..=high).contains(&ramp.position()), "no overshoot");
    }
    prop_assert_eq!(ramp, Ramp::at(target));
    Ok(())
}

proptest! {
    #[test]
    fn the_braking_velocity_is_that_of_the_exact_number_of_periods(
        distance: u64, drop in 12..60_u32, step in 1..1_u64 << 40, short in 0..40_u32, period: u8,
    ) {
        let (distance, step) = (distance >> drop, (step >> short).max(1));
        with_period!(period, braking_velocity_is_exact(distance, step))?;
    }

    #[test]
    fn a_stop_of_many_periods_starts_at_their_velocity_reductions(
        k in 1_u64 << 14..1 << 18, short in 0..10_u32, share in prop_oneof![Just(0.0), Just(1.0), 0.0..1.0_f64],
    ) {
        // The longest distance is 2^52, at 1 ms that in velocity increments times one period.
        let step = ((1_u64 << 52) / (k * k)) >> short;
        let rest = (share * (step * (k + 1) - 1) as f64) as u64;
        let travel = step * (k * (k + 1) / 2) + rest;
        let expected = step * k + rest / (k + 1);
        prop_assert_eq!(braking_velocity::<1000>(travel, step), expected as i64);
    }

    #[test]
    fn the_rough_square_root_is_low_by_a_32768th_at_most(value: u64, shift in 0..64_u32) {
        let exact = (value >> shift).isqrt();
        let rough = u64::from(rough_square_root(value >> shift));
        prop_assert!(rough <= exact && exact - rough <= exact / 32_768, "{rough} for {exact}");
    }

    #[test]
    fn a_stop_from_the_stopping_velocity_ends_within_the_distance(
        distance in 1..10_000_000_u32, deceleration in 1..100_000_000_u32, period: u8,
    ) {
        with_period!(period, stops_within(distance, deceleration))?;
    }

    #[test]
    fn a_move_ends_at_its_target_within_its_limits(
        start in -100_000..100_000_i32,
        target in -100_000..100_000_i32,
        velocity in 1_000..2_000_000_u32,
        acceleration in 10_000..10_000_000_u32,
        deceleration in 10_000..10_000_000_u32,
        period: u8,
    ) {
        let limits = Limits { velocity, acceleration, deceleration };
        with_period!(period, ends_within((start, target), limits))?;
    }
}
