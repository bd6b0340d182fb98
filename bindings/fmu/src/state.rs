//! The state of an instance and its serialisation.
//!
//! Bytes: magic (8), GUID (38), length of the body (8, little endian), CRC-32 of the body (4,
//! little endian), then the body in postcard's format. They detect damage and the state of another
//! model, version or start value; they are not protected against forgery.

use model_core::actuator::{self, InputLevel, Settings};
use model_core::parameter::Parameters;
use model_core::plant::Pwm;
use serde::{Deserialize, Serialize};

use crate::exchange::Exchange;
use crate::variables::Inputs;

/// The phase of an instance, which determines the calls that are allowed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Phase {
    /// Parameters can be set.
    Instantiated,
    /// Parameters and inputs can be set.
    Initialization,
    /// Steps can be taken: co-simulation.
    Stepping,
    /// Discrete states and inputs can be changed: model exchange.
    Event,
    /// The host integrates: model exchange.
    Continuous,
    /// Outputs can be read.
    Terminated,
    /// After an internal failure: only a reset or a saved state leads out.
    Failed,
}

/// What an instance was made for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Interface {
    /// The instance has the solver.
    CoSimulation,
    /// The host has the solver.
    ModelExchange,
}

/// The time of the host.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Time {
    /// Time of tick 0, s.
    pub start_s: f64,
    /// Stop time, s, if it is known.
    pub stop_s: Option<f64>,
    /// The present communication point, s.
    pub now_s: f64,
}

/// An actuator with a delay line of the length of the delay.
pub type Actuator = actuator::Actuator<Vec<f64>>;

/// The state of an instance.
#[derive(Debug, Clone)]
pub struct InstanceState {
    /// What the instance was made for.
    pub interface: Interface,
    /// The phase.
    pub phase: Phase,
    /// The parameters.
    pub settings: Settings,
    /// The inputs.
    pub inputs: Inputs,
    /// The quantity of the command.
    pub level: InputLevel,
    /// The time.
    pub time: Time,
    /// The actuator, from the end of the initialization on: co-simulation.
    pub actuator: Option<Box<Actuator>>,
    /// The model, from the end of the initialization on: model exchange.
    pub exchange: Option<Box<Exchange>>,
}

/// The serialised state, with the settings by value since the model is known.
#[derive(Serialize, Deserialize)]
struct Written<A> {
    interface: Interface,
    phase: Phase,
    seed: u64,
    pwm: Pwm,
    values: Vec<f64>,
    inputs: [f64; Inputs::TABLE.len()],
    level: InputLevel,
    time: Time,
    actuator: Option<A>,
    exchange: Option<Box<Exchange>>,
}

const MAGIC: &[u8; 8] = b"ActFMU\x00\x01";
const GUID_LENGTH: usize = 38;
const HEAD_LENGTH: usize = MAGIC.len() + GUID_LENGTH + 8 + 4;

impl InstanceState {
    /// The state right after the instantiation.
    pub fn new(settings: Settings) -> Self {
        Self {
            interface: Interface::CoSimulation,
            phase: Phase::Instantiated,
            settings,
            inputs: Inputs::at_start(&settings),
            level: InputLevel::Position,
            time: Time::default(),
            actuator: None,
            exchange: None,
        }
    }

    /// The state as bytes, marked with the GUID of its FMU.
    ///
    /// # Errors
    /// The error of the serialiser, which is not known to occur.
    ///
    /// ```
    /// use actuator_fmu::{description::guid, state::InstanceState};
    /// use model_core::scenario;
    ///
    /// let settings = scenario::choices().next().unwrap();
    /// let bytes = InstanceState::new(settings).to_bytes(&guid(&settings)).unwrap();
    /// let state = InstanceState::from_bytes(&bytes, &guid(&settings), &settings).unwrap();
    /// assert_eq!(state.settings, settings);
    /// assert!(InstanceState::from_bytes(&bytes[1..], &guid(&settings), &settings).is_err());
    /// ```
    pub fn to_bytes(&self, guid: &str) -> Result<Vec<u8>, String> {
        let written = Written {
            interface: self.interface,
            phase: self.phase,
            seed: self.settings.seed,
            pwm: self.settings.pwm,
            values: self.settings.values().map(|v| v.value).collect(),
            inputs: std::array::from_fn(|index| self.inputs.get(index).unwrap_or_default()),
            level: self.level,
            time: self.time,
            actuator: self.actuator.as_deref(),
            exchange: self.exchange.clone(),
        };
        let body = postcard::to_stdvec(&written).map_err(|error| error.to_string())?;
        Ok([head(guid, &body).as_slice(), body.as_slice()].concat())
    }

