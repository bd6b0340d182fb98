//! Actuators of other servos are commissioned natively and on the emulated board: each value that
//! is found of a servo is within three of its standard errors, and the broken ones are refused.
//!
//! `ACTUATOR_BENCHES` is the number of servos on the emulated board, 4 without it.

use std::time::Duration;

use crate::bench::{Bounds, with_board};
use canopen::NodeId;
use host_sim::can::client::Client;
use host_sim::can::names;
use host_sim::can::native_link::NativeLink;
use host_sim::can::native_node::{CAPTURE_VALUES, NativeNode};
use host_sim::commission::{CommissionError, Findings, Kept, Limits, centre, find, measure, write};
use model_core::control::encoder_word::Magnet;
use model_core::plant::board::{BoardPlantOptions, Defects, ENCODER_DELAY_S};
use model_core::plant::drivetrain::DrivetrainParameters;
use model_core::sensors::adc::AdcCode;
use rayon::iter::{IndexedParallelIterator, IntoParallelIterator, ParallelIterator};
use virtual_board::faults::{Fault, Planned, Trigger};

/// Range and current are those of [`LIMITS`].
const BOUNDS: Bounds = Bounds {
    angle_deg: 45.0,
    driving_a: 0.5,
};

/// The rated current is 500 mA.
const LIMITS: Limits = Limits {
    range_mdeg: Some((-45_000, 45_000)),
    permille: 1000,
    rate_mdeg_s: 120_000,
};

/// The NMT command.
const RESET_NODE: u8 = 0x81;

/// All steps of a commissioning, which are saved.
fn commission(client: &mut Client) -> Findings {
    let kept = Kept::of(client).expect("values");
    let found = find(client, &LIMITS, (&kept, true), |_| {}).expect("a sound servo");
    kept.restore(client).expect("the drive is off");
    write(client, &found).expect("it saves");
    found
}

/// Runs `work` with a client of a native board on this plant with these defects.
fn with_native<T>(
    plant: &BoardPlantOptions,
    defects: Defects,
    work: impl FnOnce(&mut Client) -> T,
) -> T {
    let buffer = Box::leak(Box::new([0; CAPTURE_VALUES]));
    let mut node = NativeNode::new(1, NodeId::new(1), plant, buffer).expect("in range");
    *node.defects() = defects;
    let mut client = Client::new(Box::new(NativeLink::new(node, |_| {})), 1);
    client.pause(Duration::from_millis(100)).expect("no input");
    work(&mut client)
}

/// What the values of [`Findings::estimates`] are of this plant, each with the largest expected
/// share of its standard error.
fn truth(plant: &BoardPlantOptions) -> [(&'static str, f64, f64); 9] {
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
        ("resistance", motor.winding_resistance_ohm, 0.015),
        ("torque constant", motor.torque_constant_nm_a * ratio, 0.02),
        ("friction upward", coulomb_nm, 0.1),
        ("friction downward", coulomb_nm, 0.1),
        // Its share of the current is below the error of the dividers.
        ("viscous upward", viscous_nm_s, 2.0),
        ("viscous downward", viscous_nm_s, 2.0),
        ("inertia", gears.inertia_kg_m2(), 0.05),
        // A duty takes effect after a PWM period.
        ("delay", 1e-3 + ENCODER_DELAY_S, 0.5),
        // Where the excitations determine it.
        ("backlash", gears.backlash_deg, 0.1),
    ]
}

fn assert_found(findings: &Findings, plant: &BoardPlantOptions, bench: &str) {
    let (estimates, truth) = (findings.estimates(), truth(plant));
    let all = truth.len();
    assert!((all - 1..=all).contains(&estimates.len()), "{bench}");
    for ((name, unit, _, found), (expected, value, share)) in estimates.into_iter().zip(truth) {
        assert_eq!(name, expected, "{bench}");
        let z = (found.value - value) / found.standard_error;
        println!("{bench}: {name} {found:?} {unit}, {z:+.2} from {value}");
        assert!(
            z.abs() < 3.0 && found.standard_error < share * value,
            "{bench}: {name} {found:?}, {z:+.2} from {value}"
        );
    }
    let contradictions = &findings.dynamics.contradictions;
    assert!(contradictions.is_empty(), "{bench}: {contradictions:?}");
}

#[test]
fn all_values_of_twenty_servos_are_within_three_standard_errors() {
    (0..20).into_par_iter().for_each(|seed| {
        let plant = BoardPlantOptions::another_servo(seed);
        let found = with_native(&plant, Defects::default(), |client| {
            measure(client, &LIMITS).expect("a sound servo")
        });
        assert_found(&found, &plant, &format!("bench {seed} natively"));
    });
}

/// The middle of a range becomes 0, and a restart keeps it: the origin and the range.
fn set_centre(client: &mut Client, found: &mut Findings) {
    found.range_mdeg = (-45_000, 25_000);
    centre(client, &LIMITS, found).expect("the shaft rests");
    write(client, found).expect("it saves");
    client.manage(RESET_NODE).expect("a bus");
    client.pause(Duration::from_millis(300)).expect("a start");
    let [origin, high] = ["2041:3", "607D:2"].map(|object| client.integer(object).expect(object));
    // Two counts of the encoder, which the shaft moves when the drive holds it.
    assert!((10_000 - origin).abs() <= 176, "{origin}");
    assert!((high - 35_000).abs() <= 176, "{high}");
}

