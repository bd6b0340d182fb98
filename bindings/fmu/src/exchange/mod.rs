//! Model exchange: a continuous model whose host integrates it.
//!
//! The state belongs to the host's solver. What is discrete here is the side of each limit that the
//! model is on, and the command on its way through sampling and delay: both change at events only,
//! so that the derivatives are smooth in between.

pub mod command;
pub mod equations;

use model_core::actuator::{InputLevel, Reading, Settings, demand};
use model_core::time::{TICK_S, ticks};
use serde::{Deserialize, Serialize};

use command::Command;
use equations::{Equations, Sides, State};

/// What a host does at the end of an event.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Update {
    /// Whether the event has changed the continuous states.
    pub changed_states: bool,
    /// The time of the next event that is known already, s.
    pub next_event_s: Option<f64>,
}

/// A continuous model during a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Exchange {
    state: State,
    sides: Sides,
    command: Command,
    level: InputLevel,
}

impl Exchange {
    /// The model at rest at zero, at the start time; `None` for the board, which is not continuous.
    pub fn new(settings: &Settings, start_s: f64, level: InputLevel, value: f64) -> Option<Self> {
        let equations = Equations::of(settings)?;
        let setup = &settings.setup;
        // As in co-simulation, both are whole ticks.
        let [delay_s, period_s] =
            [setup.delay_s, setup.host_period_s].map(|time_s| ticks(time_s) as f64 * TICK_S);
        let mut new = Self {
            state: [0.0; 3],
            sides: Sides::default(),
            command: Command::new(start_s, value, delay_s, period_s),
            level,
        };
        new.settle(&equations, start_s);
        Some(new)
    }

    /// The continuous states; a model has the first of them.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// Sets the first continuous states.
    pub fn set_state(&mut self, state: &[f64]) {
        for (own, value) in self.state.iter_mut().zip(state) {
            *own = *value;
        }
    }

    /// Takes the value of the command at a time within a step.
    pub fn set_command(&mut self, time_s: f64, value: f64) {
        self.command.set(time_s, value);
    }

    /// Accepts the step that ends at this time.
    pub fn complete_step(&mut self, time_s: f64) {
        self.command.complete(time_s);
    }

    /// Processes an event, with the command after it.
    pub fn update(
        &mut self,
        settings: &Settings,
        time_s: f64,
        level: InputLevel,
        value: f64,
    ) -> Option<Update> {
        let equations = Equations::of(settings)?;
        if level != self.level {
            self.level = level;
            self.command.restart(time_s, value);
        } else {
            self.command.update(time_s, value);
        }
        let before = self.state;
        self.settle(&equations, time_s);
        Some(Update {
            changed_states: before != self.state,
            next_event_s: self.command.next_event_s(),
        })
    }

    fn settle(&mut self, equations: &Equations, time_s: f64) {
        let demand = demand(self.level, self.command.arrived(time_s));
        equations.settle(demand, &mut self.state, &mut self.sides);
    }

    /// Adds to the integrator what a change of the gains would change the duty by.
    pub fn retune(&mut self, before: &Settings, after: &Settings, time_s: f64) {
        let demand = demand(self.level, self.command.arrived(time_s));
        let (Some(before), Some(after)) = (Equations::of(before), Equations::of(after)) else {
            return;
        };
        self.state[2] +=
            before.demand_pct(demand, &self.state) - after.demand_pct(demand, &self.state);
    }

    /// The derivatives of the states.
    pub fn derivative(&self, settings: &Settings, time_s: f64) -> State {
        let demand = demand(self.level, self.command.arrived(time_s));
        let equations = Equations::of(settings);
        equations.map_or([0.0; 3], |e| e.derivative(demand, &self.state, &self.sides))
    }

    /// The event indicators: positive between events, zero where one is due.
    pub fn indicators(&self, settings: &Settings, time_s: f64) -> Vec<f64> {
        let demand = demand(self.level, self.command.arrived(time_s));
        let equations = Equations::of(settings);
        equations.map_or(Vec::new(), |e| {
            e.indicators(demand, &self.state, &self.sides)
        })
    }

    /// The outputs.
    pub fn reading(&self, settings: &Settings, time_s: f64) -> Reading {
        let arrived = self.command.arrived(time_s);
        let demand = demand(self.level, arrived);
        let Some(equations) = Equations::of(settings) else {
            return Reading::default();
        };
        let [rate_deg_s, duty_pct] = equations.rate_and_duty(demand, &self.state, &self.sides);
        Reading {
            command_deg: match self.level {
                InputLevel::Position => arrived,
                _ => 0.0,
            },
            angle_deg: self.state[0],
            rate_deg_s,
            duty_pct,
            angle_meas_deg: self.state[0],
            rate_meas_deg_s: rate_deg_s,
            ..Reading::default()
        }
    }
}
