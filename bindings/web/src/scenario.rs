//! What is run, from one line of text.
//!
//! The line is a list of `key=value`, parted by `&`, as in the address of a page. `model`, `plant`,
//! `preset` and `input` take a name; `duration_s`, `every` and `amplitude_deg` (of the frequency
//! response) a number; `input.NAME` is a parameter of the input and any other key one of the
//! model. Of a key that stands twice the last one counts.

use core::fmt;

use model_core::actuator::{ModelKind, PlantKind, Settings};
use model_core::excitation::catalogue::Input;
use model_core::named::Named;
use model_core::parameter::{Parameter, ParameterError};
use model_core::presets::preset;
use model_core::time::{PWM_PERIOD_TICKS, TICKS_PER_SECOND, ticks};

/// The longest run, s: a browser stands still for so long as it is computed.
pub const LONGEST_S: f64 = 120.0;

/// The most rows of a run: ten numbers each, 24 MB.
pub const MOST_ROWS: u64 = 300_000;

/// Why a request was not met.
#[derive(Debug, Clone, PartialEq)]
pub enum Error {
    /// The text is not a list of `key=value`, or names what there is not.
    Request(String),
    /// A parameter is not a number, out of its range or at odds with another.
    Parameter(String),
    /// A command is not a finite number.
    Command,
    /// The run has more rows than there is room for.
    TooLong(String),
}

impl Error {
    /// Its number outside of Rust; 0 is success.
    pub fn code(&self) -> i32 {
        match self {
            Self::Request(_) => 1,
            Self::Parameter(_) => 2,
            Self::Command => 3,
            Self::TooLong(_) => 4,
        }
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Request(text) | Self::Parameter(text) | Self::TooLong(text) => f.write_str(text),
            Self::Command => f.write_str("a command is not a finite number of degrees"),
        }
    }
}

impl core::error::Error for Error {}

impl From<ParameterError> for Error {
    fn from(error: ParameterError) -> Self {
        Self::Parameter(error.to_string())
    }
}

/// Everything that a run depends on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scenario {
    /// The model and its parameters.
    pub settings: Settings,
    /// What is commanded.
    pub input: Input,
    /// How long to run, ticks.
    pub ticks: u64,
    /// Every how many ticks a row is made; not 0.
    pub every: u64,
    /// Amplitude for the frequency response, deg.
    pub amplitude_deg: f64,
}

impl Scenario {
    /// Reads a request. What it does not say is the board with the first-order plant on a pulse.
    ///
    /// ```
    /// use actuator_web::scenario::Scenario;
    ///
    /// let scenario = Scenario::parse("model=grey-box&P=12&input=sine&duration_s=3").unwrap();
    /// assert_eq!(scenario.settings.grey_box.position_gain, 12.0);
    /// assert_eq!(scenario.ticks, 60_000);
    /// ```
    ///
    /// # Errors
    /// Any but [`Error::Command`].
    pub fn parse(text: &str) -> Result<Self, Error> {
        let entries = entries(text)?;
        let mut settings = choice(&entries)?;
        let name = named(&entries, "input", "pulse");
        let mut input = Input::named(name).ok_or_else(|| unknown("input", name, Input::NAMES))?;
        let (mut duration_s, mut every, mut amplitude_deg) = (None, PWM_PERIOD_TICKS, 1.0);
        for (key, value) in entries {
            match key {
                "model" | "plant" | "preset" | "input" => {}
                "duration_s" => duration_s = Some(DURATION.check(number(key, value)?)?),
                "every" => every = EVERY.check(number(key, value)?)? as u64,
                "amplitude_deg" => amplitude_deg = AMPLITUDE.check(number(key, value)?)?,
                _ => {
                    let number = number(key, value)?;
                    let set = match key.strip_prefix("input.") {
                        Some(name) => input.set(name, number),
                        None => settings.set(key, number),
                    };
                    set.map_err(|error| explain(key, error))?;
                }
            }
        }
        Ok(Self {
            settings,
            input,
            ticks: run_ticks(&input, duration_s, every)?,
            every,
            amplitude_deg,
        })
    }

    /// How many rows the run has.
    pub fn rows(&self) -> u64 {
        self.ticks.div_ceil(self.every.max(1))
    }
}

/// A parameter of the run itself.
const fn of_the_run(name: &'static str, unit: &'static str, min: f64, max: f64) -> Parameter {
    Parameter {
        name,
        symbol: "",
        unit,
        default: min,
        min,
        max,
        source: "",
        meaning: "",
    }
}

const DURATION: Parameter = of_the_run("duration_s", "s", 1e-3, LONGEST_S);
const EVERY: Parameter = of_the_run("every", "ticks", 1.0, TICKS_PER_SECOND as f64);
const AMPLITUDE: Parameter = of_the_run("amplitude_deg", "deg", 1e-3, 180.0);

fn entries(text: &str) -> Result<Vec<(&str, &str)>, Error> {
    let entries = text.split('&').filter(|entry| !entry.is_empty());
    entries
        .map(|entry| {
            let parts = entry.split_once('=');
            parts.ok_or_else(|| Error::Request(format!("`{entry}` is not of the form key=value")))
        })
        .collect()
}

