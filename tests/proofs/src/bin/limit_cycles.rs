//! Searches the greatest limit cycle at rest that quantisation causes, over motors around a preset.
//!
//! Arguments: preset, seed, first group, groups. A group are eight boards with a motor of its own
//! within the box of `docs/proofs.md`, which hold an angle of its own for 4,000 control steps, from
//! rest at zero. The last 2,000 steps are judged: the distance between the greatest and the least
//! angle at PWM edges. A line is printed after every 1,024 groups, so that a search that was
//! interrupted continues with the next one.

use std::array::from_fn;

use model_core::{
    actuator::{
        ModelKind, Settings,
        kind::PlantKind,
        lanes::{LoopLanes, Seen},
    },
    control::{encoder_word::COUNT_DEG, units::angle},
    plant::{first_order::lanes::MotorLanes, lanes::Extremes},
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

/// What was found: counts from end to end, steady rate and pole as shares of the preset's, and the
/// angle that was held, deg.
#[derive(Clone, Copy)]
struct Found {
    counts: f64,
    gain: f64,
    pole: f64,
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

fn group(base: &Settings, seed: u64, number: u64) -> Found {
    let mut random = seed ^ number.wrapping_mul(0xD134_2543_DE82_EF95);
    let choices: [Found; BOARDS] = from_fn(|_| Found {
        counts: 0.0,
        // Gain and supply within 30 %, and pole and inertia.
        gain: (0.7 + 0.6 * share(&mut random)) * (0.7 + 0.6 * share(&mut random)),
        pole: (0.7 + 0.6 * share(&mut random)) / (0.7 + 0.6 * share(&mut random)),
        held_deg: 200.0 * share(&mut random) - 100.0,
    });
    let boards = choices.map(|choice| {
        let mut board = *base;
        board.first_order.motor_gain_up *= choice.gain;
        board.first_order.motor_gain_down *= choice.gain;
        board.first_order.motor_time_constant_s /= choice.pole;
        board
    });
    let mut lanes = LoopLanes::<MotorLanes<BOARDS>, BOARDS>::try_new(boards.each_ref())
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
        counts: counts(lane),
        ..choices[lane]
    });
    found.fold(choices[0], greater)
}

fn greater(a: Found, b: Found) -> Found {
    if b.counts > a.counts { b } else { a }
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [name, numbers @ ..] = &arguments[..] else {
        usage()
    };
    let numbers: Vec<u64> = numbers.iter().filter_map(|n| n.parse().ok()).collect();
    let (Some(preset), [seed, first, groups]) = (preset(name), &numbers[..]) else {
        usage()
    };
    let mut base = Settings::new(ModelKind::Board, PlantKind::FirstOrder);
    for (parameter, value) in preset.values {
        base.set(parameter, *value)
            .expect("a parameter of the board");
    }
    let mut greatest: Option<Found> = None;
    let mut next = *first;
    while next < first + groups {
        let end = (next + BLOCK).min(first + groups);
        let block = (next..end)
            .into_par_iter()
            .map(|number| group(&base, *seed, number))
            .reduce_with(greater);
        greatest = greatest.into_iter().chain(block).reduce(greater);
        next = end;
        if let Some(found) = greatest {
            let steps = (next - first) * (BOARDS * STEPS.iter().sum::<usize>()) as u64;
            println!(
                "next group {next}, {steps} steps: {:.3} counts at gain {:.3}, pole {:.3}, {:.4} deg",
                found.counts, found.gain, found.pole, found.held_deg
            );
        }
    }
}

fn usage() -> ! {
    eprintln!("usage: limit_cycles PRESET SEED FIRST GROUPS");
    std::process::exit(2);
}
