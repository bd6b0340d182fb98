//! Model, plant and the values of all parameters.

use super::closed_loop::TimerParameters;
use super::kind::{ModelKind, PlantKind};
use crate::control::parameters::ControlParameters;
use crate::models::SetupParameters;
use crate::models::black_box_1::BlackBox1Parameters;
use crate::models::black_box_2::BlackBox2Parameters;
use crate::models::grey_box::GreyBoxParameters;
use crate::named::Named;
use crate::parameter::{Group, ParameterError, Value};
use crate::plant::{Pwm, drivetrain::DrivetrainParameters, first_order::FirstOrderParameters};
use crate::presets::{PRESETS, Preset};
use crate::sensors::adc::{BackEmfSenseParameters, CurrentSenseParameters};
use crate::sensors::encoder::EncoderParameters;

/// Everything that defines an actuator except its command.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// The model.
    pub model: ModelKind,
    /// The plant of the board; other models have none.
    pub plant: PlantKind,
    /// How the board's bridge is switched.
    pub pwm: Pwm,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Sampling and delay of the command by the test set-up.
    pub setup: SetupParameters,
    /// Black box 1.
    pub black_box_1: BlackBox1Parameters,
    /// Black box 2.
    pub black_box_2: BlackBox2Parameters,
    /// The grey box.
    pub grey_box: GreyBoxParameters,
    /// The board's control step.
    pub control: ControlParameters,
    /// The timer of the board's bridge.
    pub timer: TimerParameters,
    /// The board's encoder.
    pub encoder: EncoderParameters,
    /// The plant of [`PlantKind::FirstOrder`].
    pub first_order: FirstOrderParameters,
    /// The plant of [`PlantKind::Drivetrain`].
    pub drivetrain: DrivetrainParameters,
    /// The front end of the motor current, on the drivetrain.
    pub current_sense: CurrentSenseParameters,
    /// The front end of the back-EMF, on the drivetrain.
    pub back_emf_sense: BackEmfSenseParameters,
}

/// Maximum number of parameter tables of a model.
const MAX_GROUPS: usize = 10;

/// The parameter tables of the selected model and plant, borrowed by `$borrow`, `&` or `&mut`;
/// unused entries are `None`.
macro_rules! groups {
    ($settings:expr, $($borrow:tt)+) => {{
        let s = $settings;
        let (a, b) = (s.model, s.plant);
        let setup = Some($($borrow)+ s.setup as _);
        match (a, b) {
            (ModelKind::BlackBox1, _) => {
                [setup, Some($($borrow)+ s.black_box_1 as _), None, None, None, None, None, None, None, None]
            }
            (ModelKind::BlackBox2, _) => {
                [setup, Some($($borrow)+ s.black_box_2 as _), None, None, None, None, None, None, None, None]
            }
            (ModelKind::GreyBox, _) => {
                [setup, Some($($borrow)+ s.grey_box as _), None, None, None, None, None, None, None, None]
            }
            (ModelKind::Board, PlantKind::FirstOrder) => [
                setup,
                Some($($borrow)+ s.control as _),
                Some($($borrow)+ s.timer as _),
                Some($($borrow)+ s.encoder as _),
                Some($($borrow)+ s.first_order as _),
                None, None, None, None, None,
            ],
            (ModelKind::Board, PlantKind::Drivetrain) => [
                setup,
                Some($($borrow)+ s.control as _),
                Some($($borrow)+ s.timer as _),
                Some($($borrow)+ s.encoder as _),
                Some($($borrow)+ s.drivetrain.electrical as _),
                Some($($borrow)+ s.drivetrain.gear_train as _),
                Some($($borrow)+ s.drivetrain.friction as _),
                Some($($borrow)+ s.drivetrain.load as _),
                Some($($borrow)+ s.current_sense as _),
                Some($($borrow)+ s.back_emf_sense as _),
            ],
        }
    }};
}

