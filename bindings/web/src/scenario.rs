//! What is run, from one line of text.
//!
//! The line is a list of `key=value` separated by `&`, as in the address of a page. The keys are
//! the options of [`Request`]; `input.NAME` for a parameter of the input; every other key is a
//! parameter of the model. If a key occurs twice, the last value applies.

use core::fmt;

use model_core::parameter::ParameterError;
use model_core::scenario::{self, Request, ScenarioError};
use model_core::time::{TICKS_PER_SECOND, ticks};

/// The longest run, s: a few seconds of a browser's time. A longer one is most likely a wrong unit.
pub const LONGEST_S: f64 = 600.0;

/// The most rows of a run: a row every 1 ms of the longest one, ten numbers each, 48 MB.
pub const MOST_ROWS: u64 = 600_000;

/// Why a request is refused.
#[derive(Debug, Clone, PartialEq)]
pub enum Error {
    /// The text is not a list of `key=value`, or contains an unknown name.
    Request(String),
    /// A parameter is not a number, is out of range, or excludes another one.
    Parameter(String),
    /// A command is not a finite number.
    Command,
    /// The run is longer, or has more rows, than a page computes.
    TooLong(String),
    /// The caller has ended the run.
    Interrupted,
}

impl Error {
    /// Its number outside of Rust; 0 is success.
    pub fn code(&self) -> i32 {
        match self {
            Self::Request(_) => 1,
            Self::Parameter(_) => 2,
            Self::Command => 3,
            Self::TooLong(_) => 4,
            Self::Interrupted => 5,
        }
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Request(text) | Self::Parameter(text) | Self::TooLong(text) => f.write_str(text),
            Self::Interrupted => f.write_str("the run was interrupted"),
            Self::Command => f.write_str("a command is not a finite number of degrees"),
        }
    }
}

impl core::error::Error for Error {}

impl From<ParameterError> for Error {
    fn from(error: ParameterError) -> Self {
        ScenarioError::Parameter(error).into()
    }
}

impl From<ScenarioError<'_>> for Error {
    fn from(error: ScenarioError<'_>) -> Self {
        match error {
            ScenarioError::Parameter(_)
            | ScenarioError::InputParameter(_)
            | ScenarioError::Duration(_)
            | ScenarioError::Every(_)
            | ScenarioError::Value { .. } => Self::Parameter(error.to_string()),
            _ => Self::Request(error.to_string()),
        }
    }
}

/// A run in a page.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scenario {
    /// What is run.
    pub run: scenario::Scenario,
    /// How long to run, ticks.
    pub ticks: u64,
}

impl Scenario {
    /// Parses a request. The default model is the board.
    ///
    /// ```
    /// use actuator_web::scenario::Scenario;
    ///
    /// let scenario = Scenario::parse("model=grey-box&P=12&input=sine&duration_s=3").unwrap();
    /// assert_eq!(scenario.run.settings.grey_box.position_gain, 12.0);
    /// assert_eq!(scenario.ticks, 60_000);
    /// ```
    ///
    /// # Errors
    /// Any but [`Error::Command`] and [`Error::Interrupted`].
    pub fn parse(text: &str) -> Result<Self, Error> {
        let mut request = Request::default();
        request.parse("model", "board")?;
        let mut parameters = Vec::new();
        for entry in text.split('&').filter(|entry| !entry.is_empty()) {
            let (key, value) = entry
                .split_once('=')
                .ok_or_else(|| Error::Request(format!("`{entry}` is not of the form key=value")))?;
            if !request.parse(key, value)? {
                parameters.push((key, number(key, value)?));
            }
        }
        // An empty name is no preset.
        request.preset = request.preset.filter(|name| !name.is_empty());
        let mut run = scenario::Scenario::try_new(&request)?;
        for (name, value) in parameters {
            run.set(name, value)?;
        }
        Ok(Self {
            run,
            ticks: run_ticks(&run)?,
        })
    }

    /// How many rows the run has.
    pub fn rows(&self) -> u64 {
        self.ticks.div_ceil(self.run.every.max(1))
    }
}

