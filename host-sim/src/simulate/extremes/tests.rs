use super::*;
use crate::{
    input::Sequence,
    scenario::{Scenario, Setting},
    trace::Trace,
};
use model_core::{named::Named, plant::Pwm};

fn simulation(model: ModelKind, every: u64, set: &[(&str, f64)]) -> Simulation {
    let scenario = Scenario {
        model: Some(model),
        input: Some("variable-step".into()),
        // Not a whole number of PWM periods.
        duration_s: Some(5.00015),
        every: Some(every),
        set: set
            .iter()
            .map(|(name, value)| Setting::new(*name, *value))
            .collect(),
        ..Default::default()
    };
    scenario.resolve().unwrap()
}

fn of_trace(trace: &Trace) -> Extremes {
    let column = |name| trace.column(name).unwrap();
    let ends = |values: &[f64]| {
        let least = values.iter().copied().fold(f64::INFINITY, f64::min);
        (
            least,
            values.iter().copied().fold(f64::NEG_INFINITY, f64::max),
        )
    };
    let (angle, rate) = (column("angle_deg"), column("rate_deg_s"));
    Extremes {
        least_angle_deg: ends(angle).0,
        greatest_angle_deg: ends(angle).1,
        least_rate_deg_s: ends(rate).0,
        greatest_rate_deg_s: ends(rate).1,
        last: PlantState {
            angle_deg: *angle.last().unwrap(),
            rate_deg_s: *rate.last().unwrap(),
        },
    }
}

#[test]
fn the_extremes_are_those_of_the_recorded_trace_to_the_last_bit() {
    // Free motion, hard stops, rate limits.
    for set in [
        &[][..],
        &[("position_limit_deg", 50.0)],
        &[("rate_limit_up_deg_s", 100.0)],
    ] {
        for every in [1, 20, 7, 33] {
            let simulation = simulation(ModelKind::Board, every, set);
            let trace = simulation.record().unwrap();
            assert_eq!(
                simulation.extremes().unwrap(),
                of_trace(&trace),
                "every {every}"
            );
        }
    }
}

#[test]
fn every_bench_of_a_campaign_moves_as_it_does_alone() {
    let bench = |k: usize| {
        // Steps of a tick from 4 to 8, and what lanes do not compute.
        let mut set = vec![
            ("load_inertia_kg_m2", 1e-6 * (1 + k % 7) as f64),
            ("coulomb_friction_nm", 0.02 + 1e-4 * k as f64),
        ];
        match k % 20 {
            3 => set.push(("friction_model", (2 + k / 20) as f64)),
            7 => set.push(("shaft_stiffness_nm_deg", f64::INFINITY)),
            11 => set.push(("pendulum_mass_kg", 0.1)),
            13 => set.push(("hard_stop_deg", 15.0)),
            17 => set.push(("coast_when_off", 1.0)),
            _ => {}
        }
        let set = set.into_iter().chain([("input.dwell_s", 0.03)]);
        let scenario = Scenario {
            model: Some(ModelKind::Board),
            plant: Some(PlantKind::Drivetrain),
            pwm: (k % 20 > 15).then_some(Pwm::Switched),
            input: Some("variable-step".into()),
            duration_s: Some(0.20015),
            every: Some(if k == 19 { 7 } else { 1 }),
            set: set.map(|(name, value)| Setting::new(name, value)).collect(),
            ..Default::default()
        };
        let mut simulation = scenario.resolve().unwrap();
        if k == 18 {
            let mut load = Sequence::default();
            load.push(1000, 0.2);
            simulation.load = Some(load);
        }
        simulation
    };
    let simulations: Vec<_> = (0..100).map(bench).collect();
    for (k, extremes) in campaign(&simulations).into_iter().enumerate() {
        let alone = simulations[k].extremes().unwrap();
        assert_eq!(extremes.unwrap(), alone, "{k}");
    }
}

#[test]
fn every_model_can_be_in_a_campaign() {
    let simulations: Vec<_> = ModelKind::ALL
        .iter()
        .map(|model| simulation(*model, 20, &[]))
        .collect();
    for (simulation, extremes) in simulations.iter().zip(campaign(&simulations)) {
        assert_eq!(extremes.unwrap(), of_trace(&simulation.record().unwrap()));
    }
}
