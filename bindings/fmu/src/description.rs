//! `modelDescription.xml`, made from the variables.

use std::collections::BTreeSet;
use std::fmt::{self, Write};

use model_core::actuator::{ModelKind, PlantKind, Settings};
use model_core::named::Named;
use model_core::parameter::Parameter;
use model_core::plant::Pwm;
use model_core::time::CONTROL_PERIOD_S;
use uuid::Uuid;

use crate::units::{self, Unit};
use crate::variables::{self, Inputs, Quantity, Type, Variable};
use crate::xml::{Escaped, Number};

/// The one category of messages.
pub const ERROR_CATEGORY: &str = "logStatusError";

/// A random UUID, the name space of the GUIDs of these FMUs.
const NAME_SPACE: Uuid = Uuid::from_u128(0x6c1f_52a0_7d3b_4e86_9a41_b2f0_35d8_e917);

/// The name of the files and of the model in a host: a C identifier.
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

/// The GUID of these settings: a hash (UUID version 5) of the description itself, so that it
/// changes with the version, with every variable and with every start value.
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

/// The description of these settings.
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
    let mut xml = String::new();
    // Writing to a string cannot fail.
    let _ = write(&mut xml, settings, guid);
    xml
}

fn write(xml: &mut String, settings: &Settings, guid: &str) -> fmt::Result {
    let list = variables::of(settings);
    let identifier = model_identifier(settings);
    let version = env!("CARGO_PKG_VERSION");
    writeln!(
        xml,
        r#"<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="{identifier}" guid="{guid}"
    description="{}" version="{version}" license="MIT OR Apache-2.0"
    generationTool="smart-actuator {version}" variableNamingConvention="flat">
  <CoSimulation modelIdentifier="{identifier}" canHandleVariableCommunicationStepSize="true"
      canNotUseMemoryManagementFunctions="true" canGetAndSetFMUstate="true"
      canSerializeFMUstate="true"/>
  <UnitDefinitions>"#,
        Escaped(summary(settings))
    )?;
    let names: BTreeSet<_> = list.iter().map(|variable| variable.unit).collect();
    for unit in names.into_iter().filter_map(units::named) {
        write_unit(xml, unit)?;
    }
    writeln!(
        xml,
        r#"  </UnitDefinitions>
  <LogCategories>
    <Category name="{ERROR_CATEGORY}" description="Calls that were refused, and why"/>
  </LogCategories>
  <DefaultExperiment startTime="0" stopTime="1" stepSize="{CONTROL_PERIOD_S}"/>
  <ModelVariables>"#
    )?;
    for (reference, variable) in list.iter().enumerate() {
        write_variable(xml, settings, reference, variable)?;
    }
    writeln!(xml, "  </ModelVariables>\n  <ModelStructure>")?;
    for tag in ["Outputs", "InitialUnknowns"] {
        write_outputs(xml, tag, &list)?;
    }
    writeln!(xml, "  </ModelStructure>\n</fmiModelDescription>")
}

/// What the model is, in a line.
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

fn write_unit(xml: &mut String, unit: &Unit) -> fmt::Result {
    write!(xml, r#"    <Unit name="{}"><BaseUnit"#, Escaped(unit.name))?;
    for (base, power) in unit.powers {
        write!(xml, r#" {base}="{power}""#)?;
    }
    if unit.factor != 1.0 {
        write!(xml, r#" factor="{}""#, Number(unit.factor))?;
    }
    writeln!(xml, "/></Unit>")
}

fn write_variable(
    xml: &mut String,
    settings: &Settings,
    reference: usize,
    variable: &Variable,
) -> fmt::Result {
    let role = match variable.quantity {
        Quantity::Input(_) => r#"causality="input" variability="continuous""#,
        Quantity::Output(_) => {
            r#"causality="output" variability="continuous" initial="calculated""#
        }
        _ => r#"causality="parameter" variability="fixed" initial="exact""#,
    };
    writeln!(
        xml,
        r#"    <ScalarVariable name="{}" valueReference="{reference}" {role}
        description="{}">"#,
        variable.name,
        Escaped(&about(variable)),
    )?;
    write!(xml, "      <{:?}", variable.quantity.of_type())?;
    if variable.quantity.of_type() == Type::Real {
        write!(xml, r#" unit="{}""#, Escaped(variable.unit))?;
    }
    match variable.quantity {
        Quantity::Output(_) => {}
        Quantity::Input(p) => write_range(xml, p, Inputs::at_start(settings).named(p))?,
        Quantity::Parameter(p) => {
            let value = settings.values().find(|v| v.parameter.name == p.name);
            write_range(xml, p, value.map_or(p.default, |v| v.value))?;
        }
        Quantity::Seed => write!(xml, r#" start="{}" min="0""#, settings.seed)?,
        Quantity::SwitchedPwm => {
            write!(xml, r#" start="{}""#, settings.pwm == Pwm::Switched)?;
        }
    }
    writeln!(xml, "/>\n    </ScalarVariable>")
}

fn write_range(xml: &mut String, parameter: &Parameter, start: f64) -> fmt::Result {
    write!(xml, r#" start="{}""#, Number(start))?;
    for (limit, value) in [("min", parameter.min), ("max", parameter.max)] {
        if value.is_finite() {
            write!(xml, r#" {limit}="{}""#, Number(value))?;
        }
    }
    Ok(())
}

/// What a variable is and where its default comes from.
fn about(variable: &Variable) -> String {
    match variable.quantity {
        Quantity::Parameter(p) if p.symbol.is_empty() => format!("{} ({})", p.meaning, p.source),
        Quantity::Parameter(p) => format!("{}: {} ({})", p.symbol, p.meaning, p.source),
        _ => variable.meaning.to_owned(),
    }
}

/// No output depends on an input of the same instant: what is seen is what the steps so far left.
fn write_outputs(xml: &mut String, tag: &str, list: &[Variable]) -> fmt::Result {
    writeln!(xml, "    <{tag}>")?;
    for (i, variable) in list.iter().enumerate() {
        if let Quantity::Output(_) = variable.quantity {
            writeln!(xml, r#"      <Unknown index="{}" dependencies=""/>"#, i + 1)?;
        }
    }
    writeln!(xml, "    </{tag}>")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identity;

    #[test]
    fn every_description_is_well_formed_and_shows_every_variable() {
        for settings in identity::defaults() {
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
    fn a_start_value_that_was_set_stands_there_and_an_unbounded_one_is_inf() {
        let mut settings = Settings::new(ModelKind::GreyBox, PlantKind::FirstOrder);
        settings.set("duty_limit_pct", f64::INFINITY).unwrap();
        settings.set("position_gain", 9.5).unwrap();
        let xml = xml(&settings);
        assert!(xml.contains(r#"start="INF""#));
        assert!(xml.contains(r#"start="9.5""#));
        assert!(!xml.contains("inf\""));
    }

    #[test]
    fn the_guids_of_all_models_differ_and_do_not_change_from_call_to_call() {
        let guids: BTreeSet<_> = identity::defaults().map(|s| guid(&s)).collect();
        assert_eq!(guids.len(), identity::defaults().count());
        assert!(identity::defaults().all(|s| guids.contains(&guid(&s))));
    }
}
