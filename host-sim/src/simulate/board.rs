//! The rows of the board in closed loop.

use model_core::{
    control::{cascade::Coefficients, units::float},
    plant::{
        Plant,
        bench::{load::Recording, pwm::PwmBench},
        first_order::FirstOrder,
    },
    sensors::{adc::FrontEnd, encoder::Encoder, noise::Noise},
    time::PWM_PERIOD_TICKS,
};

use super::{Rows, Simulation, closed_loop::ClosedLoop, time_s};
use crate::{
    error::Error,
    input::CommandPath,
    settings::{BoardSettings, PlantKind},
};

/// The streams of the noise generator: one a sensor, so that none shifts the numbers of another.
const ENCODER_STREAM: u64 = 0;
const CURRENT_STREAM: u64 = 1;
const BACK_EMF_STREAM: u64 = 2;

const BOARD_COLUMNS: [&str; 2] = ["rate_command_deg_s", "compare"];

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

/// The columns that the board has beyond the common ones.
pub(super) fn columns(settings: &BoardSettings) -> Vec<&'static str> {
    let bench: &[_] = match settings.plant {
        PlantKind::FirstOrder => &[],
        PlantKind::Bench => &BENCH_COLUMNS,
    };
    [&BOARD_COLUMNS, bench].concat()
}

pub(super) fn run(
    settings: &BoardSettings,
    simulation: &Simulation,
    path: &CommandPath,
    rows: &mut dyn Rows,
) -> Result<(), Error> {
    let mut row = Vec::new();
    match settings.plant {
        PlantKind::FirstOrder => {
            let board = around_first_order(settings, simulation)?;
            board.run(simulation, path, |board, tick, within| {
                row.clear();
                row.extend(board_row(board, path, tick, within));
                rows.row(&row)
            })
        }
        PlantKind::Bench => {
            let load = simulation.load.as_ref();
            let load = load.and_then(|load| Recording::try_new(load.points()));
            let plant = PwmBench::try_new(&settings.bench, simulation.pwm, load)?;
            let mut sensing = Sensing::new(settings, simulation.seed);
            around(plant, settings, simulation)?.run(simulation, path, |board, tick, within| {
                row.clear();
                row.extend(board_row(board, path, tick, within));
                sensing.append(&board.plant, within, &mut row);
                rows.row(&row)
            })
        }
    }
}

/// The loop around the paper's motor.
pub(super) fn around_first_order(
    settings: &BoardSettings,
    simulation: &Simulation,
) -> Result<ClosedLoop<FirstOrder>, Error> {
    around(
        FirstOrder::try_new(settings.first_order, simulation.pwm)?,
        settings,
        simulation,
    )
}

fn around<P: Plant>(
    plant: P,
    settings: &BoardSettings,
    simulation: &Simulation,
) -> Result<ClosedLoop<P>, Error> {
    let coefficients = Coefficients::try_new(&settings.control)?;
    let encoder = Encoder::new(
        settings.encoder,
        Noise::new(simulation.seed, ENCODER_STREAM),
    );
    Ok(ClosedLoop::new(
        coefficients,
        settings.timer,
        encoder,
        plant,
    ))
}

impl<P: Plant> ClosedLoop<P> {
    /// Runs, and shows every tick of which a row is made, with its place in the running period.
    #[inline(always)]
    pub(super) fn run(
        mut self,
        simulation: &Simulation,
        path: &CommandPath,
        mut show: impl FnMut(&Self, u64, usize) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let (ticks, every) = (simulation.ticks, simulation.every.max(1));
        let (mut edge, mut shown) = (0, 0_u64);
        while edge < ticks {
            self.start_period(|tick| path.command.board(path.source(tick)));
            let end = ticks.min(edge + PWM_PERIOD_TICKS);
            while shown < end {
                show(&self, shown, (shown - edge) as usize)?;
                shown = shown.saturating_add(every);
            }
            edge += PWM_PERIOD_TICKS;
        }
        Ok(())
    }
}

fn board_row<P: Plant>(
    board: &ClosedLoop<P>,
    path: &CommandPath,
    tick: u64,
    within: usize,
) -> [f64; 10] {
    let now = board.plant.at(within);
    [
        time_s(tick),
        path.command.at(tick),
        path.command.at(path.source(tick)),
        now.angle_deg,
        now.rate_deg_s,
        board.duty_pct(),
        float(board.outputs.angle),
        float(board.outputs.rate),
        float(board.outputs.rate_command),
        board.compare().get().into(),
    ]
}

/// The analogue front ends of the bench.
struct Sensing {
    current: (FrontEnd, Noise),
    back_emf: (FrontEnd, Noise),
}

impl Sensing {
    fn new(settings: &BoardSettings, seed: u64) -> Self {
        Self {
            current: (
                (&settings.current_sense).into(),
                Noise::new(seed, CURRENT_STREAM),
            ),
            back_emf: (
                (&settings.back_emf_sense).into(),
                Noise::new(seed, BACK_EMF_STREAM),
            ),
        }
    }

    fn append(&mut self, plant: &PwmBench, tick_in_period: usize, row: &mut Vec<f64>) {
        let now = plant.reading_at(tick_in_period);
        let measured = |(front_end, noise): &mut (FrontEnd, Noise), quantity| {
            front_end.quantity(front_end.convert(quantity, noise))
        };
        row.extend([
            now.current_a,
            now.back_emf_v,
            measured(&mut self.current, now.current_a),
            measured(&mut self.back_emf, now.back_emf_v),
            now.motor.angle_deg,
            now.load.angle_deg,
            now.motor_torque_nm,
            now.friction_torque_nm,
            now.load_torque_nm,
        ]);
    }
}
