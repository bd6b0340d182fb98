//! Everything of an actuator but the memory of its delay.

use core::ops::Range;

use super::closed_loop::ClosedLoop;
use super::input::{COMMAND_RANGE, CommandError, InputLevel};
use super::kind::{ModelKind, PlantKind};
use super::reading::Reading;
use super::settings::Settings;
use crate::control::units::{angle, rate};
use crate::models::{
    ActuatorModel, Output, black_box_1::BlackBox1, black_box_2::BlackBox2, delay::DelayCursor,
    grey_box::Demand, grey_box::GreyBox,
};
use crate::parameter::ParameterError;
use crate::plant::{
    PERIOD, Plant, drivetrain::stepped::SteppedDrivetrain, first_order::FirstOrder,
};
use crate::time::{UPDATE_PERIOD_TICKS, ticks};

/// Any model, stored inline: there is no heap.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[allow(clippy::large_enum_variant, reason = "no heap")]
pub(super) enum Model {
    BlackBox1(BlackBox1),
    BlackBox2(BlackBox2),
    GreyBox(GreyBox),
    FirstOrder(ClosedLoop<FirstOrder>),
    Drivetrain(ClosedLoop<SteppedDrivetrain>),
}

/// An actuator whose delay has its memory elsewhere: for callers that have no heap and allocate
/// what a delay needs themselves.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ActuatorCore {
    pub(super) model: Model,
    /// Period of the host, ticks; 0 if the host samples every tick.
    pub(super) host_ticks: u64,
    pub(super) now: Signals,
}

/// Command and time of an actuator.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Signals {
    /// The quantity that is commanded.
    pub level: InputLevel,
    /// The last command that the host sampled.
    sampled: f64,
    /// The delayed command.
    pub arrived: f64,
    pub tick: u64,
}

impl ActuatorCore {
    /// The actuator of these settings, and the delay of its command.
    ///
    /// # Errors
    /// That of the first parameter that is out of its range or inconsistent with another one.
    pub fn try_new(settings: &Settings) -> Result<(Self, DelayCursor), ParameterError> {
        settings.setup.check()?;
        let s = settings;
        let model = match (s.model, s.plant) {
            (ModelKind::BlackBox1, _) => Model::BlackBox1(BlackBox1::try_new(s.black_box_1)?),
            (ModelKind::BlackBox2, _) => Model::BlackBox2(BlackBox2::try_new(s.black_box_2)?),
            (ModelKind::GreyBox, _) => Model::GreyBox(GreyBox::try_new(s.grey_box)?),
            (ModelKind::Board, PlantKind::FirstOrder) => {
                Model::FirstOrder(s.around(FirstOrder::try_new(s.first_order, s.pwm)?)?)
            }
            (ModelKind::Board, PlantKind::Drivetrain) => {
                Model::Drivetrain(s.around(SteppedDrivetrain::try_new(&s.drivetrain, s.pwm)?)?)
            }
        };
        // The maximum of the parameter is the longest delay.
        let delay = DelayCursor::try_new(ticks(s.setup.delay_s)).ok_or(ParameterError::Unknown)?;
        let core = Self {
            model,
            host_ticks: ticks(s.setup.host_period_s),
            now: Signals {
                level: InputLevel::Position,
                sampled: 0.0,
                arrived: 0.0,
                tick: 0,
            },
        };
        Ok((core, delay))
    }

    /// As [`Actuator::advance_with`](super::Actuator::advance_with), with the delay and its memory
    /// of [`DelayCursor::len`] values.
    ///
    /// # Errors
    /// [`CommandError`] for a value beyond [`COMMAND_RANGE`] and for NaN, or if the model has no
    /// such input.
    #[inline]
    pub fn advance_with(
        &mut self,
        (delay, memory): (&mut DelayCursor, &mut [f64]),
        level: InputLevel,
        value: f64,
        ticks: u64,
    ) -> Result<(), CommandError> {
        if !COMMAND_RANGE.contains(&value) {
            return Err(CommandError::Value);
        }
        if level != self.now.level && ticks > 0 {
            if !self.has(level) {
                return Err(CommandError::Level(level));
            }
            self.now.level = level;
            self.now.sampled = value;
            delay.restart();
        }
        if delay.is_empty() && self.host_ticks == 0 {
            // The command is that of every tick.
            self.now.arrived = if ticks > 0 { value } else { self.now.arrived };
            self.run(ticks);
            return Ok(());
        }
        for _ in 0..ticks {
            if self.now.tick.checked_rem(self.host_ticks).unwrap_or(0) == 0 {
                self.now.sampled = value;
            }
            self.now.arrived = delay.shift(memory, self.now.sampled);
            self.run(1);
        }
        Ok(())
    }

    /// Whether the model has an input in this quantity.
    pub fn has(&self, level: InputLevel) -> bool {
        let (model, plant) = match &self.model {
            Model::BlackBox1(_) => (ModelKind::BlackBox1, PlantKind::FirstOrder),
            Model::BlackBox2(_) => (ModelKind::BlackBox2, PlantKind::FirstOrder),
            Model::GreyBox(_) => (ModelKind::GreyBox, PlantKind::FirstOrder),
            Model::FirstOrder(_) => (ModelKind::Board, PlantKind::FirstOrder),
            Model::Drivetrain(_) => (ModelKind::Board, PlantKind::Drivetrain),
        };
        level.is_of(model, plant)
    }

    /// Number of ticks so far.
    pub fn tick(&self) -> u64 {
        self.now.tick
    }

