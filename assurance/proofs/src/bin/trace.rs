//! Prints operations of the control step and their results, one a line, for
//! `assurance/proofs/overflow/replay.py`. Arguments: seed, operations.

use control_proofs as step;
use model_core::{
    actuator::{
        ModelKind, Settings,
        kind::PlantKind,
        lanes::{LoopLanes, Seen},
    },
    control::{
        cascade::Setpoint,
        parameters::ControlParameters,
        units::{Angle, Rate, angle},
    },
    parameter::Parameters,
    plant::first_order::{FirstOrderParameters, lanes::MotorLanes},
    presets::PRESETS,
    time::CONTROL_PERIOD_TICKS,
};

/// `SplitMix64`.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    fn below(&mut self, end: usize) -> usize {
        (self.next() % end as u64) as usize
    }

    /// Any bits, of any magnitude, or an end of the range.
    fn signal(&mut self) -> i64 {
        match self.below(8) {
            0 => i64::MIN,
            1 => i64::MAX,
            2 => 0,
            _ => (self.next() as i64) >> self.below(63),
        }
    }

    /// A value for a row: any bits, an end of its range, or one within it.
    fn value(&mut self, row: usize) -> u32 {
        let range = &ControlParameters::TABLE[row];
        let (min, max) = (range.min as f32, range.max.min(1e6) as f32);
        let share = (self.next() >> 40) as f32 / (1 << 24) as f32;
        match self.below(6) {
            0 => self.next() as u32,
            1 => min.to_bits(),
            2 => (range.max as f32).to_bits(),
            _ => (min + share * (max - min)).to_bits(),
        }
    }
}

/// Each parameter of the control step and of the motor in the presets of the board.
fn print_presets() {
    let tables = [ControlParameters::TABLE, FirstOrderParameters::TABLE].concat();
    for preset in PRESETS.iter().filter(|p| p.models.contains(&"board")) {
        for row in &tables {
            let changed = preset.values.iter().find(|(name, _)| *name == row.name);
            let value = changed.map_or(row.default, |(_, value)| *value);
            println!("preset {} {} {value:e}", preset.name, row.name);
        }
    }
}

/// A step of 5 deg from rest with the default preset, and the angle after each control period: the
/// motion that the model of the stability proof has to follow.
fn print_motion() {
    let board = Settings::new(ModelKind::Board, PlantKind::FirstOrder);
    let lanes = LoopLanes::<MotorLanes<1>, 1>::try_new([&board]);
    let mut lanes = lanes.ok().flatten().expect("a board of the defaults");
    print!("motion consistent 5");
    for _ in 0..500 {
        lanes.pass(angle(5.0), CONTROL_PERIOD_TICKS as usize, Seen::Edges);
        print!(" {}", lanes.state(0).angle_deg);
    }
    println!();
}

fn main() {
    let arguments: Vec<u64> = std::env::args()
        .skip(1)
        .filter_map(|argument| argument.parse().ok())
        .collect();
    let [seed, operations] = arguments[..] else {
        eprintln!("usage: trace SEED OPERATIONS");
        std::process::exit(2);
    };
    // The ranges, for what the proof assumes of parameters of the double-precision constructor.
    for row in ControlParameters::TABLE {
        println!("range {} {:e} {:e}", row.name, row.min, row.max);
    }
    print_presets();
    print_motion();
    let mut random = Random(seed);
    let (mut state, mut gains, mut modulator) =
        (step::start(), step::defaults(), step::modulator());
    for _ in 0..operations {
        match random.below(16) {
            0 => {
                let row = random.below(ControlParameters::TABLE.len());
                let bits = random.value(row);
                let old = gains;
                let taken = step::set(&mut gains, row, bits);
                step::retune(&mut state, &old, &gains);
                let read = step::get(&gains, row);
                println!("set {row} {bits} -> {} {read}", u8::from(taken));
            }
            1 => {
                let periods = random.next() as u16;
                step::miss(&mut state, periods);
                println!("miss {periods} ->");
            }
            2 if random.below(8) == 0 => {
                step::release(&mut state);
                println!("release ->");
            }
            3 if random.below(8) == 0 => {
                step::reset_position(&mut state);
                println!("reset_position ->");
            }
            4..8 => {
                let count = random.next() as u16;
                step::observe_count(&mut state, &gains, count);
                let (angle, rate) = (step::measured_angle(&state), step::measured_rate(&state));
                println!("observe_count {count} -> {angle} {rate}");
            }
            kind => {
                let value = random.signal();
                let (name, result) = match kind {
                    8 => {
                        let rate = Rate::from_bits(value);
                        let result = step::decelerate(&mut state, &gains, rate);
                        ("decelerate", result)
                    }
                    9 | 10 => {
                        let to = Setpoint::Rate(Rate::from_bits(value));
                        ("rate", step::regulate(&mut state, &gains, to))
                    }
                    _ => {
                        let to = Setpoint::Angle(Angle::from_bits(value));
                        ("angle", step::regulate(&mut state, &gains, to))
                    }
                };
                let compare = step::compare(&mut modulator, result.duty);
                let (command, duty) = (result.rate_command.to_bits(), result.duty.to_bits());
                println!("{name} {value} -> {command} {duty} {compare}");
            }
        }
    }
}
