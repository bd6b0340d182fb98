//! Searches the greatest limit cycle at rest that quantisation and, on the bench, backlash cause,
//! over plants around a preset.
//!
//! Arguments: preset, plant, seed, first group, groups. The plant is `motor`, of first order,
//! `bench`, with winding, friction, backlash and elastic gears, or `bench-of-any-friction`. A group
//! are eight boards with a plant of its own within the box of `docs/proofs.md`, which hold an angle
//! of its own for 4,000 control steps, from rest at zero. The last 2,000 steps are judged: the
//! distance between the greatest and the least angle at PWM edges, of which a bench's backlash is
//! subtracted. A line is printed after every 1,024 groups, so that a search that was interrupted
//! continues with the next one.

use std::array::from_fn;

use model_core::{
    actuator::{
        ModelKind, Settings,
        kind::PlantKind,
        lanes::{LoopLanes, Seen},
    },
    control::{encoder_word::COUNT_DEG, units::angle},
    plant::{
        drivetrain::lanes::DrivetrainLanes,
        first_order::lanes::MotorLanes,
        lanes::{Extremes, PlantLanes},
    },
    presets::preset,
};
use rayon::prelude::*;

/// Boards in a group.
const BOARDS: usize = 8;

/// Control steps of a board: to come to rest, and judged.
const STEPS: [usize; 2] = [2_000, 2_000];

/// Groups between two lines.
const BLOCK: u64 = 1_024;

/// Ticks in a control period.
const TICKS: usize = model_core::time::CONTROL_PERIOD_TICKS as usize;

/// Greatest backlash, counts.
const BACKLASH_COUNTS: f64 = 3.0;

/// Factors within 30 %, least and greatest.
const WITHIN_30_PERCENT: [f64; 2] = [0.7, 1.3];

/// Factors on a friction that is anything up to twice its value.
const ANY_FRICTION: [f64; 2] = [0.0, 2.0];

/// A board that holds an angle, and its motion from end to end, less the backlash of a bench.
#[derive(Clone, Copy)]
struct Found {
    counts: f64,
    board: Settings,
    held_deg: f64,
}

/// `SplitMix64`, from 0 to 1.
fn share(state: &mut u64) -> f64 {
    *state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
}

/// Changes the motor to another one of the box.
fn change_motor(board: &mut Settings, random: &mut u64) {
    let mut about_one = || 0.7 + 0.6 * share(random);
    // Gain and supply within 30 %, and pole and inertia.
    let (gain, pole) = (about_one() * about_one(), about_one() / about_one());
    board.first_order.motor_gain_up *= gain;
    board.first_order.motor_gain_down *= gain;
    board.first_order.motor_time_constant_s /= pole;
}

/// Changes what decides how many steps a tick of the bench has, which is the same in a group: to
/// inertia and stiffness within 30 %, and damping up to twice its value.
fn change_vibration(board: &mut Settings, random: &mut u64) {
    let train = &mut board.drivetrain.gear_train;
    for parameter in [
        &mut train.motor_inertia_kg_m2,
        &mut train.output_inertia_kg_m2,
        &mut train.load_inertia_kg_m2,
        &mut train.gear_stiffness_nm_deg,
        &mut train.shaft_stiffness_nm_deg,
    ] {
        *parameter *= 0.7 + 0.6 * share(random);
    }
    train.gear_damping_nm_s_deg *= 2.0 * share(random);
    train.shaft_damping_nm_s_deg *= 2.0 * share(random);
}

/// Changes the rest of the bench: supply, resistance and torque constant to others within 30 %,
/// friction by factors between two limits, and backlash to any up to the greatest.
fn change_bench(board: &mut Settings, [least, greatest]: [f64; 2], random: &mut u64) {
    let bench = &mut board.drivetrain;
    for parameter in [
        &mut bench.electrical.supply_v,
        &mut bench.electrical.winding_resistance_ohm,
        &mut bench.electrical.torque_constant_nm_a,
    ] {
        *parameter *= 0.7 + 0.6 * share(random);
    }
    for parameter in [
        &mut bench.friction.coulomb_friction_nm,
        &mut bench.friction.viscous_friction_nm_s_deg,
        &mut bench.gear_train.bearing_friction_nm,
    ] {
        *parameter *= least + (greatest - least) * share(random);
    }
    // Without backlash the chain would be another one.
    bench.gear_train.backlash_deg = BACKLASH_COUNTS * COUNT_DEG * share(random).max(1e-3);
}

