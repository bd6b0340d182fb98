//! An actuator for MuJoCo: a file of MJCF for `<include>`, with the plugin of `bindings/mujoco`.

use std::fmt::Write as _;

use model_core::{actuator::Settings, named::Named, parameter::Value};

use crate::settings::{ModelKind, PlantKind};

/// The file: an instance of the plugin with these settings and an actuator at a joint. Both and the
/// joint have names, which are identifiers.
///
/// ```
/// use host_sim::{mjcf, settings::{ModelKind, PlantKind, Settings}};
///
/// let mut settings = Settings::new(ModelKind::Board, PlantKind::Drivetrain);
/// settings.set("supply_v", 4.8).unwrap();
/// let text = mjcf::servo(&settings, "elbow", "elbow_joint");
/// assert!(text.contains(r#"<config key="parameters" value="supply_v 4.8"/>"#));
/// ```
pub fn servo(settings: &Settings, name: &str, joint: &str) -> String {
    let plugin = "smart_actuator.servo";
    let mut keys = vec![("model", settings.model.name().to_owned())];
    if settings.model == ModelKind::Board {
        keys.push(("plant", settings.plant.name().to_owned()));
        keys.push(("pwm", settings.pwm.name().to_owned()));
    }
    keys.push(("seed", settings.seed.to_string()));
    keys.push(("parameters", changed(settings)));
    let mut text = String::from("<mujocoinclude>\n  <extension>\n");
    let _ = writeln!(text, "    <plugin plugin=\"{plugin}\">");
    let _ = writeln!(text, "      <instance name=\"{name}\">");
    for (key, value) in keys {
        let _ = writeln!(text, "        <config key=\"{key}\" value=\"{value}\"/>");
    }
    text += "      </instance>\n    </plugin>\n  </extension>\n  <actuator>\n";
    if !(settings.model == ModelKind::Board && settings.plant == PlantKind::Drivetrain) {
        text +=
            "    <!-- The load does not act on this model: forcerange limits what moves it. -->\n";
    }
    let _ = writeln!(
        text,
        "    <plugin name=\"{name}\" joint=\"{joint}\" plugin=\"{plugin}\" instance=\"{name}\"/>"
    );
    text + "  </actuator>\n</mujocoinclude>\n"
}

/// The parameters that differ from their defaults, as names and values in turn, in the shortest
/// digits that read back as the same numbers.
fn changed(settings: &Settings) -> String {
    let is_changed = |v: &Value| v.value != v.parameter.default;
    let words = settings
        .values()
        .filter(is_changed)
        .map(|v| format!("{} {:?}", v.parameter.name, v.value));
    words.collect::<Vec<_>>().join(" ")
}
