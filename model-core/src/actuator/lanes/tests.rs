//! Boards side by side against single ones.

use core::array::from_fn;
use std::vec::Vec;

use proptest::{prelude::*, sample::Index};

use super::*;
use crate::actuator::PlantKind;
use crate::plant::{PERIOD, Plant, Pwm};
use crate::plant::{drivetrain::lanes::DrivetrainLanes, drivetrain::stepped::SteppedDrivetrain};
use crate::plant::{first_order::FirstOrder, first_order::lanes::MotorLanes};
use crate::time::CONTROL_PERIOD_TICKS;
use crate::{actuator::closed_loop::ClosedLoop, control::units::angle};

const LANES: usize = 3;

type MotorLoops<const N: usize> = LoopLanes<MotorLanes<N>, N>;
type BenchLoops<const N: usize> = LoopLanes<DrivetrainLanes<N>, N>;

const EDGES: usize = CONTROL_PERIOD_TICKS as usize / PERIOD;

/// Name, least and greatest value.
type Range = (&'static str, f64, f64);

const CONTROL: [Range; 13] = [
    ("position_gain", 0.0, 40.0),
    ("proportional_gain", 0.0, 6.0),
    ("integral_gain", 0.0, 100.0),
    ("anti_windup_gain", 0.0, 50.0),
    ("feed_forward_gain", 0.0, 2.0),
    ("rate_filter", 0.01, 1.0),
    ("duty_limit_pct", 5.0, 100.0),
    ("duty_slew_pct_s", 50.0, 10_000.0),
    ("rate_command_limit_up_deg_s", 5.0, 400.0),
    ("rate_command_limit_down_deg_s", 5.0, 400.0),
    ("position_min_deg", -150.0, 0.0),
    ("position_max_deg", 0.0, 150.0),
    ("encoder_zero_deg", -180.0, 180.0),
];

const MOTOR: [Range; 4] = [
    ("motor_gain_up", 0.1, 10.0),
    ("motor_gain_down", 0.1, 10.0),
    ("motor_time_constant_s", 1e-3, 1.0),
    ("position_limit_deg", 1.0, 200.0),
];

/// Of these the steps of a tick differ between boards.
const BENCH: [Range; 19] = [
    ("supply_v", 0.0, 60.0),
    ("winding_resistance_ohm", 2.0, 20.0),
    ("winding_inductance_h", 0.0, 5e-3),
    ("torque_constant_nm_a", 1e-3, 6e-3),
    ("motor_inertia_kg_m2", 1e-7, 1e-6),
    ("output_inertia_kg_m2", 1e-7, 1e-5),
    ("load_inertia_kg_m2", 1e-7, 1e-4),
    ("backlash_deg", 0.001, 3.0),
    ("gear_stiffness_nm_deg", 0.1, 8.0),
    ("gear_damping_nm_s_deg", 0.0, 1e-3),
    ("shaft_stiffness_nm_deg", 1.0, 20.0),
    ("shaft_damping_nm_s_deg", 0.0, 1e-3),
    ("bearing_friction_nm", 0.0, 0.1),
    ("hard_stop_deg", 0.0, 100.0),
    ("coulomb_friction_nm", 0.0, 0.2),
    ("viscous_friction_nm_s_deg", 0.0, 1e-3),
    ("load_torque_nm", -0.5, 0.5),
    ("hinge_moment_nm_deg", -0.01, 0.05),
    ("load_damping_nm_s_deg", 0.0, 0.01),
];

/// Which joints of the gear train are rigid.
#[derive(Debug, Clone, Copy)]
struct Rigid {
    gears: bool,
    shaft: bool,
}

impl Rigid {
    fn apply(self, settings: &mut Settings) {
        let gear_train = &mut settings.drivetrain.gear_train;
        if self.gears {
            gear_train.backlash_deg = 0.0;
            gear_train.gear_stiffness_nm_deg = f64::INFINITY;
        }
        if self.shaft {
            gear_train.shaft_stiffness_nm_deg = f64::INFINITY;
        }
    }
}

/// Settings with some of the parameters of control and plant anywhere in a useful range.
fn settings(plant: PlantKind) -> impl Strategy<Value = Settings> {
    let ranges = match plant {
        PlantKind::FirstOrder => [&CONTROL[..], &MOTOR].concat(),
        PlantKind::Drivetrain => [&CONTROL[..], &BENCH].concat(),
    };
    let changes = proptest::collection::vec((0..ranges.len(), 0.0..1.0), 0..8);
    (changes, any::<bool>()).prop_map(move |(changes, is_reversed)| {
        let mut settings = Settings::new(ModelKind::Board, plant);
        for (index, share) in changes {
            let (name, least, greatest) = ranges[index];
            let value = least + share * (greatest - least);
            settings.set(name, value).unwrap();
        }
        if is_reversed {
            settings.set("encoder_direction", -1.0).unwrap();
        }
        settings
    })
}

/// The same periods in single boards: every tick that is seen, in order.
fn single(settings: &Settings, commands: &[Angle], last: usize, see: Seen) -> Vec<PlantState> {
    match settings.plant {
        PlantKind::FirstOrder => {
            let motor = FirstOrder::try_new(settings.first_order, settings.pwm).unwrap();
            around(settings, motor, commands, last, see)
        }
        PlantKind::Drivetrain => {
            let bench = SteppedDrivetrain::try_new(&settings.drivetrain, settings.pwm).unwrap();
            around(settings, bench, commands, last, see)
        }
    }
}

fn around<P: Plant>(
    settings: &Settings,
    plant: P,
    commands: &[Angle],
    last: usize,
    see: Seen,
) -> Vec<PlantState> {
    let mut board: ClosedLoop<P> = settings.around(plant).unwrap();
    let mut seen = Vec::new();
    for (k, command) in commands.iter().enumerate() {
        let ticks = if k + 1 == commands.len() { last } else { 80 };
        for edge in 0..EDGES {
            board.start_period(|_| *command);
            let wanted = ticks.saturating_sub(edge * PERIOD).min(PERIOD);
            let shown = if see == Seen::All {
                wanted
            } else {
                wanted.min(1)
            };
            seen.extend((0..shown).map(|tick| {
                board.plant.pass_to(tick);
                board.plant.at(tick)
            }));
            board.plant.pass_to(PERIOD);
        }
    }
    seen
}

fn ends(values: impl Iterator<Item = f64> + Clone) -> (f64, f64) {
    let least = values.clone().fold(f64::INFINITY, f64::min);
    (least, values.fold(f64::NEG_INFINITY, f64::max))
}

fn compare<P: PlantLanes<N>, const N: usize>(
    settings: [&Settings; N],
    commands: &[Angle],
    last: usize,
    see: Seen,
) {
    let mut lanes = LoopLanes::<P, N>::try_new(settings)
        .unwrap()
        .expect("settings of lanes");
    for (k, command) in commands.iter().enumerate() {
        let ticks = if k + 1 == commands.len() { last } else { 80 };
        lanes.pass(*command, ticks, see);
    }
    for (lane, settings) in settings.iter().enumerate() {
        let states = single(settings, commands, last, see);
        let angle = ends(states.iter().map(|state| state.angle_deg));
        let rate = ends(states.iter().map(|state| state.rate_deg_s));
        let (least, greatest) = (lanes.seen.least.of(lane), lanes.seen.greatest.of(lane));
        assert_eq!((least.angle_deg, greatest.angle_deg), angle);
        assert_eq!((least.rate_deg_s, greatest.rate_deg_s), rate);
        let bits = |s: PlantState| [s.angle_deg, s.rate_deg_s].map(f64::to_bits);
        assert_eq!(bits(lanes.last(lane)), bits(*states.last().unwrap()));
    }
}

/// Commands that hold each of these levels, deg, for a number of control periods.
fn held(levels: &[f64], periods: usize) -> Vec<Angle> {
    let held = |level: &f64| core::iter::repeat_n(angle(*level), periods);
    levels.iter().flat_map(held).collect()
}

proptest! {
    #[test]
    fn the_extremes_and_the_end_are_those_of_single_boards(
        boards in proptest::collection::vec(settings(PlantKind::FirstOrder), LANES),
        levels in proptest::collection::vec(-200.0..200.0, 1..12),
        hold in 1_usize..120,
        last in 1_usize..=80,
        sees_all: bool,
        only: Index,
    ) {
        let commands = held(&levels, hold);
        let see = if sees_all { Seen::All } else { Seen::Edges };
        let three: [&Settings; LANES] = from_fn(|lane| &boards[lane]);
        compare::<MotorLanes<_>, _>(three, &commands, last, see);
        compare::<MotorLanes<_>, _>([only.get(&boards)], &commands, last, see);
    }

    #[test]
    fn benches_with_any_parameters_and_steps_move_as_single_ones(
        mut boards in proptest::collection::vec(settings(PlantKind::Drivetrain), LANES),
        gears: bool,
        shaft: bool,
        levels in proptest::collection::vec(-200.0..200.0, 1..4),
        hold in 1_usize..40,
        last in 1_usize..=80,
        sees_all: bool,
        only: Index,
    ) {
        let commands = held(&levels, hold);
        let see = if sees_all { Seen::All } else { Seen::Edges };
        boards.iter_mut().for_each(|board| Rigid { gears, shaft }.apply(board));
        let three: [&Settings; LANES] = from_fn(|lane| &boards[lane]);
        compare::<DrivetrainLanes<_>, _>(three, &commands, last, see);
        compare::<DrivetrainLanes<_>, _>([only.get(&boards)], &commands, last, see);
    }
}

#[test]
fn a_board_that_comes_to_rest_is_seen_to_the_last_tick() {
    let settings = Settings::new(ModelKind::Board, PlantKind::FirstOrder);
    for level in [0.0, 0.02, 30.0, -30.0] {
        compare::<MotorLanes<_>, _>([&settings], &[angle(level); 1500], 80, Seen::All);
    }
}

#[test]
fn a_bench_against_its_stop_is_that_of_a_single_one() {
    let mut settings = Settings::new(ModelKind::Board, PlantKind::Drivetrain);
    settings.set("hard_stop_deg", 20.0).unwrap();
    let commands = [[angle(30.0); 120], [angle(-30.0); 120]].concat();
    compare::<DrivetrainLanes<_>, _>([&settings], &commands, 80, Seen::All);
}

#[test]
fn what_the_lanes_do_not_compute_is_left_to_single_boards() {
    for (name, value) in [
        ("rate_limit_up_deg_s", 100.0),
        ("encoder_noise_deg", 0.03),
        ("timer_counts", 1.0),
    ] {
        let mut settings = Settings::new(ModelKind::Board, PlantKind::FirstOrder);
        settings.set(name, value).unwrap();
        assert!(MotorLoops::<1>::try_new([&settings]).unwrap().is_none());
    }
    for (name, value) in [
        ("friction_model", 2.0),
        ("pendulum_mass_kg", 0.1),
        ("encoder_noise_deg", 0.03),
        ("timer_counts", 1.0),
    ] {
        let mut settings = Settings::new(ModelKind::Board, PlantKind::Drivetrain);
        settings.set(name, value).unwrap();
        assert!(BenchLoops::<1>::try_new([&settings]).unwrap().is_none());
    }
    let mut switched = Settings::new(ModelKind::Board, PlantKind::Drivetrain);
    let three_bodies = switched;
    switched.pwm = Pwm::Switched;
    assert!(BenchLoops::<1>::try_new([&switched]).unwrap().is_none());
    let mut two_bodies = three_bodies;
    let shaft = true;
    Rigid {
        gears: false,
        shaft,
    }
    .apply(&mut two_bodies);
    let mixed = BenchLoops::try_new([&two_bodies, &three_bodies]);
    assert!(mixed.unwrap().is_none());
}
