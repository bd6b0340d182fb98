//! Which model, and the values of all of its parameters.

pub mod group;

use model_core::{
    control::parameters::ControlParameters,
    models::{
        SetupParameters, black_box_1::BlackBox1Parameters, black_box_2::BlackBox2Parameters,
        grey_box::GreyBoxParameters,
    },
    plant::{bench::BenchParameters, first_order::FirstOrderParameters},
    presets::{self, Preset},
    sensors::{
        adc::{BackEmfSenseParameters, CurrentSenseParameters},
        encoder::EncoderParameters,
    },
};
use serde::Deserialize;

use crate::{error::Error, simulate::closed_loop::TimerParameters};
use group::Group;
pub use group::Value;

/// The models that can be simulated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, clap::ValueEnum, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ModelKind {
    /// First-order lag with rate and position limits
    #[value(name = "black-box-1")]
    #[serde(rename = "black-box-1")]
    BlackBox1,
    /// Second-order lag with rate and position limits
    #[value(name = "black-box-2")]
    #[serde(rename = "black-box-2")]
    BlackBox2,
    /// Motor, PI rate loop and P position loop in continuous time
    GreyBox,
    /// The board's own fixed-point control step around a motor
    Board,
}

impl ModelKind {
    /// Every model.
    pub const ALL: [Self; 4] = [Self::BlackBox1, Self::BlackBox2, Self::GreyBox, Self::Board];

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::BlackBox1 => "black-box-1",
            Self::BlackBox2 => "black-box-2",
            Self::GreyBox => "grey-box",
            Self::Board => "board",
        }
    }

    /// The presets that apply to it, its default first.
    pub fn presets(self) -> impl Iterator<Item = &'static Preset> {
        presets::PRESETS
            .iter()
            .filter(move |preset| preset.models.contains(&self.name()))
    }
}

/// What stands for the motor and what it moves, behind the board.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, clap::ValueEnum, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PlantKind {
    /// The paper's first-order motor, solved exactly
    #[default]
    FirstOrder,
    /// Motor, gear train, friction and load in detail
    Bench,
}

impl PlantKind {
    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::FirstOrder => "first-order",
            Self::Bench => "bench",
        }
    }
}

/// Parameters of the board and of what hangs on it.
#[derive(Debug, Clone, Default)]
pub struct BoardSettings {
    /// The control step.
    pub control: ControlParameters,
    /// Which plant it drives.
    pub plant: PlantKind,
    /// The plant of [`PlantKind::FirstOrder`].
    pub first_order: FirstOrderParameters,
    /// The plant of [`PlantKind::Bench`].
    pub bench: BenchParameters,
    /// The encoder.
    pub encoder: EncoderParameters,
    /// The front end of the motor current, on the bench.
    pub current_sense: CurrentSenseParameters,
    /// The front end of the back-EMF, on the bench.
    pub back_emf_sense: BackEmfSenseParameters,
    /// The timer of the bridge.
    pub timer: TimerParameters,
}

/// Parameters of one model.
#[derive(Debug, Clone)]
pub enum ModelSettings {
    /// Of black box 1.
    BlackBox1(BlackBox1Parameters),
    /// Of black box 2.
    BlackBox2(BlackBox2Parameters),
    /// Of the grey box.
    GreyBox(GreyBoxParameters),
    /// Of the board.
    Board(Box<BoardSettings>),
}

/// A model with all of its parameters.
#[derive(Debug, Clone)]
pub struct Settings {
    /// What happens to the command on its way.
    pub setup: SetupParameters,
    /// The model.
    pub model: ModelSettings,
}

impl Settings {
    /// The defaults of a model.
    pub fn new(model: ModelKind, plant: PlantKind) -> Self {
        let model = match model {
            ModelKind::BlackBox1 => ModelSettings::BlackBox1(Default::default()),
            ModelKind::BlackBox2 => ModelSettings::BlackBox2(Default::default()),
            ModelKind::GreyBox => ModelSettings::GreyBox(Default::default()),
            ModelKind::Board => ModelSettings::Board(Box::new(BoardSettings {
                plant,
                ..Default::default()
            })),
        };
        Self {
            setup: SetupParameters::default(),
            model,
        }
    }