    /// The quantity that was commanded last.
    pub fn level(&self) -> InputLevel {
        self.now.level
    }

    /// Passes ticks with the command that has arrived.
    #[inline]
    fn run(&mut self, ticks: u64) {
        let (arrived, level, first) = (self.now.arrived, self.now.level, self.now.tick);
        self.now.tick += ticks;
        match &mut self.model {
            Model::BlackBox1(model) => (0..ticks).for_each(|_| model.advance_tick(arrived)),
            Model::BlackBox2(model) => (0..ticks).for_each(|_| model.advance_tick(arrived)),
            Model::GreyBox(model) => {
                let demand = demand(level, arrived);
                (0..ticks).for_each(|_| model.step_for(demand));
            }
            Model::FirstOrder(board) => pass_edges(board, first..self.now.tick, level, arrived),
            Model::Drivetrain(board) => {
                let mut tick = first;
                while tick < self.now.tick {
                    if tick.is_multiple_of(UPDATE_PERIOD_TICKS) {
                        match level {
                            InputLevel::Position => board.start_period(|_| angle(arrived)),
                            InputLevel::Rate => board.start_period(|_| rate(arrived)),
                            InputLevel::Duty => board.start_open_period(arrived),
                            InputLevel::Voltage => board.start_period_at_volts(arrived),
                        }
                    }
                    let edge = (tick + 1)
                        .next_multiple_of(UPDATE_PERIOD_TICKS)
                        .min(self.now.tick);
                    board.plant.advance_ticks((edge - tick) as u32);
                    tick = edge;
                }
            }
        }
    }

    /// The continuous states of a black box or a grey box: angle, deg, rate, deg/s, and integrator
    /// of the rate loop, %; 0 for those that the model does not have. The board has none.
    pub fn continuous_state(&self) -> [f64; 3] {
        match &self.model {
            Model::BlackBox1(model) => [model.angle_deg(), 0.0, 0.0],
            Model::BlackBox2(model) => {
                let [angle_deg, rate_deg_s] = model.state();
                [angle_deg, rate_deg_s, 0.0]
            }
            Model::GreyBox(model) => model.state(),
            Model::FirstOrder(_) | Model::Drivetrain(_) => [0.0; 3],
        }
    }

    /// The command that has arrived, in the unit of its quantity.
    pub fn arrived(&self) -> f64 {
        self.now.arrived
    }

    /// The outputs at this instant, before the next step.
    pub fn reading(&self) -> Reading {
        let arrived = self.now.arrived;
        let command_deg = match self.now.level {
            InputLevel::Position => arrived,
            // The angle is not commanded.
            _ => 0.0,
        };
        match &self.model {
            Model::BlackBox1(model) => of_output(model.output(arrived), command_deg),
            Model::BlackBox2(model) => of_output(model.output(arrived), command_deg),
            Model::GreyBox(model) => of_output(
                model.output_for(demand(self.now.level, arrived)),
                command_deg,
            ),
            Model::FirstOrder(board) => board.reading(self.now.tick, command_deg),
            Model::Drivetrain(board) => {
                let now = board.plant.reading();
                Reading {
                    current_a: now.current_a,
                    back_emf_v: now.back_emf_v,
                    ..board.reading(self.now.tick, command_deg)
                }
            }
        }
    }
}

/// Passes the PWM edges at these ticks.
#[inline(always)]
pub(super) fn pass_edges(
    board: &mut ClosedLoop<FirstOrder>,
    ticks: Range<u64>,
    level: InputLevel,
    arrived: f64,
) {
    let mut edge = ticks.start.next_multiple_of(UPDATE_PERIOD_TICKS);
    while edge < ticks.end {
        match level {
            InputLevel::Position => board.start_period(|_| angle(arrived)),
            InputLevel::Rate => board.start_period(|_| rate(arrived)),
            InputLevel::Duty | InputLevel::Voltage => board.start_open_period(arrived),
        }
        edge += UPDATE_PERIOD_TICKS;
    }
}

/// The command of a grey box, which has no voltage.
pub fn demand(level: InputLevel, value: f64) -> Demand {
    match level {
        InputLevel::Position => Demand::Angle(value),
        InputLevel::Rate => Demand::Rate(value),
        InputLevel::Duty | InputLevel::Voltage => Demand::Duty(value),
    }
}

/// Ticks since the start of the PWM period that ends now or later: 1 to 20, and 0 at tick 0.
pub(super) fn ticks_into_period(tick: u64) -> usize {
    match tick {
        0 => 0,
        tick => (tick - 1) as usize % PERIOD + 1,
    }
}

fn of_output(output: Output, command_deg: f64) -> Reading {
    Reading {
        command_deg,
        angle_deg: output.angle_deg,
        rate_deg_s: output.rate_deg_s,
        duty_pct: output.duty_pct,
        angle_meas_deg: output.angle_deg,
        rate_meas_deg_s: output.rate_deg_s,
        ..Default::default()
    }
}

impl<P: Plant> ClosedLoop<P> {
    fn reading(&self, tick: u64, command_deg: f64) -> Reading {
        let now = self.plant.at(ticks_into_period(tick));
        Reading {
            command_deg,
            angle_deg: now.angle_deg,
            rate_deg_s: now.rate_deg_s,
            duty_pct: self.duty_pct(),
            angle_meas_deg: self.angle_meas_deg(),
            rate_meas_deg_s: self.rate_meas_deg_s(),
            ..Default::default()
        }
    }
}