fn number(key: &str, text: &str) -> Result<f64, Error> {
    let number = text.parse();
    number.map_err(|_| Error::Parameter(format!("{key} is `{text}`, expected a number")))
}

/// How long to run: by default as long as the input, but no longer than a page computes.
fn run_ticks(run: &scenario::Scenario) -> Result<u64, Error> {
    let longest = ticks(LONGEST_S);
    let (ticks, every) = (run.ticks()?, run.every);
    if run.duration_s.is_some() && ticks > longest {
        return Err(Error::TooLong(format!(
            "a run of {} s, expected at most {LONGEST_S} s",
            ticks as f64 / TICKS_PER_SECOND as f64
        )));
    }
    if every > TICKS_PER_SECOND {
        return Err(Error::TooLong(format!(
            "a row every {every} ticks, expected at most {TICKS_PER_SECOND}"
        )));
    }
    let ticks = ticks.min(longest);
    if ticks.div_ceil(every) > MOST_ROWS {
        let most_s = MOST_ROWS as f64 * every as f64 / TICKS_PER_SECOND as f64;
        return Err(Error::TooLong(format!(
            "a row every {every} ticks for {} s, expected at most {most_s} s",
            ticks as f64 / TICKS_PER_SECOND as f64
        )));
    }
    Ok(ticks)
}

#[cfg(test)]
mod tests {
    use super::*;
    use model_core::actuator::{ModelKind, PlantKind, Settings};
    use proptest::prelude::*;

    fn refusal(text: &str) -> (i32, String) {
        let error = Scenario::parse(text).unwrap_err();
        (error.code(), error.to_string())
    }

    #[test]
    fn the_default_is_the_board_on_a_pulse() {
        let scenario = Scenario::parse("").unwrap();
        let board = Settings::new(ModelKind::Board, PlantKind::FirstOrder);
        assert_eq!(scenario.run.settings, board);
        assert_eq!(
            (scenario.run.input.name(), scenario.ticks, scenario.rows()),
            ("pulse", 100_000, 5000)
        );
    }

    #[test]
    fn a_parameter_overrides_the_preset_in_any_order() {
        let text = "motor_gain_up=3&model=board&preset=asymmetric";
        let plant = Scenario::parse(text).unwrap().run.settings.first_order;
        assert_eq!((plant.motor_gain_up, plant.motor_gain_down), (3.0, 3.5));
    }

    #[test]
    fn an_error_names_what_is_wrong_and_what_is_expected() {
        assert_eq!(refusal("P").1, "`P` is not of the form key=value");
        assert_eq!(refusal("model=bord").0, 1);
        assert!(refusal("model=bord").1.contains("black-box-1"));
        assert_eq!(refusal("quux=1").0, 1);
        assert_eq!(refusal("input.quux=1").0, 1);
        assert_eq!(refusal("P=NaN").0, 2);
        assert_eq!(
            refusal("P=-1").1,
            "parameter position_gain is -1, expected a number from 0 to 500 1/s"
        );
        assert_eq!(refusal("P=many").1, "P is `many`, expected a number");
        assert_eq!(refusal("duration_s=inf").0, 2);
        assert_eq!(refusal("every=0").0, 2);
        assert_eq!(refusal("duration_s=60&every=1").0, 4);
        assert_eq!(refusal("duration_s=601").0, 4);
        assert_eq!(refusal("every=20001").0, 4);
    }

    #[test]
    fn a_preset_of_another_plant_is_refused() {
        let (code, text) = refusal("plant=bench&preset=asymmetric");
        assert_eq!(code, 1);
        assert!(text.ends_with("the plant is `bench`"), "{text}");
    }

    #[test]
    fn a_run_is_cut_at_the_longest_that_a_page_computes() {
        let scenario = Scenario::parse("input=sine&input.frequency_hz=0.0001").unwrap();
        assert_eq!(scenario.ticks, ticks(LONGEST_S));
    }

    proptest! {
        #[test]
        fn no_text_makes_it_panic(text in "\\PC*", key in "[a-z_.]{0,12}", value: f64) {
            let _ = Scenario::parse(&text);
            let _ = Scenario::parse(&format!("{key}={value}&P={value}&duration_s={value}"));
        }
    }
}
