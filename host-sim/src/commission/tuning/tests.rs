//! Benches with secret parameters, and models of known ones.

use std::time::Duration;

use firmware::capture::Signal;
use model_core::plant::board::Defects;
use model_core::sensors::noise::Noise;

use super::design::REACH;
use super::*;
use crate::commission::tests::{LIMITS, client};
use crate::commission::{Contradiction, measure, write};

const fn exact(value: f64) -> Estimate {
    Estimate {
        value,
        standard_error: 0.0,
    }
}

/// What an ideal identification of a plant finds.
fn known(plant: &BoardPlantOptions) -> Identified {
    let drivetrain = &plant.drivetrain;
    let (motor, gears) = (&drivetrain.electrical, &drivetrain.gear_train);
    Identified {
        most_a: 1.6,
        resistance_ohm: exact(motor.winding_resistance_ohm),
        inductance_h: motor.winding_inductance_h,
        v_s_rad: exact(motor.torque_constant_nm_a * gears.gear_ratio),
        inertia_kg_m2: exact(gears.inertia_kg_m2()),
        viscous_nm_s: exact(drivetrain.friction.viscous_friction_nm_s_deg.to_degrees()),
        delay_s: exact(twin::DELAY_S),
        supply_v: exact(motor.supply_v),
    }
}

/// Without friction and backlash a model of the motor is linear but for the counts of the encoder.
#[test]
fn the_linear_loop_is_that_of_the_model() {
    let mut plant = BoardPlantOptions::default();
    plant.encoder.encoder_noise_deg = NOISE_DEG;
    plant.drivetrain.friction.coulomb_friction_nm = 0.0;
    plant.drivetrain.gear_train.bearing_friction_nm = 0.0;
    plant.drivetrain.gear_train.backlash_deg = 0.0;
    let (identified, control) = (known(&plant), ControlParameters::default());
    let twin = Twin {
        plant,
        control,
        values: ObjectValues::DEFAULT,
    };
    let (sine, base_mhz) = Multisine::reaching(6.0);
    let settings = firmware::parameters::ExcitationSettings {
        shape: 9,
        amplitude_mdeg: 1_500,
        start_mhz: base_mhz,
        lines: LINES as i32,
        ..firmware::parameters::ExcitationSettings::DEFAULT
    };
    let run = settings.run().expect("in range");
    let records: Vec<_> = (0..sine.period * sine.periods + 1)
        .map(|k| Record {
            angle_deg: 0.0,
            command_mdeg: match k as u64 {
                0 => 0,
                k => (run.sample((k - 1) * 80).angle.to_f64() * 1e3) as i32,
            },
            voltage_v: 0.0,
            supply_v: 6.0,
        })
        .collect();
    let followed = twin.follow(&records).expect("a plant");
    let response = Response::of(&followed, &sine, 1).expect("enough records");
    let (motor, timing) = (identified.motor([0.0; 5]), identified.timing(0.0));
    let servo = Loop::sampled(&motor, &control, &timing).expect("in range");
    for line in 0..LINES {
        let ratio = response.closed[line] / servo.closed.at(sine.line_hz(line));
        // A sixth of the difference that a measured loop may have.
        assert!((ratio - 1.0).norm() < 0.02, "{line}: {ratio}");
    }
}

#[test]
fn no_motor_of_the_box_has_less_than_the_least_margins() {
    let mut identified = known(&BoardPlantOptions::default());
    let uncertain = |estimate: &mut Estimate, share: f64| {
        estimate.standard_error = share * estimate.value;
    };
    uncertain(&mut identified.resistance_ohm, 0.01);
    uncertain(&mut identified.v_s_rad, 0.02);
    uncertain(&mut identified.inertia_kg_m2, 0.04);
    uncertain(&mut identified.viscous_nm_s, 0.3);
    uncertain(&mut identified.delay_s, 0.1);
    uncertain(&mut identified.supply_v, 0.02);
    let tuning = identified
        .fastest(&ControlParameters::default())
        .expect("gains");
    let least = identified.least(&tuning.control).expect("stable loops");
    assert!(least.phase_deg >= LEAST_PHASE_DEG && least.gain_db >= LEAST_GAIN_DB);
    let mut chance = Noise::new(1, 7);
    for _ in 0..300 {
        let mut within = || (REACH * chance.gaussian(1.0)).clamp(-REACH, REACH);
        let motor = identified.motor(std::array::from_fn(|_| within()));
        let timing = identified.timing(within());
        let margins = Margins::of(&motor, &tuning.control, &timing).expect("a stable loop");
        assert!(
            margins.phase_deg >= least.phase_deg - 1e-9,
            "{motor:?} {margins:?}"
        );
        assert!(
            margins.gain_db >= least.gain_db - 1e-9,
            "{motor:?} {margins:?}"
        );
    }
    // It is the fastest one.
    let mut faster = tuning.control;
    faster.proportional_gain *= 1.1;
    faster.integral_gain *= 1.1;
    faster.position_gain *= 1.1;
    let least = identified.least(&faster).expect("stable loops");
    assert!(least.phase_deg < LEAST_PHASE_DEG, "{least:?}");
}

