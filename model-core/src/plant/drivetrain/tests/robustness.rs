//! No input makes the drivetrain panic.

use proptest::prelude::*;

use super::super::stepped::SteppedDrivetrain;
use super::super::*;
use super::drivetrain;
use crate::plant::{PERIOD, Plant, Pwm};

#[test]
fn a_rotor_inertia_below_the_step_resolution_is_refused() {
    let mut p = DrivetrainParameters::default();
    p.electrical.torque_constant_nm_a = 1.0;
    let refused = Drivetrain::try_new(&p).unwrap_err();
    assert!(std::format!("{refused}").starts_with("motor_inertia_kg_m2 is 0.0000002"));
}

#[test]
fn a_hinge_moment_beyond_the_shaft_stiffness_is_refused() {
    let mut p = DrivetrainParameters::default();
    p.load.hinge_moment_nm_deg = -1.0;
    p.gear_train.shaft_stiffness_nm_deg = 0.1;
    let refused = Drivetrain::try_new(&p).unwrap_err();
    assert!(
        std::format!("{refused}")
            .starts_with("hinge_moment_nm_deg is -1, expected a number from -0.1")
    );
}

#[test]
fn an_extreme_torque_leaves_the_state_finite() {
    let mut b = drivetrain(&DrivetrainParameters::default());
    for torque_nm in [f64::MAX, f64::INFINITY, f64::NEG_INFINITY, 0.0] {
        b.set_recorded_torque_nm(torque_nm);
        b.advance(Terminal::Brake, 0.1);
        let now = b.reading();
        for part in [now.output, now.motor, now.load] {
            assert!(
                part.angle_deg.is_finite() && part.rate_deg_s.is_finite(),
                "{now:?}"
            );
        }
    }
}

/// Every parameter anywhere in its range, including the limits and infinity.
fn any_drivetrain() -> impl Strategy<Value = DrivetrainParameters> {
    prop::collection::vec((0.0..1.0, 0..10u8), 40).prop_map(|picks| {
        let mut picks = picks.into_iter().cycle();
        let mut p = DrivetrainParameters::default();
        fill(&mut p.electrical, &mut picks);
        fill(&mut p.gear_train, &mut picks);
        fill(&mut p.friction, &mut picks);
        fill(&mut p.load, &mut picks);
        p
    })
}

fn fill<P: Parameters>(p: &mut P, picks: &mut impl Iterator<Item = (f64, u8)>) {
    for (i, row) in P::TABLE.iter().enumerate() {
        let (share, kind) = picks.next().unwrap();
        let value = match kind {
            0 => row.min,
            1 => row.max,
            2..5 => row.min + share * (row.max.min(100.0) - row.min),
            _ => row.default,
        };
        *p.get_mut(i).unwrap() = value;
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn no_parameters_or_duties_panic_or_leave_the_hard_stops(
        p in any_drivetrain(), duties in prop::collection::vec(any::<f64>(), 1..8),
        pwm in prop_oneof![Just(Pwm::Average), Just(Pwm::Switched)]
    ) {
        if let Ok(mut b) = SteppedDrivetrain::try_new(&p, pwm) {
            for duty in duties {
                b.start_period(duty);
                b.pass_to(PERIOD);
            }
            let angle = b.at(PERIOD).angle_deg;
            prop_assert!(angle.abs() <= p.gear_train.hard_stop_deg + 1e-9);
        }
    }

    #[test]
    fn any_terminal_and_any_time_are_survived(
        v in any::<f64>(), dt in prop_oneof![any::<f64>().prop_filter("long ones take long", |t| *t < 1e-3 || t.is_nan()), Just(f64::NAN)],
        torque in any::<f64>()
    ) {
        let mut b = drivetrain(&DrivetrainParameters::default());
        b.set_recorded_torque_nm(torque);
        for terminal in [Terminal::Driven(v), Terminal::Brake, Terminal::Coast] {
            b.advance(terminal, dt);
            prop_assert!(b.reading().current_a.is_finite());
        }
    }
}
