//! One instance of an FMU, without the C interface.
//!
//! A call that fails changes nothing.

use std::collections::BTreeMap;

use model_core::actuator::{Reading, Settings};
use model_core::plant::Pwm;
use model_core::scenario::LONGEST_S;
use model_core::time::{TICK_S, ticks};

use crate::description::guid;
use crate::exchange::{Exchange, equations::Equations};
use crate::state::{Actuator, InstanceState, Interface, Phase, Time};
use crate::variables::{self, Quantity, Type, Variable};

pub mod exchange;
pub mod values;

/// Why a call is refused.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct Refusal {
    /// Whether the host may continue without the result (`fmi2Discard`).
    pub is_discard: bool,
    /// The problem, and what is expected.
    pub message: String,
}

impl From<String> for Refusal {
    fn from(message: String) -> Self {
        Self {
            is_discard: false,
            message,
        }
    }
}

impl From<&str> for Refusal {
    fn from(message: &str) -> Self {
        message.to_owned().into()
    }
}

/// The result of a call.
pub type Result<T> = std::result::Result<T, Refusal>;

/// Tolerance of the communication points of the host, s.
const HALF_TICK_S: f64 = TICK_S / 2.0;

const BEFORE_STEPPING: &[Phase] = &[Phase::Instantiated, Phase::Initialization];

/// One instance of an FMU.
#[derive(Debug)]
pub struct Instance {
    guid: String,
    variables: Vec<Variable>,
    initial: Settings,
    state: InstanceState,
    kept: BTreeMap<usize, Box<InstanceState>>,
    last_key: usize,
}

impl Instance {
    /// An instance for model exchange with these start values.
    ///
    /// # Errors
    /// For the board: it is not continuous.
    pub fn for_exchange(settings: Settings) -> std::result::Result<Self, String> {
        if Equations::of(&settings).is_none() {
            return Err("the board is sampled and not continuous, expected co-simulation".into());
        }
        let mut instance = Self::new(settings);
        instance.state.interface = Interface::ModelExchange;
        Ok(instance)
    }

    /// An instance for co-simulation with these start values.
    pub fn new(settings: Settings) -> Self {
        Self {
            guid: guid(&settings),
            variables: variables::of(&settings),
            initial: settings,
            state: InstanceState::new(settings),
            kept: BTreeMap::new(),
            last_key: 0,
        }
    }

    fn expect(&self, allowed: &[Phase]) -> Result<()> {
        if allowed.contains(&self.state.phase) {
            return Ok(());
        }
        Err(format!(
            "not allowed in phase {:?}, expected {allowed:?}",
            self.state.phase
        )
        .into())
    }

    /// Sets the start time and, if it is known, the stop time, s.
    ///
    /// # Errors
    /// After the start of the initialization, and for times that are not finite or in the wrong
    /// order.
    pub fn set_up_experiment(&mut self, start_s: f64, stop_s: Option<f64>) -> Result<()> {
        self.expect(&[Phase::Instantiated])?;
        if !start_s.is_finite() {
            return Err(format!("startTime is {start_s}, expected a number of seconds").into());
        }
        if let Some(stop_s) = stop_s
            && !(stop_s.is_finite() && stop_s >= start_s)
        {
            return Err(format!("stopTime is {stop_s}, expected {start_s} s or more").into());
        }
        self.state.time = Time {
            start_s,
            stop_s,
            now_s: start_s,
        };
        Ok(())
    }

    /// Starts the initialization.
    ///
    /// # Errors
    /// If it has started already.
    pub fn enter_initialization(&mut self) -> Result<()> {
        self.expect(&[Phase::Instantiated])?;
        self.state.phase = Phase::Initialization;
        Ok(())
    }

    /// Ends the initialization: the parameters are fixed from now on.
    ///
    /// # Errors
    /// Before the initialization, and for parameters that exclude each other.
    pub fn exit_initialization(&mut self) -> Result<()> {
        self.expect(&[Phase::Initialization])?;
        let mut settings = self.state.settings;
        // The input is the whole load torque.
        settings.drivetrain.load.load_torque_nm = 0.0;
        let actuator = Actuator::try_with_ring(&settings);
        // It checks the parameters for model exchange, too.
        let actuator = actuator.map_err(|error| error.to_string())?;
        match self.state.interface {
            Interface::CoSimulation => {
                self.state.actuator = Some(Box::new(actuator));
                self.state.phase = Phase::Stepping;
            }
            Interface::ModelExchange => {
                self.state.exchange = self.initial_exchange().map(Box::new);
                self.state.phase = Phase::Event;
            }
        }
        Ok(())
    }

    /// Ends the run; outputs remain readable.
    ///
    /// # Errors
    /// Before the end of the initialization, and after the end of the run.
    pub fn terminate(&mut self) -> Result<()> {
        self.expect(&[Phase::Stepping, Phase::Event, Phase::Continuous])?;
        self.state.phase = Phase::Terminated;
        Ok(())
    }

    /// Restores the state after the instantiation; saved states are kept.
    pub fn reset(&mut self) {
        self.state = InstanceState {
            interface: self.state.interface,
            ..InstanceState::new(self.initial)
        };
    }

    /// Marks the instance as failed after a panic: its state is unreliable.
    pub fn fail(&mut self) {
        self.state.phase = Phase::Failed;
    }

