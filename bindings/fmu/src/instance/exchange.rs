//! Model exchange: time, states and events by the host.

use super::{Exchange, Instance, Phase, Refusal, Result};
use crate::exchange::Update;
use crate::exchange::equations::{Equations, Sides, State};
use model_core::actuator::demand;

/// The phases of a run.
const RUNNING: &[Phase] = &[Phase::Event, Phase::Continuous];

/// The phases in which the equations can be evaluated.
const EVALUATED: &[Phase] = &[
    Phase::Initialization,
    Phase::Event,
    Phase::Continuous,
    Phase::Terminated,
];

/// States, derivatives and event indicators.
pub struct Evaluation {
    /// The continuous states.
    pub states: Vec<f64>,
    /// Their derivatives.
    pub derivatives: Vec<f64>,
    /// The event indicators.
    pub indicators: Vec<f64>,
}

impl Instance {
    /// The model at the start, with the inputs as they are.
    pub(super) fn initial_exchange(&self) -> Option<Exchange> {
        let state = &self.state;
        let value = state.inputs.command(state.level);
        Exchange::new(&state.settings, state.time.start_s, state.level, value)
    }

    fn running(&mut self) -> Result<&mut Exchange> {
        self.expect(RUNNING)?;
        let exchange = self.state.exchange.as_deref_mut();
        exchange.ok_or_else(|| "the instance is not for model exchange".into())
    }

    /// Number of continuous states and of event indicators; 0 for the board.
    pub fn dimensions(&self) -> (usize, usize) {
        let equations = Equations::of(&self.state.settings);
        equations.map_or((0, 0), |e| (e.states(), e.indicator_count()))
    }

    /// Interrupts the integration for an event.
    ///
    /// # Errors
    /// Unless the host integrates.
    pub fn enter_event_mode(&mut self) -> Result<()> {
        self.expect(&[Phase::Continuous])?;
        self.complete_step()?;
        self.state.phase = Phase::Event;
        Ok(())
    }

    /// Begins or continues the integration.
    ///
    /// # Errors
    /// Without an event.
    pub fn enter_continuous_time_mode(&mut self) -> Result<()> {
        self.expect(&[Phase::Event])?;
        self.state.phase = Phase::Continuous;
        Ok(())
    }

    /// Processes an event.
    ///
    /// # Errors
    /// Without an event.
    pub fn update_discrete_states(&mut self) -> Result<Update> {
        self.expect(&[Phase::Event])?;
        let (settings, level) = (self.state.settings, self.state.level);
        let value = self.state.inputs.command(level);
        let now_s = self.state.time.now_s;
        let update = self.running()?.update(&settings, now_s, level, value);
        update.ok_or_else(|| "the model is not continuous".into())
    }

    /// Sets the time of the integration, s.
    ///
    /// # Errors
    /// Unless the host integrates, and for a time before the start.
    pub fn set_time(&mut self, time_s: f64) -> Result<()> {
        self.expect(&[Phase::Continuous])?;
        let start_s = self.state.time.start_s;
        // Written so that NaN fails.
        if !(time_s >= start_s && time_s.is_finite()) {
            return Err(format!("time is {time_s}, expected {start_s} s or later").into());
        }
        self.state.time.now_s = time_s;
        Ok(())
    }

    /// Sets the continuous states.
    ///
    /// # Errors
    /// Unless the host integrates, and for another number of states; values that are not finite
    /// are discarded.
    pub fn set_states(&mut self, states: &[f64]) -> Result<()> {
        self.expect(&[Phase::Continuous])?;
        let expected = self.dimensions().0;
        if states.len() != expected {
            return Err(format!("there are {} states, expected {expected}", states.len()).into());
        }
        if let Some(state) = states.iter().find(|state| !state.is_finite()) {
            return Err(Refusal {
                is_discard: true,
                message: format!("a state is {state}, expected a finite number"),
            });
        }
        self.running()?.set_state(states);
        Ok(())
    }

    /// Accepts the step that ends at the present time.
    ///
    /// # Errors
    /// Unless the host integrates.
    pub fn complete_step(&mut self) -> Result<()> {
        self.expect(&[Phase::Continuous])?;
        let now_s = self.state.time.now_s;
        self.running()?.complete_step(now_s);
        Ok(())
    }

    /// The equations at the present time, for a host that integrates.
    ///
    /// # Errors
    /// Before the initialization, and for an instance that is not for model exchange.
    pub fn evaluated(&self) -> Result<Evaluation> {
        self.expect(EVALUATED)?;
        let is_running = self.state.phase != Phase::Initialization;
        if is_running && self.state.exchange.is_none() {
            return Err("the instance is not for model exchange".into());
        }
        Ok(self.evaluation())
    }

    /// The equations at the present time, also of an instance for co-simulation.
    pub(super) fn evaluation(&self) -> Evaluation {
        let (settings, now_s) = (&self.state.settings, self.state.time.now_s);
        let (states, derivatives, indicators) = match (&self.state.exchange, &self.state.actuator) {
            (None, Some(actuator)) => {
                let demand = demand(actuator.level(), actuator.arrived());
                at_rest_of_sides(settings, demand, actuator.continuous_state())
            }
            (exchange, _) => {
                let initial = self.initial_exchange();
                let exchange = exchange.as_deref().or(initial.as_ref());
                exchange.map_or(([0.0; 3], [0.0; 3], Vec::new()), |exchange| {
                    (
                        *exchange.state(),
                        exchange.derivative(settings, now_s),
                        exchange.indicators(settings, now_s),
                    )
                })
            }
        };
        let count = self.dimensions().0;
        Evaluation {
            states: states[..count].to_vec(),
            derivatives: derivatives[..count].to_vec(),
            indicators,
        }
    }
}

/// State, derivative and indicators of a state whose sides are not known.
fn at_rest_of_sides(
    settings: &model_core::actuator::Settings,
    demand: model_core::models::grey_box::Demand,
    state: State,
) -> (State, State, Vec<f64>) {
    let Some(equations) = Equations::of(settings) else {
        return (state, [0.0; 3], Vec::new());
    };
    let (mut settled, mut sides) = (state, Sides::default());
    equations.settle(demand, &mut settled, &mut sides);
    (
        state,
        equations.derivative(demand, &settled, &sides),
        equations.indicators(demand, &settled, &sides),
    )
}