impl Settings {
    /// The defaults of a model.
    ///
    /// ```
    /// use model_core::actuator::{ModelKind, PlantKind, Settings};
    ///
    /// let mut settings = Settings::new(ModelKind::Board, PlantKind::FirstOrder);
    /// settings.set("P", 16.0).unwrap();
    /// assert_eq!(settings.control.position_gain, 16.0);
    /// ```
    pub fn new(model: ModelKind, plant: PlantKind) -> Self {
        Self {
            model,
            plant,
            pwm: Pwm::Average,
            seed: 0,
            setup: Default::default(),
            black_box_1: Default::default(),
            black_box_2: Default::default(),
            grey_box: Default::default(),
            control: Default::default(),
            timer: Default::default(),
            encoder: Default::default(),
            first_order: Default::default(),
            drivetrain: Default::default(),
            current_sense: Default::default(),
            back_emf_sense: Default::default(),
        }
    }

    fn groups(&self) -> [Option<&dyn Group>; MAX_GROUPS] {
        groups!(self, &)
    }

    fn groups_mut(&mut self) -> [Option<&mut dyn Group>; MAX_GROUPS] {
        groups!(self, &mut)
    }

    /// Every parameter of the selected model and plant with its present value, in the order of the
    /// tables.
    pub fn values(&self) -> impl Iterator<Item = Value> + '_ {
        let groups = self.groups().into_iter().flatten();
        groups.flat_map(|group| (0..).map_while(move |index| group.value(index)))
    }

    /// Sets a parameter of the selected model and plant, by name or by symbol.
    ///
    /// # Errors
    /// [`ParameterError::Unknown`] if no parameter has this name, otherwise the error of the value;
    /// nothing is changed then.
    pub fn set(&mut self, name: &str, value: f64) -> Result<(), ParameterError> {
        for group in self.groups_mut().into_iter().flatten() {
            match group.assign(name, value) {
                Err(ParameterError::Unknown) => {}
                result => return result,
            }
        }
        Err(ParameterError::Unknown)
    }

    /// Applies a preset. A parameter of the preset that the selected model and plant do not have is
    /// an error.
    ///
    /// # Errors
    /// [`ParameterError::Unknown`] if model and plant do not have a parameter of the preset;
    /// nothing is changed then.
    pub fn apply(&mut self, preset: &Preset) -> Result<(), ParameterError> {
        let mut changed = *self;
        for (name, value) in preset.values {
            changed.set(name, *value)?;
        }
        *self = changed;
        Ok(())
    }
}

impl ModelKind {
    /// The presets of this model, the default first.
    pub fn presets(self) -> impl Iterator<Item = &'static Preset> {
        PRESETS
            .iter()
            .filter(move |preset| preset.models.contains(&self.name()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    fn all_settings() -> impl Iterator<Item = Settings> {
        ModelKind::ALL.iter().flat_map(|model| {
            PlantKind::ALL
                .iter()
                .map(|plant| Settings::new(*model, *plant))
        })
    }

    #[test]
    fn no_two_parameters_of_a_model_share_a_name_or_a_symbol() {
        for settings in all_settings() {
            let mut seen = BTreeSet::new();
            for Value { parameter, .. } in settings.values() {
                for name in [parameter.name, parameter.symbol] {
                    assert!(
                        name.is_empty() || seen.insert(name),
                        "{name} in {settings:?}"
                    );
                }
            }
        }
    }

    #[test]
    fn every_default_is_in_its_range_and_can_be_set() {
        for mut settings in all_settings() {
            let before = settings;
            for Value { parameter, value } in before.values() {
                assert_eq!(value, parameter.default);
                settings.set(parameter.name, value).unwrap();
            }
            assert_eq!(settings, before);
        }
    }

    #[test]
    fn every_preset_applies_to_its_models() {
        for model in ModelKind::ALL {
            assert!(model.presets().count() > 0);
            for preset in model.presets() {
                Settings::new(*model, PlantKind::FirstOrder)
                    .apply(preset)
                    .unwrap();
            }
        }
    }

    #[test]
    fn a_preset_for_another_plant_changes_nothing() {
        let mut settings = Settings::new(ModelKind::Board, PlantKind::Drivetrain);
        let asymmetric = crate::presets::preset("asymmetric").unwrap();
        assert_eq!(settings.apply(asymmetric), Err(ParameterError::Unknown));
        assert_eq!(
            settings,
            Settings::new(ModelKind::Board, PlantKind::Drivetrain)
        );
    }
}
