//! `documentation/index.html`: what the variables mean and how time passes.

use std::fmt::{self, Write};

use model_core::actuator::Settings;

use crate::description::{model_identifier, summary};
use crate::variables::{self, Quantity};
use crate::xml::Escaped;

const TIME: &str = "<h2>Time</h2>
<p>The actuator moves by ticks of 50 us. Communication points are counted from the start time and
rounded to ticks, so steps of any length do not drift. Whatever the communication step, the PWM
period is 1 ms and the control step comes every 4 ms.</p>
<p>An input is held from one communication point to the next. An output is what can be seen at the
end of the step, before a PWM edge or a control step of that very instant. The first command is
taken to have stood there for ever, so the transport delay starts filled with it.</p>
<p>Parameters are fixed: they can be set until the initialization ends.</p>
";

/// The page of these settings.
///
/// ```
/// use model_core::actuator::{ModelKind, PlantKind, Settings};
///
/// let settings = Settings::new(ModelKind::BlackBox1, PlantKind::FirstOrder);
/// assert!(actuator_fmu::documentation::html(&settings).contains("<td>command_deg</td>"));
/// ```
pub fn html(settings: &Settings) -> String {
    let mut html = String::new();
    // Writing to a string cannot fail.
    let _ = write(&mut html, settings);
    html
}

fn write(html: &mut String, settings: &Settings) -> fmt::Result {
    let name = model_identifier(settings);
    writeln!(
        html,
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>{name}</title></head><body>
<h1>{name}</h1>\n<p>{}.</p>\n{TIME}<h2>Variables</h2>\n<table border=\"1\">
<tr><th>name</th><th>kind</th><th>unit</th><th>range</th><th>meaning</th><th>source</th></tr>",
        Escaped(summary(settings))
    )?;
    for variable in variables::of(settings) {
        let (kind, range, source) = match variable.quantity {
            Quantity::Input(p) => ("input", format!("{} to {}", p.min, p.max), p.source),
            Quantity::Output(_) => ("output", String::new(), ""),
            Quantity::Parameter(p) => ("parameter", format!("{} to {}", p.min, p.max), p.source),
            Quantity::Seed | Quantity::SwitchedPwm => ("parameter", String::new(), ""),
        };
        write!(html, "<tr>")?;
        for cell in [
            variable.name,
            kind,
            variable.unit,
            &range,
            variable.meaning,
            source,
        ] {
            write!(html, "<td>{}</td>", Escaped(cell))?;
        }
        writeln!(html, "</tr>")?;
    }
    writeln!(html, "</table>\n</body></html>")
}
