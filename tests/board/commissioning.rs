//! Actuators of other servos are commissioned on the emulated board, and natively: each value that
//! is found of a servo is within three of its standard errors, and the broken ones are refused.
//!
//! `ACTUATOR_BENCHES` is the number of servos, 4 without it.

use std::time::Duration;

use crate::bench::with_board;
use canopen::NodeId;
use host_sim::can::client::Client;
use host_sim::can::native_link::NativeLink;
use host_sim::can::native_node::{CAPTURE_VALUES, NativeNode};
use host_sim::commission::{CommissionError, Findings, Kept, Limits, find, measure, write};
use model_core::plant::board::{BoardPlantOptions, Defects, ENCODER_DELAY_S};
use model_core::plant::drivetrain::DrivetrainParameters;
use rayon::iter::{IndexedParallelIterator, IntoParallelIterator, ParallelIterator};

/// Half of the range.
const RANGE_DEG: f64 = 45.0;

const LIMITS: Limits = Limits {
    range_mdeg: Some((-45_000, 45_000)),
    permille: 1000,
    rate_mdeg_s: 120_000,
};

/// All steps of a commissioning, which are saved.
fn commission(client: &mut Client) -> Findings {
    let kept = Kept::of(client).expect("values");
    let found = find(client, &LIMITS, (&kept, true), |_| {}).expect("a sound servo");
    kept.restore(client).expect("the drive is off");
    write(client, &found).expect("it saves");
    found
}

fn natively(plant: &BoardPlantOptions) -> Findings {
    let buffer = Box::leak(Box::new([0; CAPTURE_VALUES]));
    let node = NativeNode::new(1, NodeId::new(1), plant, buffer).expect("in range");
    let mut client = Client::new(Box::new(NativeLink::new(node, |_| {})), 1);
    client.pause(Duration::from_millis(100)).expect("no input");
    commission(&mut client)
}

/// What the values of [`Findings::estimates`] are of this plant.
fn truth(plant: &BoardPlantOptions) -> [(&'static str, f64); 8] {
    let DrivetrainParameters {
        electrical: motor,
        gear_train: gears,
        friction,
        ..
    } = plant.drivetrain;
    // The ratio 2011h:3 is not measured.
    let ratio = gears.gear_ratio / DrivetrainParameters::default().gear_train.gear_ratio;
    let coulomb_nm = friction.coulomb_friction_nm + gears.bearing_friction_nm;
    let viscous_nm_s = friction.viscous_friction_nm_s_deg.to_degrees();
    [
        ("resistance", motor.winding_resistance_ohm),
        ("torque constant", motor.torque_constant_nm_a * ratio),
        ("friction upward", coulomb_nm),
        ("friction downward", coulomb_nm),
        ("viscous upward", viscous_nm_s),
        ("viscous downward", viscous_nm_s),
        ("inertia", gears.inertia_kg_m2()),
        // A duty takes effect after a PWM period.
        ("delay", 1e-3 + ENCODER_DELAY_S),
    ]
}

fn assert_found(findings: &Findings, truth: &[(&str, f64)], bench: &str) {
    let estimates = findings.estimates();
    assert_eq!(estimates.len(), truth.len(), "{bench}");
    for ((name, unit, _, found), (expected, value)) in estimates.into_iter().zip(truth) {
        assert_eq!(name, *expected, "{bench}");
        let z = (found.value - value) / found.standard_error;
        println!("{bench}: {name} {found:?} {unit}, {z:+.2} from {value}");
        assert!(
            z.abs() < 3.0,
            "{bench}: {name} {found:?}, {z:+.2} from {value}"
        );
    }
    // The sweep of the loop has the predicted margins within 2 deg and 1 dB.
    let tuning = findings.tuning.as_ref().expect("it was tuned");
    assert!(tuning.disagreements.is_empty(), "{bench}: {tuning:?}");
}

#[test]
fn other_servos_are_commissioned_on_the_emulated_board_and_natively() {
    let count = std::env::var("ACTUATOR_BENCHES");
    let count = count.map_or(4, |text| text.parse().expect("a number of benches"));
    (0..count).into_par_iter().for_each(|seed| {
        let plant = BoardPlantOptions::another_servo(seed);
        let truth = truth(&plant);
        let emulated = with_board(&plant, Defects::default(), RANGE_DEG, commission);
        assert_found(&emulated, &truth, &format!("bench {seed}"));
        assert_found(&natively(&plant), &truth, &format!("bench {seed} natively"));
    });
}

#[test]
fn broken_servos_are_refused_on_the_emulated_board_by_name() {
    let sound = Defects::default();
    let frozen = Defects {
        is_encoder_frozen: true,
        ..sound
    };
    let loose = Defects {
        encoder_loss_pct: 100.0,
        ..sound
    };
    let reversed = Defects {
        current_loss_pct: 200.0,
        ..sound
    };
    let open = Defects {
        is_motor_open: true,
        ..sound
    };
    let broken = [
        (
            1.0,
            frozen,
            "the encoder does not: magnet or encoder is stuck",
        ),
        (1.0, loose, "the coupling is loose"),
        (1.0, reversed, "the current sense is reversed"),
        (1.0, open, "motor or current sense is not connected"),
        (-1.0, sound, "the encoder is reversed"),
    ];
    broken
        .into_par_iter()
        .enumerate()
        .for_each(|(bench, (direction, defects, word))| {
            let mut plant = BoardPlantOptions::another_servo(20 + bench as u64);
            plant.encoder.magnet_direction = direction;
            let error = with_board(&plant, defects, RANGE_DEG, |client| {
                measure(client, &LIMITS).expect_err(word)
            });
            assert!(matches!(error, CommissionError::Refused { .. }), "{error}");
            assert!(error.to_string().contains(word), "bench {bench}: {error}");
        });
}
