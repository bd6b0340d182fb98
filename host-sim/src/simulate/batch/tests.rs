use super::*;
use crate::settings::{ModelKind, PlantKind};

/// Boards that differ in gains, plants and delays; some benches are not like the others.
fn settings(count: usize, plant: PlantKind) -> Vec<Settings> {
    let one = |i: usize| {
        let mut settings = Settings::new(ModelKind::Board, plant);
        let mut set = |name, value| settings.set(name, value).unwrap();
        set("position_gain", 4.0 + (i % 7) as f64);
        set("delay_s", 0.003 * (i % 11) as f64);
        match plant {
            PlantKind::FirstOrder => set("motor_gain_up", 2.0 + 0.1 * (i % 5) as f64),
            PlantKind::Drivetrain => {
                set("load_inertia_kg_m2", 1e-6 * (1 + i % 5) as f64);
                match i % 16 {
                    0 => set("friction_model", 4.0),
                    7 => set("shaft_stiffness_nm_deg", f64::INFINITY),
                    12 => set("host_period_s", 0.02),
                    13 => set("encoder_noise_deg", 0.03),
                    _ => {}
                }
            }
        }
        settings
    };
    (0..count).map(one).collect()
}

fn command(actuator: usize, step: usize) -> f64 {
    // Changes in every third step, as a host that is slower than the batch.
    ((actuator * 37 + step / 3 * 61) % 157) as f64 - 78.3
}

fn expected(actuator: &Actuator<Vec<f64>>) -> BatchState {
    let now = actuator.reading();
    BatchState {
        angle_deg: now.angle_deg,
        rate_deg_s: now.rate_deg_s,
        angle_meas_deg: now.angle_meas_deg,
        rate_meas_deg_s: now.rate_meas_deg_s,
    }
}

#[test]
fn every_actuator_moves_as_it_does_alone_also_after_others_were_replaced() {
    for (plant, ticks, count) in [
        (PlantKind::FirstOrder, 80, 70),
        (PlantKind::FirstOrder, 400, 33),
        (PlantKind::FirstOrder, 90, 5),
        (PlantKind::Drivetrain, 80, 5),
        (PlantKind::Drivetrain, 80, 70),
        (PlantKind::Drivetrain, 400, 33),
    ] {
        let settings = settings(count, plant);
        let mut batch = Batch::try_new(&settings, ticks).unwrap();
        let new = |settings: &Settings| Actuator::try_with_ring(settings).unwrap();
        let mut alone: Vec<Actuator<Vec<f64>>> = settings.iter().map(new).collect();
        let mut states = vec![BatchState::default(); count];
        for step in 0..60 {
            if step == 25 {
                let fresh = (0..count).step_by(3);
                let fresh: Vec<_> = fresh.map(|i| (i, settings[(i + 1) % count])).collect();
                batch.replace(&fresh).unwrap();
                for (i, settings) in &fresh {
                    alone[*i] = new(settings);
                }
            }
            let commands: Vec<_> = (0..count).map(|i| command(i, step)).collect();
            batch.step(&commands, &mut states);
            for (i, actuator) in alone.iter_mut().enumerate() {
                actuator.advance(commands[i], ticks).unwrap();
                assert_eq!(states[i], expected(actuator), "{plant} {ticks} {i} {step}");
            }
        }
    }
}

#[test]
fn the_actuator_whose_parameters_are_refused_is_named() {
    let mut settings = settings(50, PlantKind::FirstOrder);
    settings[41].first_order.motor_gain_up = f64::NAN;
    assert_eq!(
        Batch::try_new(&settings, 80).err().map(|e| e.index),
        Some(41)
    );
}