/// The greatest motion in a group, whose benches have friction within these factors.
fn group<P: PlantLanes<BOARDS>>(
    base: &Settings,
    friction: [f64; 2],
    seed: u64,
    number: u64,
) -> Found {
    let mut random = seed ^ number.wrapping_mul(0xD134_2543_DE82_EF95);
    let mut common = *base;
    if base.plant == PlantKind::Drivetrain {
        change_vibration(&mut common, &mut random);
    }
    let choices: [Found; BOARDS] = from_fn(|_| {
        let mut board = common;
        match base.plant {
            PlantKind::FirstOrder => change_motor(&mut board, &mut random),
            PlantKind::Drivetrain => change_bench(&mut board, friction, &mut random),
        }
        let held_deg = 200.0 * share(&mut random) - 100.0;
        Found {
            counts: 0.0,
            board,
            held_deg,
        }
    });
    let mut lanes = LoopLanes::<P, BOARDS>::try_new(choices.each_ref().map(|it| &it.board))
        .expect("parameters within their ranges")
        .expect("boards that the lanes compute");
    let commands = choices.map(|choice| angle(choice.held_deg));
    for steps in STEPS {
        lanes.seen = Extremes::default();
        for _ in 0..steps {
            lanes.pass_each(&commands, TICKS, Seen::Edges);
        }
    }
    let counts = |lane: usize| {
        let (least, greatest) = (lanes.seen.least.of(lane), lanes.seen.greatest.of(lane));
        (greatest.angle_deg - least.angle_deg) / COUNT_DEG
    };
    let found = (0..BOARDS).map(|lane| Found {
        counts: counts(lane) - backlash_counts(&choices[lane].board),
        ..choices[lane]
    });
    found.fold(choices[0], greater)
}

fn backlash_counts(board: &Settings) -> f64 {
    match board.plant {
        PlantKind::FirstOrder => 0.0,
        PlantKind::Drivetrain => board.drivetrain.gear_train.backlash_deg / COUNT_DEG,
    }
}

fn greater(a: Found, b: Found) -> Found {
    if b.counts > a.counts { b } else { a }
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [name, plant, numbers @ ..] = &arguments[..] else {
        usage()
    };
    let (plant, friction) = match plant.as_str() {
        "motor" => (PlantKind::FirstOrder, WITHIN_30_PERCENT),
        "bench" => (PlantKind::Drivetrain, WITHIN_30_PERCENT),
        "bench-of-any-friction" => (PlantKind::Drivetrain, ANY_FRICTION),
        _ => usage(),
    };
    let group = match plant {
        PlantKind::FirstOrder => group::<MotorLanes<BOARDS>>,
        PlantKind::Drivetrain => group::<DrivetrainLanes<BOARDS>>,
    };
    let numbers: Vec<u64> = numbers.iter().filter_map(|n| n.parse().ok()).collect();
    let (Some(preset), [seed, first, groups]) = (preset(name), &numbers[..]) else {
        usage()
    };
    let mut base = Settings::new(ModelKind::Board, plant);
    for (parameter, value) in preset.values {
        if base.set(parameter, *value).is_err() {
            eprintln!("preset {name} sets {parameter}, which this plant does not have");
            std::process::exit(2);
        }
    }
    let mut greatest: Option<Found> = None;
    let mut next = *first;
    while next < first + groups {
        let end = (next + BLOCK).min(first + groups);
        let block = (next..end)
            .into_par_iter()
            .map(|number| group(&base, friction, *seed, number))
            .reduce_with(greater);
        greatest = greatest.into_iter().chain(block).reduce(greater);
        next = end;
        if let Some(found) = greatest {
            let steps = (next - first) * (BOARDS * STEPS.iter().sum::<usize>()) as u64;
            println!(
                "next group {next}, {steps} steps: {:.3} counts at {:.4} deg, {}",
                found.counts,
                found.held_deg,
                difference(&base, &found.board)
            );
        }
    }
}

/// The parameters of a board that differ from the preset's, as multiples of them.
fn difference(base: &Settings, board: &Settings) -> String {
    let values = base.values().zip(board.values());
    let changed = values.filter(|(before, now)| before.value != now.value);
    let texts = changed
        .map(|(before, now)| format!("{} x {:.3}", now.parameter.name, now.value / before.value));
    texts.collect::<Vec<_>>().join(", ")
}

fn usage() -> ! {
    eprintln!("usage: limit_cycles PRESET motor|bench|bench-of-any-friction SEED FIRST GROUPS");
    std::process::exit(2);
}