fn named<'a>(entries: &[(&str, &'a str)], key: &str, default: &'a str) -> &'a str {
    let last = entries.iter().rev().find(|entry| entry.0 == key);
    last.map_or(default, |entry| entry.1)
}

/// The model and plant that are asked for, with the preset.
fn choice(entries: &[(&str, &str)]) -> Result<Settings, Error> {
    let model = named(entries, "model", ModelKind::Board.name());
    let plant = named(entries, "plant", PlantKind::FirstOrder.name());
    let mut settings = Settings::new(
        ModelKind::named(model).ok_or_else(|| unknown("model", model, ModelKind::NAMES))?,
        PlantKind::named(plant).ok_or_else(|| unknown("plant", plant, PlantKind::NAMES))?,
    );
    let name = named(entries, "preset", "");
    if !name.is_empty() {
        let known: Vec<_> = presets(&settings).map(|preset| preset.name).collect();
        let preset = preset(name).filter(|preset| known.contains(&preset.name));
        settings.apply(preset.ok_or_else(|| unknown("preset of this model", name, &known))?)?;
    }
    Ok(settings)
}

/// The presets that go with a model and its plant.
pub fn presets(
    settings: &Settings,
) -> impl Iterator<Item = &'static model_core::presets::Preset> + use<> {
    let settings = *settings;
    let of_model = settings.model.presets();
    of_model.filter(move |preset| settings.clone().apply(preset).is_ok())
}

fn unknown(what: &str, name: &str, known: &[&str]) -> Error {
    let known = known.join(", ");
    Error::Request(format!("no {what} is called `{name}`, expected {known}"))
}

fn number(key: &str, text: &str) -> Result<f64, Error> {
    let number = text.parse();
    number.map_err(|_| Error::Parameter(format!("{key} is `{text}`, expected a number")))
}

fn explain(key: &str, error: ParameterError) -> Error {
    match error {
        ParameterError::Unknown => Error::Request(format!(
            "neither the model nor its input has a parameter `{key}`"
        )),
        error => error.into(),
    }
}

/// How long to run: as long as the input, but no longer than any run, unless it is said.
fn run_ticks(input: &Input, duration_s: Option<f64>, every: u64) -> Result<u64, Error> {
    let of_input = input.duration_ticks()?.min(ticks(LONGEST_S));
    let run = duration_s.map_or(of_input, ticks);
    if run.div_ceil(every) > MOST_ROWS {
        let most = MOST_ROWS as f64 * every as f64 / TICKS_PER_SECOND as f64;
        return Err(Error::TooLong(format!(
            "a row every {every} ticks for {} s, expected at most {most} s",
            run as f64 / TICKS_PER_SECOND as f64
        )));
    }
    Ok(run)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn refusal(text: &str) -> (i32, String) {
        let error = Scenario::parse(text).unwrap_err();
        (error.code(), error.to_string())
    }

    #[test]
    fn nothing_said_is_the_board_on_a_pulse() {
        let scenario = Scenario::parse("").unwrap();
        let board = Settings::new(ModelKind::Board, PlantKind::FirstOrder);
        assert_eq!(scenario.settings, board);
        assert_eq!(
            (scenario.input.name(), scenario.ticks, scenario.rows()),
            ("pulse", 100_000, 5000)
        );
    }

    #[test]
    fn a_parameter_wins_over_the_preset_wherever_it_stands() {
        let text = "motor_gain_up=3&model=board&preset=asymmetric";
        let plant = Scenario::parse(text).unwrap().settings.first_order;
        assert_eq!((plant.motor_gain_up, plant.motor_gain_down), (3.0, 3.5));
    }

    #[test]
    fn what_is_wrong_is_named_with_what_was_expected() {
        assert_eq!(refusal("P").1, "`P` is not of the form key=value");
        assert_eq!(refusal("model=bord").0, 1);
        assert!(refusal("model=bord").1.contains("black-box-1"));
        assert_eq!(refusal("quux=1").0, 1);
        assert_eq!(refusal("input.quux=1").0, 1);
        assert_eq!(refusal("P=NaN").0, 2);
        assert_eq!(
            refusal("P=-1").1,
            "position_gain is -1, expected a number from 0 to 500 1/s"
        );
        assert_eq!(refusal("P=many").1, "P is `many`, expected a number");
        assert_eq!(refusal("duration_s=inf").0, 2);
        assert_eq!(refusal("every=0").0, 2);
        assert_eq!(refusal("duration_s=60&every=1").0, 4);
    }

    #[test]
    fn a_preset_of_another_plant_is_refused_with_those_that_there_are() {
        let (code, text) = refusal("plant=bench&preset=asymmetric");
        assert_eq!(code, 1);
        assert!(text.ends_with("expected consistent"), "{text}");
    }

    #[test]
    fn an_endless_input_is_cut_where_no_run_is_longer() {
        let scenario = Scenario::parse("input=sine&input.frequency_hz=0.0001").unwrap();
        assert_eq!(scenario.ticks, ticks(LONGEST_S));
    }

    proptest! {
        #[test]
        fn no_text_whatever_makes_it_panic(text in "\\PC*", key in "[a-z_.]{0,12}", value: f64) {
            let _ = Scenario::parse(&text);
            let _ = Scenario::parse(&format!("{key}={value}&P={value}&duration_s={value}"));
        }
    }
}
