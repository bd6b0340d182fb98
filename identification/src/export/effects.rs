//! What a target does not have.

use model_core::actuator::{ModelKind, PlantKind, Settings};

use super::response::value;

/// An effect of a model that not every target has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Effect {
    /// Inertia, and the motion under a load.
    Torque,
    /// The delay of the command.
    Delay,
    /// A limit of the rate or of the torque.
    Limit,
    /// A limit of the rate that differs by direction.
    Direction,
    /// Coulomb friction.
    Friction,
    /// Friction that depends on rate and load.
    LoadFriction,
    /// Backlash.
    Backlash,
    /// Control in steps of 4 ms, encoder counts, noise.
    Sampling,
}

/// All effects with their descriptions.
const ALL: [(Effect, &str); 8] = [
    (Effect::Torque, "inertia and the motion under a load"),
    (Effect::Delay, "the delay of the command"),
    (Effect::Limit, "limits of rate and torque"),
    (Effect::Direction, "rate limits that differ by direction"),
    (Effect::Friction, "Coulomb friction"),
    (
        Effect::LoadFriction,
        "friction that depends on rate and load",
    ),
    (Effect::Backlash, "backlash"),
    (
        Effect::Sampling,
        "sampled control, encoder counts and noise",
    ),
];

impl Effect {
    /// Whether a model has it.
    fn is_of(self, settings: &Settings) -> bool {
        let at = |name| value(settings, name);
        let is_positive = |name| at(name).is_some_and(|value| value > 0.0);
        match self {
            Self::Torque => has_torque(settings),
            Self::Delay => is_positive("delay_s"),
            Self::Limit => true,
            Self::Direction => [
                ("rate_limit_up_deg_s", "rate_limit_down_deg_s"),
                ("motor_gain_up", "motor_gain_down"),
            ]
            .iter()
            .any(|(up, down)| at(up) != at(down)),
            Self::Friction => is_positive("coulomb_friction_nm"),
            Self::LoadFriction => at("friction_model").is_some_and(|model| model > 1.0),
            Self::Backlash => is_positive("backlash_deg"),
            Self::Sampling => settings.model == ModelKind::Board,
        }
    }
}

/// Whether a model has torques.
pub(super) fn has_torque(settings: &Settings) -> bool {
    settings.model == ModelKind::Board && settings.plant == PlantKind::Drivetrain
}

/// Descriptions of what is lost of a model where only some effects are kept.
pub(super) fn lost(settings: &Settings, kept: &[Effect]) -> Vec<&'static str> {
    let is_lost = |(effect, _): &&(Effect, &str)| effect.is_of(settings) && !kept.contains(effect);
    ALL.iter().filter(is_lost).map(|(_, text)| *text).collect()
}
