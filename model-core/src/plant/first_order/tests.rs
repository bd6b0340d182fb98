use proptest::prelude::*;
use std::vec::Vec;

use super::*;

/// Section S9c of the specification literally: one tick at a time, limits after each.
struct Sequential {
    parameters: FirstOrderParameters,
    pwm: Pwm,
    angle: f64,
    rate: f64,
}

impl Sequential {
    fn advance(&mut self, duty: f64, dt: f64) {
        let p = &self.parameters;
        let gain = if duty > 0.0 {
            p.motor_gain_up
        } else {
            p.motor_gain_down
        };
        let steady = gain * duty;
        let left = libm::exp(-dt / p.motor_time_constant_s);
        self.angle += steady * dt + (self.rate - steady) * p.motor_time_constant_s * (1.0 - left);
        self.rate = steady + (self.rate - steady) * left;
    }

    fn tick(&mut self, duty: f64, q: usize) {
        match self.pwm {
            Pwm::Average => self.advance(duty, TICK_S),
            Pwm::Switched => {
                let on = (duty.abs() / 100.0 * 20.0 - q as f64).clamp(0.0, 1.0);
                self.advance(libm::copysign(100.0, duty), on * TICK_S);
                self.advance(0.0, (1.0 - on) * TICK_S);
            }
        }
        let p = &self.parameters;
        self.rate = self
            .rate
            .clamp(-p.rate_limit_down_deg_s, p.rate_limit_up_deg_s);
        if self.angle.abs() > p.position_limit_deg {
            self.angle = self
                .angle
                .clamp(-p.position_limit_deg, p.position_limit_deg);
            if self.angle * self.rate > 0.0 {
                self.rate = 0.0;
            }
        }
    }
}

fn motor(parameters: FirstOrderParameters, pwm: Pwm) -> FirstOrder {
    FirstOrder::try_new(parameters, pwm).unwrap()
}

fn any_pwm() -> impl Strategy<Value = Pwm> {
    prop_oneof![Just(Pwm::Average), Just(Pwm::Switched)]
}

/// Plants from the fastest motor of the presets (1/54 s) to a slow one, with and without limits in
/// reach.
fn any_parameters() -> impl Strategy<Value = FirstOrderParameters> {
    let limit = || prop_oneof![Just(f64::INFINITY), 0.0..400.0];
    (
        (1.0..4.0, 1.0..4.0, 0.018..0.5),
        (limit(), limit(), 1.0..200.0),
    )
        .prop_map(
            |((up, down, tau), (rate_up, rate_down, stop))| FirstOrderParameters {
                motor_gain_up: up,
                motor_gain_down: down,
                motor_time_constant_s: tau,
                rate_limit_up_deg_s: rate_up,
                rate_limit_down_deg_s: rate_down,
                position_limit_deg: stop,
            },
        )
}

fn any_duties() -> impl Strategy<Value = Vec<f64>> {
    let duty = prop_oneof![
        -100.0..100.0,
        Just(0.0),
        Just(100.0),
        Just(-100.0),
        // Edges on the grid of ticks.
        (-20i32..=20).prop_map(|d| f64::from(d) * 5.0),
    ];
    prop::collection::vec(duty, 1..400)
}

proptest! {
    /// Tolerance of 1e-10 deg and deg/s over up to 0.4 s: the two round differently in 8,000 steps.
    #[test]
    fn every_tick_is_that_of_the_tick_by_tick_recursion(
        parameters in any_parameters(), pwm in any_pwm(), duties in any_duties()
    ) {
        let mut plant = motor(parameters, pwm);
        let mut reference = Sequential { parameters, pwm, angle: 0.0, rate: 0.0 };
        for duty in duties {
            plant.start_period(duty);
            for q in 0..PERIOD {
                let state = plant.at(q);
                prop_assert!((state.angle_deg - reference.angle).abs() < 1e-10);
                prop_assert!((state.rate_deg_s - reference.rate).abs() < 1e-10);
                reference.tick(duty, q);
            }
        }
    }

    #[test]
    fn a_period_starts_bit_exactly_at_the_end_of_the_previous_one(
        parameters in any_parameters(), pwm in any_pwm(), duties in any_duties()
    ) {
        let mut plant = motor(parameters, pwm);
        for duty in duties {
            let end = plant.at(PERIOD);
            plant.start_period(duty);
            let start = plant.at(0);
            prop_assert_eq!(end.angle_deg.to_bits(), start.angle_deg.to_bits());
            prop_assert_eq!(end.rate_deg_s.to_bits(), start.rate_deg_s.to_bits());
        }
    }

    #[test]
    fn the_states_of_all_ticks_equal_those_of_single_ticks_bit_exactly(
        parameters in any_parameters(), pwm in any_pwm(), duties in any_duties()
    ) {
        let mut watched = motor(parameters, pwm);
        let mut unwatched = watched.clone();
        for duty in duties {
            watched.start_period(duty);
            unwatched.start_period(duty);
            let ticks = watched.ticks();
            for q in 0..PERIOD {
                let PlantState { angle_deg, rate_deg_s } = watched.at(q);
                prop_assert_eq!((ticks.angle_deg[q], ticks.rate_deg_s[q]), (angle_deg, rate_deg_s));
            }
        }
        prop_assert_eq!(watched.at(PERIOD), unwatched.at(PERIOD));
    }

    #[test]
    fn any_duty_leaves_a_finite_state_within_the_stops(
        duties in prop::collection::vec(any::<f64>(), 1..50), pwm in any_pwm()
    ) {
        let mut plant = motor(FirstOrderParameters::default(), pwm);
        for duty in duties {
            plant.start_period(duty);
            let state = plant.at(usize::MAX);
            prop_assert!(state.angle_deg.abs() <= 180.0 && state.rate_deg_s.abs() <= 283.6 + 1e-9);
        }
    }
}

#[test]
fn a_nan_duty_is_zero_and_an_infinite_duty_is_full() {
    for pwm in [Pwm::Average, Pwm::Switched] {
        let mut plant = motor(FirstOrderParameters::default(), pwm);
        plant.start_period(f64::NAN);
        assert_eq!(plant.at(PERIOD), PlantState::default());
        let mut full = plant.clone();
        plant.start_period(f64::INFINITY);
        full.start_period(100.0);
        assert_eq!(plant.at(PERIOD), full.at(PERIOD));
    }
}

#[test]
fn switched_and_average_pwm_are_bit_identical_at_full_duty() {
    let mut average = motor(FirstOrderParameters::default(), Pwm::Average);
    let mut switched = motor(FirstOrderParameters::default(), Pwm::Switched);
    for _ in 0..400 {
        average.start_period(100.0);
        switched.start_period(100.0);
        assert_eq!(average.ticks(), switched.ticks());
    }
}

#[test]
fn a_motor_at_its_stop_is_at_rest_and_leaves_it_immediately() {
    let mut plant = motor(FirstOrderParameters::default(), Pwm::Switched);
    for _ in 0..2000 {
        plant.start_period(80.0);
    }
    let at_stop = PlantState {
        angle_deg: 180.0,
        rate_deg_s: 0.0,
    };
    assert_eq!(plant.at(PERIOD), at_stop);
    plant.start_period(-80.0);
    assert!(plant.at(1).angle_deg < 180.0);
}

#[test]
fn a_parameter_outside_its_range_is_refused() {
    let parameters = FirstOrderParameters {
        motor_time_constant_s: f64::NAN,
        ..Default::default()
    };
    assert!(FirstOrder::try_new(parameters, Pwm::Average).is_err());
}
