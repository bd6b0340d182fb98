//! `modelDescription.xml`, generated from the variables with `templates/model_description.xml`.

use std::collections::BTreeSet;
use std::fmt;

use askama::Template;
use model_core::actuator::{ModelKind, PlantKind, Settings};
use model_core::named::Named;
use model_core::plant::Pwm;
use model_core::time::CONTROL_PERIOD_S;
use uuid::Uuid;

use crate::exchange::equations::Equations;
use crate::units::{self, Unit};
use crate::variables::{self, Inputs, Quantity, Type, Variable, finite};

/// The only log category.
pub const ERROR_CATEGORY: &str = "logStatusError";

/// A random UUID: the namespace of the GUIDs of these FMUs.
const NAME_SPACE: Uuid = Uuid::from_u128(0x6c1f_52a0_7d3b_4e86_9a41_b2f0_35d8_e917);

/// The model identifier, which is also the name of the files: a C identifier.
///
/// ```
/// use model_core::actuator::{ModelKind, PlantKind, Settings};
///
/// let settings = Settings::new(ModelKind::Board, PlantKind::Drivetrain);
/// assert_eq!(actuator_fmu::description::model_identifier(&settings), "actuator_board_bench");
/// ```
pub fn model_identifier(settings: &Settings) -> String {
    let plant = match (settings.model, settings.plant) {
        (ModelKind::Board, PlantKind::Drivetrain) => "_bench",
        _ => "",
    };
    format!(
        "actuator_{}{plant}",
        settings.model.name().replace('-', "_")
    )
}

/// The GUID of these settings: a hash (UUID version 5) of the description. It changes with the
/// version, with every variable and with every start value.
///
/// ```
/// use model_core::actuator::{ModelKind, PlantKind, Settings};
///
/// let mut settings = Settings::new(ModelKind::GreyBox, PlantKind::FirstOrder);
/// let before = actuator_fmu::description::guid(&settings);
/// settings.set("position_gain", 9.0).unwrap();
/// assert_ne!(actuator_fmu::description::guid(&settings), before);
/// assert_eq!(before.len(), 38);
/// ```
pub fn guid(settings: &Settings) -> String {
    let content = with_guid(settings, "");
    Uuid::new_v5(&NAME_SPACE, content.as_bytes())
        .braced()
        .to_string()
}

/// The model description of these settings.
///
/// ```
/// use model_core::actuator::{ModelKind, PlantKind, Settings};
///
/// let settings = Settings::new(ModelKind::BlackBox1, PlantKind::FirstOrder);
/// let xml = actuator_fmu::description::xml(&settings);
/// assert!(xml.contains(r#"<Real unit="rad/s" start="30""#));
/// ```
pub fn xml(settings: &Settings) -> String {
    with_guid(settings, &guid(settings))
}

fn with_guid(settings: &Settings, guid: &str) -> String {
    // Writing to a string does not fail.
    description(settings, guid).render().unwrap_or_default()
}

fn description<'a>(settings: &'a Settings, guid: &'a str) -> ModelDescription<'a> {
    let variables = variables::of(settings);
    let units: BTreeSet<_> = variables.iter().map(|variable| variable.unit).collect();
    ModelDescription {
        identifier: model_identifier(settings),
        guid,
        summary: summary(settings),
        version: env!("CARGO_PKG_VERSION"),
        units: units.into_iter().filter_map(units::named).collect(),
        variables,
        settings,
    }
}

/// The model description of these settings for FMI 3.0.
///
/// ```
/// use model_core::actuator::{ModelKind, PlantKind, Settings};
///
/// let settings = Settings::new(ModelKind::BlackBox1, PlantKind::FirstOrder);
/// let xml = actuator_fmu::description::xml_3(&settings);
/// assert!(xml.contains(r#"<Float64 unit="rad/s" name="pole_rad_s""#));
/// ```
pub fn xml_3(settings: &Settings) -> String {
    let guid = guid(settings);
    let inner = description(settings, &guid);
    // Writing to a string does not fail.
    ModelDescription3 { inner }.render().unwrap_or_default()
}

/// One line that describes the model.
pub fn summary(settings: &Settings) -> &'static str {
    match (settings.model, settings.plant) {
        (ModelKind::Board, PlantKind::Drivetrain) => {
            "RC-servo actuator: the board's own fixed-point control step every 4 ms, around motor, \
             gear train, friction and load in detail"
        }
        (ModelKind::Board, PlantKind::FirstOrder) => {
            "RC-servo actuator: the board's own fixed-point control step every 4 ms, around the \
             paper's first-order motor"
        }
        (ModelKind::GreyBox, _) => {
            "RC-servo actuator, grey box: motor, PI rate loop and P position loop in continuous time"
        }
        (ModelKind::BlackBox1, _) => {
            "RC-servo actuator, black box 1: first-order lag with rate and position limits"
        }
        (ModelKind::BlackBox2, _) => {
            "RC-servo actuator, black box 2: second-order lag with rate and position limits"
        }
    }
}

#[derive(Template)]
#[template(path = "model_description.xml")]
struct ModelDescription<'a> {
    identifier: String,
    guid: &'a str,
    summary: &'static str,
    version: &'static str,
    units: Vec<&'static Unit>,
    variables: Vec<Variable>,
    settings: &'a Settings,
}

#[derive(Template)]
#[template(path = "model_description_3.xml")]
struct ModelDescription3<'a> {
    inner: ModelDescription<'a>,
}

