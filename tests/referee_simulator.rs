//! The simulator, with its own excitations, against the referee on all its inputs.
//!
//! It covers the complete path of a command: excitation, delay, model or board, rows. It does not
//! cover the hard stops, which no input of the referee reaches.

use host_sim::scenario::{Scenario, Setting};
use host_sim::settings::{ModelKind, Pwm};
use host_sim::trace::Trace;
use system_tests::{INPUTS, Row, golden};

/// The referee prints every 397th tick.
const EVERY: u64 = 397;

fn run(scenario: &Scenario, input: &str) -> Trace {
    let scenario = Scenario {
        input: Some(input.into()),
        every: Some(EVERY),
        ..scenario.clone()
    };
    scenario
        .resolve()
        .and_then(|simulation| simulation.record())
        .expect("a run")
}

/// The greatest differences of a run from the referee's rows.
#[derive(Debug, Default)]
struct Worst {
    angle_deg: f64,
    rate_deg_s: f64,
    measured_deg: f64,
    squares: f64,
    rows: usize,
}

impl Worst {
    fn of(trace: &Trace, rows: &[Row]) -> Self {
        assert_eq!(trace.len(), rows.len(), "as many rows as the referee");
        let column = |name: &str| trace.column(name).expect("a column").to_vec();
        let (angle, rate) = (column("angle_deg"), column("rate_deg_s"));
        let measured = column("angle_meas_deg");
        let mut worst = Self::default();
        for (i, row) in rows.iter().enumerate() {
            let off_deg = (angle[i] - row.angle_deg).abs();
            worst.angle_deg = worst.angle_deg.max(off_deg);
            worst.rate_deg_s = worst.rate_deg_s.max((rate[i] - row.rate_deg_s).abs());
            worst.measured_deg = worst
                .measured_deg
                .max((measured[i] - row.angle_meas_deg).abs());
            worst.squares += off_deg * off_deg;
            worst.rows += 1;
        }
        worst
    }

    fn rms_deg(&self) -> f64 {
        (self.squares / self.rows as f64).sqrt()
    }
}

#[test]
fn every_model_in_floating_point_agrees_within_a_micro_degree() {
    for (referee, model, preset) in [
        ("bb1", ModelKind::BlackBox1, "paper"),
        ("bb2", ModelKind::BlackBox2, "paper"),
        ("grey", ModelKind::GreyBox, "consistent"),
        ("grey-asym", ModelKind::GreyBox, "asymmetric"),
        ("grey-paper", ModelKind::GreyBox, "as-printed"),
        ("grey-strict", ModelKind::GreyBox, "as-printed-strict"),
    ] {
        let scenario = Scenario {
            model: Some(model),
            preset: Some(preset.into()),
            ..Default::default()
        };
        for input in INPUTS {
            let worst = Worst::of(&run(&scenario, input), &golden(referee, input));
            // The integer sine has an error of 1.5e-9 of its amplitude, which is transmitted with
            // a gain of at most one to the angle, and of the loop's 300 1/s to the rate.
            assert!(worst.angle_deg < 1e-6, "{referee} on {input}: {worst:?}");
            assert!(worst.rate_deg_s < 1e-4, "{referee} on {input}: {worst:?}");
        }
    }
}

#[test]
fn the_board_in_fixed_point_gives_the_referees_encoder_counts_in_every_recorded_row() {
    for (referee, preset, pwm) in [
        ("fw", "consistent", Pwm::Average),
        ("fw-pwm", "consistent", Pwm::Switched),
        ("fw-meas", "as-measured", Pwm::Average),
    ] {
        let scenario = Scenario {
            model: Some(ModelKind::Board),
            preset: Some(preset.into()),
            pwm: Some(pwm),
            ..Default::default()
        };
        for input in INPUTS {
            let worst = Worst::of(&run(&scenario, input), &golden(referee, input));
            // No count differs, so the loops stay together: what is left are coefficients that
            // are off by 2^-31 of them, over a travel of 90 deg.
            assert!(worst.measured_deg < 1e-6, "{referee} on {input}: {worst:?}");
            assert!(worst.angle_deg < 5e-6, "{referee} on {input}: {worst:?}");
        }
    }
}

#[test]
fn the_steps_of_the_boards_timer_change_the_angle_by_less_than_two_encoder_counts() {
    let scenario = Scenario {
        model: Some(ModelKind::Board),
        set: vec![Setting::new("timer_counts", 1.0)],
        ..Default::default()
    };
    for input in INPUTS {
        let worst = Worst::of(&run(&scenario, input), &golden("fw", input));
        // A timer step moves the instant of a count, from where the hunting around it differs.
        assert!(worst.angle_deg < 2.0 * 360.0 / 4096.0, "{input}: {worst:?}");
        assert!(worst.rms_deg() < 0.02, "{input}: {worst:?}");
    }
}