    /// The value reference of the time in FMI 3.0: behind all variables.
    pub fn time_reference(&self) -> u32 {
        self.variables.len() as u32
    }

    /// The present communication point, s.
    pub fn now_s(&self) -> f64 {
        self.state.time.now_s
    }

    /// Steps from one communication point over `step_s`.
    ///
    /// The end is rounded to a tick from the start time, so that rounding errors of step sizes that
    /// are not whole numbers of ticks do not accumulate.
    ///
    /// # Errors
    /// Those of [`Self::end_of_step`].
    pub fn step(&mut self, point_s: f64, step_s: f64) -> Result<()> {
        let end_s = self.end_of_step(point_s, step_s)?;
        self.step_to(end_s)
    }

    /// The end of such a step, s; nothing is advanced.
    ///
    /// # Errors
    /// For a point other than the present one, a step size that is not positive, and an end after
    /// the stop time or four months.
    pub fn end_of_step(&self, point_s: f64, step_s: f64) -> Result<f64> {
        self.expect(&[Phase::Stepping])?;
        let time = &self.state.time;
        // Written so that NaN fails, here and below.
        if !(step_s > 0.0 && step_s <= LONGEST_S) {
            return Err(format!(
                "communicationStepSize is {step_s}, expected more than 0 and at most {LONGEST_S} s"
            )
            .into());
        }
        let is_here = (point_s - time.now_s).abs() <= HALF_TICK_S;
        if !is_here {
            return Err(format!(
                "currentCommunicationPoint is {point_s}, expected {} s",
                time.now_s
            )
            .into());
        }
        let end_s = point_s + step_s;
        let last_s = time.stop_s.unwrap_or(f64::INFINITY);
        let last_s = last_s.min(time.start_s + LONGEST_S);
        if end_s > last_s + HALF_TICK_S {
            return Err(format!("the step ends at {end_s}, expected at most {last_s} s").into());
        }
        Ok(end_s)
    }

    /// Advances to a time that [`Self::end_of_step`] returned, or one before it.
    ///
    /// # Errors
    /// In a phase without steps.
    pub fn step_to(&mut self, time_s: f64) -> Result<()> {
        self.expect(&[Phase::Stepping])?;
        self.advance_to(ticks(time_s - self.state.time.start_s))?;
        self.state.time.now_s = time_s;
        Ok(())
    }

    fn advance_to(&mut self, tick: u64) -> Result<()> {
        let (inputs, level) = (self.state.inputs, self.state.level);
        let actuator = self.state.actuator.as_deref_mut();
        let actuator = actuator.ok_or("there is no actuator")?;
        let taken = actuator
            .set_load_torque_nm(inputs.load_torque_nm)
            .and_then(|()| actuator.set_load_inertia_kg_m2(inputs.added_inertia_kg_m2))
            .and_then(|()| {
                let count = tick.saturating_sub(actuator.tick());
                actuator.advance_with(level, inputs.command(level), count)
            });
        taken.map_err(|error| error.to_string().into())
    }

    /// Saves a copy of the state, and returns its key. With the key of a saved state, that one is
    /// replaced.
    ///
    /// # Errors
    /// For a key of no saved state.
    pub fn keep(&mut self, key: Option<usize>) -> Result<usize> {
        self.keep_under(key, self.state.clone())
    }

    fn keep_under(&mut self, key: Option<usize>, state: InstanceState) -> Result<usize> {
        let key = match key {
            Some(key) => self.kept(key).map(|_| key)?,
            None => {
                // Keys are never reused.
                self.last_key += 1;
                self.last_key
            }
        };
        self.kept.insert(key, Box::new(state));
        Ok(key)
    }

    fn kept(&self, key: usize) -> Result<&InstanceState> {
        let state = self.kept.get(&key).map(Box::as_ref);
        state.ok_or_else(|| "the state is not one that this instance has saved".into())
    }

    /// Restores a saved state.
    ///
    /// # Errors
    /// For a key of no saved state.
    pub fn put_back(&mut self, key: usize) -> Result<()> {
        self.state = self.kept(key)?.clone();
        Ok(())
    }

    /// Removes a saved state.
    ///
    /// # Errors
    /// For a key of no saved state.
    pub fn forget(&mut self, key: usize) -> Result<()> {
        self.kept(key)?;
        self.kept.remove(&key);
        Ok(())
    }

    /// A saved state as bytes.
    ///
    /// # Errors
    /// For a key of no saved state.
    pub fn bytes(&self, key: usize) -> Result<Vec<u8>> {
        Ok(self.kept(key)?.to_bytes(&self.guid)?)
    }

    /// Saves a state that was serialised by an instance of the same FMU. It replaces the one with
    /// this key, if there is one: the standard does not require a host to clear its variable.
    ///
    /// # Errors
    /// For bytes that are damaged or not such a state.
    pub fn keep_bytes(&mut self, bytes: &[u8], key: Option<usize>) -> Result<usize> {
        let state = InstanceState::from_bytes(bytes, &self.guid, &self.initial);
        let state = state.map_err(|why| format!("the state is refused: {why}"))?;
        if state.interface != self.state.interface {
            return Err(format!(
                "the state is of an instance for {:?}, expected {:?}",
                state.interface, self.state.interface
            )
            .into());
        }
        self.keep_under(key.filter(|key| self.kept.contains_key(key)), state)
    }
}