/// Changes of the sign of the duty in 2 s of a shaft that has arrived and settled.
fn changes_at_rest(client: &mut Client) -> usize {
    client.enable(1).expect("no fault");
    arrive(client, 12_300).expect("within the range");
    client.pause(Duration::from_secs(4)).expect("no input");
    let recorded = record(client, &[Signal::Duty], |client| {
        client.pause(Duration::from_secs(2))
    });
    let (capture, _) = recorded.expect("a capture");
    let records = capture.records.windows(2);
    let is_change = |pair: &[Vec<i32>]| i64::from(pair[0][0]) * i64::from(pair[1][0]) < 0;
    records.filter(|pair| is_change(pair)).count()
}

#[test]
fn twenty_loops_have_the_predicted_margins_and_a_shaft_at_rest_keeps_the_sign_of_its_duty() {
    for seed in 0..20 {
        let options = BoardPlantOptions::another_servo(seed);
        let mut client = client(&options, Defects::default());
        let mut found = measure(&mut client, &LIMITS).expect("a good bench");
        let tuning = tune(&mut client, &found).expect("a tuning");
        found.tuning = Some(tuning.clone());
        write(&mut client, &found).expect("it saves");
        assert_eq!(changes_at_rest(&mut client), 0, "bench {seed}");
        assert!(tuning.disagreements.is_empty(), "bench {seed}: {tuning:#?}");
        assert_eq!(tuning.without_forward, None, "bench {seed}");
        assert_eq!(tuning.objects().len(), GAINS.len() + FORWARD.len());
        let proposal = tuning.proposal.expect("gains");
        let mut control = ControlParameters::default();
        for ((_, field), (_, value)) in GAINS.iter().zip(&proposal.gains) {
            *field(&mut control) = *value;
        }
        let truth = known(&options);
        let truth = Margins::of(&truth.motor([0.0; 5]), &control, &truth.timing(0.0));
        let truth = truth.expect("a stable loop");
        assert!(truth.phase_deg >= LEAST_PHASE_DEG && truth.gain_db >= LEAST_GAIN_DB);
        for margins in [
            proposal.predicted,
            proposal.measured.expect("a stable loop"),
        ] {
            let phase_deg = (margins.phase_deg - truth.phase_deg).abs();
            let gain_db = (margins.gain_db - truth.gain_db).abs();
            assert!(
                phase_deg < 2.0 && gain_db < 1.0,
                "bench {seed}: {margins:?}, {truth:?}"
            );
        }
    }
}

#[test]
fn a_motor_that_is_not_the_identified_one_keeps_its_gains() {
    let mut client = client(&BoardPlantOptions::another_servo(1), Defects::default());
    let found = measure(&mut client, &LIMITS).expect("a good bench");
    let changed = |change: fn(&mut Findings)| {
        let mut found = found.clone();
        change(&mut found);
        found
    };
    let lighter = changed(|found| found.dynamics.inertia_kg_m2.value *= 0.75);
    let stronger = changed(|found| found.torque_constant_nm_a.value *= 1.2);
    let earlier = changed(|found| found.dynamics.delay_s.value += 1.5e-3);
    for (name, found) in [
        ("inertia", lighter),
        ("constant", stronger),
        ("delay", earlier),
    ] {
        let tuning = tune(&mut client, &found).expect("a tuning");
        assert!(!tuning.disagreements.is_empty(), "{name}: {tuning:#?}");
        assert!(tuning.objects().is_empty(), "{name}");
    }
    let sticky = changed(|found| {
        found.friction.upward.coulomb_nm.value *= 4.0;
        found.friction.downward.coulomb_nm.value *= 4.0;
    });
    let tuning = tune(&mut client, &sticky).expect("a tuning");
    assert!(tuning.without_forward.is_some(), "{tuning:#?}");
    assert!(
        !tuning
            .objects()
            .iter()
            .any(|object| FORWARD.contains(object))
    );
}

#[test]
fn what_is_contradicted_is_not_tuned_and_not_fed_forward() {
    let mut client = client(&BoardPlantOptions::another_servo(2), Defects::default());
    let found = measure(&mut client, &LIMITS).expect("a good bench");
    let contradicted = |parameter| {
        let mut found = found.clone();
        let text = "a text".into();
        found
            .dynamics
            .contradictions
            .push(Contradiction { parameter, text });
        found
    };
    for parameter in [Parameter::Inertia, Parameter::Delay] {
        let tuning = tune(&mut client, &contradicted(parameter)).expect("a tuning");
        assert!(tuning.disagreements[0].ends_with("a text"), "{tuning:#?}");
        assert!(tuning.objects().is_empty());
    }
    let tuning = tune(&mut client, &contradicted(Parameter::Coulomb)).expect("a tuning");
    assert_eq!(tuning.objects().len(), GAINS.len(), "{tuning:#?}");
    assert!(
        tuning
            .without_forward
            .is_some_and(|why| why.ends_with("a text"))
    );
}