    /// Which model it is.
    pub fn kind(&self) -> ModelKind {
        match self.model {
            ModelSettings::BlackBox1(_) => ModelKind::BlackBox1,
            ModelSettings::BlackBox2(_) => ModelKind::BlackBox2,
            ModelSettings::GreyBox(_) => ModelKind::GreyBox,
            ModelSettings::Board(_) => ModelKind::Board,
        }
    }

    fn plant(&self) -> PlantKind {
        match &self.model {
            ModelSettings::Board(board) => board.plant,
            _ => PlantKind::FirstOrder,
        }
    }

    fn groups(&mut self) -> Vec<&mut dyn Group> {
        let mut groups: Vec<&mut dyn Group> = vec![&mut self.setup];
        match &mut self.model {
            ModelSettings::BlackBox1(p) => groups.push(p),
            ModelSettings::BlackBox2(p) => groups.push(p),
            ModelSettings::GreyBox(p) => groups.push(p),
            ModelSettings::Board(board) => {
                groups.push(&mut board.control);
                groups.push(&mut board.timer);
                groups.push(&mut board.encoder);
                match board.plant {
                    PlantKind::FirstOrder => groups.push(&mut board.first_order),
                    PlantKind::Bench => {
                        let bench = &mut board.bench;
                        groups.push(&mut bench.electrical);
                        groups.push(&mut bench.gear_train);
                        groups.push(&mut bench.friction);
                        groups.push(&mut bench.load);
                        groups.push(&mut board.current_sense);
                        groups.push(&mut board.back_emf_sense);
                    }
                }
            }
        }
        groups
    }

    /// Every parameter with its present value, in the order of the tables.
    pub fn values(&self) -> Vec<Value> {
        group::values(&self.clone().groups())
    }

    /// Sets a parameter by name or by symbol.
    ///
    /// # Errors
    /// [`Error::UnknownName`] where the model has none of this name, [`Error::Parameter`] where it
    /// cannot take the value.
    pub fn set(&mut self, name: &str, value: f64) -> Result<(), Error> {
        let command = match self.kind() {
            ModelKind::Board => format!("simulate board --plant {}", self.plant().name()),
            kind => format!("simulate {}", kind.name()),
        };
        group::set(&mut self.groups(), name, value, &command)
    }

    /// Applies a preset of this model.
    ///
    /// # Errors
    /// [`Error::UnknownName`] where the model has no such preset, and [`Error::Conflict`] where the
    /// preset is for a plant that was not chosen.
    pub fn apply(&mut self, preset: &str) -> Result<&'static Preset, Error> {
        let kind = self.kind();
        let Some(found) = kind.presets().find(|known| known.name == preset) else {
            return Err(self.no_preset(preset));
        };
        for (name, value) in found.values {
            match self.set(name, *value) {
                Err(Error::UnknownName { .. }) if self.plant() == PlantKind::Bench => {
                    return Err(Error::Conflict(format!(
                        "preset `{preset}` sets {name} of the first-order motor, which --plant \
                         bench replaces; expected --plant first-order, or --set for the bench"
                    )));
                }
                result => result?,
            }
        }
        Ok(found)
    }

    fn no_preset(&self, name: &str) -> Error {
        let kind = self.kind();
        let names: Vec<_> = kind.presets().map(|preset| preset.name).collect();
        let expected = names.join(", ");
        match presets::preset(name) {
            Some(elsewhere) => Error::Conflict(format!(
                "preset `{name}` is for {}, not for {}: {}; expected {expected}",
                elsewhere.models.join(" and "),
                kind.name(),
                elsewhere.summary
            )),
            None => Error::unknown("preset", name, names, expected),
        }
    }
}