#[test]
fn other_servos_are_commissioned_on_the_emulated_board() {
    let count = std::env::var("ACTUATOR_BENCHES");
    let count = count.map_or(4, |text| text.parse().expect("a number of benches"));
    (0..count).into_par_iter().for_each(|seed| {
        let plant = BoardPlantOptions::another_servo(seed);
        let found = with_board(&plant, Defects::default(), BOUNDS, |client, _| {
            let mut found = commission(client);
            set_centre(client, &mut found);
            found
        });
        assert_found(&found, &plant, &format!("bench {seed}"));
        // The sweep of the loop has the predicted margins within 2 deg and 1 dB.
        let tuning = found.tuning.expect("it was tuned");
        let disagreements = tuning.disagreements;
        assert!(disagreements.is_empty(), "bench {seed}: {disagreements:?}");
    });
}

/// Length of a loss of the supply, ns.
const OFF_NS: u64 = 2_000_000;

/// Time from one loss of the supply, after the start of a write, to that of the next one: the write
/// takes a hundred ms, the save with the erase of a page a second.
const LATER_NS: u64 = 57_000_000;

/// `power_loss` loses it in each word of a save.
#[test]
fn a_loss_of_the_supply_during_the_write_leaves_the_set_of_one_servo() {
    let plant = BoardPlantOptions::default();
    let sets = [0, 1].map(|seed| {
        let plant = BoardPlantOptions::another_servo(seed);
        with_native(&plant, Defects::default(), commission)
    });
    let values = |client: &mut Client, set: &Findings| -> Vec<(f32, f32)> {
        let objects = set.objects().into_iter().map(|(object, value)| {
            let entry = names::find(object).expect("an object");
            let text = client.get(entry).expect("a value").to_string();
            (text.parse().expect("a number"), value as f32)
        });
        objects.collect()
    };
    let has = |client: &mut Client, set| values(client, set).iter().all(|(is, of)| is == of);
    with_board(&plant, Defects::default(), BOUNDS, |client, requests| {
        write(client, &sets[0]).expect("it saves");
        let (mut held, mut changes, mut cuts) = (0, 0, 0);
        for after_ns in (0..).step_by(LATER_NS as usize) {
            let cut = requests.act(move |view| {
                let ns = view.now_ns() + after_ns;
                view.plan(Planned {
                    trigger: Trigger::At { ns },
                    for_ns: Some(OFF_NS),
                    fault: Fault::PowerLoss,
                });
            });
            cut.expect("the run goes on");
            let written = write(client, &sets[1 - held]);
            // Until the supply was off, and the board has started.
            client.pause(Duration::from_nanos(after_ns)).expect("a run");
            client.pause(Duration::from_millis(200)).expect("a run");
            let found = [0, 1].map(|set| has(client, &sets[set]));
            assert_eq!(
                written.is_ok(),
                found[1 - held],
                "{after_ns} ns: {written:?}"
            );
            assert_ne!(found[0], found[1], "{after_ns} ns: {written:?}");
            cuts += 1;
            if written.is_ok() {
                held = 1 - held;
                changes += 1;
            }
            if changes == 2 {
                break;
            }
        }
        // The write with its save takes more than fifteen of the intervals.
        assert!(cuts > 15, "{cuts}");
    });
}

#[test]
fn broken_servos_are_refused_natively_and_on_the_emulated_board_by_name() {
    let sound = Defects::default();
    let frozen = Defects {
        is_encoder_frozen: true,
        ..sound
    };
    let loose = Defects {
        encoder_loss_pct: 100.0,
        ..sound
    };
    let jammed = Defects {
        is_jammed: true,
        ..sound
    };
    let open = Defects {
        is_motor_open: true,
        ..sound
    };
    let dead = Defects {
        stuck_current: Some(AdcCode::new(2048)),
        ..sound
    };
    let reversed = Defects {
        current_loss_pct: 200.0,
        ..sound
    };
    let half = Defects {
        current_loss_pct: 60.0,
        ..sound
    };
    let weak = Defects {
        source_ohm: Some(2.0),
        ..sound
    };
    let weak_magnet = Defects {
        magnet: Some(Magnet::Marginal),
        ..sound
    };
    let hot = Defects {
        temperature_deg_c: Some(70.0),
        ..sound
    };
    let broken = [
        (1.0, weak_magnet, "the magnet is weak or lost"),
        (1.0, hot, "the temperature of the board"),
        (1.0, dead, "the current measurement is dead"),
        (1.0, reversed, "the current sense is reversed"),
        (1.0, half, "the gain of the current measurement is wrong"),
        (1.0, weak, "the supply sags"),
        (
            1.0,
            frozen,
            "the encoder does not: magnet or encoder is stuck",
        ),
        (1.0, loose, "the coupling is loose"),
        (1.0, jammed, "the shaft is held"),
        (1.0, open, "motor or current sense is not connected"),
        (-1.0, sound, "the encoder is reversed"),
    ];
    let benches = broken.into_par_iter().enumerate();
    benches.for_each(|(bench, (direction, defects, word))| {
        let mut plant = BoardPlantOptions::another_servo(20 + bench as u64);
        plant.encoder.magnet_direction = direction;
        let refused = |client: &mut Client| measure(client, &LIMITS).expect_err(word);
        for error in [
            with_native(&plant, defects, refused),
            with_board(&plant, defects, BOUNDS, |client, _| refused(client)),
        ] {
            assert!(matches!(error, CommissionError::Refused { .. }), "{error}");
            assert!(error.to_string().contains(word), "bench {bench}: {error}");
        }
    });
}