impl ModelDescription<'_> {
    /// Number of continuous states; 0 for the board.
    fn states(&self) -> usize {
        Equations::of(self.settings).map_or(0, |equations| equations.states())
    }

    /// Number of event indicators; 0 for the board.
    fn indicators(&self) -> usize {
        Equations::of(self.settings).map_or(0, |equations| equations.indicator_count())
    }

    /// Whether the model structure lists a variable under a tag, of either version.
    fn is_listed(&self, tag: &str, variable: &Variable) -> bool {
        let tag = tag.trim_end_matches('s');
        match variable.quantity {
            Quantity::Output(_) => matches!(tag, "Output" | "InitialUnknown"),
            Quantity::State(_) => tag == "InitialUnknown",
            Quantity::Derivative(_) => matches!(
                tag,
                "Derivative" | "ContinuousStateDerivative" | "InitialUnknown"
            ),
            Quantity::Indicator(_) => tag == "EventIndicator",
            _ => false,
        }
    }

    /// The value reference of the state with this index.
    fn state(&self, index: &usize) -> usize {
        let is_it = |v: &Variable| matches!(v.quantity, Quantity::State(i) if i == *index);
        self.variables.iter().position(is_it).unwrap_or_default()
    }

    /// The start value; an output has none.
    fn start(&self, variable: &Variable) -> Option<String> {
        let value = match variable.quantity {
            Quantity::Output(_)
            | Quantity::State(_)
            | Quantity::Derivative(_)
            | Quantity::Indicator(_) => return None,
            Quantity::Seed => return Some(self.settings.seed.to_string()),
            Quantity::Level => return Some("0".into()),
            Quantity::SwitchedPwm => return Some((self.settings.pwm == Pwm::Switched).to_string()),
            Quantity::Input(p) => Inputs::at_start(self.settings).named(p),
            Quantity::Parameter(p) | Quantity::Gain(p) => {
                let value = self.settings.values().find(|v| v.parameter.name == p.name);
                value.map_or(p.default, |v| v.value)
            }
        };
        Some(Number(value).to_string())
    }

    /// The lower and the upper limit of the value, if they are finite.
    fn limits(&self, variable: &Variable) -> [Option<Number>; 2] {
        match variable.quantity {
            Quantity::Input(p) | Quantity::Parameter(p) | Quantity::Gain(p) => {
                [p.min, p.max].map(|limit| Some(Number(limit)).filter(|_| limit.is_finite()))
            }
            Quantity::Seed => [Some(Number(0.0)), None],
            Quantity::Level => [Some(Number(0.0)), Some(Number(3.0))],
            Quantity::Output(_)
            | Quantity::State(_)
            | Quantity::Derivative(_)
            | Quantity::Indicator(_)
            | Quantity::SwitchedPwm => [None, None],
        }
    }
}

/// A number in the notation of XML Schema, with enough digits to restore it exactly. Infinity,
/// which few hosts can show, is the largest number.
struct Number(f64);

impl fmt::Display for Number {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match finite(self.0) {
            // All digits of the largest numbers would be 309.
            largest if largest.abs() == f64::MAX => write!(f, "{largest:e}"),
            value => write!(f, "{value}"),
        }
    }
}

/// The meaning of a variable and the source of its default.
fn about(variable: &Variable) -> String {
    match variable.quantity {
        Quantity::Parameter(p) | Quantity::Gain(p) => {
            let symbol = match p.symbol {
                "" => String::new(),
                symbol => format!("{symbol}: "),
            };
            let limit = match p.max.is_infinite() {
                true => format!(", {:e} is unlimited", f64::MAX),
                false => String::new(),
            };
            format!("{symbol}{} ({}{limit})", p.meaning, p.source)
        }
        _ => variable.meaning.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use model_core::scenario;

    #[test]
    fn every_description_is_well_formed_and_lists_every_variable() {
        for settings in scenario::choices() {
            let xml = xml(&settings);
            let document = roxmltree::Document::parse(&xml).unwrap();
            let scalars = document
                .descendants()
                .filter(|node| node.has_tag_name("ScalarVariable"));
            let names: Vec<_> = scalars.filter_map(|node| node.attribute("name")).collect();
            let expected: Vec<_> = variables::of(&settings).iter().map(|v| v.name).collect();
            assert_eq!(names, expected);
        }
    }

    #[test]
    fn infinity_is_written_as_the_largest_number() {
        assert_eq!(
            Number(f64::NEG_INFINITY).to_string(),
            "-1.7976931348623157e308"
        );
        assert_eq!(Number(0.0175).to_string(), "0.0175");
    }

    #[test]
    fn a_start_value_is_written_as_set_and_infinity_as_the_largest_number() {
        let mut settings = Settings::new(ModelKind::GreyBox, PlantKind::FirstOrder);
        settings.set("duty_limit_pct", f64::INFINITY).unwrap();
        settings.set("position_gain", 9.5).unwrap();
        let xml = xml(&settings);
        assert!(xml.contains(r#"start="1.7976931348623157e308""#));
        assert!(xml.contains("1.7976931348623157e308 is unlimited"));
        assert!(xml.contains(r#"start="9.5""#));
        assert!(!xml.to_lowercase().contains("inf\""));
    }

    #[test]
    fn the_guids_of_all_models_differ_and_are_reproducible() {
        let guids: BTreeSet<_> = scenario::choices().map(|s| guid(&s)).collect();
        assert_eq!(guids.len(), scenario::choices().count());
        assert!(scenario::choices().all(|s| guids.contains(&guid(&s))));
    }
}