    /// The state that [`InstanceState::to_bytes`] wrote for the FMU of this GUID and these start
    /// values.
    ///
    /// # Errors
    /// The problem of the bytes.
    pub fn from_bytes(bytes: &[u8], guid: &str, initial: &Settings) -> Result<Self, String> {
        let (found, body) = bytes
            .split_at_checked(HEAD_LENGTH)
            .ok_or("it is shorter than its head")?;
        let expected = head(guid, body);
        let (found_origin, found_sums) = found.split_at(MAGIC.len() + GUID_LENGTH);
        let (origin, sums) = expected.split_at(MAGIC.len() + GUID_LENGTH);
        if found_origin != origin {
            return Err("it is not a state of this FMU".into());
        }
        if found_sums != sums {
            return Err("it is damaged: length or checksum differ".into());
        }
        let (written, rest): (Written<Box<Actuator>>, _) =
            postcard::take_from_bytes(body).map_err(|error| error.to_string())?;
        if !rest.is_empty() {
            return Err("it has bytes after its end".into());
        }
        written.restored(initial)
    }
}

/// The head of a body.
fn head(guid: &str, body: &[u8]) -> Vec<u8> {
    let mut head = MAGIC.to_vec();
    head.extend(guid.bytes().chain(std::iter::repeat(0)).take(GUID_LENGTH));
    head.extend((body.len() as u64).to_le_bytes());
    head.extend(crc32fast::hash(body).to_le_bytes());
    head
}

impl Written<Box<Actuator>> {
    fn restored(self, initial: &Settings) -> Result<InstanceState, String> {
        let mut settings = *initial;
        (settings.seed, settings.pwm) = (self.seed, self.pwm);
        if self.values.len() != initial.values().count() {
            return Err("it has another number of parameters".into());
        }
        for (known, value) in initial.values().zip(self.values) {
            let set = settings.set(known.parameter.name, value);
            set.map_err(|error| error.to_string())?;
        }
        let mut inputs = Inputs::default();
        for (parameter, value) in Inputs::TABLE.iter().zip(self.inputs) {
            let set = inputs.set(parameter.name, value);
            set.map_err(|error| error.to_string())?;
        }
        Ok(InstanceState {
            interface: self.interface,
            phase: self.phase,
            settings,
            inputs,
            level: self.level,
            time: self.time,
            actuator: self.actuator,
            exchange: self.exchange,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::description::guid;
    use model_core::scenario;

    fn stepped(settings: &Settings) -> InstanceState {
        let mut actuator = Actuator::try_with_ring(settings).unwrap();
        actuator.advance(20.0, 777).unwrap();
        let mut state = InstanceState::new(*settings);
        state.phase = Phase::Stepping;
        state.time.now_s = 777.0 * 50e-6;
        state.actuator = Some(Box::new(actuator));
        state
    }

    #[test]
    fn every_flipped_bit_of_a_state_is_detected() {
        let settings = scenario::choices().last().unwrap();
        let (state, guid) = (stepped(&settings), guid(&settings));
        let bytes = state.to_bytes(&guid).unwrap();
        // Every 7th bit suffices: the CRC detects any single bit.
        for bit in (0..bytes.len() * 8).step_by(7) {
            let mut broken = bytes.clone();
            broken[bit / 8] ^= 1 << (bit % 8);
            assert!(InstanceState::from_bytes(&broken, &guid, &settings).is_err());
        }
        for length in 0..bytes.len() {
            assert!(InstanceState::from_bytes(&bytes[..length], &guid, &settings).is_err());
        }
    }

    #[test]
    fn a_state_of_another_model_is_refused() {
        let all: Vec<_> = scenario::choices().collect();
        for (mine, other) in all.iter().zip(&all[1..]) {
            let bytes = stepped(mine).to_bytes(&guid(mine)).unwrap();
            let error = InstanceState::from_bytes(&bytes, &guid(other), other).unwrap_err();
            assert_eq!(error, "it is not a state of this FMU");
        }
    }

    #[test]
    fn the_size_of_a_state_grows_with_the_commands_in_the_delay_line() {
        let settings = scenario::choices().next().unwrap();
        let bytes = stepped(&settings).to_bytes(&guid(&settings)).unwrap();
        // 350 ticks of delay, 8 bytes each.
        assert!((2800..3100).contains(&bytes.len()), "{}", bytes.len());
    }
}
