//! The rows of the board in closed loop.

use model_core::{
    actuator::closed_loop::ClosedLoop,
    plant::{
        Plant, PlantState,
        drivetrain::{load::Recording, stepped::SteppedDrivetrain},
        first_order::FirstOrder,
    },
    sensors::{adc::FrontEnd, noise::Noise},
    time::{UPDATE_PERIOD_TICKS, seconds},
};

use super::{Rows, Simulation};
use crate::{
    error::Error,
    input::CommandPath,
    settings::{PlantKind, Settings},
};

const BOARD_COLUMNS: [&str; 2] = ["rate_command_deg_s", "compare_counts"];

const BENCH_COLUMNS: [&str; 9] = [
    "current_a",
    "back_emf_v",
    "current_meas_a",
    "back_emf_meas_v",
    "motor_angle_deg",
    "load_angle_deg",
    "motor_torque_nm",
    "friction_torque_nm",
    "load_torque_nm",
];

/// The columns of the board in addition to the common ones.
pub(super) fn columns(plant: PlantKind) -> Vec<&'static str> {
    let bench: &[_] = match plant {
        PlantKind::FirstOrder => &[],
        PlantKind::Drivetrain => &BENCH_COLUMNS,
    };
    [&BOARD_COLUMNS, bench].concat()
}

pub(super) fn run(
    simulation: &Simulation,
    path: &CommandPath,
    rows: &mut dyn Rows,
) -> Result<(), Error> {
    let settings = &simulation.settings;
    let mut row = Vec::new();
    match settings.plant {
        PlantKind::FirstOrder => {
            let board = around_first_order(settings)?;
            drive(board, simulation, path, |board, tick, within| {
                row.clear();
                row.extend(board_row(board, path, tick, within));
                rows.row(&row)
            })
        }
        PlantKind::Drivetrain => {
            let board = around_drivetrain(simulation)?;
            let mut front_ends = settings.front_ends();
            drive(board, simulation, path, |board, tick, within| {
                row.clear();
                row.extend(board_row(board, path, tick, within));
                row.extend(bench_row(&board.plant.drivetrain, &mut front_ends));
                rows.row(&row)
            })
        }
    }
}

/// Runs, and passes the state of the plant at every tick of a row.
#[inline(always)]
pub(super) fn states(
    simulation: &Simulation,
    path: &CommandPath,
    mut see: impl FnMut(PlantState),
) -> Result<(), Error> {
    let settings = &simulation.settings;
    match settings.plant {
        PlantKind::FirstOrder => drive(
            around_first_order(settings)?,
            simulation,
            path,
            |board, _, within| {
                see(board.plant.at(within));
                Ok(())
            },
        ),
        PlantKind::Drivetrain => drive(
            around_drivetrain(simulation)?,
            simulation,
            path,
            |board, _, within| {
                see(board.plant.at(within));
                Ok(())
            },
        ),
    }
}

/// The loop around the motor of the paper.
fn around_first_order(settings: &Settings) -> Result<ClosedLoop<FirstOrder>, Error> {
    Ok(settings.around(FirstOrder::try_new(settings.first_order, settings.pwm)?)?)
}

/// The loop around the bench.
fn around_drivetrain(simulation: &Simulation) -> Result<ClosedLoop<Bench<'_>>, Error> {
    let settings = &simulation.settings;
    let load = simulation.load.as_ref();
    Ok(settings.around(Bench {
        drivetrain: SteppedDrivetrain::try_new(&settings.drivetrain, settings.pwm)?,
        load: load.and_then(|load| Recording::try_new(load.points())),
        tick: 0,
        passed: 0,
    })?)
}

/// The bench with the recorded torque on its load.
struct Bench<'a> {
    drivetrain: SteppedDrivetrain,
    load: Option<Recording<'a>>,
    /// At the start of the running period, and how many of it have passed.
    tick: u64,
    passed: usize,
}

impl Plant for Bench<'_> {
    #[inline(always)]
    fn start_period(&mut self, duty_pct: f64) {
        self.tick += self.passed as u64;
        self.passed = 0;
        self.drivetrain.start_period(duty_pct);
    }

    #[inline(always)]
    fn pass_to(&mut self, tick_in_period: usize) {
        if let Some(load) = &self.load {
            for tick in self.passed..tick_in_period {
                let torque_nm = load.torque_nm(self.tick + tick as u64);
                self.drivetrain.set_recorded_torque_nm(torque_nm);
                self.drivetrain.advance_ticks(1);
            }
        }
        self.passed = tick_in_period;
        self.drivetrain.pass_to(tick_in_period);
    }

    #[inline(always)]
    fn at(&self, tick_in_period: usize) -> PlantState {
        self.drivetrain.at(tick_in_period)
    }
}

/// Runs, and passes every tick of a row to `show`, with its index in the PWM period.
#[inline(always)]
fn drive<P: Plant>(
    mut board: ClosedLoop<P>,
    simulation: &Simulation,
    path: &CommandPath,
    mut show: impl FnMut(&ClosedLoop<P>, u64, usize) -> Result<(), Error>,
) -> Result<(), Error> {
    let (ticks, every) = (simulation.ticks, simulation.every.max(1));
    let (mut edge, mut shown) = (0, 0_u64);
    while edge < ticks {
        simulation.check(edge)?;
        board.start_period(|tick| path.command.board(path.source(tick)));
        let end = ticks.min(edge + UPDATE_PERIOD_TICKS);
        while shown < end {
            let within = (shown - edge) as usize;
            board.plant.pass_to(within);
            show(&board, shown, within)?;
            shown = shown.saturating_add(every);
        }
        board.plant.pass_to(UPDATE_PERIOD_TICKS as usize);
        edge += UPDATE_PERIOD_TICKS;
    }
    Ok(())
}

fn board_row<P: Plant>(
    board: &ClosedLoop<P>,
    path: &CommandPath,
    tick: u64,
    within: usize,
) -> [f64; 10] {
    let now = board.plant.at(within);
    [
        seconds(tick),
        path.command.at(tick),
        path.command.at(path.sent(tick)),
        now.angle_deg,
        now.rate_deg_s,
        board.duty_pct(),
        board.angle_meas_deg(),
        board.rate_meas_deg_s(),
        board.last_step().rate_command.to_f64(),
        board.compare().get().into(),
    ]
}

fn bench_row(plant: &SteppedDrivetrain, front_ends: &mut [(FrontEnd, Noise); 2]) -> [f64; 9] {
    let now = plant.reading();
    let measured = |(front_end, noise): &mut (FrontEnd, Noise), quantity| {
        front_end.quantity(front_end.convert(quantity, noise))
    };
    let [current, back_emf] = front_ends;
    [
        now.current_a,
        now.back_emf_v,
        measured(current, now.current_a),
        measured(back_emf, now.back_emf_v),
        now.motor.angle_deg,
        now.load.angle_deg,
        now.motor_torque_nm,
        now.friction_torque_nm,
        now.load_torque_nm,
    ]
}
